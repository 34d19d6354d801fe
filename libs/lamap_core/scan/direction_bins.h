#pragma once

#include <lamap_core/scan/direction_angles.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <utility>

namespace lamap
{
/** Directions in bins of a part of a degree: rows by elevation, columns by azimuth. Whole steps stand in the
 * middle of a bin: sensors like them. @tparam kPerDegree bins */
template <int kPerDegree>
struct DirectionBinOf
{
  static constexpr int kRows = 180 * kPerDegree + 1;  ///< from straight down to straight up
  static constexpr int kColumns = 360 * kPerDegree;

  int row;
  int column;

  [[nodiscard]] static bool hasOne(const Eigen::Vector3d& direction)
  {
    return direction.allFinite() && !direction.isZero(0);
  }

  /// @param direction with hasOne(); its length does not matter. The same on every processor.
  [[nodiscard]] static DirectionBinOf of(const Eigen::Vector3d& direction)
  {
    return of(direction, direction).first;
  }
  /// Two at once, which costs no more than one.
  [[nodiscard]] static std::pair<DirectionBinOf, DirectionBinOf> of(const Eigen::Vector3d& one,
                                                                    const Eigen::Vector3d& other)
  {
    const Eigen::Vector3f a = scaled(one);
    const Eigen::Vector3f b = scaled(other);
    const Eigen::Array4f angles =
        anglesOf({a.y(), a.z(), b.y(), b.z()}, {a.x(), across(a), b.x(), across(b)});
    return {{rowAt(angles[1]), columnAt(angles[0])}, {rowAt(angles[3]), columnAt(angles[2])}};
  }

 private:
  /// So that no square is too small or too large.
  static Eigen::Vector3f scaled(const Eigen::Vector3d& direction)
  {
    return (direction / direction.cwiseAbs().maxCoeff()).cast<float>();
  }
  static float across(const Eigen::Vector3f& v)
  {
    const float xx = v.x() * v.x();
    const float yy = v.y() * v.y();
    return std::sqrt(xx + yy);
  }
  static int binAlong(float angle, float lowest_deg)
  {
    constexpr auto kDegree = static_cast<float>(3.141592653589793 / 180);
    return static_cast<int>((angle / kDegree - lowest_deg) * kPerDegree + 0.5F);  // of what is not negative
  }
  static int rowAt(float angle) { return std::clamp(binAlong(angle, -90), 0, kRows - 1); }
  static int columnAt(float angle) { return std::clamp(binAlong(angle, -180), 0, kColumns) % kColumns; }
};

using DirectionBin = DirectionBinOf<1>;  ///< of a degree each

}  // namespace lamap
