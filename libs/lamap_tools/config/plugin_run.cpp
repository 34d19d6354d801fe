#include <lamap_core/options/nearest_name.h>
#include <lamap_mrpt/compat/mrpt_compat.h>
#include <lamap_mrpt/options/option_group.h>
#include <lamap_tools/config/ini_lines.h>
#include <lamap_tools/config/map_setup.h>
#include <lamap_tools/config/plugin_run.h>
#include <lamap_tools/config/recorded_config.h>
#include <lamap_tools/files/text_fields.h>
#include <mrpt/config/CConfigFile.h>
#include <mrpt/core/format.h>
#include <mrpt/system/string_utils.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <set>
#include <stdexcept>

namespace lamap::tools
{
namespace
{
using mrpt::system::strCmpI;
using mrpt::system::strStartsI;

/// Names by which an .ini file may ask for one of our maps, the aliases first.
const std::vector<std::string>& ourNames()
{
  // Found once: a map of each class is made for it.
  static const std::vector<std::string> kNames = []
  {
    std::vector<std::string> names;
    for (const std::string& name : registeredMapNames())
      if (isLearnedMap(name)) names.push_back(name);
    // Aliases begin with a small letter, class names with a capital or their namespace.
    std::stable_partition(names.begin(), names.end(),
                          [](const std::string& name)
                          { return name.find(':') == std::string::npos && std::islower(name.front()) != 0; });
    return names;
  }();
  return kNames;
}

bool isRegistered(const std::string& name)
{
  const auto names = registeredMapNames();
  return std::any_of(names.begin(), names.end(),
                     [&](const std::string& other) { return strCmpI(name, other); });
}

/// Maps of ours that a section counts.
struct Request
{
  std::string section;
  std::string map;
  unsigned count = 0;

  [[nodiscard]] std::string prefix(unsigned index) const
  {
    return section + "_" + map + mrpt::format("_%02u", index);
  }
};

class StockConfigCheck
{
 public:
  explicit StockConfigCheck(const std::string& path) : config_(path), ours_(ourNames())
  {
    config_.getAllSections(sections_);
  }

  void run()
  {
    for (const std::string& section : sections_) findRequests(section);
    if (requests_.empty())
      throw std::runtime_error("asks for none of this library's maps; expected e.g. " + ours_.front() +
                               "_count = 1 in the section that counts the application's maps");
    for (const Request& request : requests_) checkOptions(request);
    for (const std::string& section : sections_) checkName(section);
  }

 private:
  void findRequests(const std::string& section)
  {
    std::vector<std::string> keys;
    config_.getAllKeys(section, keys);
    for (const std::string& key : keys)
    {
      constexpr size_t kEnding = 6;  // of "_count"
      if (key.size() <= kEnding || !strCmpI(key.substr(key.size() - kEnding), "_count")) continue;
      const std::string map = key.substr(0, key.size() - kEnding);
      const auto ours = std::find_if(ours_.begin(), ours_.end(),
                                     [&](const std::string& name) { return strCmpI(name, map); });
      if (ours != ours_.end())
        addRequest(section, key, *ours);
      else if (!isRegistered(map))
        refuseMistyped(section, key, map);
    }
  }

  void addRequest(const std::string& section, const std::string& key, const std::string& map)
  {
    const std::string text = withoutComment(config_.read_string(section, key, ""));
    const auto count = numberIn<unsigned>(text);
    constexpr unsigned kMost = 99;  // two digits in the names of sections
    if (!count || *count > kMost)
      throw std::runtime_error("[" + section + "] " + key + " = " + text +
                               ": must be a whole number from 0 to 99");
    counting_.insert(mrpt::system::lowerCase(section));
    if (*count > 0) requests_.push_back({section, map, *count});
  }

  void refuseMistyped(const std::string& section, const std::string& key, const std::string& map) const
  {
    const std::string nearest = nearestOf(map, ours_);
    if (looksLikeMistyped(map, nearest))
      throw std::runtime_error("[" + section + "] " + key + ": no map of this name; did you mean " + nearest +
                               "_count?");
  }

  void checkOptions(const Request& request)
  {
    for (unsigned i = 0; i < request.count; ++i)
    {
      const RecordedConfig recorded(config_);
      const mrpt::maps::TMetricMapInitializer::Ptr definition(
          mrpt::maps::TMetricMapInitializer::factory(request.map));
      definition->loadFromConfigFile(recorded, request.prefix(i));
      recorded.requireAllRead(request.prefix(i), false);
      const auto asked = recorded.askedSections();
      readSections_.insert(readSections_.end(), asked.begin(), asked.end());
    }
  }

  /// A section that was meant for one of our maps, but has another number or a mistyped name.
  void checkName(const std::string& section) const
  {
    const auto isRead = [&](const std::string& other) { return strCmpI(section, other); };
    if (std::any_of(readSections_.begin(), readSections_.end(), isRead)) return;
    const std::string nearest = nearestOf(section, readSections_);
    const auto isOurs = [&](const Request& request)
    { return strStartsI(section, request.section + "_" + request.map + "_"); };
    const bool meantForOurs = std::any_of(requests_.begin(), requests_.end(), isOurs);
    const auto prefix = prefixOfOurs(section);
    const bool isCountedAsNone = !meantForOurs && prefix && counting_.count(*prefix) > 0;
    if (isCountedAsNone) return;
    if (meantForOurs || (isNobodysMap(section) && looksLikeMistyped(section, nearest)))
      throw std::runtime_error("section [" + section + "] is not read; did you mean [" + nearest + "]?");
    if (prefix) refuseOtherPrefix(section, *prefix, nearest);
  }

