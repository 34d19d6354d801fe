#include <lamap_mrpt/files/environment.h>
#include <lamap_mrpt/files/map_file.h>
#include <lamap_tools/cells/cell_map.h>
#include <lamap_tools/cells/octomap_file.h>
#include <mrpt/core/format.h>
#include <mrpt/maps/CColouredOctoMap.h>
#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/maps/COctoMap.h>
#include <mrpt/opengl/COctoMapVoxels.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

namespace lamap::tools
{
namespace
{
double logoddsOf(double prob)
{
  return std::log(prob) - std::log1p(-prob);
}

class LearnedCells : public CellMap
{
 public:
  explicit LearnedCells(std::shared_ptr<CLearnedMap> map) : map_(std::move(map)) {}

  std::string className() const override { return map_->GetRuntimeClass()->className; }
  double resolution() const override { return map_->resolution(); }
  std::vector<std::string> evidenceNames() const override { return map_->evidenceNames(); }
  std::optional<CellEstimate> estimateAt(const mrpt::math::TPoint3D& point_map) const override
  {
    return map_->estimateAt(point_map);
  }
  void visitCells(const CellVisitor& visitor) const override { map_->visitCells(visitor); }

 private:
  std::shared_ptr<CLearnedMap> map_;
};

/// MRPT keeps its octree to itself (COctoMapBase::Impl), so leaves are asked for as voxels to draw.
template <class OctoMap>
class MrptOctoCells : public CellMap
{
 public:
  explicit MrptOctoCells(std::shared_ptr<OctoMap> map) : map_(std::move(map)) {}

  std::string className() const override { return map_->GetRuntimeClass()->className; }
  double resolution() const override { return map_->getResolution(); }
  std::vector<std::string> evidenceNames() const override { return {"logodds"}; }

  std::optional<CellEstimate> estimateAt(const mrpt::math::TPoint3D& point_map) const override
  {
    // At its centre, since MRPT rounds the point to float first.
    const auto cell = cellAt({point_map.x, point_map.y, point_map.z}, resolution());
    if (!cell) return std::nullopt;
    return estimateOf(*cell);
  }

  void visitCells(const CellVisitor& visitor) const override { visitCellsOfLeaves(*this, visitor); }

  void visitLeaves(const LeafVisitor& visitor) const override
  {
    const auto leaves = leavesAsVoxels();
    const double r = resolution();
    for (size_t set = 0; set < leaves->getVoxelSetCount(); ++set)
    {
      for (size_t i = 0; i < leaves->getVoxelCount(set); ++i)
      {
        const auto& leaf = leaves->getVoxel(set, i);
        const double half_m = leaf.side_length / 2;
        const auto first = [&](double centre_m) { return heldCell(std::round((centre_m - half_m) / r)); };
        const CellIndex cell{first(leaf.coords.x), first(leaf.coords.y), first(leaf.coords.z)};
        if (const auto estimate = estimateOf(cell))
          visitor(cell, heldCell(std::round(leaf.side_length / r)), *estimate);
      }
    }
  }

 private:
  mrpt::opengl::COctoMapVoxels::Ptr leavesAsVoxels() const
  {
    const auto drawn = map_->renderingOptions;
    map_->renderingOptions = {};
    map_->renderingOptions.generateOccupiedVoxels = true;
    map_->renderingOptions.generateFreeVoxels = true;
    auto leaves = mrpt::opengl::COctoMapVoxels::Create();
    map_->getAsOctoMapVoxels(*leaves);
    map_->renderingOptions = drawn;
    return leaves;
  }

  std::optional<CellEstimate> estimateOf(const CellIndex& cell) const
  {
    const Eigen::Vector3d centre = cellCentre(cell, resolution());
    CellEstimate estimate;
    if (!map_->getPointOccupancy(static_cast<float>(centre.x()), static_cast<float>(centre.y()),
                                 static_cast<float>(centre.z()), estimate.prob))
      return std::nullopt;
    estimate.state = estimate.prob >= map_->getOccupancyThres() ? CellState::Occupied : CellState::Free;
    estimate.evidence[0] = logoddsOf(estimate.prob);
    return estimate;
  }

  std::shared_ptr<OctoMap> map_;
};

class GridCells : public CellMap
{
 public:
  explicit GridCells(std::shared_ptr<mrpt::maps::COccupancyGridMap2D> map) : map_(std::move(map)) {}

  std::string className() const override { return map_->GetRuntimeClass()->className; }
  /// MRPT holds it as float: 0.1 shall not become 0.10000000149. It is the decimal with the fewest places
  /// that is this float.
  double resolution() const override
  {
    const float stored = map_->getResolution();
    for (double scale = 1; scale <= 1e9; scale *= 10)
      if (const double decimal = std::round(static_cast<double>(stored) * scale) / scale;
          static_cast<float>(decimal) == stored)
        return decimal;
    return static_cast<double>(stored);
  }
  std::vector<std::string> evidenceNames() const override { return {"logodds"}; }

  std::optional<CellEstimate> estimateAt(const mrpt::math::TPoint3D& point_map) const override
  {
    const auto cell = cellAt({point_map.x, point_map.y, point_map.z}, resolution());
    if (!cell || cell->z != 0) return std::nullopt;
    return estimateOf(cell->x - firstIndex(map_->getXMin()), cell->y - firstIndex(map_->getYMin()));
  }

