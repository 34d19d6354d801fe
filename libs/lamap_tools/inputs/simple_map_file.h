#pragma once

#include <mrpt/maps/CSimpleMap.h>

#include <functional>
#include <string>

namespace lamap::tools
{
/** Reads a simple map; a file that might crash MRPT or exhaust memory is tried in a child process first.
 * @return an empty map if it was stopped
 * @throws std::runtime_error naming the file if it is not a simple map, truncated or damaged */
[[nodiscard]] mrpt::maps::CSimpleMap readSimpleMap(const std::string& path,
                                                   const std::function<bool()>& shouldStop);

}  // namespace lamap::tools
