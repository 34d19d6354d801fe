#include <lamap_core/options/nearest_name.h>
#include <lamap_mrpt/options/option_group.h>
#include <lamap_tools/config/recorded_config.h>
#include <mrpt/system/string_utils.h>
#include <strings.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <stdexcept>

namespace lamap::tools
{
using mrpt::system::strCmpI;

namespace
{
template <class Map>
std::vector<std::string> keysOf(const Map& map)
{
  std::vector<std::string> keys;
  keys.reserve(map.size());
  for (const auto& entry : map) keys.push_back(entry.first);
  return keys;
}

bool isNumber(const std::string& text)
{
  char* end = nullptr;
  const double number = std::strtod(text.c_str(), &end);
  return end != text.c_str() && *end == '\0' && std::isfinite(number);
}

/// Names of what was laid over that are not there already, case counting nothing.
template <class Map>
void addMissing(const Map& laidOver, std::vector<std::string>& names)
{
  for (const auto& entry : laidOver)
    if (std::none_of(names.begin(), names.end(),
                     [&](const std::string& name) { return strCmpI(entry.first, name); }))
      names.push_back(entry.first);
}

bool isYesOrNo(const std::string& text)
{
  const auto& words = {"true", "false", "yes", "no"};
  return std::any_of(words.begin(), words.end(), [&](const char* word) { return strCmpI(text, word); });
}

/** What is wrong with a value, judged by the default its reader gave: MRPT prints a floating-point default in
 * scientific notation and a whole number or a flag in digits. Empty: nothing that could be told. */
std::string complaintAbout(const std::string& text, const std::string& defaultText)
{
  if (!isNumber(defaultText)) return "";
  const bool isWhole = defaultText.find_first_of(".eE") == std::string::npos;
  if (!isWhole) return isNumber(text) ? "" : "must be a finite number, without a unit";
  if (isYesOrNo(text)) return "";
  const bool onlyDigits = isNumber(text) && text.find_first_of(".eExXnN") == std::string::npos;
  return onlyDigits ? "" : "must be a whole number, or true or false";
}
}  // namespace

bool RecordedConfig::NoCase::operator()(const std::string& a, const std::string& b) const
{
  return strcasecmp(a.c_str(), b.c_str()) < 0;
}

void RecordedConfig::setValue(const std::string& section, const std::string& key, const std::string& text)
{
  overlay_[section][key] = text;
}

void RecordedConfig::requireAllRead(const std::string& prefix, bool shorten) const
{
  const auto shown = [&](const std::string& section)
  { return shorten ? section.substr(prefix.size() + 1) : section; };
  std::vector<std::string> sections;
  getAllSections(sections);
  for (const std::string& section : sections)
  {
    if (!mrpt::system::strStartsI(section, prefix + "_")) continue;
    const auto asked = asked_.find(section);
    if (asked == asked_.end())
    {
      std::vector<std::string> known = askedSections();
      std::transform(known.begin(), known.end(), known.begin(), shown);
      throw std::runtime_error("section " + shown(section) + " is not read; " +
                               suggestionFor(shown(section), known));
    }
    std::vector<std::string> keys;
    collectKeys(section, keys);
    for (const std::string& key : keys)
    {
      const std::string place = shorten ? shown(section) + "." + key : "[" + section + "] " + key;
      const auto found = asked->second.find(key);
      if (found == asked->second.end())
        throw std::runtime_error(place + ": no such key; " + suggestionFor(key, keysOf(asked->second)));
      const std::string text = withoutComment(readString(section, key, "", false));
      const std::string complaint = complaintAbout(text, found->second);
      if (!complaint.empty()) throw std::runtime_error(place + " = " + text + ": " + complaint);
    }
  }
}

std::vector<std::string> RecordedConfig::askedSections() const
{
  return keysOf(asked_);
}

void RecordedConfig::getAllSections(std::vector<std::string>& sections) const
{
  base_.getAllSections(sections);
  addMissing(overlay_, sections);
}

void RecordedConfig::getAllKeys(const std::string& section, std::vector<std::string>& keys) const
{
  asked_[section];  // who wants all keys reads the section
  collectKeys(section, keys);
}

void RecordedConfig::collectKeys(const std::string& section, std::vector<std::string>& keys) const
{
  base_.getAllKeys(section, keys);
  if (const auto laid = overlay_.find(section); laid != overlay_.end()) addMissing(laid->second, keys);
}

void RecordedConfig::clear()
{
  throw std::logic_error("a recorded configuration is read only");
}

void RecordedConfig::writeString(const std::string&, const std::string&, const std::string&)
{
  throw std::logic_error("a recorded configuration is read only");
}

std::string RecordedConfig::readString(const std::string& section, const std::string& name,
                                       const std::string& defaultText, bool failIfNotFound) const
{
  asked_[section].emplace(name, defaultText);
  if (const auto laid = overlay_.find(section); laid != overlay_.end())
    if (const auto value = laid->second.find(name); value != laid->second.end()) return value->second;
  return base_.read_string(section, name, defaultText, failIfNotFound);
}

}  // namespace lamap::tools
