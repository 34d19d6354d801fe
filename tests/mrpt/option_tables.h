#pragma once

#include <lamap_mrpt/learned_map/CLearnedMap.h>

#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

// The tables of doc/options.md: as they stand there, and as the options' descriptions say them.
namespace lamap::test
{
inline const std::string kDefaultsHeader = "| key | default | legal | meaning |";
inline const std::string kPresetsHeader = "| key | `";

/// An option as documented: its cells are key, default, legal, meaning.
struct DocumentedOption
{
  std::string key;
  std::string usual;
  std::string legal;
  std::string meaning;
};

inline std::string rowOf(const std::vector<std::string>& cells)
{
  std::string row = "|";
  for (const std::string& cell : cells) row += " " + cell + " |";
  return row + "\n";
}

/// The text of an option for a table.
inline std::string documentedText(const Option& option, ConstAnyOptions options)
{
  const std::string text = option.textOf(options);
  if (option.type == OptionType::Choice) return "`" + text + "`";
  if (!text.empty()) return text;
  return option.emptyText.empty() ? "none" : option.emptyText;
}

/// The table of a group's options. @param untouched a group with the defaults
inline std::string tableOf(const TOptionGroup& untouched)
{
  std::string table = kDefaultsHeader + "\n|---|---|---|---|\n";
  for (const Option& option : untouched.optionTable().options())
    table +=
        rowOf({"`" + option.key + "`", documentedText(option, untouched), option.legalInShort(), option.doc});
  return table;
}

/// The options in which the presets of a map differ from its default. @tparam Map a LearnerMap
template <typename Map>
std::string presetTableOf()
{
  using Definition = typename Map::TMapDefinition;
  const Definition usual;
  const auto& creation = usual.creationOpts.optionTable();
  const auto& insertion = usual.insertionOpts.optionTable();
  const Option& preset = creation.require("preset");
  std::vector<Definition> presets(preset.names.size() - 1);
  std::vector<std::string> header{"key"};
  for (size_t i = 0; i < presets.size(); ++i)
  {
    preset.parse(presets[i].creationOpts, preset.names[i + 1]);
    presets[i].usePreset();
    header.push_back("`" + preset.names[i + 1] + "`");
  }
  std::string table = rowOf(header) + "|";
  for (size_t i = 0; i < header.size(); ++i) table += "---|";
  table += "\n";
  const auto addRows = [&](const OptionTable& options, auto group)
  {
    for (const Option& option : options.options())
    {
      if (option.key == "preset") continue;
      std::vector<std::string> row{"`" + option.key + "`"};
      bool differs = false;
      for (const Definition& one : presets)
      {
        row.push_back(documentedText(option, group(one)));
        differs |= row.back() != documentedText(option, group(usual));
      }
      if (differs) table += rowOf(row);
    }
  };
  addRows(creation, [](const Definition& one) -> const TOptionGroup& { return one.creationOpts; });
  addRows(insertion, [](const Definition& one) -> const TOptionGroup& { return one.insertionOpts; });
  return table;
}

inline std::string readOptionsPage()
{
  std::ifstream in(LAMAP_DOC_DIR "/options.md");
  std::ostringstream text;
  text << in.rdbuf();
  if (!in) throw std::runtime_error("cannot read " LAMAP_DOC_DIR "/options.md");
  return text.str();
}

/// Where a line of the page stands: "bgkMap" and "insertOpts"; for all maps: "" and "likelihoodOpts".
struct PagePlace
{
  std::string map;
  std::string section;

  void see(const std::string& line)
  {
    if (line.rfind("## ", 0) != 0) return;
    const auto inQuotes = [&](size_t from)
    {
      const size_t begin = line.find('`', from) + 1;
      return line.substr(begin, line.find('`', begin) - begin);
    };
    map = line.rfind("## All maps", 0) == 0 ? "" : inQuotes(0);
    section = inQuotes(line.find(": `"));
  }
};

/// The options that the page documents, by map and section.
inline std::map<std::pair<std::string, std::string>, std::vector<DocumentedOption>> documentedOptions()
{
  std::map<std::pair<std::string, std::string>, std::vector<DocumentedOption>> all;
  std::istringstream page(readOptionsPage());
  PagePlace place;
  bool inTable = false;
  for (std::string line; std::getline(page, line);)
  {
    place.see(line);
    if (line == kDefaultsHeader) inTable = true;
    if (line.rfind("|", 0) != 0) inTable = false;
    if (!inTable || line.rfind("| `", 0) != 0) continue;
    std::vector<std::string> cells;
    for (size_t begin = 2, end; (end = line.find(" |", begin)) != std::string::npos; begin = end + 3)
      cells.push_back(line.substr(begin, end - begin));
    const std::string key = cells.at(0).substr(1, cells.at(0).size() - 2);
    all[{place.map, place.section}].push_back({key, cells.at(1), cells.at(2), cells.at(3)});
  }
  return all;
}

}  // namespace lamap::test
