#pragma once

#include <lamap_core/options/option.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace lamap
{
/** Describes every option of a struct once; checking, comparing, loading, saving, printing, serializing and
 * documenting follow from it. Made by OptionTableOf, which knows the struct.
 *
 * Immutable after construction: may be shared between threads. */
class OptionTable
{
 public:
  /// A condition that no range says. @throws std::invalid_argument naming the option, its value and what is
  /// legal
  using Check = std::function<void(ConstAnyOptions)>;

  /// Of the group in messages and as the end of its section, e.g. "insertOpts".
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const std::vector<Option>& options() const { return options_; }
  /// By key, in which case does not matter, as in MRPT's .ini files; nullptr if there is none.
  [[nodiscard]] const Option* find(const std::string& key) const;
  /// The same. @throws std::invalid_argument naming the nearest key if there is none.
  [[nodiscard]] const Option& require(const std::string& key) const;

  /** Checks every option, then what depends on several.
   * @param resolution_m nothing: ends of ranges that are given in cells are not checked
   * @throws std::invalid_argument "<name> = <value>: must be <legal>" for the first that is illegal. A choice
   * that is none of the names has no value to be named. */
  void validate(ConstAnyOptions options, std::optional<double> resolution_m) const;
  /// The first option in which two structs differ; nullptr if there is none.
  [[nodiscard]] const Option* firstDifference(ConstAnyOptions a, ConstAnyOptions b) const;
  /// Whether two structs have the same in every option.
  [[nodiscard]] bool same(ConstAnyOptions a, ConstAnyOptions b) const { return !firstDifference(a, b); }
  /// Sets lengths that are left empty to their default number of cells.
  void fillIn(AnyOptions options, double resolution_m) const;

 protected:
  explicit OptionTable(std::string name) : name_(std::move(name)) {}
  [[nodiscard]] static const std::vector<Check>& checksOf(const OptionTable& table) { return table.checks_; }

  std::vector<Option> options_;
  std::vector<Check> checks_;

 private:
  std::string name_;
};

/// Builds the table of a struct. @tparam Options the struct
template <typename Options>
class OptionTableOf : public OptionTable
{
 public:
  explicit OptionTableOf(std::string name) : OptionTable(std::move(name)) {}

  /** Adds an option.
   * @param place a pointer to member or a function from Options& to a reference: double, uint32_t, an
   * std::optional of these (then with what is usual), int, bool, std::string, an enumeration (then with
   * names) or an std::optional of one, for which there is the name "automatic", too. */
  template <typename Place>
  OptionTableOf& add(const std::string& key, Place place, OptionTraits traits, const std::string& doc);

  /// Adds the options of a struct that Options derives from, as its own table describes them.
  template <typename Base>
  OptionTableOf& include();

  /// States that options that were added before have no effect unless one of the conditions holds.
  OptionTableOf& onlyWhere(const std::vector<std::string>& keys, const Option::AnyOf& conditions)
  {
    for (Option& option : options_)
      if (std::find(keys.begin(), keys.end(), option.key) != keys.end())
        option.conditions.push_back(conditions);
    return *this;
  }

  /// Adds a condition that no range says. @param check of a const Options&
  template <typename CheckOptions>
  OptionTableOf& check(CheckOptions check)
  {
    checks_.push_back([check](ConstAnyOptions options) { check(options.as<Options>()); });
    return *this;
  }
};

/// Checks a struct by its own table, as OptionTable::validate().
template <typename Options>
void requireLegalOptions(const Options& options, std::optional<double> resolution_m)
{
  Options::optionTable().validate(ConstAnyOptions(&options), resolution_m);
}

/// Compares two structs by their own table.
template <typename Options>
[[nodiscard]] bool sameOptions(const Options& a, const Options& b)
{
  return Options::optionTable().same(ConstAnyOptions(&a), ConstAnyOptions(&b));
}

/** Refuses a struct that differs from a model in any option.
 * @throws std::invalid_argument "<name> <whose> = <text>: must be <due>, <text>" for the first difference. */
template <typename Options>
void requireSameOptions(const Options& options, const Options& model, const std::string& whose,
                        const std::string& due)
{
  const Option* option =
      Options::optionTable().firstDifference(ConstAnyOptions(&options), ConstAnyOptions(&model));
  if (option)
    throw std::invalid_argument(option->key + " " + whose + " = " +
                                option->textOf(ConstAnyOptions(&options)) + ": must be " + due + ", " +
                                option->textOf(ConstAnyOptions(&model)));
}

/// A copy with the lengths that are given in cells filled in.
template <typename Options>
[[nodiscard]] Options withLengths(Options options, double resolution_m)
{
  Options::optionTable().fillIn(AnyOptions(&options), resolution_m);
  return options;
}

// ------------------------------------------------------------------------------------------------------------------

namespace detail
{
template <typename T>
struct IsOptional : std::false_type
{
};
template <typename T>
struct IsOptional<std::optional<T>> : std::true_type
{
};

template <typename T>
constexpr OptionType optionType()
{
  if constexpr (std::is_same_v<T, double>) return OptionType::Number;
  if constexpr (std::is_same_v<T, uint32_t>) return OptionType::Unsigned;
  if constexpr (std::is_same_v<T, int32_t>) return OptionType::Signed;
  if constexpr (std::is_same_v<T, bool>) return OptionType::Flag;
  if constexpr (std::is_same_v<T, std::string>) return OptionType::Text;
  return OptionType::Choice;
}

/// How a member of a type is content, and back.
template <typename T>
struct OptionAccess
{
  static OptionContent get(const T& member)
  {
    if constexpr (std::is_enum_v<T>)
      return OptionChoice{static_cast<size_t>(member)};
    else
      return member;
  }
  static void set(T& member, const OptionContent& content)
  {
    if constexpr (std::is_enum_v<T>)
      member = static_cast<T>(std::get<OptionChoice>(content).number);
    else
      member = std::get<T>(content);
  }
};
/// An enumeration that is left empty has the number 0, "automatic"; a number has no content.
template <typename T>
struct OptionAccess<std::optional<T>>
{
  static OptionContent get(const std::optional<T>& member)
  {
    if constexpr (std::is_enum_v<T>)
    {
      const size_t number = member ? static_cast<size_t>(*member) : 0;
      // That of −1 does not become 0.
      return OptionChoice{member && number + 1 != 0 ? number + 1 : number};
    }
    else
      return member ? OptionContent(*member) : OptionContent();
  }
  static void set(std::optional<T>& member, const OptionContent& content)
  {
    member.reset();
    if constexpr (std::is_enum_v<T>)
    {
      const size_t number = std::get<OptionChoice>(content).number;
      if (number > 0) member = static_cast<T>(number - 1);
    }
    else if (!std::holds_alternative<std::monostate>(content))
      member = std::get<T>(content);
  }
};
}  // namespace detail

template <typename Options>
template <typename Place>
OptionTableOf<Options>& OptionTableOf<Options>::add(const std::string& key, Place place, OptionTraits traits,
                                                    const std::string& doc)
{
  using Member = std::remove_reference_t<std::invoke_result_t<Place, Options&>>;
  Option option;
  static_cast<OptionTraits&>(option) = std::move(traits);
  option.key = key;
  option.doc = doc;
  if constexpr (detail::IsOptional<Member>::value)
  {
    using Held = typename Member::value_type;
    option.type = detail::optionType<Held>();
    option.mayBeEmpty = !std::is_enum_v<Held>;
    if (std::is_enum_v<Held>) option.names.insert(option.names.begin(), "automatic");
  }
  else
    option.type = detail::optionType<Member>();
  option.get = [place](ConstAnyOptions options)
  {
    // Reading through a place changes nothing.
    return detail::OptionAccess<Member>::get(std::invoke(place, const_cast<Options&>(options.as<Options>())));
  };
  option.set = [place](AnyOptions options, const OptionContent& content)
  { detail::OptionAccess<Member>::set(std::invoke(place, options.as<Options>()), content); };
  options_.push_back(std::move(option));
  return *this;
}

template <typename Options>
template <typename Base>
OptionTableOf<Options>& OptionTableOf<Options>::include()
{
  static_assert(std::is_base_of_v<Base, Options>);
  const OptionTable& table = Base::optionTable();
  const auto constBase = [](ConstAnyOptions options)
  { return ConstAnyOptions(static_cast<const Base*>(&options.as<Options>())); };
  for (Option option : table.options())
  {
    option.get = [get = std::move(option.get), constBase](ConstAnyOptions options)
    { return get(constBase(options)); };
    option.set = [set = std::move(option.set)](AnyOptions options, const OptionContent& content)
    { set(AnyOptions(static_cast<Base*>(&options.as<Options>())), content); };
    options_.push_back(std::move(option));
  }
  for (const Check& check : checksOf(table))
    checks_.push_back([check, constBase](ConstAnyOptions options) { check(constBase(options)); });
  return *this;
}

}  // namespace lamap
