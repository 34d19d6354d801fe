#include <lamap_core/options/nearest_name.h>
#include <lamap_mrpt/options/option_group.h>
#include <lamap_python/errors.h>
#include <lamap_python/options.h>
#include <lamap_python/paths.h>
#include <lamap_tools/config/map_setup.h>
#include <lamap_tools/files/usage_error.h>

#include <map>
#include <optional>
#include <stdexcept>
#include <utility>

namespace py = pybind11;

namespace lamap::python
{
namespace
{
const std::vector<std::string> kAliases{"bgkMap", "gpMap", "hilbertMap", "overlappingHilbertMap"};

/// The tables of a map's four groups; they last as long as the program.
using OptionTables = std::vector<const OptionTable*>;

std::shared_ptr<CLearnedMap> createLearned(const std::string& alias, const std::vector<std::string>& settings)
{
  const auto map = tools::createMap(tools::readMapDefinition({alias, "", settings, {}}));
  return std::dynamic_pointer_cast<CLearnedMap>(map);
}

/// Called with the GIL, which guards what is kept.
const OptionTables& tablesOf(const std::string& alias)
{
  static std::map<std::string, OptionTables> kept;
  OptionTables& tables = kept[alias];
  if (tables.empty())
    createLearned(alias, {})->visitOptionGroups([&](const TOptionGroup& group, const TOptionGroup&)
                                                { tables.push_back(&group.optionTable()); });
  return tables;
}

/// @return the section and the option
std::pair<std::string, const Option*> findOption(const std::string& alias, const std::string& key)
{
  std::vector<std::string> known;
  for (const OptionTable* table : tablesOf(alias))
  {
    if (const Option* option = table->find(key)) return {table->name(), option};
    for (const Option& option : table->options()) known.push_back(option.key);
  }
  throw std::invalid_argument("unknown option \"" + key + "\"; " + suggestionFor(key, known, "\"", "\""));
}

/// A value as it would stand in an .ini file.
std::string textOf(const py::handle& value, const std::string& key)
{
  const std::string type = py::str(py::type::handle_of(value).attr("__name__"));
  if (py::isinstance<py::bool_>(value) || type == "bool_") return value.cast<bool>() ? "true" : "false";
  if (py::isinstance<py::str>(value) || py::hasattr(value, "__fspath__")) return pathOf(value);
  if (PyIndex_Check(value.ptr()) != 0) return py::str(py::int_(py::reinterpret_borrow<py::object>(value)));
  if (PyFloat_Check(value.ptr()) != 0 || py::hasattr(value, "__float__"))
    return py::repr(py::float_(py::reinterpret_borrow<py::object>(value)));
  throw std::invalid_argument(key + ": must be a number, a truth value or a text, not of type " + type);
}
}  // namespace

std::string withoutFlag(const std::string& message)
{
  const bool hasFlag = message.rfind("-s ", 0) == 0 || message.rfind("-m ", 0) == 0;
  return hasFlag ? message.substr(3) : message;
}

std::vector<std::string> settingsOf(const std::string& alias, const py::dict& keywords)
{
  std::vector<std::string> settings;
  for (const auto& [name, value] : keywords)
  {
    const auto [section, option] = findOption(alias, py::str(name));
    if (value.is_none()) continue;
    const std::string text = textOf(value, option->key);
    if (text.empty() && option->type == OptionType::Text) continue;
    if (text.empty())
      throw std::invalid_argument(section + "." + option->key + " = \"\": must be " + option->legalText());
    if (withoutComment(text) != text)
      throw std::invalid_argument(
          section + "." + option->key + " = \"" + text +
          "\": must not begin or end with a space, or hold what .ini files take for a "
          "comment");
    settings.push_back(section + "." + option->key + "=" + text);
  }
  return settings;
}

std::shared_ptr<CLearnedMap> makeMap(const std::string& alias, const py::dict& keywords)
{
  const std::vector<std::string> settings = settingsOf(alias, keywords);
  const std::string priorMap =
      keywords.contains("priorMap") && !keywords["priorMap"].is_none() ? pathOf(keywords["priorMap"]) : "";
  try
  {
    return withFile(priorMap, [&] { return createLearned(alias, settings); });
  }
  catch (const tools::UsageError& error)
  {
    throw std::invalid_argument(withoutFlag(error.what()));
  }
}

namespace
{
py::object pythonOf(const OptionValue& value)
{
  struct Convert
  {
    const OptionValue& value;
    py::object operator()(std::monostate) const { return py::none(); }
    py::object operator()(const OptionChoice&) const { return py::str(value.text); }
    py::object operator()(double number) const { return py::float_(number); }
    py::object operator()(bool flag) const { return py::bool_(flag); }
    py::object operator()(const std::string& text) const { return py::str(text); }
    py::object operator()(uint32_t number) const { return py::int_(number); }
    py::object operator()(int32_t number) const { return py::int_(number); }
  };
  return std::visit(Convert{value}, value.content);
}
}  // namespace

py::object optionsOf(const std::vector<OptionValue>& values)
{
  py::dict options;
  for (const OptionValue& value : values) options[py::str(value.key)] = pythonOf(value);
  return py::module_::import("types").attr("MappingProxyType")(options);
}

std::string aliasOf(const py::handle& map)
{
  if (py::isinstance<py::type>(map) && py::hasattr(map, "alias") &&
      py::isinstance<py::str>(map.attr("alias")))
    return py::str(map.attr("alias"));
  if (!py::isinstance<py::str>(map))
    throw std::invalid_argument("map: must be the name or the class of a map");
  const std::string name = py::str(map);
  std::vector<std::string> names;
  for (const std::string& alias : kAliases)
  {
    const std::string shortName = alias.substr(0, alias.size() - 3);
    if (name == alias || name == shortName) return alias;
    names.push_back(shortName);
  }
  throw std::invalid_argument(name + ": no map of this name; " + suggestionFor(name, names));
}

}  // namespace lamap::python
