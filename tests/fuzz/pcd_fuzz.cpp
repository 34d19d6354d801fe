// PCD files.
#include <lamap_tools/inputs/pcd_file.h>

#include "file_in_memory.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size)
{
  lamap::fuzz::readFile(bytes, size, ".pcd",
                        [](const std::string& path) { (void)lamap::tools::readPcdFile(path); });
  return 0;
}
