#include <lamap_mrpt/maps/COverlappingHilbertMap.h>

#include <lamap_mrpt/files/overlapping_map_content.h>
#include <lamap_mrpt/files/payload.h>
#include <lamap_mrpt/maps/map_definition.h>
#include <lamap_mrpt/maps/map_sections.h>
#include <lamap_mrpt/observations/isometry.h>
#include <lamap_mrpt/options/hilbert_option_tables.h>
#include <lamap_mrpt/options/shared_options.h>

#include <stdexcept>

namespace lamap
{
IMPLEMENTS_SERIALIZABLE(COverlappingHilbertMap, mrpt::maps::CMetricMap, lamap)
MAP_DEFINITION_REGISTER("overlappingHilbertMap,lamap::COverlappingHilbertMap", lamap::COverlappingHilbertMap)

namespace
{
/// Stands after the macros: registering before the class's own static data is there would go wrong.
struct Registration
{
  Registration() { mrpt::rtti::registerClass(CLASS_ID(lamap::COverlappingHilbertMap)); }
} const registration;

constexpr uint8_t kFormatVersion = 1;
}  // namespace

// ---- Options
// ---------------------------------------------------------------------------------------------------------

const OptionTable& COverlappingHilbertMap::TCreationOptions::optionTable() const
{
  using Self = TCreationOptions;
  static const OptionTable table = []
  {
    OptionTable all("creationOpts");
    all.add<Self>("preset", &Self::preset, OptionTable::Traits::oneOf({"default", "thesis"}),
                  "named set of options, applied before all others");
    addResolutionOption<Self>(all);
    addBlockOptions<Self>(all);
    addPlanarOptions<Self>(all);
    addFeatureOptions<Self>(all)
        .add<Self>("outOfFieldLimit", &Self::outOfFieldLimit, {"", {0, 1e3}},
                   "log-odds that cells no scan had in its field are held to; 0: models are silent there")
        .add<Self>("keepModels", &Self::keepModels, {},
                   "for queries at points and for moving models; else cells are all there is")
        .onlyWhere({"cutoff", "latticeSpacing"}, {{"features", {"compact"}}});
    return all;
  }();
  return table;
}

std::vector<std::string> COverlappingHilbertMap::TCreationOptions::foreignFlags() const
{
  return genericMapKeys();
}

const OptionTable& COverlappingHilbertMap::TInsertionOptions::optionTable() const
{
  using Self = TInsertionOptions;
  const LegalRange fromZero{0, kMetresMost};
  static const OptionTable table = [&]
  {
    OptionTable all("insertOpts");
    addSamplingOptions<Self>(all);
    addRangeOptions<Self>(all);
    all.add<Self>("solver", &Self::solver, OptionTable::Traits::oneOf({"lbfgs", "sgdL1", "sgdL2"}),
                  "what minimizes the loss");
    addSolverOptions<Self>(all)
        .add<Self>("scansPerModel", &Self::scansPerModel, {"", {1, 1e6}},
                   "scans that one model is trained on together")
        .add<Self>("boxQuantile", &Self::boxQuantile, {"", {0, 0.4999}},
                   "share of the training points left out of a model's box at each of its ends")
        .add<Self>("fieldNear", &Self::fieldNear, {"m", fromZero},
                   "cells so near to the sensor are in its field")
        .add<Self>("fieldDepth", &Self::fieldDepth, {"m", fromZero},
                   "the field reaches so far behind the end of a ray")
        .add<Self>("fieldAngle", &Self::fieldAngle, {"deg", {0.1, 90}},
                   "edge of the bins of directions that share a depth")
        .add<Self>("fieldWeight", &Self::fieldWeight, {"", {0, 1e3, false}},
                   "weight of log-odds in the field");
    addUncertaintyOptions<Self>(all);
    addThresholdOptions<Self>(all);
    return all;
  }();
  return table;
}

// ---- Definition
// ------------------------------------------------------------------------------------------------------

COverlappingHilbertMap::TMapDefinition::TMapDefinition() = default;

void COverlappingHilbertMap::TMapDefinition::usePreset()
{
  const OverlappingOptions preset = presetOptions(creationOpts.preset);
  static_cast<OverlappingStructure&>(creationOpts) = preset.structure;
  static_cast<OverlappingInference&>(insertionOpts) = preset.inference;
}

COverlappingHilbertMap::TInsertionOptions COverlappingHilbertMap::TMapDefinition::resolvedInsertion() const
{
  insertionOpts.validate();
  return insertionOpts;
}

void COverlappingHilbertMap::TMapDefinition::loadFromConfigFile_map_specific(
    const mrpt::config::CConfigFileBase& source, const std::string& sectionNamePrefix)
{
  loadDefinition(*this, source, sectionNamePrefix);
}

void COverlappingHilbertMap::TMapDefinition::saveToConfigFile(mrpt::config::CConfigFileBase& target,
                                                              const std::string& sectionPrefix) const
{
  saveDefinition(*this, target, sectionPrefix);
}

void COverlappingHilbertMap::TMapDefinition::dumpToTextStream_map_specific(std::ostream& out) const
{
  dumpDefinition(*this, out);
}

compat::CreatedMap COverlappingHilbertMap::internal_CreateFromMapDefinition(
    const mrpt::maps::TMetricMapInitializer& initializer)
{
  return createDefined<COverlappingHilbertMap>(initializer);
}

// ---- The map
// ---------------------------------------------------------------------------------------------------------

COverlappingHilbertMap::COverlappingHilbertMap(double resolution_m)
    : COverlappingHilbertMap(
          [&]
          {
            TCreationOptions options;
            options.resolution = resolution_m;
            return options;
          }())
{
}

COverlappingHilbertMap::COverlappingHilbertMap(const TCreationOptions& options)
    : creationOptions_(options), map_(options)
{
  creationOptions_.gamma = options.resolvedGamma();
  setLoggerName("lamap::COverlappingHilbertMap");
}

void COverlappingHilbertMap::cellsChanged()
{
  withPending_.reset();
  contentChanged();
}

std::shared_ptr<const OverlappingHilbertMap> COverlappingHilbertMap::whole() const
{
  // Nobody owns the map that is handed out where no scans wait.
  if (map_.pending().scans.empty()) return {std::shared_ptr<void>(), &map_};
  return withPending_.get([](const OverlappingHilbertMap&) { return true; },
                          [&]
                          {
                            auto trained = std::make_shared<OverlappingHilbertMap>(map_);
                            trained->trainPending(insertionOptions, threadCount());
                            return trained;
                          });
}

void COverlappingHilbertMap::merge(const COverlappingHilbertMap& other)
{
  map_.merge(other.map_, insertionOptions.thresholds);
  cellsChanged();
}

mrpt::poses::CPose3D COverlappingHilbertMap::modelPose(size_t model) const
{
  return poseOf(map_.modelPose(model));
}

void COverlappingHilbertMap::setModelPose(size_t model, const mrpt::poses::CPose3D& sensor_map)
{
  map_.setModelPose(model, isometryOf(sensor_map), insertionOptions.thresholds, threadCount());
  cellsChanged();
}

std::optional<CellEstimate> COverlappingHilbertMap::estimateAt(const mrpt::math::TPoint3D& point_map) const
{
  const Eigen::Vector3d point(point_map.x, point_map.y, point_map.z);
  return map_.structure().keepModels ? whole()->continuousAt(point, insertionOptions.thresholds)
                                     : whole()->at(point, insertionOptions.thresholds);
}

std::optional<CellEstimate> COverlappingHilbertMap::estimateCell(const CellIndex& cell) const
{
  return whole()->cell(cell, insertionOptions.thresholds);
}

void COverlappingHilbertMap::visitCells(const CellVisitor& visitor) const
{
  whole()->visitCells(insertionOptions.thresholds, visitor);
}

std::vector<CLearnedMap::Fact> COverlappingHilbertMap::facts() const
{
  std::vector<Fact> facts = cellFacts();
  facts.push_back({"blocks", std::to_string(map_.grid().blockCount()), ""});
  facts.push_back({"models", std::to_string(map_.modelCount()), ""});
  if (!map_.pending().scans.empty())
    facts.push_back({"scans that wait for others", std::to_string(map_.pending().scans.size()), ""});
  facts.push_back(memoryFact());
  const std::vector<Fact> ofScans = scanFacts();
  facts.insert(facts.end(), ofScans.begin(), ofScans.end());
  return facts;
}

RayCounts COverlappingHilbertMap::learnScan(const Scan& scan, const ScanPose& pose)
{
  const auto uncertainty = insertionOptions.of(pose);
  std::optional<Eigen::Isometry3d> sensor;
  // Where no model can stand no ray can begin: then the rays are counted and left out.
  if (pose.sensor_map &&
      ModelPose::isLegal(isometryOf(*pose.sensor_map), resolution(), creationOptions_.planar))
    sensor = isometryOf(*pose.sensor_map);
  withPending_.reset();
  return map_.insert(scan, insertionOptions, sensor, uncertainty ? &*uncertainty : nullptr, threadCount());
}

std::optional<int32_t> COverlappingHilbertMap::planarLayer() const
{
  if (!map_.structure().planar) return std::nullopt;
  return map_.planarLayer();
}

void COverlappingHilbertMap::updateVoxel(double x, double y, double z, bool occupied)
{
  const double weight = occupied ? insertionOptions.hitWeight : -insertionOptions.freeWeight;
  map_.addEvidence(addressableCell("updateVoxel", x, y, z), insertionOptions.fieldWeight * weight,
                   insertionOptions.thresholds);
  cellsChanged();
}

void COverlappingHilbertMap::visitOptionGroups(const VisitGroup& visit) const
{
  visitGroups(creationOptions_, insertionOptions, *this, visit);
}

void COverlappingHilbertMap::internal_clear()
{
  map_.clear();
  cellsChanged();
}

// ---- Serialization
// ---------------------------------------------------------------------------------------------------

uint8_t COverlappingHilbertMap::serializeGetVersion() const
{
  return kFormatVersion;
}

void COverlappingHilbertMap::serializeTo(mrpt::serialization::CArchive& out) const
{
  ByteWriter content;
  creationOptions_.write(content);
  writeOverlappingMap(map_, content);
  writeOptions(insertionOptions, *this, content);
  writePayload(out, content.bytes());
}

void COverlappingHilbertMap::serializeFrom(mrpt::serialization::CArchive& in, uint8_t version)
{
  if (version != kFormatVersion) refuseVersion(className, version, kFormatVersion);
  const std::vector<uint8_t> payload = readPayload(in);
  ByteReader content(payload);
  // Everything is read before anything changes.
  TCreationOptions creation;
  creation.read(content);
  try
  {
    OverlappingHilbertMap map(creation);
    readOverlappingMap(map, content);
    TInsertionOptions insertion;
    const StoredOptions others = readOptions(insertion, content);
    content.expectEnd();
    insertion.validate();

    creationOptions_ = creation;
    map_ = std::move(map);
    insertionOptions = insertion;
    others.handTo(*this);
  }
  catch (const std::invalid_argument& error)
  {
    content.fail(error.what());
  }
  cellsChanged();
}

}  // namespace lamap
