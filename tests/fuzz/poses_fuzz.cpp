// Files of poses in every format that is read.
#include <lamap_tools/inputs/pose_track.h>

#include "file_in_memory.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size)
{
  lamap::fuzz::readFile(bytes, size, ".txt",
                        [](const std::string& path) { (void)lamap::tools::readPoseFile(path); });
  return 0;
}
