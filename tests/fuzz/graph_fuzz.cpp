// OctoMap's scan graphs.
#include <lamap_tools/inputs/graph_file.h>

#include "file_in_memory.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size)
{
  lamap::fuzz::readFile(bytes, size, ".graph",
                        [](const std::string& path)
                        {
                          lamap::tools::GraphFile file(path);
                          while (file.next())
                          {
                          }
                        });
  return 0;
}
