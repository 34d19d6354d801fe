#include "legal_values.h"

#include <algorithm>
#include <charconv>
#include <utility>

namespace lamap::app
{
CLI::Validator wordToNumber(std::map<std::string, int> words)
{
  const auto translate = [words = std::move(words)](std::string& text) -> std::string
  {
    std::string all;
    for (const auto& [word, number] : words)
    {
      if (CLI::detail::to_lower(text) == CLI::detail::to_lower(word))
      {
        text = std::to_string(number);
        return "";
      }
      all += (all.empty() ? "" : ", ") + word;
    }
    return "'" + text + "' is none of: " + all;
  };
  return {translate, ""};
}

CLI::Validator wholeNumber(int64_t low, int64_t high)
{
  const auto judge = [low, high](std::string& text) -> std::string
  {
    int64_t number = 0;
    const char* end = text.data() + text.size();
    const auto read = std::from_chars(text.data(), end, number);
    if (read.ec == std::errc() && read.ptr == end && number >= low && number <= high) return "";
    return "'" + text + "' is not a whole number from " + std::to_string(low) + " to " + std::to_string(high);
  };
  return {judge, ""};
}

CLI::Validator probability()
{
  const auto judge = [](std::string& text) -> std::string
  {
    double number = 0;
    const char* end = text.data() + text.size();
    const auto read = std::from_chars(text.data(), end, number);
    // NaN is in no range.
    if (read.ec == std::errc() && read.ptr == end && number >= 0 && number <= 1) return "";
    return "'" + text + "' is not a number from 0 to 1";
  };
  return {judge, ""};
}

}  // namespace lamap::app
