#include <lamap_mrpt/maps/CBGKMap.h>

#include <lamap_mrpt/files/map_file.h>
#include <lamap_mrpt/files/payload.h>
#include <lamap_mrpt/maps/bgk_map_content.h>
#include <lamap_mrpt/maps/map_definition.h>
#include <lamap_mrpt/maps/map_sections.h>
#include <lamap_mrpt/options/shared_options.h>

#include <cstdio>
#include <stdexcept>

namespace lamap
{
IMPLEMENTS_SERIALIZABLE(CBGKMap, mrpt::maps::CMetricMap, lamap)
MAP_DEFINITION_REGISTER("bgkMap,lamap::CBGKMap", lamap::CBGKMap)

namespace
{
/// Stands after the macros: registering before the class's own static data is there would go wrong.
struct Registration
{
  Registration() { mrpt::rtti::registerClass(CLASS_ID(lamap::CBGKMap)); }
} const registration;

constexpr uint8_t kFormatVersion = 1;

/// α and β of another map as prior.
std::shared_ptr<const BgkMap> loadPrior(const std::string& path)
{
  const auto map = loadMapFile(path);
  const auto bgk = std::dynamic_pointer_cast<const CBGKMap>(map);
  if (!bgk)
    throw std::invalid_argument("creationOpts.priorMap = \"" + path + "\" is a " +
                                map->GetRuntimeClass()->className + "; legal is a file of a lamap::CBGKMap");
  return std::make_shared<const BgkMap>(bgk->core());
}

std::string inUnits(double number, const char* format)
{
  char text[48];
  std::snprintf(text, sizeof(text), format, number);
  return text;
}
}  // namespace

// ---- Options
// ---------------------------------------------------------------------------------------------------------

const OptionTable& CBGKMap::TCreationOptions::optionTable() const
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
        .add<Self>("priorAlpha", &Self::priorAlpha, {"", {0, 1e6, false}},
                   "pseudo-count for occupied of every cell")
        .add<Self>("priorBeta", &Self::priorBeta, {"", {0, 1e6, false}},
                   "pseudo-count for free of every cell")
        .add<Self>("priorMap", &Self::priorMap, {},
                   "map file whose cells are the prior where they have evidence");
    return all;
  }();
  return table;
}

std::vector<std::string> CBGKMap::TCreationOptions::foreignFlags() const
{
  return genericMapKeys();
}

const OptionTable& CBGKMap::TInsertionOptions::optionTable() const
{
  using Self = TInsertionOptions;
  static const OptionTable table = []
  {
    OptionTable all("insertOpts");
    all.add<Self>("freeSpace", &Self::freeSpace, OptionTable::Traits::oneOf({"samples", "line", "none"}),
                  "where a ray says free: points along it, its nearest point to each cell, nowhere");
    addFreeSampleOptions<Self>(all, "1 cell")
        .add<Self>("freeWeight", &Self::freeWeight, {"", {0, 1e3}}, "weight of free evidence");
    addTrainingPointOptions<Self>(all)
        .add<Self>("protectHits", &Self::protectHits, {"", {0, 4294967295.0}},
                   "a cell with so many hits in a scan takes no free evidence from it; 0: none is protected")
        .add<Self>("kernel", &Self::kernel,
                   OptionTable::Traits::oneOf({"sparse", "sparseMatern32", "wendlandC2"}),
                   "how evidence falls with distance")
        .add<Self>("kernelSupport", &Self::kernelSupport, {"m", {0, kMetresMost, false}, "2 cells"},
                   "distance from which on a point says nothing")
        .add<Self>("kernelScale", &Self::kernelScale, {"", {0, 1e3, false}}, "evidence at distance zero")
        .onlyWhere({"freeResolution", "freeDownsampling"}, {{"freeSpace", {"samples"}}})
        .onlyWhere({"freeMargin", "freeWeight", "protectHits"}, {{"freeSpace", {"samples", "line"}}});
    addRangeOptions<Self>(all);
    addThresholdOptions<Self>(all);
    return addVarianceThresholdOption<Self>(all);
  }();
  return table;
}

void CBGKMap::TInsertionOptions::validate() const
{
  // Lengths are compared with the resolution, which is not known here.
  BgkInference withoutLengths = *this;
  withoutLengths.freeResolution = withoutLengths.freeMargin = std::nullopt;
  withoutLengths.hitDownsampling = withoutLengths.kernelSupport = std::nullopt;
  withoutLengths.validate(1.0);
}

// ---- Definition
// ------------------------------------------------------------------------------------------------------

CBGKMap::TMapDefinition::TMapDefinition() = default;

void CBGKMap::TMapDefinition::usePreset()
{
  const BgkOptions preset = presetOptions(creationOpts.preset);
  static_cast<BgkStructure&>(creationOpts) = preset.structure;
  static_cast<BgkInference&>(insertionOpts) = preset.inference;
}

CBGKMap::TInsertionOptions CBGKMap::TMapDefinition::resolvedInsertion() const
{
  insertionOpts.BgkInference::validate(creationOpts.resolution);
  return TInsertionOptions(insertionOpts.resolved(creationOpts.resolution));
}

void CBGKMap::TMapDefinition::loadFromConfigFile_map_specific(const mrpt::config::CConfigFileBase& source,
                                                              const std::string& sectionNamePrefix)
{
  loadDefinition(*this, source, sectionNamePrefix);
}

void CBGKMap::TMapDefinition::saveToConfigFile(mrpt::config::CConfigFileBase& target,
                                               const std::string& sectionPrefix) const
{
  saveDefinition(*this, target, sectionPrefix);
}

