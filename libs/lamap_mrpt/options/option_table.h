#pragma once

#include <lamap_mrpt/files/byte_stream.h>
#include <mrpt/config/CConfigFileBase.h>
#include <mrpt/config/CLoadableOptions.h>
#include <mrpt/serialization/CArchive.h>

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace lamap
{
class TOptionGroup;

/// The numbers that an option may have. Whole numbers are in it if both ends, as numbers, allow them.
struct LegalRange
{
  double low = -std::numeric_limits<double>::max();
  double high = std::numeric_limits<double>::max();
  bool lowIncluded = true;

  [[nodiscard]] bool holds(double number) const
  {
    return (lowIncluded ? number >= low : number > low) && number <= high;
  }
  /// For messages: "a number >= 0", "a number from 0 to 1".
  [[nodiscard]] std::string asText(const std::string& noun) const;
};

/** One option of a group: its name in .ini files, its type, unit, legal range, what it means, and where it is
 * kept. */
struct Option
{
  /// An enumeration whose enumerators count from 0 in the order of `names`.
  struct Choice
  {
    std::function<int(const TOptionGroup&)> get;
    std::function<void(TOptionGroup&, int)> set;
    std::vector<std::string> names;
  };
  template <typename T>
  using Member = std::function<T&(TOptionGroup&)>;
  /// A number that may be left empty has a default that other options decide, e.g. a length in cells.
  using Access =
      std::variant<Member<double>, Member<std::optional<double>>, Member<uint32_t>,
                   Member<std::optional<uint32_t>>, Member<int>, Member<bool>, Member<std::string>, Choice>;

  /// Another option, maybe of another group of the map, and what it must be.
  struct Condition
  {
    std::string key;
    std::vector<std::string> texts;  ///< any of them
  };
  /// Conditions of which one must hold.
  using AnyOf = std::vector<Condition>;

  std::string key;
  std::string doc;   ///< one line
  std::string unit;  ///< "m", "deg" or "" for a plain number
  LegalRange range;
  std::string emptyText;  ///< what a number means that is left empty, e.g. "2 cells"
  Access access;
  std::vector<AnyOf> conditions{};  ///< all must hold, else the option is without effect

  /// Shortest text that parse() turns into the same; empty for a length that is left empty.
  [[nodiscard]] std::string textOf(const TOptionGroup& group) const;
  /** Sets the option from text as it stands in an .ini file, without comments.
   * @throws std::invalid_argument saying what is wrong and what is legal; the option keeps what it had. */
  void parse(TOptionGroup& group, const std::string& text) const;
  /// For messages: "a number >= 0, in m", "one of: samples, line, none".
  [[nodiscard]] std::string legalText() const;

  void write(const TOptionGroup& group, ByteWriter& out) const;
  /// @throws std::runtime_error if the type differs or the content is not legal.
  void read(TOptionGroup& group, ByteReader& in) const;
};

/** Describes every option of a group once; loading, saving, printing, serializing and comparing follow from
 * it.
 *
 * Immutable after construction: may be shared between threads. */
class OptionTable
{
 public:
  /// What an option needs beside its key, its place and its meaning.
  struct Traits
  {
    std::string unit{};
    LegalRange range{};
    std::string emptyText{};
    std::vector<std::string> names{};

    [[nodiscard]] static Traits oneOf(std::vector<std::string> names)
    {
      return {"", {}, "", std::move(names)};
    }
  };

  /// @param name of the group in messages and as the end of its section, e.g. "insertOpts".
  explicit OptionTable(std::string name) : name_(std::move(name)) {}

  /** Adds an option.
   * @param place a pointer to member or a function from Group& to a reference: double, uint32_t, an
   * std::optional of these (then traits.emptyText), int, bool, std::string, an enumeration (then
   * traits.names) or an std::optional of one, for which there is the name "automatic", too. */
  template <typename Group, typename Place>
  OptionTable& add(const std::string& key, Place place, Traits traits, const std::string& doc);

  /** States that options which were added before have no effect unless one of the conditions holds. */
  OptionTable& onlyWhere(const std::vector<std::string>& keys, const Option::AnyOf& conditions);

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const std::vector<Option>& options() const { return options_; }
  /// By key, in which case does not matter, as in MRPT's .ini files; nullptr if there is none.
  [[nodiscard]] const Option* find(const std::string& key) const;
  /// The same. @throws std::invalid_argument naming the nearest key if there is none.
  [[nodiscard]] const Option& require(const std::string& key) const;

 private:
  std::string name_;
  std::vector<Option> options_;
};

/** A group of options that loads, saves, prints and serializes itself as MRPT's groups do, but strictly.
 *
 * A class derived from it gives its table, and validate() where options depend on each other. */
class TOptionGroup : public mrpt::config::CLoadableOptions
{
 public:
  [[nodiscard]] virtual const OptionTable& optionTable() const = 0;

  /// @throws std::invalid_argument if options that are legal by themselves contradict each other.
  virtual void validate() const {}

  /** Loads what the section holds; options that it does not name keep what they have. Nothing changes on an
   * error.
   * @throws std::invalid_argument naming file, section, key and text, and what would be right: for a key that
   * is not an option (keys() of optionTable() are), a text that is not of the option's type, or out of its
   * range. */
  void loadFromConfigFile(const mrpt::config::CConfigFileBase& source, const std::string& section) override;

  /// Writes every option with its meaning as a comment; lengths that are left empty are not written.
  void saveToConfigFile(mrpt::config::CConfigFileBase& target, const std::string& section) const override;
  void dumpToTextStream(std::ostream& out) const override;

  /// Every option, exactly. With count and checksum: a damaged stream is refused.
  void writeToStream(mrpt::serialization::CArchive& out) const;
  /// @throws std::runtime_error as readPayload() and read(); nothing changes then.
  void readFromStream(mrpt::serialization::CArchive& in);

  /// The same as part of larger content.
  void write(ByteWriter& out) const;
  /** Options that the content does not hold keep what they have.
   * @throws std::runtime_error if it holds an option that is not known here, or one that is not legal. */
  void read(ByteReader& in);

  /// Whether both have the same options with the same content.
  [[nodiscard]] bool sameOptions(const TOptionGroup& other) const;

 protected:
  /// Keys that a section of this group may also hold because somebody else reads them, as yes or no.
  [[nodiscard]] virtual std::vector<std::string> foreignFlags() const { return {}; }
};

/// An option as text, for reports and for comparison.
struct OptionValue
{
  std::string section;  ///< e.g. "insertOpts"
  std::string key;
  std::string text;         ///< as it stands; a length that is left empty: e.g. "2 cells"
  std::string defaultText;  ///< as in a group nobody has touched
  std::string unit;
  std::string legal;  ///< e.g. "a number >= 0, in m"
  std::string doc;
};

/// Without what follows //, # or ; at the start or after a space, and without spaces around.
[[nodiscard]] std::string withoutComment(const std::string& text);

/** A message that MRPT passes on whole: when it wraps an exception it takes what stands before the first ]
 * for a place in the source. */
[[nodiscard]] std::string withoutBrackets(std::string message);

/** Whether a section has a key. Asks for it by name: MRPT's CConfigFilePrefixer (map-partition reads through
 * one) lists the keys of another section, as keyExists() does then. */
[[nodiscard]] bool hasKey(const mrpt::config::CConfigFileBase& source, const std::string& section,
                          const std::string& key);

/// The file that was loaded, or "the configuration".
[[nodiscard]] std::string nameOf(const mrpt::config::CConfigFileBase& source);

// ------------------------------------------------------------------------------------------------------------------

template <typename T>
struct IsOptionalEnumeration : std::false_type
{
};
template <typename T>
struct IsOptionalEnumeration<std::optional<T>> : std::is_enum<T>
{
};

template <typename Group, typename Place>
OptionTable& OptionTable::add(const std::string& key, Place place, Traits traits, const std::string& doc)
{
  static_assert(std::is_base_of_v<TOptionGroup, Group>);
  using Content = std::remove_reference_t<std::invoke_result_t<Place, Group&>>;
  Option option{key, doc, traits.unit, traits.range, traits.emptyText, {}, {}};
  if constexpr (IsOptionalEnumeration<Content>::value)
  {
    // Number 0 is the empty one.
    std::vector<std::string> names = traits.names;
    names.insert(names.begin(), "automatic");
    option.access = Option::Choice{[place](const TOptionGroup& group)
                                   {
                                     const Content& chosen = std::invoke(
                                         place, const_cast<Group&>(static_cast<const Group&>(group)));
                                     return chosen ? static_cast<int>(*chosen) + 1 : 0;
                                   },
                                   [place](TOptionGroup& group, int number)
                                   {
                                     Content& chosen = std::invoke(place, static_cast<Group&>(group));
                                     chosen.reset();
                                     if (number > 0)
                                       chosen = static_cast<typename Content::value_type>(number - 1);
                                   },
                                   std::move(names)};
  }
  else if constexpr (std::is_enum_v<Content>)
  {
    option.access = Option::Choice{
        [place](const TOptionGroup& group) {
          return static_cast<int>(std::invoke(place, const_cast<Group&>(static_cast<const Group&>(group))));
        },
        [place](TOptionGroup& group, int number)
        { std::invoke(place, static_cast<Group&>(group)) = static_cast<Content>(number); },
        traits.names};
  }
  else
  {
    option.access = Option::Member<Content>([place](TOptionGroup& group) -> Content&
                                            { return std::invoke(place, static_cast<Group&>(group)); });
  }
  options_.push_back(std::move(option));
  return *this;
}

}  // namespace lamap
