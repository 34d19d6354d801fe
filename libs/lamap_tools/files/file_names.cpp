#include <lamap_tools/files/file_names.h>
#include <mrpt/system/string_utils.h>

#include <filesystem>

namespace lamap::tools
{
std::string extensionOf(const std::string& path)
{
  return mrpt::system::lowerCase(std::filesystem::path(path).extension().string());
}

bool endsWith(const std::string& path, const std::string& ending)
{
  return path.size() > ending.size() &&
         mrpt::system::lowerCase(path.substr(path.size() - ending.size())) == ending;
}

}  // namespace lamap::tools
