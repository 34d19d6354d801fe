#pragma once

#include <mrpt/maps/CSimpleMap.h>

#include <functional>
#include <string>

namespace lamap::tools
{
/** Reads a simple map; what might crash or take all memory is tried in a child process first.
 * @return an empty map if it was asked to stop
 * @throws std::runtime_error naming the file if it is none, cut short or damaged */
[[nodiscard]] mrpt::maps::CSimpleMap readSimpleMap(const std::string& path,
                                                   const std::function<bool()>& shouldStop);

}  // namespace lamap::tools