  void visitCells(const CellVisitor& visitor) const override
  {
    const int firstX = firstIndex(map_->getXMin());
    const int firstY = firstIndex(map_->getYMin());
    for (int y = 0; y < static_cast<int>(map_->getSizeY()); ++y)
      for (int x = 0; x < static_cast<int>(map_->getSizeX()); ++x)
        if (const auto estimate = estimateOf(x, y)) visitor({firstX + x, firstY + y, 0}, *estimate);
  }

 private:
  int firstIndex(double limit_m) const { return heldCell(std::round(limit_m / resolution())); }

  std::optional<CellEstimate> estimateOf(int x, int y) const
  {
    if (x < 0 || y < 0 || x >= static_cast<int>(map_->getSizeX()) || y >= static_cast<int>(map_->getSizeY()))
      return std::nullopt;
    const auto* row = map_->getRow(y);
    if (row[x] == 0) return std::nullopt;  // log-odds 0: as the grid was made
    CellEstimate estimate;
    estimate.prob = 1.0 - static_cast<double>(map_->getCell(x, y));  // MRPT's grids hold P(free)
    estimate.state = estimate.prob > 0.5 ? CellState::Occupied : CellState::Free;
    estimate.evidence[0] = logoddsOf(estimate.prob);
    return estimate;
  }

  std::shared_ptr<mrpt::maps::COccupancyGridMap2D> map_;
};
}  // namespace

std::unique_ptr<CellMap> cellsOf(const mrpt::maps::CMetricMap::Ptr& map)
{
  if (auto learned = std::dynamic_pointer_cast<CLearnedMap>(map))
    return std::make_unique<LearnedCells>(learned);
  if (auto octo = std::dynamic_pointer_cast<mrpt::maps::COctoMap>(map))
    return std::make_unique<MrptOctoCells<mrpt::maps::COctoMap>>(octo);
  if (auto coloured = std::dynamic_pointer_cast<mrpt::maps::CColouredOctoMap>(map))
    return std::make_unique<MrptOctoCells<mrpt::maps::CColouredOctoMap>>(coloured);
  if (auto grid = std::dynamic_pointer_cast<mrpt::maps::COccupancyGridMap2D>(map))
    return std::make_unique<GridCells>(grid);
  return nullptr;
}

OpenedMap openMap(const std::string& path)
{
  OpenedMap opened;
  if (isOctomapFile(path))
  {
    opened.cells = readOctomapFile(path);
    opened.cells->setPath(path);
    return opened;
  }
  MapFile file = readMapFile(path);
  opened.formatVersion = static_cast<int8_t>(file.version);
  opened.map = std::move(file.map);
  opened.cells = cellsOf(opened.map);
  if (opened.cells) opened.cells->setPath(path);
  return opened;
}

OpenedMap openMapOfCells(const std::string& path)
{
  OpenedMap opened = openMap(path);
  if (opened.cells) requireReadableResolution(path, opened.cells->resolution());
  if (!opened.cells)
    throw std::runtime_error(path + ": its map is a " + opened.map->GetRuntimeClass()->className +
                             ", which has no cells; expected one of this library's maps, COctoMap, "
                             "CColouredOctoMap, COccupancyGridMap2D, or a .ot or .bt file");
  return opened;
}

std::unique_ptr<CellMap> openCellMap(const std::string& path)
{
  return openMapOfCells(path).cells;
}

namespace
{
/// How many cells of so many leaves are read one by one.
double mostCellsOf(double leaves)
{
  constexpr double kMost = 0x1p28;
  constexpr double kAlways = 0x1p20;
  constexpr double kEach = 256;
  const auto wanted = limitFromEnvironment("LAMAP_MAX_CELLS");
  return wanted ? static_cast<double>(*wanted) : std::min(kMost, kAlways + kEach * leaves);
}
}  // namespace

void visitCellsOfLeaves(const CellMap& octree, const CellMap::CellVisitor& visitor)
{
  double cells = 0;
  double leaves = 0;
  octree.visitLeaves(
      [&](const CellIndex&, int edge, const CellEstimate&)
      {
        cells += std::pow(edge, 3);
        ++leaves;
      });
  if (const double most = mostCellsOf(leaves); cells > most)
    throw std::runtime_error(mrpt::format(
        "%sthe octree's leaves, %.0f in all, stand for %.3g finest cells; no more than %.3g are read one "
        "by one from so few leaves, a limit that the environment variable LAMAP_MAX_CELLS raises",
        octree.path().empty() ? "" : (octree.path() + ": ").c_str(), leaves, cells, most));
  octree.visitLeaves(
      [&](const CellIndex& first, int edge, const CellEstimate& estimate)
      {
        for (int z = 0; z < edge; ++z)
          for (int y = 0; y < edge; ++y)
            for (int x = 0; x < edge; ++x) visitor({first.x + x, first.y + y, first.z + z}, estimate);
      });
}

void requireReadableResolution(const std::string& path, double resolution_m)
{
  if (resolution_m >= 1e-6 && resolution_m <= 1e6) return;
  throw std::runtime_error(mrpt::format("%s: states a resolution of %g m; expected one from 1e-6 to 1e6 m",
                                        path.c_str(), resolution_m));
}

const char* stateName(CellState state)
{
  switch (state)
  {
    case CellState::Free:
      return "free";
    case CellState::Occupied:
      return "occupied";
    case CellState::Unknown:
      break;
  }
  return "unknown";
}

}  // namespace lamap::tools
