#include <lamap_tools/files/file_input.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <stdexcept>

namespace lamap::tools
{
void requireNoFolder(const std::string& path, const std::string& what)
{
  if (std::filesystem::is_directory(path)) throw std::runtime_error(path + ": is a folder, not " + what);
}

std::ifstream openedFile(const std::string& path, const std::string& what, std::ios::openmode mode)
{
  requireNoFolder(path, what);
  std::ifstream file(path, mode);
  if (!file) throw std::runtime_error(path + ": cannot be opened: " + std::strerror(errno));
  return file;
}

}  // namespace lamap::tools
