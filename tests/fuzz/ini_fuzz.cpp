// Configurations: as `lamap build -c` and as `lamap run` read them.
#include <lamap_tools/config/map_setup.h>
#include <lamap_tools/config/plugin_run.h>

#include "file_in_memory.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size)
{
  const auto read = [](const std::string& path)
  {
    const auto definition = lamap::tools::readMapDefinition({"", path, {}});
    (void)lamap::tools::createMap(definition);
  };
  lamap::fuzz::readFile(bytes, size, ".ini", read);
  lamap::fuzz::readFile(bytes, size, ".ini", lamap::tools::checkStockConfig);
  return 0;
}
