#pragma once

#include <lamap_mrpt/learned_map/CLearnedMap.h>
#include <pybind11/pybind11.h>

#include <memory>
#include <string>
#include <vector>

namespace lamap::python
{
/** Keywords as the settings "section.key=value" that `lamap build -s` takes. None leaves an option alone.
 * @param alias  of the kind of map
 * @throws std::invalid_argument naming the nearest option for an unknown one, or a value that no option has
 */
[[nodiscard]] std::vector<std::string> settingsOf(const std::string& alias, const pybind11::dict& keywords);

/// A new map with these options. @throws as settingsOf(), and naming an illegal option; FileError for a prior
/// map that cannot be read
[[nodiscard]] std::shared_ptr<CLearnedMap> makeMap(const std::string& alias, const pybind11::dict& keywords);

/// All options by key, read-only: numbers, truth values and texts; None where an option is left empty.
[[nodiscard]] pybind11::object optionsOf(const std::vector<OptionValue>& values);

/// "bgk", "bgkMap" or the class of Python: the alias of the map. @throws std::invalid_argument
/// naming the nearest name
[[nodiscard]] std::string aliasOf(const pybind11::handle& map);

/// Takes the flag from a message of the command line: "-s insertOpts.…" becomes "insertOpts.…".
[[nodiscard]] std::string withoutFlag(const std::string& message);

}  // namespace lamap::python
