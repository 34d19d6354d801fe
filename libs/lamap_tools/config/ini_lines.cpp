#include <lamap_tools/config/ini_lines.h>

#include <lamap_tools/files/text_fields.h>

#include <mrpt/system/string_utils.h>

#include <fstream>
#include <map>
#include <stdexcept>

namespace lamap::tools
{
namespace
{
bool isComment(const std::string& line)
{
  return line.front() == '#' || line.front() == ';' || line.compare(0, 2, "//") == 0;
}
}  // namespace

void requireAssignments(const std::string& path,
                        const std::function<bool(const std::string& section)>& isAskedAbout)
{
  std::ifstream file(path);
  std::string section;
  std::map<std::string, size_t> lines;  // of sections' keys
  bool continued = false;               // by a backslash at the end of the line before
  std::string text;
  for (size_t number = 1; std::getline(file, text); ++number)
  {
    const std::string line(trimmed(text));
    const bool belongsToLineBefore = continued;
    continued = !line.empty() && line.back() == '\\';
    if (line.empty() || belongsToLineBefore || isComment(line) || line.front() == '@') continue;
    if (line.front() == '[')
    {
      section = line.substr(1, line.find(']') - 1);
      continue;
    }
    const size_t equals = line.find('=');
    if (!isAskedAbout(section)) continue;
    if (equals == std::string::npos)
      throw std::runtime_error("line " + std::to_string(number) + ", \"" + line + "\" in section \"" +
                               section + "\", is no \"key = value\"; MRPT would ignore it");
    const std::string key(trimmed(std::string_view(line).substr(0, equals)));
    const auto [first, isNew] = lines.insert({mrpt::system::lowerCase(section + "\n" + key), number});
    if (!isNew)
      throw std::runtime_error("line " + std::to_string(number) + ": \"" + key +
                               "\" is given twice in section \"" + section + "\", first in line " +
                               std::to_string(first->second));
  }
}

}  // namespace lamap::tools