void CBGKMap::TMapDefinition::dumpToTextStream_map_specific(std::ostream& out) const
{
  dumpDefinition(*this, out);
}

compat::CreatedMap CBGKMap::internal_CreateFromMapDefinition(
    const mrpt::maps::TMetricMapInitializer& initializer)
{
  return createDefined<CBGKMap>(initializer);
}

// ---- The map
// ---------------------------------------------------------------------------------------------------------

CBGKMap::CBGKMap(double resolution_m)
    : CBGKMap(
          [&]
          {
            TCreationOptions options;
            options.resolution = resolution_m;
            return options;
          }())
{
}

CBGKMap::CBGKMap(const TCreationOptions& options)
    : insertionOptions(BgkInference().resolved(options.resolution)), creationOptions_(options), map_(options)
{
  setLoggerName("lamap::CBGKMap");
  if (!options.priorMap.empty()) map_.setPriorMap(loadPrior(options.priorMap));
}

void CBGKMap::merge(const CBGKMap& other)
{
  map_.merge(other.map_, insertionOptions.thresholds);
  contentChanged();
}

std::optional<CellEstimate> CBGKMap::estimateAt(const mrpt::math::TPoint3D& point_map) const
{
  return map_.at({point_map.x, point_map.y, point_map.z}, insertionOptions.thresholds);
}

std::optional<CellEstimate> CBGKMap::estimateCell(const CellIndex& cell) const
{
  return map_.cell(cell, insertionOptions.thresholds);
}

void CBGKMap::visitCells(const CellVisitor& visitor) const
{
  map_.visitCells(insertionOptions.thresholds, visitor);
}

std::vector<CLearnedMap::Fact> CBGKMap::facts() const
{
  double alpha = 0;
  double beta = 0;
  std::vector<Fact> facts = cellFacts(
      [&](const CellIndex& cell, const CellEstimate&)
      {
        const Evidence evidence = map_.grid().evidence(cell);
        alpha += static_cast<double>(evidence.occupied) * kEvidenceUnit;
        beta += static_cast<double>(evidence.free) * kEvidenceUnit;
      });
  facts.push_back({"blocks", std::to_string(map_.grid().blockCount()), ""});
  facts.push_back(memoryFact());
  facts.push_back({"evidence for occupied", inUnits(alpha, "%.6g"), "pseudo-counts"});
  facts.push_back({"evidence for free", inUnits(beta, "%.6g"), "pseudo-counts"});
  if (map_.structure().planar)
    facts.push_back({"planar, at height", inUnits(map_.structure().planarHeight, "%g"), "m"});
  if (map_.priorMap())
    facts.push_back({"blocks of the prior map", std::to_string(map_.priorMap()->grid().blockCount()), ""});
  const std::vector<Fact> ofScans = scanFacts();
  facts.insert(facts.end(), ofScans.begin(), ofScans.end());
  return facts;
}

RayCounts CBGKMap::learnScan(const Scan& scan, const ScanPose& /*pose*/)
{
  return map_.insert(scan, insertionOptions, threadCount());
}

std::optional<int32_t> CBGKMap::planarLayer() const
{
  if (!map_.structure().planar) return std::nullopt;
  return map_.planarLayer();
}

RangeLimits CBGKMap::rangeLimits() const
{
  return {insertionOptions.minRange, insertionOptions.maxRange,
          insertionOptions.considerInvalidRangesAsFreeSpace, insertionOptions.rayDecimation};
}

void CBGKMap::updateVoxel(double x, double y, double z, bool occupied)
{
  const double scale = insertionOptions.kernelScale;
  map_.addEvidence(addressableCell("updateVoxel", x, y, z), occupied ? scale : 0.0,
                   occupied ? 0.0 : insertionOptions.freeWeight * scale, insertionOptions.thresholds);
  contentChanged();
}

void CBGKMap::visitOptionGroups(const VisitGroup& visit) const
{
  visitGroups(creationOptions_, TInsertionOptions(insertionOptions.resolved(resolution())), *this, visit);
}

void CBGKMap::internal_clear()
{
  map_.clear();
  contentChanged();
}

// ---- Serialization
// ---------------------------------------------------------------------------------------------------

uint8_t CBGKMap::serializeGetVersion() const
{
  return kFormatVersion;
}

void CBGKMap::serializeTo(mrpt::serialization::CArchive& out) const
{
  ByteWriter content;
  writeBgkMap(creationOptions_, map_, content);
  writeOptions(TInsertionOptions(insertionOptions.resolved(resolution())), *this, content);
  writePayload(out, content.bytes());
}

void CBGKMap::serializeFrom(mrpt::serialization::CArchive& in, uint8_t version)
{
  if (version != kFormatVersion) refuseVersion(className, version, kFormatVersion);
  const std::vector<uint8_t> payload = readPayload(in);
  ByteReader content(payload);
  // Everything is read before anything changes.
  TCreationOptions creation;
  BgkMap map = readBgkMap(creation, content);
  TInsertionOptions insertion;
  const StoredOptions others = readOptions(insertion, content);
  content.expectEnd();
  try
  {
    insertion.BgkInference::validate(creation.resolution);
  }
  catch (const std::invalid_argument& error)
  {
    content.fail(error.what());
  }

  creationOptions_ = creation;
  map_ = std::move(map);
  insertionOptions = insertion;
  others.handTo(*this);
  contentChanged();
}

}  // namespace lamap
