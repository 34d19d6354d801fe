// Points as CSV.
#include <lamap_tools/files/point_list.h>

#include "file_in_memory.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size)
{
  lamap::fuzz::readFile(bytes, size, ".csv",
                        [](const std::string& path) { (void)lamap::tools::readPointsFile(path); });
  return 0;
}
