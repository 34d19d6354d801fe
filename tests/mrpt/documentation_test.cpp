// What doc/options.md says of each option is what the program does.
#include <gtest/gtest.h>
#include <lamap_mrpt/maps/CBGKMap.h>
#include <lamap_mrpt/maps/CGPMap.h>
#include <lamap_mrpt/maps/CHilbertMap.h>
#include <lamap_mrpt/maps/COverlappingHilbertMap.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace
{
/// Cells of a line of a table, without the blanks around.
std::vector<std::string> cellsOf(const std::string& line)
{
  std::vector<std::string> cells;
  std::istringstream in(line.substr(1));
  for (std::string cell; std::getline(in, cell, '|');)
  {
    const size_t first = cell.find_first_not_of(' ');
    const size_t last = cell.find_last_not_of(' ');
    cells.push_back(first == std::string::npos ? "" : cell.substr(first, last - first + 1));
  }
  return cells;
}

std::vector<std::string> listed(const std::string& text)
{
  std::vector<std::string> parts;
  std::string part;
  for (const char letter : text + ",")
  {
    if (letter == ',')
      parts.push_back(std::exchange(part, ""));
    else if (letter != '`' && (letter != ' ' || !part.empty()))
      part += letter;
  }
  return parts;
}

/// Default of each section and key in the tables that have a column for it, of one map and of all maps.
std::map<std::pair<std::string, std::string>, std::string> documentedDefaults(const std::string& alias)
{
  std::map<std::pair<std::string, std::string>, std::string> defaults;
  std::ifstream in(LAMAP_DOC_DIR "/options.md");
  std::string section;
  bool inTable = false;
  for (std::string line; std::getline(in, line);)
  {
    if (line.rfind("## ", 0) == 0)
    {
      const bool isMeant =
          line.rfind("## `" + alias + "`: `", 0) == 0 || line.rfind("## All maps: `", 0) == 0;
      const size_t begin = line.find(": `") + 3;
      section = isMeant ? line.substr(begin, line.find('`', begin) - begin) : "";
    }
    if (section.empty()) continue;
    if (line.empty() || line.front() != '|')
      inTable = false;
    else if (line.rfind("| key | default |", 0) == 0)
      inTable = true;
    else if (inTable && line.rfind("|---", 0) != 0)
    {
      const std::vector<std::string> cells = cellsOf(line);
      const std::vector<std::string> keys = listed(cells.at(0));
      const std::vector<std::string> values = listed(cells.at(1));
      for (size_t i = 0; i < keys.size(); ++i)
        defaults[{section, keys[i]}] = values.size() == keys.size() ? values[i] : cells[1];
    }
  }
  return defaults;
}

std::optional<double> numberIn(const std::string& text)
{
  double number = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), number);
  if (read.ec != std::errc() || read.ptr != text.data() + text.size()) return std::nullopt;
  return number;
}

bool sameDefault(const std::string& documented, const std::string& real)
{
  if (numberIn(documented) && numberIn(real)) return *numberIn(documented) == *numberIn(real);
  std::string plain = documented;
  plain.erase(std::remove(plain.begin(), plain.end(), '`'), plain.end());
  return plain == (real.empty() ? "none" : real);
}

void expectDocumented(const lamap::CLearnedMap& map)
{
  SCOPED_TRACE(map.alias());
  auto documented = documentedDefaults(map.alias());
  for (const lamap::OptionValue& option : map.optionValues())
  {
    const auto found = documented.find({option.section, option.key});
    if (found == documented.end())
    {
      ADD_FAILURE() << option.section << "." << option.key << " is not in doc/options.md";
      continue;
    }
    EXPECT_TRUE(sameDefault(found->second, option.defaultText))
        << option.section << "." << option.key << ": documented " << found->second << ", in truth "
        << option.defaultText;
    documented.erase(found);
  }
  for (const auto& [name, text] : documented)
    ADD_FAILURE() << name.first << "." << name.second << " is in doc/options.md, but no option";
}

TEST(Documentation, NamesEveryOptionWithItsDefault)
{
  expectDocumented(lamap::CBGKMap());
  expectDocumented(lamap::CGPMap());
  expectDocumented(lamap::CHilbertMap());
  expectDocumented(lamap::COverlappingHilbertMap());
}
}  // namespace
