#include <lamap_core/legal_range.h>

#include <array>
#include <charconv>
#include <stdexcept>

namespace lamap
{
void requireLegal(bool condition, const char* name, double value, const std::string& legal)
{
  if (condition) return;
  std::array<char, 32> shortest{};
  const auto end = std::to_chars(shortest.data(), shortest.data() + shortest.size(), value);
  throw std::invalid_argument(std::string(name) + " = " + std::string(shortest.data(), end.ptr) +
                              ": must be " + legal);
}

}  // namespace lamap
