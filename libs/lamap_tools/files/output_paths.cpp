#include <lamap_tools/files/output_paths.h>
#include <lamap_tools/files/usage_error.h>

#include <filesystem>

namespace lamap::tools
{
namespace
{
bool sameFile(const std::string& a, const std::string& b)
{
  std::error_code missing;
  if (std::filesystem::equivalent(a, b, missing)) return true;
  return std::filesystem::weakly_canonical(a, missing) == std::filesystem::weakly_canonical(b, missing);
}

std::string beside(const std::string& path, const std::string& other)
{
  return path == other ? path : path + " (" + other + ")";
}
}  // namespace

void requireOwnPlaces(const std::vector<std::string>& outputs, const std::vector<std::string>& inputs)
{
  for (size_t i = 0; i < outputs.size(); ++i)
  {
    if (outputs[i].empty()) continue;
    for (const std::string& input : inputs)
      if (!input.empty() && sameFile(outputs[i], input))
        throw UsageError(beside(outputs[i], input) +
                         ": is an input, and would be overwritten; give the output another name");
    for (size_t j = 0; j < i; ++j)
      if (!outputs[j].empty() && sameFile(outputs[i], outputs[j]))
        throw UsageError(beside(outputs[i], outputs[j]) + ": would be written twice");
  }
}

}  // namespace lamap::tools
