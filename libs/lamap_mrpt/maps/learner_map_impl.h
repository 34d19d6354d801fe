#pragma once

#include <lamap_mrpt/files/payload.h>
#include <lamap_mrpt/learned_map/cell_walk.h>
#include <lamap_mrpt/learned_map/end_point_likelihood.h>
#include <lamap_mrpt/maps/learner_map.h>
#include <lamap_mrpt/maps/uncertain_inputs.h>
#include <lamap_mrpt/options/map_sections.h>

#include <cmath>
#include <memory>
#include <ostream>
#include <stdexcept>
#include <type_traits>
#include <utility>

// The members of LearnerMap, for the sources that instantiate it.
namespace lamap
{
// ---- Options

template <typename Learner>
const OptionTable& LearnerMap<Learner>::TCreationOptions::optionTable() const
{
  static const OptionTable table = []
  {
    OptionTableOf<TCreationOptions> all("creationOpts");
    return all
        .add("preset", &TCreationOptions::preset, oneOf(Learner::kPresets),
             "named set of options, applied before all others wherever it stands")
        .template include<typename Learner::Creation>();
  }();
  return table;
}

template <typename Learner>
std::vector<std::string> LearnerMap<Learner>::TCreationOptions::foreignFlags() const
{
  return genericMapKeys();
}

template <typename Learner>
const OptionTable& LearnerMap<Learner>::TInsertionOptions::optionTable() const
{
  static const OptionTable table =
      OptionTableOf<TInsertionOptions>("insertOpts").template include<Insertion>();
  return table;
}

template <typename Learner>
void LearnerMap<Learner>::visitOptionGroups(const VisitGroup& visit) const
{
  TCreationOptions newCreation;
  visit(creationOptions_, newCreation);
  TInsertionOptions newInsertion;
  visit(resolvedInsertion(), newInsertion);
  TLikelihoodOptions newLikelihood;
  visit(likelihoodOptions, newLikelihood);
  TRenderingOptions newRendering;
  visit(renderingOptions, newRendering);
}

// ---- Definition

template <typename Learner>
LearnerMap<Learner>::TMapDefinition::TMapDefinition() : TMetricMapInitializer(CLASS_ID(Map))
{
}

template <typename Learner>
void LearnerMap<Learner>::TMapDefinition::usePreset()
{
  const auto preset = presetOptions(creationOpts.preset);
  static_cast<Structure&>(creationOpts) = preset.structure;
  static_cast<Insertion&>(insertionOpts) = preset.inference;
}

template <typename Learner>
typename LearnerMap<Learner>::TInsertionOptions LearnerMap<Learner>::TMapDefinition::resolvedInsertion() const
{
  Learner::validate(insertionOpts, creationOpts);
  return TInsertionOptions(Learner::resolved(insertionOpts, creationOpts));
}

/// What the preset leaves the options at, at this definition's resolution.
template <typename Learner>
typename LearnerMap<Learner>::TMapDefinition LearnerMap<Learner>::TMapDefinition::untouched() const
{
  TMapDefinition preset;
  preset.creationOpts.preset = creationOpts.preset;
  preset.usePreset();
  try
  {
    TMapDefinition resolving = preset;
    resolving.creationOpts.resolution = creationOpts.resolution;
    preset.insertionOpts = resolving.resolvedInsertion();
  }
  catch (const std::invalid_argument&)
  {
    // Lengths of the preset do not fit this resolution: the definition has others, and these stay as they
    // are.
  }
  return preset;
}

/// Warns of what a source sets though it has no effect.
template <typename Learner>
void LearnerMap<Learner>::TMapDefinition::warnOfIdleSettings(const mrpt::config::CConfigFileBase& source,
                                                             const std::string& prefix) const
{
  const TMapDefinition preset = untouched();
  const TInsertionOptions insertion = resolvedInsertion();
  for (const std::string& message :
       settingsWithoutEffect(source, {{prefix + kCreationSection, &creationOpts, &preset.creationOpts},
                                      {prefix + kInsertSection, &insertion, &preset.insertionOpts}}))
    warnOnce(Map::className + (": " + message));
}

template <typename Learner>
void LearnerMap<Learner>::TMapDefinition::loadFromConfigFile_map_specific(
    const mrpt::config::CConfigFileBase& source, const std::string& prefix)
{
  const std::string creationSection = prefix + kCreationSection;
  const std::string insertSection = prefix + kInsertSection;
  requireKnownSections(source, prefix);
  requireOptionsInTheirSections(source, {{creationSection, &creationOpts},
                                         {insertSection, &insertionOpts},
                                         {prefix + kLikelihoodSection, &likelihoodOpts},
                                         {prefix + kRenderSection, &renderingOpts}});
  if (hasKey(source, creationSection, "preset"))
  {
    creationOpts.loadFromConfigFile(source, creationSection);
    usePreset();
  }
  creationOpts.loadFromConfigFile(source, creationSection);
  insertionOpts.loadFromConfigFile(source, insertSection);
  likelihoodOpts.loadFromConfigFile(source, prefix + kLikelihoodSection);
  renderingOpts.loadFromConfigFile(source, prefix + kRenderSection);
  try
  {
    (void)resolvedInsertion();
  }
  catch (const std::invalid_argument& error)
  {
    throw std::invalid_argument(
        withoutBrackets("section \"" + insertSection + "\" of " + nameOf(source) + ": " + error.what()));
  }
  warnOfIdleSettings(source, prefix);
}

template <typename Learner>
void LearnerMap<Learner>::TMapDefinition::saveToConfigFile(mrpt::config::CConfigFileBase& target,
                                                           const std::string& prefix) const
{
  creationOpts.saveToConfigFile(target, prefix + kCreationSection);
  saveGenericParams(genericMapParams, target, prefix + kCreationSection);
  resolvedInsertion().saveToConfigFile(target, prefix + kInsertSection);
  likelihoodOpts.saveToConfigFile(target, prefix + kLikelihoodSection);
  renderingOpts.saveToConfigFile(target, prefix + kRenderSection);
}

template <typename Learner>
void LearnerMap<Learner>::TMapDefinition::dumpToTextStream_map_specific(std::ostream& out) const
{
  creationOpts.dumpToTextStream(out);
  resolvedInsertion().dumpToTextStream(out);
  likelihoodOpts.dumpToTextStream(out);
  renderingOpts.dumpToTextStream(out);
}

template <typename Learner>
compat::CreatedDefinition LearnerMap<Learner>::MapDefinition()
{
  return compat::handOver<compat::CreatedDefinition>(std::make_unique<TMapDefinition>());
}

namespace detail
{
template <typename Map>
std::unique_ptr<Map> createDefined(const typename Map::TMapDefinition& definition)
{
  auto map = std::make_unique<Map>(definition.creationOpts);
  map->insertionOptions = definition.resolvedInsertion();
  map->likelihoodOptions = definition.likelihoodOpts;
  map->renderingOptions = definition.renderingOpts;
  map->genericMapParams = definition.genericMapParams;
  return map;
}
}  // namespace detail

template <typename Learner>
compat::CreatedOf<typename LearnerMap<Learner>::Map> LearnerMap<Learner>::CreateFromMapDefinition(
    const mrpt::maps::TMetricMapInitializer& definition)
{
  return compat::handOver<compat::CreatedOf<Map>>(
      detail::createDefined<Map>(dynamic_cast<const TMapDefinition&>(definition)));
}

template <typename Learner>
compat::CreatedMap LearnerMap<Learner>::internal_CreateFromMapDefinition(
    const mrpt::maps::TMetricMapInitializer& definition)
{
  return compat::handOver(detail::createDefined<Map>(dynamic_cast<const TMapDefinition&>(definition)));
}

/// Makes a class known to MRPT. For a static object that stands after IMPLEMENTS_SERIALIZABLE: registering
/// before the class's own static data is there would go wrong.
template <typename Learner>
struct MapRegistration
{
  MapRegistration()
  {
    using Map = typename Learner::Map;
    mrpt::maps::internal::TMetricMapTypesRegistry::Instance().doRegister(
        std::string(Learner::kAlias) + "," + Map::className, &Map::MapDefinition,
        &Map::internal_CreateFromMapDefinition);
    mrpt::rtti::registerClass(CLASS_ID(Map));
  }
};

// ---- The map

template <typename Learner>
LearnerMap<Learner>::LearnerMap(double resolution_m)
    : LearnerMap(
          [&]
          {
            TCreationOptions options;
            options.resolution = resolution_m;
            return options;
          }())
{
}

template <typename Learner>
LearnerMap<Learner>::LearnerMap(const TCreationOptions& options)
    : creationOptions_(options), map_(Learner::make(options))
{
  options.validate();  // what is not the learner's: the preset
  insertionOptions = TInsertionOptions(Learner::resolved({}, options));
  static_cast<Structure&>(creationOptions_) = map_.structure();
  setLoggerName(Map::className);
}

template <typename Learner>
LearnerMap<Learner>& LearnerMap<Learner>::operator=(const LearnerMap& other)
{
  if (this == &other) return *this;
  TCreationOptions creation = other.creationOptions_;
  Core map = other.map_;
  CLearnedMap::operator=(other);
  insertionOptions = other.insertionOptions;
  creationOptions_ = std::move(creation);
  map_ = std::move(map);
  return *this;
}

template <typename Learner>
typename LearnerMap<Learner>::TInsertionOptions LearnerMap<Learner>::resolvedInsertion() const
{
  return TInsertionOptions(Learner::resolved(insertionOptions, creationOptions_));
}

template <typename Learner>
std::optional<CellEstimate> LearnerMap<Learner>::estimateAt(const mrpt::math::TPoint3D& point_map) const
{
  return map_.at({point_map.x, point_map.y, point_map.z}, insertionOptions.thresholds);
}

template <typename Learner>
std::optional<CellEstimate> LearnerMap<Learner>::estimateCell(const CellIndex& cell) const
{
  return map_.cell(cell, insertionOptions.thresholds);
}

template <typename Learner>
void LearnerMap<Learner>::visitCells(const CellVisitor& visitor) const
{
  map_.visitCells(insertionOptions.thresholds, visitor);
}

template <typename Learner>
std::optional<std::pair<CellIndex, CellIndex>> LearnerMap<Learner>::cellBounds() const
{
  return map_.cellBounds();
}

template <typename Learner>
int LearnerMap<Learner>::emptyAround(const CellIndex& cell) const
{
  return map_.emptyAround(cell);
}

template <typename Learner>
std::vector<CLearnedMap::Fact> LearnerMap<Learner>::factsWith(std::vector<Fact> ofCells,
                                                              const std::vector<Fact>& own) const
{
  std::vector<Fact> facts = std::move(ofCells);
  facts.insert(facts.end(), own.begin(), own.end());
  constexpr double kMiB = 1024 * 1024;
  facts.push_back({"memory", std::round(1000 * static_cast<double>(memoryBytes()) / kMiB) / 1000, "MiB"});
  if (map_.structure().planar) facts.push_back({"planar, at height", map_.structure().planarHeight, "m"});
  const std::vector<Fact> ofScans = scanFacts();
  facts.insert(facts.end(), ofScans.begin(), ofScans.end());
  return facts;
}

template <typename Learner>
RayCounts LearnerMap<Learner>::learnScan(const Scan& scan)
{
  if constexpr (std::is_base_of_v<UncertainInputs, Insertion>)
  {
    const auto uncertainty = uncertaintyOf(insertionOptions, scan);
    return map_.insert(scan, insertionOptions, uncertainty ? &*uncertainty : nullptr, threadCount());
  }
  else
  {
    if (insertionOptions.usePoseCovariance) warnWithoutCovariance(scan);
    return map_.insert(scan, insertionOptions, threadCount());
  }
}

namespace detail
{
template <typename Core, typename = void>
struct HasAccessor : std::false_type
{
};
template <typename Core>
struct HasAccessor<Core, std::void_t<typename Core::Accessor>> : std::true_type
{
};

template <typename Core>
RayWalk followIn(const Core& map, const RayStretch& ray, const StateThresholds& thresholds)
{
  typename Core::Accessor accessor(map, thresholds);
  return followRay(
      ray, map.structure().resolution, [&](const CellIndex& cell) { return accessor.state(cell); },
      [&](const CellIndex&) { return accessor.emptyAroundLast(); });
}

template <typename Core>
class ProbsIn : public CellProbs
{
 public:
  explicit ProbsIn(const Core& map) : accessor_(map) {}
  std::optional<double> prob(const CellIndex& cell) override { return accessor_.prob(cell); }

