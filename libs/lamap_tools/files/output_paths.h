#pragma once

#include <string>
#include <vector>

namespace lamap::tools
{
/** Refuses to write over what is read, and to write a file twice: what stood there would be lost. Different
 * paths to one file (links, "./") are one file. Empty paths count nothing.
 * @throws UsageError naming the paths */
void requireOwnPlaces(const std::vector<std::string>& outputs, const std::vector<std::string>& inputs);

}  // namespace lamap::tools
