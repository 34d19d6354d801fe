#pragma once

#include <lamap_core/scan/scan.h>

#include <Eigen/Core>
#include <array>
#include <cstddef>

namespace lamap
{
/** Widths that training points in cells are told apart by, in units of SamplingRules::widthUnit.
 *
 * A point takes the nearest one. The first is none: what is narrower than a quarter of a unit is exactly
 * where it is. */
inline constexpr std::array<double, 8> kWidthLevels = {0, 0.5, 0.75, 1, 1.5, 2, 3, 4};
inline constexpr size_t kWideLevels = kWidthLevels.size() - 1;

/// Finds the number of a point's width among kWidthLevels.
class WidthLevels
{
 public:
  /// @param unit of kWidthLevels, > 0, in the unit of the widths
  explicit WidthLevels(double unit)
  {
    for (size_t i = 0; i < bounds_.size(); ++i)
    {
      const double between = (kWidthLevels[i] + kWidthLevels[i + 1]) / 2 * unit;
      bounds_[i] = between * between;
    }
  }

  /// @param from which number the search begins. @return the nearest width's
  [[nodiscard]] size_t of(double variance, size_t from = 0) const
  {
    while (from < bounds_.size() && variance > bounds_[from]) ++from;
    while (from > 0 && variance <= bounds_[from - 1]) --from;
    return from;
  }

 private:
  std::array<double, kWideLevels> bounds_{};  ///< variances between one width and the next
};

/** How uncertain it is where the points of one ray are: the mean, over the axes, of their variances, as a
 * function of their distance from the ray's origin. */
struct RayWidth
{
  double constant = 0;
  double linear = 0;
  double square = 0;
  double ofRange = 0;  ///< what the range adds, at a hit

  [[nodiscard]] double variance(double distance) const
  {
    return constant + distance * (linear + distance * square);
  }
  [[nodiscard]] bool any() const { return constant > 0 || linear > 0 || square > 0 || ofRange > 0; }
};

/// What the uncertainty of a scan's pose adds to the widths of its rays.
class PoseWidth
{
 public:
  /// @param pose of the sensor, with its translation [m] and rotation vector along the axes of the map
  /// @throws std::invalid_argument unless it is a covariance
  PoseWidth(const Scan::PoseCovariance& pose, bool planar);

  /// @param centre_map of the ray, relative to the sensor [m]; @param direction_map of length 1
  /// @return variances [m²] at distances in metres
  [[nodiscard]] RayWidth along(const Eigen::Vector3d& centre_map, const Eigen::Vector3d& direction_map) const;

 private:
  double translation_ = 0;    ///< sum of the variances of the translation
  Eigen::Vector3d mixed_;     ///< p·mixed_: half of what translation and rotation share at p
  Eigen::Matrix3d rotation_;  ///< pᵀ·rotation_·p: sum of the variances of ω × p
  double axes_ = 3;
};

}  // namespace lamap
