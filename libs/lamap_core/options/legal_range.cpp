#include <lamap_core/options/legal_range.h>

#include <array>
#include <charconv>
#include <cmath>
#include <stdexcept>

namespace lamap
{
namespace
{
/// 1e6 instead of 1e+06.
std::string withPlainExponent(std::string text)
{
  const size_t e = text.find('e');
  if (e == std::string::npos) return text;
  size_t digits = e + 1;
  if (text[digits] == '+') text.erase(digits, 1);
  if (text[digits] == '-') ++digits;
  while (digits + 1 < text.size() && text[digits] == '0') text.erase(digits, 1);
  return text;
}

std::string formatted(double value, std::chars_format format, int precision)
{
  std::array<char, 512> text{};  // 309 digits, and decimals
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value, format, precision);
  return {text.data(), end.ptr};
}
}  // namespace

void requireLegal(bool condition, const char* name, double value, const std::string& legal)
{
  if (!condition)
    throw std::invalid_argument(std::string(name) + " = " + shortText(value) + ": must be " + legal);
}

std::string shortText(double value)
{
  std::array<char, 32> shortest{};
  const auto end = std::to_chars(shortest.data(), shortest.data() + shortest.size(), value);
  return withPlainExponent({shortest.data(), end.ptr});
}

std::string roundedText(double value, int digits)
{
  return formatted(value, std::chars_format::general, digits);
}

std::string fixedText(double value, int decimals)
{
  return formatted(value, std::chars_format::fixed, decimals);
}

std::string cellsText(double cells)
{
  const double inverse = std::round(1 / cells);
  if (cells > 0 && cells < 1 && std::abs(inverse * cells - 1) < 1e-9)
    return "1/" + shortText(inverse) + " cell";
  return shortText(cells) + (cells == 1 ? " cell" : " cells");
}

bool LegalRange::holds(double number, std::optional<double> resolution_m) const
{
  if (orZero && number == 0) return true;
  if (!(lowIncluded ? number >= low : number > low) || !(number <= high)) return false;
  if (!resolution_m) return true;
  return (!lowCells || number >= *lowCells * *resolution_m) &&
         (!highCells || number <= *highCells * *resolution_m);
}

std::string LegalRange::asText() const
{
  const LegalRange any;
  const bool below = low > any.low;
  const bool above = high < any.high;
  if (below && above && lowIncluded) return "from " + shortText(low) + " to " + shortText(high);
  if (below && above) return "> " + shortText(low) + ", at most " + shortText(high);
  if (below) return (lowIncluded ? ">= " : "> ") + shortText(low);
  if (above) return "at most " + shortText(high);
  return "";
}

std::string LegalRange::cellsAsText() const
{
  if (lowCells && highCells && *lowCells == -*highCells) return "within " + cellsText(*highCells);
  if (lowCells && highCells) return "from " + cellsText(*lowCells) + " to " + cellsText(*highCells);
  if (lowCells) return "at least " + cellsText(*lowCells);
  return highCells ? "at most " + cellsText(*highCells) : "";
}

}  // namespace lamap
