#pragma once

#include <cstddef>
#include <vector>

namespace lamap
{
/// What of a ping's intensities is an echo.
struct EchoRules
{
  /// Least intensity of an echo near the sensor, and at the maximum range; linear between them, because
  /// echoes fade with range. In the unit of the intensities.
  double nearThreshold = 0;
  double farThreshold = 0;
  double deadZone_m = 0.5;    ///< what is nearer is the transmitter's own noise
  double separation_m = 0.5;  ///< of two echoes that are nearer to each other, the stronger one counts
  size_t mostEchoes = 3;      ///< of one ping, the nearest ones

  /// @throws std::invalid_argument naming the first illegal rule, its value and the legal range
  void validate() const;
};

struct DetectedEcho
{
  double range_m = 0;
  double intensity = 0;

  friend bool operator==(const DetectedEcho& a, const DetectedEcho& b)
  {
    return a.range_m == b.range_m && a.intensity == b.intensity;
  }
};

/** Finds the echoes in the intensities of one ping: local maxima that reach the threshold of their range.
 *
 * Of bins of equal intensity side by side, the nearest one is the maximum: an echo begins where the sound
 * meets a surface. NaN is below any threshold.
 * @param intensities of bins of equal length from the sensor to the maximum range
 * @param rangeMax_m > 0. @param rules valid
 * @return by range, each at the middle of its bin */
[[nodiscard]] std::vector<DetectedEcho> findEchoes(const std::vector<double>& intensities, double rangeMax_m,
                                                   const EchoRules& rules);

}  // namespace lamap