  /// What stands before "_NAME_", NAME one of our maps, in lower case; nothing where there is no such name.
  [[nodiscard]] std::optional<std::string> prefixOfOurs(const std::string& section) const
  {
    const std::string lower = mrpt::system::lowerCase(section);
    for (const std::string& name : ours_)
      if (const size_t at = lower.find("_" + mrpt::system::lowerCase(name) + "_"); at != std::string::npos)
        return lower.substr(0, at);
    return std::nullopt;
  }

  /// A section of one of our maps whose prefix is of no section that counts them, such as the [map] of `lamap
  /// build`.
  [[noreturn]] void refuseOtherPrefix(const std::string& section, const std::string& prefix,
                                      const std::string& nearest) const
  {
    const std::string meant = requests_.front().section + section.substr(prefix.size());
    const bool isRead = std::any_of(readSections_.begin(), readSections_.end(),
                                    [&](const std::string& other) { return strCmpI(meant, other); });
    throw std::runtime_error("section [" + section + "] is not read, because no section [" +
                             section.substr(0, prefix.size()) + "] counts such maps; did you mean [" +
                             (isRead ? meant : nearest) + "]?");
  }

  /// Whether a section is neither a request's own nor one of a map that MRPT knows.
  [[nodiscard]] bool isNobodysMap(const std::string& section) const
  {
    for (const Request& request : requests_)
    {
      if (strCmpI(section, request.section)) return false;
      if (!strStartsI(section, request.section + "_")) continue;
      for (const std::string& name : registeredMapNames())
        if (strStartsI(section, request.section + "_" + name + "_")) return false;
    }
    return true;
  }

  mrpt::config::CConfigFile config_;
  std::vector<std::string> ours_;
  std::vector<std::string> sections_;
  std::vector<Request> requests_;
  std::set<std::string> counting_;  ///< sections that count maps of ours, be it 0 of them; lower case
  std::vector<std::string> readSections_;
};

bool namesIniFile(const std::string& argument)
{
  return std::filesystem::path(argument).extension() == ".ini";
}

/// The .ini files among the arguments; map-partition reads one that is not, in the folder where it runs.
std::vector<std::string> configsOf(const std::vector<std::string>& command)
{
  std::vector<std::string> configs;
  std::copy_if(command.begin() + 1, command.end(), std::back_inserter(configs), namesIniFile);
  const std::string ofMapPartition = "MAP-PARTITION_CONFIG.ini";
  if (std::filesystem::path(command.front()).filename() == "map-partition" &&
      std::filesystem::is_regular_file(ofMapPartition))
    configs.push_back(ofMapPartition);
  return configs;
}
}  // namespace

void checkStockConfig(const std::string& path)
{
  if (!std::filesystem::is_regular_file(path) || !std::ifstream(path))
    throw std::runtime_error(
        path + ": there is no such file, or it cannot be read; with --no-check the program decides");
  try
  {
    StockConfigCheck(path).run();
    const std::vector<std::string>& ours = ourNames();
    requireAssignments(path,
                       [&](const std::string& section)
                       {
                         return std::any_of(ours.begin(), ours.end(),
                                            [&](const std::string& name)
                                            { return section.find("_" + name + "_") != std::string::npos; });
                       });
  }
  catch (const std::exception& error)
  {
    throw std::runtime_error(path + ": " + compat::messageOf(error));
  }
}

std::string pluginPath()
{
  if (const char* chosen = std::getenv("LAMAP_PLUGIN"))
  {
    if (!std::filesystem::is_regular_file(chosen))
      throw std::runtime_error(std::string("LAMAP_PLUGIN names ") + chosen + ", where there is no file");
    return std::filesystem::absolute(chosen);
  }
  const std::filesystem::path program = std::filesystem::canonical("/proc/self/exe").parent_path();
  for (const char* folder : {LAMAP_BIN_TO_LIB, "../lib"})
    if (const auto library = program / folder / "libmrpt-lamap.so"; std::filesystem::is_regular_file(library))
      return std::filesystem::canonical(library);
  throw std::runtime_error("libmrpt-lamap.so is not in " +
                           (program / LAMAP_BIN_TO_LIB).lexically_normal().string() +
                           ": name it in LAMAP_PLUGIN");
}

void runWithPlugin(const std::vector<std::string>& command, bool check)
{
  if (command.empty()) throw std::runtime_error("no program to run");
  if (check)
    for (const std::string& config : configsOf(command)) checkStockConfig(config);

  const char* others = std::getenv("LD_PRELOAD");
  const std::string preload = pluginPath() + (others && *others ? ":" + std::string(others) : "");
  setenv("LD_PRELOAD", preload.c_str(), 1);
  std::vector<char*> arguments;
  arguments.reserve(command.size() + 1);
  for (const std::string& argument : command) arguments.push_back(const_cast<char*>(argument.c_str()));
  arguments.push_back(nullptr);
  execvp(arguments.front(), arguments.data());
  throw std::runtime_error(command.front() + ": cannot be started: " + std::strerror(errno));
}

}  // namespace lamap::tools
