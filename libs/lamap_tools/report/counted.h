#pragma once

#include <cstddef>
#include <string>

namespace lamap::tools
{
/// How many of a thing: "1 scan", "2 scans", "3 entries". @param noun in the singular
[[nodiscard]] std::string counted(size_t count, const std::string& noun);

}  // namespace lamap::tools
