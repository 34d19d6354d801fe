#pragma once

#include <lamap_mrpt/compat/mrpt_compat.h>
#include <lamap_mrpt/maps/map_sections.h>
#include <lamap_mrpt/options/option_table.h>
#include <mrpt/maps/TMetricMapInitializer.h>

#include <memory>
#include <ostream>
#include <stdexcept>
#include <string>

// What the definitions of all learned maps do alike. A definition has the groups creationOpts, insertionOpts,
// likelihoodOpts and renderingOpts, and
//   void usePreset()                       sets creation and insertion options to what creationOpts.preset
//   names TInsertionOptions resolvedInsertion()  insertion options as they hold for a map of these creation
//   options,
//                                          lengths that are given in cells in metres; throws
//                                          std::invalid_argument if the two do not fit together
namespace lamap
{
/// What the preset of a definition leaves its options at, at the definition's resolution.
template <typename Definition>
Definition presetOf(const Definition& definition)
{
  Definition preset;
  preset.creationOpts.preset = definition.creationOpts.preset;
  preset.usePreset();
  try
  {
    auto resolving = preset;
    resolving.creationOpts.resolution = definition.creationOpts.resolution;
    preset.insertionOpts = resolving.resolvedInsertion();
  }
  catch (const std::invalid_argument&)
  {
    // Lengths of the preset do not fit this resolution: the definition has others, and these stay as they
    // are.
  }
  return preset;
}

/// Warns of what a source sets though it has no effect. @param source, prefix  where the definition was read
template <typename Definition>
void warnOfIdleSettings(const Definition& definition, const mrpt::config::CConfigFileBase& source,
                        const std::string& prefix)
{
  const Definition preset = presetOf(definition);
  const auto insertion = definition.resolvedInsertion();
  const auto messages = settingsWithoutEffect(
      source, {{prefix + kCreationSection, &definition.creationOpts, &preset.creationOpts},
               {prefix + kInsertSection, &insertion, &preset.insertionOpts}});
  for (const std::string& message : messages)
    warnOnce(definition.getMetricMapClassType()->className + (": " + message));
}

/** Reads a definition: a preset is applied first, wherever it stands. Warns of settings without effect.
 * @param prefix of its sections, e.g. "map_bgkMap_00"
 * @throws std::invalid_argument naming file, section, key and text, and what would be right. */
template <typename Definition>
void loadDefinition(Definition& definition, const mrpt::config::CConfigFileBase& source,
                    const std::string& prefix)
{
  requireKnownSections(source, prefix);
  const std::string creationSection = prefix + kCreationSection;
  const std::string insertSection = prefix + kInsertSection;
  requireOptionsInTheirSections(source, {{creationSection, &definition.creationOpts},
                                         {insertSection, &definition.insertionOpts},
                                         {prefix + kLikelihoodSection, &definition.likelihoodOpts},
                                         {prefix + kRenderSection, &definition.renderingOpts}});
  if (hasKey(source, creationSection, "preset"))
  {
    definition.creationOpts.loadFromConfigFile(source, creationSection);
    definition.usePreset();
  }
  definition.creationOpts.loadFromConfigFile(source, creationSection);
  definition.insertionOpts.loadFromConfigFile(source, insertSection);
  definition.likelihoodOpts.loadFromConfigFile(source, prefix + kLikelihoodSection);
  definition.renderingOpts.loadFromConfigFile(source, prefix + kRenderSection);
  try
  {
    (void)definition.resolvedInsertion();
  }
  catch (const std::invalid_argument& error)
  {
    throw std::invalid_argument(
        withoutBrackets("section \"" + insertSection + "\" of " + nameOf(source) + ": " + error.what()));
  }
  warnOfIdleSettings(definition, source, prefix);
}

/// As loadDefinition() reads it.
template <typename Definition>
void saveDefinition(const Definition& definition, mrpt::config::CConfigFileBase& target,
                    const std::string& prefix)
{
  definition.creationOpts.saveToConfigFile(target, prefix + kCreationSection);
  definition.genericMapParams.saveToConfigFile(target, prefix + kCreationSection);
  definition.resolvedInsertion().saveToConfigFile(target, prefix + kInsertSection);
  definition.likelihoodOpts.saveToConfigFile(target, prefix + kLikelihoodSection);
  definition.renderingOpts.saveToConfigFile(target, prefix + kRenderSection);
}

template <typename Definition>
void dumpDefinition(const Definition& definition, std::ostream& out)
{
  definition.creationOpts.dumpToTextStream(out);
  definition.resolvedInsertion().dumpToTextStream(out);
  definition.likelihoodOpts.dumpToTextStream(out);
  definition.renderingOpts.dumpToTextStream(out);
}

/// Makes the map that a definition of its class asks for.
template <typename Map>
compat::CreatedMap createDefined(const mrpt::maps::TMetricMapInitializer& initializer)
{
  const auto& definition = dynamic_cast<const typename Map::TMapDefinition&>(initializer);
  auto map = std::make_unique<Map>(definition.creationOpts);
  map->insertionOptions = definition.resolvedInsertion();
  map->likelihoodOptions = definition.likelihoodOpts;
  map->renderingOptions = definition.renderingOpts;
  map->genericMapParams = definition.genericMapParams;
  return compat::handOver(std::move(map));
}

}  // namespace lamap
