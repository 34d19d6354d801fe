#include <lamap_core/options/nearest_name.h>
#include <lamap_core/options/option_table.h>

#include <stdexcept>

namespace lamap
{
namespace
{
[[noreturn]] void refuse(const Option& option, double number, const std::string& legal)
{
  throw std::invalid_argument(option.key + " = " + shortText(number) + ": must be " + legal);
}

/// A number that was cast into an enumeration need not be one of its enumerators.
void requireNamed(const Option& option, OptionChoice choice)
{
  if (choice.number >= option.names.size())
    throw std::invalid_argument(option.key + " is not an enumerator: must be " + option.legalText());
}
}  // namespace

const Option* OptionTable::find(const std::string& key) const
{
  for (const Option& option : options_)
    if (option.key == key) return &option;
  for (const Option& option : options_)
    if (lowerCase(option.key) == lowerCase(key)) return &option;
  return nullptr;
}

const Option& OptionTable::require(const std::string& key) const
{
  if (const Option* option = find(key)) return *option;
  std::vector<std::string> known;
  for (const Option& option : options_) known.push_back(option.key);
  throw std::invalid_argument("unknown option \"" + name_ + "." + key + "\"; " +
                              suggestionFor(key, known, name_ + "."));
}

void OptionTable::validate(ConstAnyOptions options, std::optional<double> resolution_m) const
{
  for (const Option& option : options_)
  {
    const OptionContent content = option.get(options);
    if (const auto* choice = std::get_if<OptionChoice>(&content)) requireNamed(option, *choice);
    const std::optional<double> number = numberIn(content);
    if (!number) continue;
    if (!option.range.holds(*number, resolution_m)) refuse(option, *number, option.legalText());
    if (option.floorKey.empty() || (option.range.orZero && *number == 0)) continue;
    const std::optional<double> floor = numberIn(require(option.floorKey).get(options));
    if (floor && !(option.floorIncluded ? *number >= *floor : *number > *floor))
      refuse(option, *number, option.legalText() + "; " + option.floorKey + " is " + shortText(*floor));
  }
  for (const Check& check : checks_) check(options);
}

const Option* OptionTable::firstDifference(ConstAnyOptions a, ConstAnyOptions b) const
{
  const auto found = std::find_if(options_.begin(), options_.end(),
                                  [&](const Option& option) { return !(option.get(a) == option.get(b)); });
  return found == options_.end() ? nullptr : &*found;
}

void OptionTable::fillIn(AnyOptions options, double resolution_m) const
{
  for (const Option& option : options_)
    if (option.emptyCells != 0 && std::holds_alternative<std::monostate>(option.get(options)))
      option.set(options, option.emptyCells * resolution_m);
}

}  // namespace lamap
