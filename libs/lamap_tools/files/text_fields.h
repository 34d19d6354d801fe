#pragma once

#include <charconv>
#include <functional>
#include <iosfwd>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

// Numbers, lists and lines of texts that people write.
namespace lamap::tools
{
/// Without spaces, tabs and carriage returns at either end.
[[nodiscard]] std::string_view trimmed(std::string_view text);

/// What stands between any of the separators, trimmed; one field for a text without any.
[[nodiscard]] std::vector<std::string_view> fieldsBetween(std::string_view line, std::string_view separators);

/// The number that the whole text is, if it is one; a leading + is allowed.
template <class Number>
[[nodiscard]] std::optional<Number> numberIn(std::string_view text)
{
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  Number number{};
  const char* end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, number);
  if (read.ec != std::errc() || read.ptr != end) return std::nullopt;
  return number;
}

/// A coordinate. @throws std::runtime_error naming the axis and the field unless it is a finite number
[[nodiscard]] double coordinateIn(std::string_view field, const std::string& axis);

/// Where each name stands among the fields; nothing where it does not.
[[nodiscard]] std::vector<std::optional<size_t>> placesOf(const std::vector<std::string>& names,
                                                          const std::vector<std::string_view>& fields);

/** Calls the visitor for each line that says something, trimmed, with its number: empty lines and those that
 * begin with # are left out, as is a byte order mark.
 * @param name  of the text, for messages
 * @throws std::runtime_error naming the text, and the line where the visitor throws one */
void forEachLine(std::istream& in, const std::string& name,
                 const std::function<void(std::string_view line, size_t number)>& visitor);

/// The texts in their order, separated.
[[nodiscard]] std::string joined(const std::vector<std::string>& texts, const std::string& separator = ", ");
/// The first three, and how many more there are: "a, b, c and 7 more".
[[nodiscard]] std::string firstFewOf(const std::vector<std::string>& texts);

}  // namespace lamap::tools
