#include <lamap_mrpt/options/map_sections.h>

#include <lamap_core/options/nearest_name.h>
#include <mrpt/system/string_utils.h>

#include <algorithm>
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
                             " has no effect: it matters only if " + *reason);
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
    if (!mrpt::system::strStartsI(section, start)) continue;
    if (std::any_of(known.begin(), known.end(),
                    [&](const auto& one) { return mrpt::system::strCmpI(section, one); }))
      continue;
    throw std::invalid_argument(withoutBrackets("unknown section \"" + section + "\" of " + nameOf(source) +
                                                "; " + suggestionFor(section, known, "\"", "\"")));
  }
}

std::vector<std::string> genericMapKeys()
{
  return {"enableSaveAs3DObject", "enableObservationLikelihood", "enableObservationInsertion"};
}

void saveGenericParams(const mrpt::maps::TMapGenericParams& params, mrpt::config::CConfigFileBase& target,
                       const std::string& section)
{
  constexpr int kNotPadded = -1;
  const auto save = [&](const char* key, bool flag, const char* doc)
  { target.write(section, key, std::string(flag ? "true" : "false"), kNotPadded, kNotPadded, doc); };
  save("enableSaveAs3DObject", params.enableSaveAs3DObject, "show this map in 3D views");
  save("enableObservationLikelihood", params.enableObservationLikelihood, "score observations by this map");
  save("enableObservationInsertion", params.enableObservationInsertion, "insert observations into this map");
}

}  // namespace lamap
