#pragma once

#include <lamap_core/bgk/expected_kernel.h>
#include <lamap_core/bgk/kernel.h>
#include <lamap_core/training/point_width.h>

#include <cstddef>
#include <vector>

namespace lamap
{
/// A kernel, and what is expected of it for points of each of kWidthLevels, in units of its support. All in
/// cells.
class KernelsByWidth
{
 public:
  KernelsByWidth(KernelShape shape, double support, double scale, bool planar)
      : sharp_(shape, support, scale), levels_(support)
  {
    for (size_t level = 1; level < kWidthLevels.size(); ++level)
      wide_.emplace_back(shape, support, scale, kWidthLevels[level] * support, planar);
  }

  [[nodiscard]] const Kernel& sharp() const { return sharp_; }
  /// Of kWidthLevels[1] and so on.
  [[nodiscard]] const std::vector<ExpectedKernel>& wide() const { return wide_; }

  /// @param variance of a point [cells²]
  [[nodiscard]] size_t levelOf(double variance) const { return levels_.of(variance); }
  [[nodiscard]] double supportOf(size_t level) const
  {
    return level == 0 ? sharp_.support() : wide_[level - 1].support();
  }
  [[nodiscard]] double at(size_t level, double squaredDistance) const
  {
    return level == 0 ? sharp_.atSquaredDistance(squaredDistance)
                      : wide_[level - 1].atSquaredDistance(squaredDistance);
  }

 private:
  Kernel sharp_;
  WidthLevels levels_;
  std::vector<ExpectedKernel> wide_;
};

}  // namespace lamap
