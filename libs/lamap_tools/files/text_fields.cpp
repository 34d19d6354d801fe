#include <lamap_tools/files/text_fields.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <istream>
#include <stdexcept>

namespace lamap::tools
{
std::string_view trimmed(std::string_view text)
{
  constexpr const char* kBlanks = " \t\r";
  const size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) + 1 - first);
}

std::vector<std::string_view> fieldsBetween(std::string_view line, std::string_view separators)
{
  std::vector<std::string_view> fields;
  for (;;)
  {
    const size_t end = line.find_first_of(separators);
    fields.push_back(trimmed(line.substr(0, end)));
    if (end == std::string_view::npos) return fields;
    line.remove_prefix(end + 1);
  }
}

double coordinateIn(std::string_view field, const std::string& axis)
{
  const auto number = numberIn<double>(field);
  if (!number || !std::isfinite(*number))
    throw std::runtime_error(axis + " is '" + std::string(field) + "', expected a finite number [m]");
  return *number;
}

std::vector<std::optional<size_t>> placesOf(const std::vector<std::string>& names,
                                            const std::vector<std::string_view>& fields)
{
  std::vector<std::optional<size_t>> places;
  for (const std::string& name : names)
  {
    const auto found = std::find(fields.begin(), fields.end(), name);
    places.emplace_back();
    if (found != fields.end()) places.back() = static_cast<size_t>(found - fields.begin());
  }
  return places;
}

void forEachLine(std::istream& in, const std::string& name,
                 const std::function<void(std::string_view line, size_t number)>& visitor)
{
  size_t number = 0;
  for (std::string line; std::getline(in, line);)
  {
    std::string_view content = line;
    if (++number == 1 && content.substr(0, 3) == "\xEF\xBB\xBF") content.remove_prefix(3);  // byte order mark
    content = trimmed(content);
    if (content.empty() || content.front() == '#') continue;
    try
    {
      visitor(content, number);
    }
    catch (const std::runtime_error& error)
    {
      throw std::runtime_error(name + ":" + std::to_string(number) + ": " + error.what());
    }
  }
  if (in.bad()) throw std::runtime_error(name + ": cannot be read: " + std::strerror(errno));
}

std::string joined(const std::vector<std::string>& texts, const std::string& separator)
{
  std::string all;
  for (const std::string& text : texts) all += (&text == texts.data() ? "" : separator) + text;
  return all;
}

std::string firstFewOf(const std::vector<std::string>& texts)
{
  constexpr size_t kFew = 3;
  if (texts.size() <= kFew) return joined(texts);
  return joined({texts.begin(), texts.begin() + kFew}) + " and " + std::to_string(texts.size() - kFew) +
         " more";
}

}  // namespace lamap::tools
