#pragma once

#include <limits>
#include <optional>
#include <string>

namespace lamap
{
/** Refuses an illegal option.
 * @throws std::invalid_argument "<name> = <value>: must be <legal>" unless the condition holds. */
void requireLegal(bool condition, const char* name, double value, const std::string& legal);

/// A number in its shortest form that reads back as the same, e.g. "0.1", "1e6"; the same in every locale.
[[nodiscard]] std::string shortText(double value);
/// As printf's "%.<digits>g", with a decimal point in every locale.
[[nodiscard]] std::string roundedText(double value, int digits = 6);
/// As printf's "%.<decimals>f".
[[nodiscard]] std::string fixedText(double value, int decimals);
/// "1 cell", "64 cells", "1/1000 cell".
[[nodiscard]] std::string cellsText(double cells);

/** The numbers that an option may have. Ends given in cells hold where the resolution is known; 0 may be
 * legal beside them all. */
struct LegalRange
{
  double low = -std::numeric_limits<double>::max();
  double high = std::numeric_limits<double>::max();
  bool lowIncluded = true;
  std::optional<double> lowCells{};   ///< and at least this many times the resolution
  std::optional<double> highCells{};  ///< and at most this many times the resolution
  bool orZero = false;

  [[nodiscard]] bool holds(double number, std::optional<double> resolution_m = std::nullopt) const;
  /// "from 0 to 1", "> 0, at most 1e6", ">= 0", or "" if every finite number is legal.
  [[nodiscard]] std::string asText() const;
  /// "at least 1/1000 cell", "at most 64 cells", "within 1e9 cells", or "" without ends in cells.
  [[nodiscard]] std::string cellsAsText() const;
};

}  // namespace lamap
