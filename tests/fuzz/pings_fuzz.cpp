// Pings of a scanning sonar as CSV, and their echoes.
#include <lamap_tools/inputs/ping_file.h>

#include "file_in_memory.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size)
{
  lamap::fuzz::readFile(bytes, size, ".csv",
                        [](const std::string& path)
                        {
                          const lamap::tools::PingFile file =
                              lamap::tools::PingFile::read(path, {}, [] { return false; });
                          for (const auto& ping : file.pings) (void)lamap::tools::fanOf(ping, {});
                        });
  return 0;
}
