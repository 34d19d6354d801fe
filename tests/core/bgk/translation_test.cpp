// Invariant 4, moving scene and sensor by whole cells moves the map, where points are on faces and between
// them.
#include <gtest/gtest.h>
#include <lamap_core/bgk/map.h>
#include <support/bgk_oracle.h>
#include <support/grid_words.h>
#include <support/random_options.h>
#include <support/seeded_scans.h>
#include <support/seeds.h>

#include <cmath>
#include <cstdlib>
#include <sstream>

namespace lamap::test
{
namespace
{
/// Empty where `there` is `here` moved by whole cells, counts differing by no more than the tolerance.
std::string differenceAfterMove(const BgkMap& here, const BgkMap& there, const CellIndex& by,
                                uint64_t tolerance_units = 0)
{
  const std::vector<CellEvidence> cells = cellsOf(here.evidence());
  const auto apart = [](uint64_t a, uint64_t b) { return a > b ? a - b : b - a; };
  std::ostringstream text;
  for (const CellEvidence& cell : cells)
  {
    const CellSums moved = there.evidence().at({cell.cell.x + by.x, cell.cell.y + by.y, cell.cell.z + by.z});
    if (apart(moved.first, cell.evidence.first) <= tolerance_units &&
        apart(moved.second, cell.evidence.second) <= tolerance_units)
      continue;
    text << "cell (" << cell.cell.x << ", " << cell.cell.y << ", " << cell.cell.z << ") holds "
         << cell.evidence.first << ", " << cell.evidence.second << " here, " << moved.first << ", "
         << moved.second << " there";
    return text.str();
  }
  const size_t count = cellsOf(there.evidence()).size();
  if (tolerance_units == 0 && count != cells.size())
    text << cells.size() << " cells here, " << count << " there";
  return text.str();
}

std::vector<CellIndex> movesInCells(bool planar)
{
  // Across the origin, not by whole blocks; 1,000 km away in every direction; near the last cell there is.
  std::vector<CellIndex> moves{{1, 0, 0},
                               {-3, 5, -7},
                               {-11, -13, 9},
                               {64, -32, 17},
                               {8000003, 0, 0},
                               {-8000001, 7999999, 5},
                               {7999993, -8000011, -8000005}};
  if (planar)
    for (CellIndex& move : moves) move.z = 0;
  return moves;
}

struct Case
{
  BgkStructure structure;
  BgkInference inference;
  Scan scan;
};

Case randomCase(Random& random, double resolution)
{
  Case made;
  made.structure.resolution = resolution;
  made.structure.blockDepth = random.integer(2, 6);
  made.structure.planar = random.chance(0.3);
  made.structure.planarHeight = 0.3 * resolution;
  made.inference = randomInference(random, resolution);
  // Voxels that move onto voxels.
  if (made.inference.hitDownsampling && *made.inference.hitDownsampling > 0)
    made.inference.hitDownsampling = resolution;
  if (made.inference.freeDownsampling > 0) made.inference.freeDownsampling = resolution;
  // A range of whole steps: rounding must not decide whether a ray has its last sample.
  if (made.inference.maxRange > 0 && random.chance(0.5))
  {
    made.inference.maxRange = 5 * resolution;
    made.inference.freeResolution = resolution;
  }
  ScanRecipe recipe;
  recipe.halfEdge_m = 7 * resolution;
  recipe.clusterRadius_m = resolution;
  recipe.statedRanges = false;
  made.scan = randomScan(random, recipe);
  return made;
}

BgkMap mapOf(const Case& from, const Scan& scan)
{
  BgkMap map(from.structure);
  map.insert(scan, from.inference, 1);
  return map;
}

// Ends, origins and samples on faces: rays along the axes and Pythagorean directions, whose samples fall on
// faces again and again.
TEST(BgkMapProperty, PointsOnFacesMoveBitByBitToo)
{
  const double resolution = 0.125;
  for (const TrainingPoints trainingPoints : kAllTrainingPoints)
    for (const FreeSpace freeSpace : kAllFreeSpaces)
      for (const double freeResolution_cells : {1.0, 0.5, 5.0, 3.0})
      {
        Case made;
        made.structure.resolution = resolution;
        made.inference.trainingPoints = trainingPoints;
        made.inference.freeSpace = freeSpace;
        made.inference.freeResolution = freeResolution_cells * resolution;
        made.inference.maxRange = 30 * resolution;
        SCOPED_TRACE(nameOf(made.inference) + ", a free point every " + std::to_string(freeResolution_cells) +
                     " cells");
        RayFan fan;
        for (const Eigen::Vector3d& ray : {Eigen::Vector3d(10, 0, 0),
                                           {0, -9, 0},
                                           {0, 0, 8},
                                           {9, 12, 0},
                                           {0, -12, 16},
                                           {-5, 0, 12},
                                           {3, 4, 12},
                                           {-8, 9, 12},
                                           {7, 7, 0},
                                           {6, 6, 6},
                                           {24, 32, 0},
                                           {-40, 0, 0}})
          fan.addReturn(ray * resolution);
        for (const Eigen::Vector3d& direction : {Eigen::Vector3d(3, -4, 0), {0, 0, -1}, {1, 1, 1}})
          fan.add(RayEnd::NoReturn, direction);
        made.scan.fans = {fan};
        const BgkMap here = mapOf(made, made.scan);
        for (const CellIndex& by : movesInCells(false))
        {
          const Scan there = moved(made.scan, Eigen::Vector3d(by.x, by.y, by.z) * resolution);
          ASSERT_EQ(differenceAfterMove(here, mapOf(made, there), by), "")
              << "moved by " << by.x << ", " << by.y << ", " << by.z << " cells";
        }
      }
}

bool isAwayFromFaces(const Eigen::Vector3d& point, double edge)
{
  for (int axis = 0; axis < 3; ++axis)
    if (std::abs(point[axis] - std::round(point[axis] / edge) * edge) < 2e-6) return false;
  return true;
}

/// All points of the scan, and all its free points before they are snapped, are farther than 1e-6 m from
/// faces, and none of its rays is within 1e-6 m of one sample more or less.
bool isAwayFromFaces(const Case& made)
{
  for (const RayFan& fan : made.scan.fans)
  {
    if (!isAwayFromFaces(fan.centre, made.structure.resolution)) return false;
    for (const auto& end : endsOf(fan))
      if (end.allFinite() && !isAwayFromFaces(end, made.structure.resolution)) return false;
  }
  BgkInference exact = made.inference;
  if (exact.trainingPoints == TrainingPoints::Cells) exact.hitDownsampling = made.structure.resolution;
  exact.trainingPoints = TrainingPoints::Centroids;
  exact.freeDownsampling = 0;
  exact.freeSpace = FreeSpace::Samples;
  const TrainingSet training = trainingSetOf(made.scan, made.structure, exact);
  for (const auto& point : training.frees_map)
  {
    Eigen::Vector3d inLayer = point;
    if (made.structure.planar) inLayer.z() = 0.5 * made.structure.resolution;
    if (!isAwayFromFaces(inLayer, made.structure.resolution)) return false;
  }
  for (const double nudge : {-2e-6, 2e-6})
  {
    BgkInference nudged = exact;
    nudged.freeMargin = std::max(0.0, exact.freeMargin.value_or(made.structure.resolution) + nudge);
    if (trainingSetOf(made.scan, made.structure, nudged).frees_map.size() != training.frees_map.size())
      return false;
  }
  return true;
}

TEST(BgkMapProperty, WholeCellsOfAnyResolutionMoveTheMap)
{
  const double resolution = 0.1;
  int compared = 0;
  for (unsigned seed = 1; seed <= seeds(120); ++seed)
  {
    Random random(seed);
    Case made = randomCase(random, resolution);
    if (!isAwayFromFaces(made)) continue;
    SCOPED_TRACE("seed " + std::to_string(seed) + ": " + nameOf(made.inference));
    ++compared;
    const BgkMap here = mapOf(made, made.scan);
    // Cells and their centres do not depend on where exactly the points are; lines and centroids do, by some
    // 1e-10 m.
    const bool exact =
        made.inference.trainingPoints == TrainingPoints::Cells && made.inference.freeSpace != FreeSpace::Line;
    for (const CellIndex& by : {CellIndex{1, 0, 0},
                                {-3, 5, -7},
                                {-11, -13, 9},
                                {10000003, 0, 0},
                                {-10000001, 9999999, 5},
                                {9999993, -10000011, -10000005}})
    {
      const CellIndex move{by.x, by.y, made.structure.planar ? 0 : by.z};
      const Scan there = moved(made.scan, Eigen::Vector3d(move.x, move.y, move.z) * resolution);
      ASSERT_EQ(differenceAfterMove(here, mapOf(made, there), move, exact ? 0 : 1), "")
          << "moved by " << move.x << ", " << move.y << ", " << move.z << " cells";
    }
  }
  EXPECT_GE(2 * static_cast<unsigned>(compared), seeds(120));
}
}  // namespace
}  // namespace lamap::test
