#include <lamap_mrpt/maps/CHilbertMap.h>

#include <lamap_core/math/portable_math.h>
#include <lamap_mrpt/files/hilbert_map_content.h>
#include <lamap_mrpt/files/payload.h>
#include <lamap_mrpt/maps/map_definition.h>
#include <lamap_mrpt/maps/map_sections.h>
#include <lamap_mrpt/options/hilbert_option_tables.h>
#include <lamap_mrpt/options/shared_options.h>

#include <stdexcept>

namespace lamap
{
IMPLEMENTS_SERIALIZABLE(CHilbertMap, mrpt::maps::CMetricMap, lamap)
MAP_DEFINITION_REGISTER("hilbertMap,lamap::CHilbertMap", lamap::CHilbertMap)

namespace
{
/// Stands after the macros: registering before the class's own static data is there would go wrong.
struct Registration
{
  Registration() { mrpt::rtti::registerClass(CLASS_ID(lamap::CHilbertMap)); }
} const registration;

constexpr uint8_t kFormatVersion = 1;
}  // namespace

// ---- Options
// ---------------------------------------------------------------------------------------------------------

const OptionTable& CHilbertMap::TCreationOptions::optionTable() const
{
  using Self = TCreationOptions;
  static const OptionTable table = []
  {
    OptionTable all("creationOpts");
    all.add<Self>("preset", &Self::preset, OptionTable::Traits::oneOf({"default", "thesis"}),
                  "named set of options, applied before all others");
    addResolutionOption<Self>(all);
    addPlanarOptions<Self>(all).add<Self>(
        "training", &Self::training, OptionTable::Traits::oneOf({"incremental", "batch", "sgd"}),
        "scan by scan with a posterior, all points together, or a few epochs of descent a scan");
    addFeatureOptions<Self>(all);
    return all;
  }();
  return table;
}

std::vector<std::string> CHilbertMap::TCreationOptions::foreignFlags() const
{
  return genericMapKeys();
}

const OptionTable& CHilbertMap::TInsertionOptions::optionTable() const
{
  using Self = TInsertionOptions;
  static const OptionTable table = []
  {
    OptionTable all("insertOpts");
    addSamplingOptions<Self>(all);
    addRangeOptions<Self>(all);
    all.add<Self>("solver", &Self::solver, OptionTable::Traits::oneOf({"lbfgs", "sgdL1", "sgdL2"}),
                  "what minimizes the loss");
    addSolverOptions<Self>(all);
    addUncertaintyOptions<Self>(all);
    addThresholdOptions<Self>(all);
    return all;
  }();
  return table;
}

CHilbertMap::TInsertionOptions CHilbertMap::TInsertionOptions::resolved(
    const HilbertStructure& structure) const
{
  HilbertInference::validate(structure);
  TInsertionOptions filled = *this;
  filled.solver = solverFor(structure.training);
  filled.iterations = iterationsFor(structure.training);
  return filled;
}

// ---- Definition
// ------------------------------------------------------------------------------------------------------

CHilbertMap::TMapDefinition::TMapDefinition() = default;

void CHilbertMap::TMapDefinition::usePreset()
{
  static_cast<HilbertStructure&>(creationOpts) = {};
  static_cast<HilbertInference&>(insertionOpts) = {};
  if (creationOpts.preset == Preset::Default) return;
  creationOpts.training = HilbertTraining::Batch;
  creationOpts.features = HilbertFeatures::Nystroem;
  insertionOpts.solver = HilbertSolver::SgdL1;
  insertionOpts.trainingPoints = HilbertPoints::Points;
  insertionOpts.freeMargin = 0.0;
  insertionOpts.freeResolution = 0.5;
  insertionOpts.hitWeight = 1.0;
  insertionOpts.considerInvalidRangesAsFreeSpace = false;
}

CHilbertMap::TInsertionOptions CHilbertMap::TMapDefinition::resolvedInsertion() const
{
  return insertionOpts.resolved(creationOpts);
}

void CHilbertMap::TMapDefinition::loadFromConfigFile_map_specific(const mrpt::config::CConfigFileBase& source,
                                                                  const std::string& sectionNamePrefix)
{
  loadDefinition(*this, source, sectionNamePrefix);
}

void CHilbertMap::TMapDefinition::saveToConfigFile(mrpt::config::CConfigFileBase& target,
                                                   const std::string& sectionPrefix) const
{
  saveDefinition(*this, target, sectionPrefix);
}

void CHilbertMap::TMapDefinition::dumpToTextStream_map_specific(std::ostream& out) const
{
  dumpDefinition(*this, out);
}

compat::CreatedMap CHilbertMap::internal_CreateFromMapDefinition(
    const mrpt::maps::TMetricMapInitializer& initializer)
{
  return createDefined<CHilbertMap>(initializer);
}

// ---- The map
// ---------------------------------------------------------------------------------------------------------

CHilbertMap::CHilbertMap(double resolution_m)
    : CHilbertMap(
          [&]
          {
            TCreationOptions options;
            options.resolution = resolution_m;
            return options;
          }())
{
}

CHilbertMap::CHilbertMap(const TCreationOptions& options)
    : insertionOptions(TInsertionOptions().resolved(options)), creationOptions_(options), map_(options)
{
  creationOptions_.gamma = options.kernel().gamma();
  setLoggerName("lamap::CHilbertMap");
}

CellEstimate CHilbertMap::estimate(double logodds) const
{
  CellEstimate cell;
  cell.prob = logistic(logodds);
  cell.state = stateOf(cell.prob, insertionOptions.thresholds);
  cell.evidence = {logodds, 0};
  return cell;
}

std::optional<CellEstimate> CHilbertMap::estimateAt(const mrpt::math::TPoint3D& point_map) const
{
  const auto logodds = map_.logoddsAt(Eigen::Vector3d(point_map.x, point_map.y, point_map.z));
  if (!logodds) return std::nullopt;
  return estimate(*logodds);
}

std::optional<CellEstimate> CHilbertMap::estimateCell(const CellIndex& cell) const
{
  const auto logodds = map_.logoddsOf(cell);
  if (!logodds) return std::nullopt;
  return estimate(*logodds);
}

std::optional<double> CHilbertMap::expectedLogoddsAt(const mrpt::math::TPoint3D& point_map,
                                                     const mrpt::math::CMatrixDouble33& covariance) const
{
  return map_.logoddsAt(Eigen::Vector3d(point_map.x, point_map.y, point_map.z), covariance.asEigen());
}

void CHilbertMap::visitCells(const CellVisitor& visitor) const
{
  map_.visitCells([&](const CellIndex& cell, double logodds) { visitor(cell, estimate(logodds)); },
                  threadCount());
}

std::vector<CLearnedMap::Fact> CHilbertMap::facts() const
{
  std::vector<Fact> facts = cellFacts();
  facts.push_back({"weights", std::to_string(map_.weightCount()), ""});
  if (map_.structure().training == HilbertTraining::Batch)
    facts.push_back({"training points", std::to_string(map_.trainingPointCount()), ""});
  facts.push_back(memoryFact());
  const std::vector<Fact> ofScans = scanFacts();
  facts.insert(facts.end(), ofScans.begin(), ofScans.end());
  return facts;
}

RayCounts CHilbertMap::learnScan(const Scan& scan, const ScanPose& pose)
{
  const auto uncertainty = insertionOptions.of(pose);
  return map_.insert(scan, insertionOptions, uncertainty ? &*uncertainty : nullptr, threadCount());
}

std::optional<int32_t> CHilbertMap::planarLayer() const
{
  return map_.structure().planarLayer();
}

void CHilbertMap::updateVoxel(double /*x*/, double /*y*/, double /*z*/, bool /*occupied*/)
{
  throw std::logic_error(
      "updateVoxel: the cells of a lamap::CHilbertMap are a view of its model and cannot be written; insert "
      "observations or rays, or use a lamap::CBGKMap or lamap::COverlappingHilbertMap");
}

void CHilbertMap::visitOptionGroups(const VisitGroup& visit) const
{
  visitGroups(creationOptions_, insertionOptions.resolved(map_.structure()), *this, visit);
}

void CHilbertMap::internal_clear()
{
  map_.clear();
  contentChanged();
}

// ---- Serialization
// ---------------------------------------------------------------------------------------------------

uint8_t CHilbertMap::serializeGetVersion() const
{
  return kFormatVersion;
}

void CHilbertMap::serializeTo(mrpt::serialization::CArchive& out) const
{
  ByteWriter content;
  creationOptions_.write(content);
  writeHilbertState(map_.state(), content);
  writeOptions(insertionOptions.resolved(map_.structure()), *this, content);
  writePayload(out, content.bytes());
}

void CHilbertMap::serializeFrom(mrpt::serialization::CArchive& in, uint8_t version)
{
  if (version != kFormatVersion) refuseVersion(className, version, kFormatVersion);
  const std::vector<uint8_t> payload = readPayload(in);
  ByteReader content(payload);
  // Everything is read before anything changes.
  TCreationOptions creation;
  creation.read(content);
  try
  {
    HilbertMap map(creation);
    map.restore(readHilbertState(content));
    TInsertionOptions insertion;
    const StoredOptions others = readOptions(insertion, content);
    content.expectEnd();
    insertion = insertion.resolved(creation);

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
