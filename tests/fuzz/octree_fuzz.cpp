// OctoMap's trees: the first byte chooses between .ot and .bt.
#include <lamap_tools/cells/cell_map.h>

#include "file_in_memory.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size)
{
  if (size == 0) return 0;
  const auto read = [](const std::string& path)
  {
    const auto map = lamap::tools::openCellMap(path);
    size_t leaves = 0;
    map->visitLeaves([&](const lamap::CellIndex&, int, const lamap::CellEstimate&) { ++leaves; });
    (void)map->estimateAt({0.1, 0.2, 0.3});
  };
  lamap::fuzz::readFile(bytes + 1, size - 1, bytes[0] % 2 == 0 ? ".ot" : ".bt", read);
  return 0;
}
