// .gridmap, .pts.gz, .metricmap: MRPT's own maps, which any MRPT program loads.
#include <lamap_mrpt/files/map_file.h>
#include <lamap_tools/cells/octomap_file.h>
#include <lamap_tools/export/flat_cells.h>
#include <lamap_tools/files/file_names.h>
#include <lamap_tools/files/usage_error.h>
#include <mrpt/maps/CMultiMetricMap.h>
#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/maps/COctoMap.h>
#include <mrpt/maps/CSimplePointsMap.h>

#include <stdexcept>

namespace lamap::tools
{
namespace
{
using mrpt::maps::CMetricMap;

CMetricMap::Ptr gridOf(const CellMap& map, const std::string& path, const ExportOptions& options)
{
  const FlatCells flat = flatCellsOf(map, path, options);
  const CellIndex& first = flat.extent.first;
  const CellIndex& last = flat.extent.last;
  requireFloatPrecision(map, path, {first.x, first.y, 0}, {last.x, last.y, 0}, "a grid's float coordinates");
  const double edge = map.resolution();
  const auto metres = [&](int64_t index) { return static_cast<float>(static_cast<double>(index) * edge); };
  auto grid = mrpt::maps::COccupancyGridMap2D::Create();
  grid->setSize(metres(first.x), metres(int64_t{last.x} + 1), metres(first.y), metres(int64_t{last.y} + 1),
                static_cast<float>(edge));
  if (grid->getSizeX() != flat.width || grid->getSizeY() != flat.height())
    throw std::runtime_error(path + ": MRPT's grid would have " + std::to_string(grid->getSizeX()) + " x " +
                             std::to_string(grid->getSizeY()) + " cells instead of " +
                             std::to_string(flat.width) + " x " + std::to_string(flat.height()));
  for (size_t i = 0; i < flat.cells.size(); ++i)
    grid->setCell(static_cast<int>(i % flat.width), static_cast<int>(i / flat.width), 1 - flat.cells[i].prob);
  return grid;
}

CMetricMap::Ptr pointsOf(const CellMap& map, const std::string& path)
{
  auto points = mrpt::maps::CSimplePointsMap::Create();
  std::optional<CellExtent> extent;
  visitCellsSorted(map,
                   [&](const CellRow& row)
                   {
                     if (row.estimate.state != CellState::Occupied) return;
                     if (!extent) extent = CellExtent{row.index, row.index};
                     extent->include(row.index);
                     const Eigen::Vector3f centre = cellCentre(row.index, map.resolution()).cast<float>();
                     points->insertPoint(centre.x(), centre.y(), centre.z());
                   });
  if (!extent) throw std::runtime_error(path + ": the map has no occupied cell, there is no point to write");
  requireFloatPrecision(map, path, extent->first, extent->last, "a points map's float coordinates");
  return points;
}

CMetricMap::Ptr octomapOf(const CellMap& map, const std::string& path)
{
  const auto extent = cellExtent(map, [](const CellIndex&, const CellEstimate& estimate)
                                 { return estimate.state != CellState::Unknown; });
  if (!extent)
    throw std::runtime_error(path + ": no cell is free or occupied, an octree has nothing to hold");
  requireOctomapKeys(*extent, path, map.resolution());
  auto tree = std::make_shared<mrpt::maps::COctoMap>(map.resolution());
  map.visitCells(
      [&](const CellIndex& cell, const CellEstimate& estimate)
      {
        if (estimate.state == CellState::Unknown) return;
        const Eigen::Vector3d centre = cellCentre(cell, map.resolution());
        tree->updateVoxel(centre.x(), centre.y(), centre.z(), estimate.state == CellState::Occupied);
      });
  return tree;
}

CMetricMap::Ptr stockMapOf(StockMap kind, const CellMap& map, const std::string& path,
                           const ExportOptions& options)
{
  if (kind == StockMap::Grid) return gridOf(map, path, options);
  if (kind == StockMap::Points) return pointsOf(map, path);
  return octomapOf(map, path);
}

/// As endsWith(), with or without .gz.
bool isCalled(const std::string& path, const std::string& ending)
{
  return endsWith(path, ending) || endsWith(path, ending + ".gz");
}
}  // namespace

bool isStockMapFile(const std::string& path)
{
  return isCalled(path, ".gridmap") || isCalled(path, ".metricmap") || extensionOf(path) == ".gz";
}

std::vector<StockMap> stockMapsIn(const std::string& path, const ExportOptions& options)
{
  if (isCalled(path, ".metricmap"))
    return options.as.empty() ? std::vector<StockMap>{StockMap::Points, StockMap::Grid, StockMap::Octomap}
                              : options.as;
  std::vector<StockMap> expected = options.as;
  if (isCalled(path, ".gridmap")) expected = {StockMap::Grid};
  if (endsWith(path, ".pts.gz")) expected = {StockMap::Points};
  if (expected.size() != 1)
    throw UsageError(path +
                     ": which map is it to hold? Give --as grid, points or octomap, or several for a "
                     ".metricmap");
  if (!options.as.empty() && options.as != expected)
    throw UsageError(path + ": --as names another map than the extension does");
  return expected;
}

void writeStockMaps(const CellMap& map, const std::string& path, const ExportOptions& options)
{
  const std::vector<StockMap> kinds = stockMapsIn(path, options);
  CMetricMap::Ptr written;
  if (isCalled(path, ".metricmap"))
  {
    auto several = mrpt::maps::CMultiMetricMap::Create();
    for (const StockMap kind : kinds) several->maps.push_back(stockMapOf(kind, map, path, options));
    written = several;
  }
  else
    written = stockMapOf(kinds.front(), map, path, options);
  saveMapFile(*written, path);
}

}  // namespace lamap::tools
