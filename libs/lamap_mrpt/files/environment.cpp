#include <lamap_mrpt/files/environment.h>

#include <charconv>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>

namespace lamap
{
std::optional<uint64_t> limitFromEnvironment(const char* name)
{
  const char* const set = std::getenv(name);
  if (set == nullptr) return std::nullopt;
  const std::string_view text = set;
  double number = 0;
  const auto parsed = std::from_chars(text.data(), text.data() + text.size(), number);
  const bool isNumber = parsed.ec == std::errc() && parsed.ptr == text.data() + text.size();
  if (!isNumber || !std::isfinite(number) || number < 1)
    throw std::runtime_error("the environment variable " + std::string(name) + " is '" + std::string(text) +
                             "'; it must be a number of at least 1");
  constexpr auto kMost = std::numeric_limits<uint64_t>::max();
  return number >= static_cast<double>(kMost) ? kMost : static_cast<uint64_t>(number);
}

}  // namespace lamap
