#pragma once

#include <lamap_core/scan/direction_angles.h>
#include <lamap_core/scan/scan.h>

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <vector>

namespace lamap
{
/** Directions in bins of a part of a degree: rows by elevation, columns by azimuth. Whole steps stand in the
 * middle of a bin: sensors like them. The same on every processor. @tparam kPerDegree bins */
template <int kPerDegree>
struct DirectionBinOf
{
  static constexpr int kRows = 180 * kPerDegree + 1;  ///< from straight down to straight up
  static constexpr int kColumns = 360 * kPerDegree;
  static constexpr int kNowhere = -1;  ///< the column of what has no direction

  int row = 0;
  int column = kNowhere;

  [[nodiscard]] bool isSomewhere() const { return column != kNowhere; }

  [[nodiscard]] static bool hasOne(const Eigen::Vector3d& direction)
  {
    return direction.allFinite() && !direction.isZero(0);
  }

  /// @param direction with hasOne(); its length does not matter
  [[nodiscard]] static DirectionBinOf of(const Eigen::Vector3d& direction)
  {
    DirectionBatch batch;
    batch.add(direction);
    findAngles(batch);
    return ofAngles(batch.elevation[0], batch.azimuth[0]);
  }

  /** The bins of many directions, which takes a fraction of the time for each.
   * @param directionOf(i) of the i-th
   * @param bins set to one for each */
  template <typename DirectionOf>
  static void ofAll(size_t count, const DirectionOf& directionOf, std::vector<DirectionBinOf>& bins)
  {
    bins.assign(count, {});
    DirectionBatch batch;
    std::array<size_t, DirectionBatch::kMost> numbers;
    const auto finish = [&]
    {
      findAngles(batch);
      for (size_t i = 0; i < batch.count; ++i)
        bins[numbers[i]] = ofAngles(batch.elevation[i], batch.azimuth[i]);
      batch.count = 0;
    };
    for (size_t i = 0; i < count; ++i)
    {
      const Eigen::Vector3d direction = directionOf(i);
      if (!hasOne(direction)) continue;
      numbers[batch.count] = i;
      batch.add(direction);
      if (batch.full()) finish();
    }
    finish();
  }
  /// Of the rays of a fan.
  static void ofAll(const RayFan& fan, std::vector<DirectionBinOf>& bins)
  {
    ofAll(
        fan.rays.size(), [&](size_t i) { return fan.directionOf(fan.rays[i]); }, bins);
  }

 private:
  static DirectionBinOf ofAngles(float elevation, float azimuth)
  {
    return {std::clamp(binAlong(elevation, -90), 0, kRows - 1),
            std::clamp(binAlong(azimuth, -180), 0, kColumns) % kColumns};
  }
  static int binAlong(float angle, float lowest_deg)
  {
    constexpr auto kDegree = static_cast<float>(3.141592653589793 / 180);
    return static_cast<int>((angle / kDegree - lowest_deg) * kPerDegree + 0.5F);  // of what is not negative
  }
};

using DirectionBin = DirectionBinOf<1>;  ///< of a degree each

}  // namespace lamap
