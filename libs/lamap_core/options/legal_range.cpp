#include <lamap_core/options/legal_range.h>

#include <array>
#include <charconv>
#include <stdexcept>

namespace lamap
{
void requireLegal(bool condition, const char* name, double value, const std::string& legal)
{
  if (!condition)
    throw std::invalid_argument(std::string(name) + " = " + shortText(value) + ": must be " + legal);
}

std::string shortText(double value)
{
  std::array<char, 32> shortest{};
  const auto end = std::to_chars(shortest.data(), shortest.data() + shortest.size(), value);
  return {shortest.data(), end.ptr};
}

}  // namespace lamap
