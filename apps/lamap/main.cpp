#include "commands.h"

#include <dlfcn.h>

#include <filesystem>
#include <iostream>
#include <string>

namespace lamap::app
{
std::string messageOf(const std::exception& error)
{
  return error.what();
}

void drawProgressOn(std::streambuf* /*terminal*/) {}

namespace
{
/// The library that runs commands, beside the program.
std::filesystem::path libraryPath()
{
  const std::filesystem::path folder = std::filesystem::canonical("/proc/self/exe").parent_path();
  for (const char* toLibraries : {LAMAP_BIN_TO_LIB, "../lib"})
  {
    const std::filesystem::path path = folder / toLibraries / LAMAP_COMMANDS_LIBRARY;
    if (std::filesystem::exists(path)) return path;
  }
  return folder / LAMAP_BIN_TO_LIB / LAMAP_COMMANDS_LIBRARY;
}

int run(int argc, char** argv)
{
  using Run = int (*)(int, char**);
  void* const library = dlopen(libraryPath().c_str(), RTLD_LAZY);
  const auto run = library != nullptr ? reinterpret_cast<Run>(dlsym(library, "lamapRunCommand")) : nullptr;
  if (run != nullptr) return run(argc, argv);
  std::cerr << "lamap: cannot load what runs commands: " << dlerror() << "\n";
  return kFailed;
}
}  // namespace
}  // namespace lamap::app

int main(int argc, char** argv)
{
  const auto code = lamap::app::runCommandLine(argc, argv);
  return code ? *code : lamap::app::run(argc, argv);
}
