#include <lamap_mrpt/maps/map_sections.h>
#include <lamap_mrpt/options/nearest_name.h>

#include <algorithm>
#include <cctype>
#include <iostream>
#include <mutex>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>

namespace lamap
{
namespace
{
bool sameIgnoringCase(const std::string& a, const std::string& b)
{
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](unsigned char x, unsigned char y) { return std::tolower(x) == std::tolower(y); });
}

std::string listed(const std::vector<std::string>& texts)
{
  std::string list;
  for (const std::string& text : texts) list += (list.empty() ? "" : " or ") + text;
  return list;
}

/// What an option of one of the groups is, and its name with that of its group.
std::pair<std::string, std::string> textAndName(const std::string& key,
                                                const std::vector<LoadedGroup>& groups)
{
  for (const LoadedGroup& group : groups)
  {
    const OptionTable& table = group.loaded->optionTable();
    if (const Option* option = table.find(key))
      return {option->textOf(*group.loaded), table.name() + "." + option->key};
  }
  throw std::logic_error("no group has the option " + key);
}

/// Nothing if one of the conditions holds, else what they are.
std::optional<std::string> unmet(const Option::AnyOf& conditions, const std::vector<LoadedGroup>& groups)
{
  std::string all;
  for (const Option::Condition& condition : conditions)
  {
    const auto [text, name] = textAndName(condition.key, groups);
    if (std::find(condition.texts.begin(), condition.texts.end(), text) != condition.texts.end())
      return std::nullopt;
    all += (all.empty() ? "" : ", or ") + name + " is " + listed(condition.texts) + " (it is " + text + ")";
  }
  return all;
}
}  // namespace

void requireOptionsInTheirSections(const mrpt::config::CConfigFileBase& source,
                                   const std::vector<LoadedGroup>& groups)
{
  for (const LoadedGroup& group : groups)
  {
    std::vector<std::string> keys;
    source.getAllKeys(group.section, keys);
    for (const std::string& key : keys)
    {
      if (group.loaded->optionTable().find(key) || !hasKey(source, group.section, key)) continue;
      for (const LoadedGroup& other : groups)
        if (const Option* option = other.loaded->optionTable().find(key))
          throw std::invalid_argument(withoutBrackets("option \"" + option->key + "\" in section \"" +
                                                      group.section + "\" of " + nameOf(source) +
                                                      " belongs to section \"" + other.section + "\""));
    }
  }
}

std::vector<std::string> settingsWithoutEffect(const mrpt::config::CConfigFileBase& source,
                                               const std::vector<LoadedGroup>& groups)
{
  std::vector<std::string> messages;
  for (const LoadedGroup& group : groups)
  {
    const OptionTable& table = group.loaded->optionTable();
    for (const Option& option : table.options())
    {
      const std::string text = option.textOf(*group.loaded);
      if (text == option.textOf(*group.preset) || !hasKey(source, group.section, option.key)) continue;
      for (const Option::AnyOf& conditions : option.conditions)
        if (const auto reason = unmet(conditions, groups))
          messages.push_back(table.name() + "." + option.key + " = " + text +
                             " has no effect: it has one only where " + *reason);
    }
  }
  return messages;
}

void warnOnce(const std::string& message)
{
  static std::mutex mutex;
  static std::set<std::string> told;
  const std::lock_guard<std::mutex> lock(mutex);
  if (told.insert(message).second) std::cerr << "warning: " << message << std::endl;
}

void requireKnownSections(const mrpt::config::CConfigFileBase& source, const std::string& prefix)
{
  std::vector<std::string> known;
  for (const char* end : {kCreationSection, kInsertSection, kLikelihoodSection, kRenderSection})
    known.push_back(prefix + end);
  std::vector<std::string> sections;
  source.getAllSections(sections);
  const std::string start = prefix + "_";
  for (const std::string& section : sections)
  {
    if (!sameIgnoringCase(section.substr(0, start.size()), start)) continue;
    if (std::any_of(known.begin(), known.end(),
                    [&](const auto& one) { return sameIgnoringCase(section, one); }))
      continue;
    throw std::invalid_argument(withoutBrackets("unknown section \"" + section + "\" of " + nameOf(source) +
                                                "; the nearest one is \"" + nearestOf(section, known) +
                                                "\""));
  }
}

std::vector<std::string> genericMapKeys()
{
  return {"enableSaveAs3DObject", "enableObservationLikelihood", "enableObservationInsertion"};
}

void StoredOptions::handTo(CLearnedMap& map) const
{
  map.likelihoodOptions = likelihood;
  map.renderingOptions = rendering;
  map.genericMapParams = generic;
}

void writeOptions(const TOptionGroup& insertion, const CLearnedMap& map, ByteWriter& out)
{
  insertion.write(out);
  map.likelihoodOptions.write(out);
  map.renderingOptions.write(out);
  out.number(map.genericMapParams.enableSaveAs3DObject);
  out.number(map.genericMapParams.enableObservationLikelihood);
  out.number(map.genericMapParams.enableObservationInsertion);
}

StoredOptions readOptions(TOptionGroup& insertion, ByteReader& in)
{
  insertion.read(in);
  StoredOptions stored;
  stored.likelihood.read(in);
  stored.rendering.read(in);
  stored.generic.enableSaveAs3DObject = in.number<bool>();
  stored.generic.enableObservationLikelihood = in.number<bool>();
  stored.generic.enableObservationInsertion = in.number<bool>();
  return stored;
}

void refuseVersion(const char* className, uint8_t version, uint8_t newestKnown)
{
  const std::string what = "a " + std::string(className) + " of format version " + std::to_string(version);
  const std::string known = "; this program reads up to version " + std::to_string(newestKnown);
  throw std::runtime_error(what + known +
                           (version > newestKnown ? ": it was written by a newer mrpt-lamap" : ""));
}

}  // namespace lamap
