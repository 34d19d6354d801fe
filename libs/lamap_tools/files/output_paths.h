#pragma once

#include <string>
#include <vector>

namespace lamap::tools
{
/** Refuses to overwrite a file that is read, and to write a file twice. Different paths to one file (links,
 * "./") are one file. Empty paths are ignored.
 * @throws UsageError naming the paths */
void requireOwnPlaces(const std::vector<std::string>& outputs, const std::vector<std::string>& inputs);

}  // namespace lamap::tools
