#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

namespace lamap
{
/// Places along a ray, in the scan's frame [cells]: the i-th is first + i·step from its origin, but not less
/// than 0 and not more than last.
struct SampledRay
{
  Eigen::Vector3d origin;
  Eigen::Vector3d direction;
  double first;
  double step;
  double last;
};

/// The cells of some samples of a ray, found at once. The same on every processor.
class SampleCells
{
 public:
  static constexpr int kMost = 64;

  /// @param from number of the first sample; @param count of samples, at most kMost
  void find(const SampledRay& ray, int64_t from, int count);

  [[nodiscard]] int32_t x(int i) const { return cells_[0][static_cast<size_t>(i)]; }
  [[nodiscard]] int32_t y(int i) const { return cells_[1][static_cast<size_t>(i)]; }
  [[nodiscard]] int32_t z(int i) const { return cells_[2][static_cast<size_t>(i)]; }

 private:
  std::array<std::array<int32_t, kMost>, 3> cells_;
};

}  // namespace lamap