 private:
  typename Core::Accessor accessor_;
};
}  // namespace detail

template <typename Learner>
RayWalk LearnerMap<Learner>::follow(const RayStretch& ray) const
{
  if constexpr (detail::HasAccessor<Core>::value)
    return detail::followIn(map_, ray, insertionOptions.thresholds);
  else
    return CLearnedMap::follow(ray);
}

template <typename Learner>
void LearnerMap<Learner>::withProbs(const UseProbs& use) const
{
  if constexpr (detail::HasAccessor<Core>::value)
  {
    detail::ProbsIn<Core> probs(map_);
    use(probs);
  }
  else
    CLearnedMap::withProbs(use);
}

template <typename Learner>
void LearnerMap<Learner>::internal_clear()
{
  map_.clear();
  contentChanged();
}

// ---- Serialization

template <typename Learner>
uint8_t LearnerMap<Learner>::serializeGetVersion() const
{
  return Learner::kFormatVersion;
}

template <typename Learner>
void LearnerMap<Learner>::validateOptions() const
{
  Learner::validate(insertionOptions, creationOptions_);
  likelihoodOptions.validate();
  renderingOptions.validate();
}

template <typename Learner>
void LearnerMap<Learner>::serializeTo(mrpt::serialization::CArchive& out) const
{
  validateOptions();  // a file with an illegal option would be refused when it is read
  ByteWriter content;
  creationOptions_.write(content);
  Learner::write(map_, content);
  resolvedInsertion().write(content);
  likelihoodOptions.write(content);
  renderingOptions.write(content);
  content.number(genericMapParams.enableSaveAs3DObject);
  content.number(genericMapParams.enableObservationLikelihood);
  content.number(genericMapParams.enableObservationInsertion);
  writePayload(out, content.bytes());
}

template <typename Learner>
void LearnerMap<Learner>::serializeFrom(mrpt::serialization::CArchive& in, uint8_t version)
{
  if (version < 1 || version > Learner::kFormatVersion)
    refuseVersion(Map::className, version, Learner::kFormatVersion);
  const std::vector<uint8_t> payload = readPayload(in);
  ByteReader content(payload);
  try
  {
    // Everything is read before anything changes.
    TCreationOptions creation;
    Learner::setAsBefore(creation, version);
    creation.read(content);
    Core map(creation);
    Learner::read(map, content, version);
    TInsertionOptions insertion;
    if (version == 1) insertion.beamWidth = BeamWidth::None;  // such files do not hold it
    insertion.read(content);
    Learner::validate(insertion, creation);
    insertion = TInsertionOptions(Learner::resolved(insertion, creation));
    TLikelihoodOptions likelihood;
    likelihood.read(content);
    TRenderingOptions rendering;
    rendering.read(content);
    mrpt::maps::TMapGenericParams generic;
    generic.enableSaveAs3DObject = content.number<bool>();
    generic.enableObservationLikelihood = content.number<bool>();
    generic.enableObservationInsertion = content.number<bool>();
    content.expectEnd();
    if (const size_t dropped = Learner::settle(map, insertion, threadCount()); dropped > 0)
      MRPT_LOG_WARN_STREAM(
          "scans of the file that waited for others are left out, for they are too long for "
          "the map's cells: "
          << dropped);

    creationOptions_ = creation;
    map_ = std::move(map);
    insertionOptions = insertion;
    likelihoodOptions = likelihood;
    renderingOptions = rendering;
    genericMapParams = generic;
  }
  catch (const std::invalid_argument& error)
  {
    content.fail(error.what());
  }
  contentChanged();
}

}  // namespace lamap
