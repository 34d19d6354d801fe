#pragma once

#include <cstdint>
#include <exception>
#include <filesystem>
#include <fstream>
#include <string>

#include <unistd.h>

#include "heap_limit.h"

// For targets that read files.
namespace lamap::fuzz
{
/// The path of a file with these bytes, always the same one; in memory where the system has a place for it.
inline std::string fileWith(const uint8_t* bytes, size_t size, const std::string& extension)
{
  static const std::string folder =
      std::filesystem::exists("/dev/shm") ? "/dev/shm" : std::filesystem::temp_directory_path().string();
  const std::string path = folder + "/lamap-fuzz-" + std::to_string(getpid()) + extension;
  std::ofstream(path, std::ios::binary | std::ios::trunc)
      .write(reinterpret_cast<const char*>(bytes), static_cast<std::streamsize>(size));
  return path;
}

/** Reads a file by read(path): what it refuses, it must refuse by an exception, and whatever it holds, within
 * the memory that a file of its size may take. */
template <typename Read>
void readFile(const uint8_t* bytes, size_t size, const std::string& extension, const Read& read)
{
  const std::string path = fileWith(bytes, size, extension);
  try
  {
    const HeapLimit limit(heapForFile(size));
    read(path);
  }
  catch (const std::exception&)
  {
  }
  std::filesystem::remove(path);
}

}  // namespace lamap::fuzz
