#include <lamap_core/options/nearest_name.h>
#include <lamap_core/options/option.h>

#include <charconv>
#include <cmath>
#include <stdexcept>
#include <string_view>

namespace lamap
{
namespace
{
/// Whole text to number, the decimal point is a point everywhere; nothing if it is no number.
template <typename T>
std::optional<T> toNumber(std::string_view text)
{
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  T number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return number;
}

std::string joined(const std::vector<std::string>& texts, const std::string& quote)
{
  std::string all;
  for (const std::string& text : texts) all += (all.empty() ? "" : ", ") + quote + text + quote;
  return all;
}

void append(std::string& text, const std::string& more)
{
  if (!more.empty()) text += (text.empty() ? "" : ", ") + more;
}
}  // namespace

OptionTraits& OptionTraits::usuallyCells(double cells)
{
  emptyCells = cells;
  return usually(cellsText(cells));
}

std::string Option::textOf(ConstAnyOptions options) const
{
  const OptionContent content = get(options);
  if (const auto* text = std::get_if<std::string>(&content)) return *text;
  if (const auto* flag = std::get_if<bool>(&content)) return *flag ? "true" : "false";
  if (const auto* choice = std::get_if<OptionChoice>(&content))
    return choice->number < names.size() ? names[choice->number] : "?";
  const auto number = numberIn(content);
  return number ? shortText(*number) : "";
}

OptionContent Option::parsed(const std::string& text) const
{
  const auto refuse = [&](const std::string& what)
  {
    throw std::invalid_argument(what + "; legal is " + legalText() +
                                (unit.empty() ? "" : " (without the unit)"));
  };
  const auto legal = [&](auto number, const char* noun) -> OptionContent
  {
    if (!number) refuse(std::string("is not ") + noun);
    if (!std::isfinite(static_cast<double>(*number))) refuse("is not a finite number");
    if (!range.holds(static_cast<double>(*number))) refuse("is out of range");
    return *number;
  };
  switch (type)
  {
    case OptionType::Number:
      return legal(toNumber<double>(text), "a number");
    case OptionType::Unsigned:
      return legal(toNumber<uint32_t>(text), "a whole number >= 0");
    case OptionType::Signed:
      return legal(toNumber<int32_t>(text), "a whole number");
    case OptionType::Flag:
      if (const auto flag = flagIn(text)) return *flag;
      refuse("is neither yes nor no");
      break;
    case OptionType::Text:
      return text;
    case OptionType::Choice:
      for (size_t i = 0; i < names.size(); ++i)
        if (lowerCase(names[i]) == lowerCase(text)) return OptionChoice{i};
      refuse("is not known; " + suggestionFor(text, names));
  }
  return {};
}

void Option::parse(AnyOptions options, const std::string& text) const
{
  set(options, parsed(text));
}

/// The ends of the range; a lower one that another option stands above need not be said.
std::string Option::endsText() const
{
  LegalRange ends = range;
  if (!floorKey.empty()) ends.low = LegalRange().low;
  return ends.asText();
}

std::string Option::legalText() const
{
  if (type == OptionType::Flag) return "true or false";
  if (type == OptionType::Text) return "a text";
  if (type == OptionType::Choice) return "one of: " + joined(names, "");
  std::string text = range.orZero ? "0, or " : "";
  text += type == OptionType::Number ? "a number" : "a whole number";
  if (!floorKey.empty()) text += (floorIncluded ? " >= " : " > ") + floorKey;
  if (const std::string ends = endsText(); !ends.empty()) text += (floorKey.empty() ? " " : ", ") + ends;
  append(text, range.cellsAsText());
  if (!unit.empty()) append(text, "in " + unit);
  return text;
}

std::string Option::legalInShort() const
{
  if (type == OptionType::Flag) return "true, false";
  if (type == OptionType::Text) return "a text";
  if (type == OptionType::Choice) return joined(names, "`");
  std::string ends = endsText();
  if (ends.rfind("from ", 0) == 0) ends = ends.substr(5);
  if (!unit.empty() && !ends.empty()) ends += " " + unit;
  std::string text = floorKey.empty() ? "" : (floorIncluded ? ">= `" : "> `") + floorKey + "`";
  append(text, ends);
  append(text, range.cellsAsText());
  return (range.orZero ? "0, or " : "") + text;
}

std::optional<double> numberIn(const OptionContent& content)
{
  if (const auto* number = std::get_if<double>(&content)) return *number;
  if (const auto* number = std::get_if<uint32_t>(&content)) return *number;
  if (const auto* number = std::get_if<int32_t>(&content)) return *number;
  return std::nullopt;
}

std::optional<bool> flagIn(const std::string& text)
{
  const std::string word = lowerCase(text);
  if (word == "true" || word == "yes" || word == "on" || word == "1") return true;
  if (word == "false" || word == "no" || word == "off" || word == "0") return false;
  return std::nullopt;
}

std::string lowerCase(std::string text)
{
  for (char& letter : text)
    if (letter >= 'A' && letter <= 'Z') letter = static_cast<char>(letter - 'A' + 'a');
  return text;
}

}  // namespace lamap
