#include <lamap_mrpt/maps/CGPMap.h>

#include <lamap_core/grid/signed_evidence.h>
#include <lamap_mrpt/files/grid_content.h>
#include <lamap_mrpt/files/payload.h>
#include <lamap_mrpt/maps/map_definition.h>
#include <lamap_mrpt/maps/map_sections.h>
#include <lamap_mrpt/options/shared_options.h>

#include <cstdio>
#include <stdexcept>

namespace lamap
{
IMPLEMENTS_SERIALIZABLE(CGPMap, mrpt::maps::CMetricMap, lamap)
MAP_DEFINITION_REGISTER("gpMap,lamap::CGPMap", lamap::CGPMap)

namespace
{
/// Stands after the macros: registering before the class's own static data is there would go wrong.
struct Registration
{
  Registration() { mrpt::rtti::registerClass(CLASS_ID(lamap::CGPMap)); }
} const registration;

constexpr uint8_t kFormatVersion = 1;

std::string shortNumber(double number)
{
  char text[48];
  std::snprintf(text, sizeof(text), "%.6g", number);
  return text;
}

/// Refuses a grid whose cells hold what no GP map of this kind could.
void requireSums(const GpMap& map, const ByteReader& in)
{
  const bool isBcm = map.structure().fusion == GpFusion::Bcm;
  for (const BlockIndex& index : map.grid().sortedBlocks())
  {
    map.grid().find(index)->visitLeaves(map.grid().shape(),
                                        [&](uint32_t, uint32_t, const Evidence& evidence)
                                        {
                                          const auto precision = decodedSum(evidence.occupied);
                                          const bool fits = isBcm ? precision && *precision >= 0 : !precision;
                                          if (!fits || !decodedSum(evidence.free))
                                            in.fail("the evidence of a cell is not that of its fusion");
                                        });
  }
}
}  // namespace

// ---- Options
// ---------------------------------------------------------------------------------------------------------

const OptionTable& CGPMap::TCreationOptions::optionTable() const
{
  using Self = TCreationOptions;
  static const OptionTable table = []
  {
    OptionTable all("creationOpts");
    all.add<Self>("preset", &Self::preset, OptionTable::Traits::oneOf({"default", "thesis", "la3dm"}),
                  "named set of options, applied before all others");
    addResolutionOption<Self>(all);
    addBlockOptions<Self>(all);
    addPlanarOptions<Self>(all)
        .add<Self>("fusion", &Self::fusion, OptionTable::Traits::oneOf({"bcm", "bayes"}),
                   "what adds up in a cell: precisions and weighted means (BCM), or log-odds")
        .add<Self>("signalVariance", &Self::signalVariance, {"", {1e-3, 1e3}},
                   "variance of what the map says of cells without data")
        .add<Self>("noiseVariance", &Self::noiseVariance, {"", {1e-6, 1e3}},
                   "variance of a label around what is there")
        .add<Self>("squashGain", &Self::squashGain, {"", {0, 1e6, false}},
                   "gain of the function that makes probabilities of means and variances")
        .add<Self>("minVariance", &Self::minVariance, {"", {0, 1e3, false}, "noiseVariance"},
                   "smallest variance there is, for that function");
    return all;
  }();
  return table;
}

std::vector<std::string> CGPMap::TCreationOptions::foreignFlags() const
{
  return genericMapKeys();
}

const OptionTable& CGPMap::TInsertionOptions::optionTable() const
{
  using Self = TInsertionOptions;
  static const OptionTable table = []
  {
    const LegalRange aboveZero{0, kMetresMost, false};
    OptionTable all("insertOpts");
    all.add<Self>("nested", &Self::nested, {},
                  "a GP a block with data, those around a cell fused (nested BCM); else one a block, on all "
                  "data around it")
        .add<Self>("freeSpace", &Self::freeSpace, OptionTable::Traits::oneOf({"samples", "none"}),
                   "where a ray says free: points along it, nowhere");
    addFreeSampleOptions<Self>(all, "2 cells");
    addTrainingPointOptions<Self>(all)
        .add<Self>("protectHits", &Self::protectHits, {"", {0, 4294967295.0}},
                   "no free points in a cell with so many raw hits in a scan; 0: none is protected")
        .add<Self>("kernelSupport", &Self::kernelSupport, {"m", aboveZero, "2 cells"},
                   "a GP is silent so far from all its data, and takes no data farther from its block")
        .add<Self>("lengthScale", &Self::lengthScale, {"m", aboveZero}, "how far what is alike is near")
        .add<Self>("maxPoints", &Self::maxPoints, {"", {1, 4096}},
                   "training points of one GP; more are split, and the parts fused")
        .onlyWhere({"freeResolution", "freeMargin", "freeDownsampling", "protectHits"},
                   {{"freeSpace", {"samples"}}});
    addRangeOptions<Self>(all);
    addThresholdOptions<Self>(all);
    return addVarianceThresholdOption<Self>(all).onlyWhere({"varianceThreshold"}, {{"fusion", {"bcm"}}});
  }();
  return table;
}

void CGPMap::TInsertionOptions::validate() const
{
  // Lengths are compared with the resolution, which is not known here.
  GpInference withoutLengths = *this;
  withoutLengths.freeResolution = withoutLengths.freeMargin = std::nullopt;
  withoutLengths.hitDownsampling = withoutLengths.kernelSupport = std::nullopt;
  withoutLengths.lengthScale = 1.0;
  withoutLengths.freeDownsampling = 0.0;
  withoutLengths.validate(1.0);
}

// ---- Definition
// ------------------------------------------------------------------------------------------------------

CGPMap::TMapDefinition::TMapDefinition() = default;

void CGPMap::TMapDefinition::usePreset()
{
  const GpOptions preset = presetOptions(creationOpts.preset);
  static_cast<GpStructure&>(creationOpts) = preset.structure;
  static_cast<GpInference&>(insertionOpts) = preset.inference;
}

CGPMap::TInsertionOptions CGPMap::TMapDefinition::resolvedInsertion() const
{
  insertionOpts.GpInference::validate(creationOpts.resolution);
  return TInsertionOptions(insertionOpts.resolved(creationOpts.resolution));
}

void CGPMap::TMapDefinition::loadFromConfigFile_map_specific(const mrpt::config::CConfigFileBase& source,
                                                             const std::string& sectionNamePrefix)
{
  loadDefinition(*this, source, sectionNamePrefix);
}

void CGPMap::TMapDefinition::saveToConfigFile(mrpt::config::CConfigFileBase& target,
                                              const std::string& sectionPrefix) const
{
  saveDefinition(*this, target, sectionPrefix);
}

void CGPMap::TMapDefinition::dumpToTextStream_map_specific(std::ostream& out) const
{
  dumpDefinition(*this, out);
}

compat::CreatedMap CGPMap::internal_CreateFromMapDefinition(
    const mrpt::maps::TMetricMapInitializer& initializer)
{
  return createDefined<CGPMap>(initializer);
}

// ---- The map
// ---------------------------------------------------------------------------------------------------------

CGPMap::CGPMap(double resolution_m)
    : CGPMap(
          [&]
          {
            TCreationOptions options;
            options.resolution = resolution_m;
            return options;
          }())
{
}

CGPMap::CGPMap(const TCreationOptions& options)
    : insertionOptions(GpInference().resolved(options.resolution)), creationOptions_(options), map_(options)
{
  creationOptions_.minVariance = options.resolvedMinVariance();
  setLoggerName("lamap::CGPMap");
}

void CGPMap::merge(const CGPMap& other)
{
  map_.merge(other.map_, insertionOptions.thresholds);
  contentChanged();
}

std::optional<CellEstimate> CGPMap::estimateAt(const mrpt::math::TPoint3D& point_map) const
{
  return map_.at({point_map.x, point_map.y, point_map.z}, insertionOptions.thresholds);
}

std::optional<CellEstimate> CGPMap::estimateCell(const CellIndex& cell) const
{
  return map_.cell(cell, insertionOptions.thresholds);
}

void CGPMap::visitCells(const CellVisitor& visitor) const
{
  map_.visitCells(insertionOptions.thresholds, visitor);
}

std::vector<std::string> CGPMap::evidenceNames() const
{
  if (creationOptions_.fusion == GpFusion::Bayes) return {"logodds"};
  return {"precision", "mean"};
}

std::vector<CLearnedMap::Fact> CGPMap::facts() const
{
  double least = map_.structure().signalVariance;
  std::vector<Fact> facts = cellFacts([&](const CellIndex&, const CellEstimate& cell)
                                      { least = std::min(least, cell.variance.value_or(least)); });
  facts.push_back({"blocks", std::to_string(map_.grid().blockCount()), ""});
  facts.push_back(memoryFact());
  if (creationOptions_.fusion == GpFusion::Bcm)
    facts.push_back({"smallest variance of a cell", shortNumber(least), ""});
  if (map_.structure().planar)
    facts.push_back({"planar, at height", shortNumber(map_.structure().planarHeight), "m"});
  const std::vector<Fact> ofScans = scanFacts();
  facts.insert(facts.end(), ofScans.begin(), ofScans.end());
  return facts;
}

RayCounts CGPMap::learnScan(const Scan& scan, const ScanPose& /*pose*/)
{
  return map_.insert(scan, insertionOptions, threadCount());
}

std::optional<int32_t> CGPMap::planarLayer() const
{
  if (!map_.structure().planar) return std::nullopt;
  return map_.planarLayer();
}

RangeLimits CGPMap::rangeLimits() const
{
  return {insertionOptions.minRange, insertionOptions.maxRange,
          insertionOptions.considerInvalidRangesAsFreeSpace, insertionOptions.rayDecimation};
}

void CGPMap::updateVoxel(double x, double y, double z, bool occupied)
{
  map_.addObservation(addressableCell("updateVoxel", x, y, z), occupied, insertionOptions.thresholds);
  contentChanged();
}

void CGPMap::visitOptionGroups(const VisitGroup& visit) const
{
  visitGroups(creationOptions_, TInsertionOptions(insertionOptions.resolved(resolution())), *this, visit);
}

void CGPMap::internal_clear()
{
  map_.clear();
  contentChanged();
}

// ---- Serialization
// ---------------------------------------------------------------------------------------------------

uint8_t CGPMap::serializeGetVersion() const
{
  return kFormatVersion;
}

void CGPMap::serializeTo(mrpt::serialization::CArchive& out) const
{
  ByteWriter content;
  creationOptions_.write(content);
  writeGrid(map_.grid(), content);
  writeOptions(TInsertionOptions(insertionOptions.resolved(resolution())), *this, content);
  writePayload(out, content.bytes());
}

void CGPMap::serializeFrom(mrpt::serialization::CArchive& in, uint8_t version)
{
  if (version != kFormatVersion) refuseVersion(className, version, kFormatVersion);
  const std::vector<uint8_t> payload = readPayload(in);
  ByteReader content(payload);
  // Everything is read before anything changes.
  TCreationOptions creation;
  creation.read(content);
  try
  {
    creation.validate();
    GpMap map(creation);
    readGrid(map.grid(), creation.planar ? std::optional(map.planarLayer()) : std::nullopt, content);
    requireSums(map, content);
    TInsertionOptions insertion;
    const StoredOptions others = readOptions(insertion, content);
    content.expectEnd();
    insertion.GpInference::validate(creation.resolution);

    creationOptions_ = creation;
    map_ = std::move(map);
    insertionOptions = insertion;
    others.handTo(*this);
  }
  catch (const std::invalid_argument& error)
  {
    content.fail(error.what());
  }
  contentChanged();
}

}  // namespace lamap
