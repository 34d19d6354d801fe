#pragma once

#include <fuzzer/FuzzedDataProvider.h>
#include <mrpt/poses/CPose3D.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace lamap::fuzz
{
/** The bytes of an input as numbers of the kind that a target asks for: mostly ones that maps are used with,
 * some that no sensor gives. */
class FuzzInput
{
 public:
  FuzzInput(const uint8_t* bytes, size_t size) : bytes_(bytes, size) {}

  [[nodiscard]] bool isEmpty() { return bytes_.remaining_bytes() == 0; }
  /// From 0 to count - 1.
  [[nodiscard]] size_t below(size_t count) { return bytes_.ConsumeIntegralInRange<size_t>(0, count - 1); }
  [[nodiscard]] bool yesOrNo() { return bytes_.ConsumeBool(); }
  [[nodiscard]] std::string text(size_t longest) { return bytes_.ConsumeRandomLengthString(longest); }

  /// Within 3.2 of 0 in steps of 1/40, sometimes between, sometimes nothing that a place could be. Small, for
  /// under the sanitizers each cell of a ray counts.
  [[nodiscard]] double number()
  {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    constexpr double kHostile[] = {std::numeric_limits<double>::quiet_NaN(),
                                   kInfinity,
                                   -kInfinity,
                                   std::numeric_limits<float>::max(),
                                   std::numeric_limits<double>::max(),
                                   std::numeric_limits<double>::denorm_min(),
                                   -0.0,
                                   1e-9,
                                   -1e-30,
                                   2147483647.0,
                                   -2147483649.0,
                                   2.139e8,
                                   1e12,
                                   -1e300};
    const auto kind = bytes_.ConsumeIntegral<uint8_t>();
    if (kind < 200) return 0.025 * bytes_.ConsumeIntegral<int8_t>();
    if (kind < 240) return bytes_.ConsumeFloatingPointInRange(-5.0, 5.0);
    return kHostile[kind % std::size(kHostile)];
  }

  /// The same as a float.
  [[nodiscard]] float shortNumber()
  {
    constexpr double kMost = std::numeric_limits<float>::max();
    const double wide = number();
    return static_cast<float>(std::isfinite(wide) ? std::clamp(wide, -kMost, kMost) : wide);
  }

  [[nodiscard]] mrpt::poses::CPose3D pose()
  {
    const double x = number();
    const double y = number();
    const double z = number();
    const double yaw = number();
    const double pitch = number();
    return {x, y, z, yaw, pitch, number()};
  }

 private:
  FuzzedDataProvider bytes_;
};

}  // namespace lamap::fuzz
