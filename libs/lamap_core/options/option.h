#pragma once

#include <lamap_core/options/legal_range.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace lamap
{
/// A struct of options whose type only its own OptionTable knows.
class AnyOptions
{
 public:
  template <typename Options>
  explicit AnyOptions(Options* options) : address_(options)
  {
  }
  /// @tparam Options the type it was made of
  template <typename Options>
  [[nodiscard]] Options& as() const
  {
    return *static_cast<Options*>(address_);
  }

 private:
  friend class ConstAnyOptions;
  void* address_;
};

/// The same, read-only.
class ConstAnyOptions
{
 public:
  template <typename Options>
  explicit ConstAnyOptions(const Options* options) : address_(options)
  {
  }
  ConstAnyOptions(AnyOptions options) : address_(options.address_) {}
  template <typename Options>
  [[nodiscard]] const Options& as() const
  {
    return *static_cast<const Options*>(address_);
  }

 private:
  const void* address_;
};

/// Which of an option's names is chosen; beyond them all: what is no enumerator.
struct OptionChoice
{
  size_t number = 0;

  friend bool operator==(OptionChoice a, OptionChoice b) { return a.number == b.number; }
};

/// What an option holds; std::monostate if it is left empty.
using OptionContent =
    std::variant<std::monostate, double, uint32_t, int32_t, bool, std::string, OptionChoice>;

enum class OptionType
{
  Number,
  Unsigned,
  Signed,
  Flag,
  Text,
  Choice
};

/// What an option needs besides its key, its place and its meaning.
struct OptionTraits
{
  std::string unit{};  ///< "m", "deg", or "" for a plain number
  LegalRange range{};
  std::string floorKey{};            ///< key of the option that this one must not be below
  bool floorIncluded = true;         ///< whether it may equal that option
  std::string emptyText{};           ///< meaning of a number that is left empty, e.g. "2 cells"
  double emptyCells = 0;             ///< the length that it stands for, in cells; 0: other options decide
  std::vector<std::string> names{};  ///< of a choice; enumerators count from 0 in this order

  // Chained: metres().above(0).to(1e6).atMostCells(64).usuallyCells(2)
  OptionTraits& from(double low) { return range.low = low, *this; }
  OptionTraits& above(double low) { return range.low = low, range.lowIncluded = false, *this; }
  OptionTraits& to(double high) { return range.high = high, *this; }
  OptionTraits& atLeastCells(double cells) { return range.lowCells = cells, *this; }
  OptionTraits& atMostCells(double cells) { return range.highCells = cells, *this; }
  OptionTraits& orZero() { return range.orZero = true, *this; }
  OptionTraits& notBelow(std::string key) { return floorKey = std::move(key), *this; }
  OptionTraits& exceeds(std::string key) { return floorIncluded = false, notBelow(std::move(key)); }
  OptionTraits& usually(std::string text) { return emptyText = std::move(text), *this; }
  OptionTraits& usuallyCells(double cells);
};

/// A number without a unit; a truth value; a text.
[[nodiscard]] inline OptionTraits plain()
{
  return {};
}
/// A length.
[[nodiscard]] inline OptionTraits metres()
{
  OptionTraits traits;
  traits.unit = "m";
  return traits;
}
/// One of several names.
[[nodiscard]] inline OptionTraits oneOf(std::vector<std::string> names)
{
  OptionTraits traits;
  traits.names = std::move(names);
  return traits;
}

/// One option: its key in .ini files, its type, unit, legal range, meaning and the member that holds it.
struct Option : public OptionTraits
{
  /// Another option, possibly of another group of the map, and the values it must have.
  struct Condition
  {
    std::string key;
    std::vector<std::string> texts;  ///< any of them
  };
  /// At least one of these conditions must hold.
  using AnyOf = std::vector<Condition>;

  std::string key;
  std::string doc;  ///< one line
  OptionType type = OptionType::Number;
  bool mayBeEmpty = false;
  std::vector<AnyOf> conditions{};  ///< all must hold, otherwise the option has no effect
  std::function<OptionContent(ConstAnyOptions)> get;
  /// Takes content of the option's type (or none, if it may be empty), legal or not.
  std::function<void(AnyOptions, const OptionContent&)> set;

  /// Shortest text that parse() reads back as the same value; "" if it is left empty, "?" for a choice that
  /// is none of the names.
  [[nodiscard]] std::string textOf(ConstAnyOptions options) const;
  /** Sets the option from text as it stands in an .ini file, without comments. Ends of the range that depend
   * on other options are checked by OptionTable::validate().
   * @throws std::invalid_argument saying what is wrong and what is legal; the option keeps its value. */
  void parse(AnyOptions options, const std::string& text) const;

  /// For messages: "a number >= 0, in m", "one of: samples, line, none".
  [[nodiscard]] std::string legalText() const;
  /// For tables: "0 to 1e6 m", "> 0, at most 1000".
  [[nodiscard]] std::string legalInShort() const;

 private:
  [[nodiscard]] OptionContent parsed(const std::string& text) const;
  [[nodiscard]] std::string endsText() const;
};

/// A number or a whole number as a number; nothing for other content.
[[nodiscard]] std::optional<double> numberIn(const OptionContent& content);

/// "true", "yes", "on", "1" or their opposites, in any case; nothing for other texts.
[[nodiscard]] std::optional<bool> flagIn(const std::string& text);

/// In ASCII.
[[nodiscard]] std::string lowerCase(std::string text);

}  // namespace lamap
