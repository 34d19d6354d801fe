#include <gtest/gtest.h>
#include <lamap_core/training/scan_labels.h>
#include <support/seeded_scans.h>
#include <support/seeds.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>
#include <tuple>

namespace lamap::test
{
namespace
{
using Cells = std::vector<CellIndex>;

bool contains(const Cells& cells, const CellIndex& cell)
{
  return std::find(cells.begin(), cells.end(), cell) != cells.end();
}

Cells rowOfCells(int first, int last)
{
  Cells cells;
  for (int x = first; x <= last; ++x) cells.push_back({x, 0, 0});
  return cells;
}

Scan scanOf(const Eigen::Vector3d& origin, const std::vector<Eigen::Vector3d>& returns,
            const std::vector<Eigen::Vector3d>& noReturns = {})
{
  return scanWith({fanOf(origin, returns, noReturns)});
}

const Eigen::Vector3d kOrigin(0.5, 0.5, 0.5);

LabelRules metreCells()
{
  LabelRules rules;
  rules.resolution_m = 1;
  return rules;
}

// From 0.5 to 10.5: the return is in cell 10, the points stand at 8.5, 7.5 … 1.5.
TEST(ScanLabels, OfOneRayByHand)
{
  const ScanLabels labels = labelCells(scanOf(kOrigin, {{10.5, 0.5, 0.5}}), metreCells());
  EXPECT_EQ(labels.occupied, rowOfCells(10, 10));
  EXPECT_EQ(labels.free, rowOfCells(1, 8));
}

TEST(ScanLabels, TheMarginIsInMetres)
{
  LabelRules rules = metreCells();
  rules.freeMargin_m = 5;
  EXPECT_EQ(labelCells(scanOf(kOrigin, {{10.5, 0.5, 0.5}}), rules).free, rowOfCells(1, 5));
  rules.freeMargin_m = 0;
  EXPECT_EQ(labelCells(scanOf(kOrigin, {{10.5, 0.5, 0.5}}), rules).free, rowOfCells(1, 9))
      << "the cell of the return is not free";
  rules.freeMargin_m = 50;
  EXPECT_TRUE(labelCells(scanOf(kOrigin, {{10.5, 0.5, 0.5}}), rules).free.empty());
}

TEST(ScanLabels, BeyondTheMaximumRangeThereIsNoHitAndFreeSpaceUpToIt)
{
  LabelRules rules = metreCells();
  rules.maxRange_m = 6;
  const ScanLabels cut = labelCells(scanOf(kOrigin, {{10.5, 0.5, 0.5}}), rules);
  EXPECT_TRUE(cut.occupied.empty());
  EXPECT_EQ(cut.free, rowOfCells(1, 6));
  const ScanLabels noReturn = labelCells(scanOf(kOrigin, {}, {{0.1, 0, 0}}), rules);
  EXPECT_EQ(noReturn.free, cut.free);
  rules.maxRange_m = 0;
  const ScanLabels unbounded = labelCells(scanOf(kOrigin, {}, {{1, 0, 0}}), rules);
  EXPECT_TRUE(unbounded.free.empty()) << "nobody says how far the ray was free";
}

TEST(ScanLabels, ACellWithAReturnIsNeverFreeAndEachCellStandsOnce)
{
  const ScanLabels labels = labelCells(
      scanOf(kOrigin, {{10.5, 0.5, 0.5}, {10.6, 0.5, 0.5}, {5.5, 0.5, 0.5}, {9.5, 0.5, 0.5}}), metreCells());
  EXPECT_EQ(labels.occupied, (Cells{{5, 0, 0}, {9, 0, 0}, {10, 0, 0}}));
  EXPECT_EQ(labels.free,
            (Cells{{1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {4, 0, 0}, {6, 0, 0}, {7, 0, 0}, {8, 0, 0}}));
}

TEST(ScanLabels, ACellSeenFromTwoPlacesStandsOnce)
{
  Scan scan = scanOf(kOrigin, {{10.5, 0.5, 0.5}});
  scan.fans.push_back(scan.fans.front());
  scan.fans.back().centre.y() = 3.5;
  EXPECT_EQ(labelCells(scan, metreCells()).occupied, rowOfCells(10, 10));
}

TEST(ScanLabels, OfALayerAreAllInIt)
{
  LabelRules rules = metreCells();
  rules.layer = 7;
  const ScanLabels labels = labelCells(scanOf(kOrigin, {{10.5, 0.5, 20.5}}), rules);
  EXPECT_EQ(labels.occupied, (Cells{{10, 0, 7}}));
  Cells expected = rowOfCells(1, 8);
  for (CellIndex& cell : expected) cell.z = 7;
  EXPECT_EQ(labels.free, expected);
}

TEST(ScanLabels, LeaveOutWhatIsNoRay)
{
  const double nan = std::nan("");
  const ScanLabels labels =
      labelCells(scanOf(kOrigin, {{nan, 0, 0}, kOrigin, {INFINITY, 0, 0}}, {{0, 0, 0}}), metreCells());
  EXPECT_TRUE(labels.occupied.empty() && labels.free.empty());
}

TEST(ScanLabels, RefuseIllegalRules)
{
  for (const double wrong : {0.0, -1.0, std::nan(""), static_cast<double>(INFINITY)})
  {
    LabelRules rules;
    rules.resolution_m = wrong;
    EXPECT_THROW((void)labelCells({}, rules), std::invalid_argument);
    rules = {};
    rules.freeMargin_m = wrong - 1;
    EXPECT_THROW((void)labelCells({}, rules), std::invalid_argument);
  }
}

/// Whether a line meets the box of a cell, or a hair around it.
bool crosses(const Eigen::Vector3d& from, const Eigen::Vector3d& to, const CellIndex& cell, double edge)
{
  const Eigen::Vector3d centre = cellCentre(cell, edge);
  double enter = 0, leave = 1;
  for (int axis = 0; axis < 3; ++axis)
  {
    const double step = to[axis] - from[axis];
    const double a = (centre[axis] - edge / 2 - 1e-9 - from[axis]) / step;
    const double b = (centre[axis] + edge / 2 + 1e-9 - from[axis]) / step;
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return enter <= leave;
}

// Every label has a ray that explains it, and every ray is explained.
TEST(ScanLabelsProperty, LabelsAreWhatTheRaysShow)
{
  for (unsigned seed = 1; seed <= seeds(10); ++seed)
  {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::normal_distribution<double> spread(0, 3);
    std::vector<Eigen::Vector3d> ends;
    for (int i = 0; i < 60; ++i) ends.emplace_back(spread(random), spread(random), spread(random));
    const Eigen::Vector3d origin(0.2, -0.3, 0.1);
    LabelRules rules;
    rules.resolution_m = 0.25;
    rules.freeMargin_m = 0.6;
    const ScanLabels labels = labelCells(scanOf(origin, ends), rules);

    for (const Cells* cells : {&labels.occupied, &labels.free})
      EXPECT_TRUE(std::is_sorted(cells->begin(), cells->end(),
                                 [](const CellIndex& a, const CellIndex& b)
                                 { return std::tie(a.z, a.y, a.x) < std::tie(b.z, b.y, b.x); }));
    for (const Eigen::Vector3d& end : ends) EXPECT_TRUE(contains(labels.occupied, *cellAt(end, 0.25)));
    EXPECT_LE(labels.occupied.size(), ends.size());
    const auto isCrossed = [&](const CellIndex& cell)
    {
      return std::any_of(ends.begin(), ends.end(),
                         [&](const Eigen::Vector3d& end)
                         {
                           const double length = (end - origin).norm();
                           return length > 0.6 &&
                                  crosses(origin, origin + (end - origin) * (1 - 0.6 / length), cell, 0.25);
                         });
    };
    EXPECT_GT(labels.free.size(), 200U);
    for (const CellIndex& cell : labels.free)
    {
      EXPECT_TRUE(isCrossed(cell)) << cell.x << " " << cell.y << " " << cell.z;
      EXPECT_FALSE(contains(labels.occupied, cell));
    }
  }
}
}  // namespace
}  // namespace lamap::test
