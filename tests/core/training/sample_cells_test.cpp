#include <gtest/gtest.h>
#include <lamap_core/scan/scan_frame.h>
#include <lamap_core/training/sample_cells.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace lamap
{
namespace
{
TEST(SampleCells, AreThoseOfThePlaces)
{
  std::mt19937 random(4);
  std::uniform_real_distribution<double> number(-100, 100);
  for (int round = 0; round < 200; ++round)
  {
    const Eigen::Vector3d origin(number(random), number(random), number(random));
    const Eigen::Vector3d direction =
        Eigen::Vector3d(number(random), number(random), number(random)).normalized();
    const double length = std::abs(number(random));
    const SampledRay fromSensor{origin, direction, 0.0, 1.0, length};
    const SampledRay fromEnd{origin, direction, length, -0.7, length};
    for (const SampledRay& ray : {fromSensor, fromEnd})
    {
      constexpr int64_t kFrom = 17;
      SampleCells cells;
      cells.find(ray, kFrom, SampleCells::kMost);
      for (int i = 0; i < SampleCells::kMost; ++i)
      {
        const double along = std::clamp(ray.first + static_cast<double>(kFrom + i) * ray.step, 0.0, ray.last);
        const CellIndex expected = cellOfLocal(origin + along * direction);
        ASSERT_EQ((CellIndex{cells.x(i), cells.y(i), cells.z(i)}), expected) << i;
      }
    }
  }
}

TEST(SampleCells, LieBelowZeroToo)
{
  SampleCells cells;
  cells.find({Eigen::Vector3d(-0.5, 0, 2), -Eigen::Vector3d::UnitX(), 0.0, 0.5, 10.0}, 0, 3);
  EXPECT_EQ(cells.x(0), -1);
  EXPECT_EQ(cells.x(1), -1);  // −1 begins its cell
  EXPECT_EQ(cells.x(2), -2);
  EXPECT_EQ(cells.y(2), 0);
  EXPECT_EQ(cells.z(2), 2);
}

}  // namespace
}  // namespace lamap
