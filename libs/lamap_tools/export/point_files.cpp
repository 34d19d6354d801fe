// .csv, .ply and .pcd: one line or point per cell.
#include <lamap_tools/cells/cell_table.h>
#include <lamap_tools/export/export_map.h>
#include <lamap_tools/files/file_output.h>
#include <lamap_tools/pictures/palette.h>

#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace lamap::tools
{
namespace
{
/// Calls write(cell, its centre [m], its estimate) for the cells of these states, sorted.
template <class Write>
void forEachCell(const CellMap& map, const StateSet& states, const Write& write)
{
  visitCellsSorted(map,
                   [&](const CellRow& row)
                   {
                     if (states.has(row.estimate.state))
                       write(row.index, cellCentre(row.index, map.resolution()), row.estimate);
                   });
}
}  // namespace

void writeCsv(const CellMap& map, const std::string& path, const StateSet& states)
{
  const auto names = map.evidenceNames();
  FileOutput out(path);
  out.append("x,y,z,prob,variance,state");
  for (const auto& name : names) out.append("," + name);
  out.append("\n");
  forEachCell(map, states,
              [&](const CellIndex&, const Eigen::Vector3d& centre, const CellEstimate& estimate)
              {
                for (const double number : {centre.x(), centre.y(), centre.z(), estimate.prob})
                {
                  out.append(number);
                  out.append(",");
                }
                if (estimate.variance) out.append(*estimate.variance);
                out.append(",");
                out.append(stateName(estimate.state));
                for (size_t i = 0; i < names.size(); ++i)
                {
                  out.append(",");
                  out.append(estimate.evidence[i]);
                }
                out.append("\n");
              });
  out.commit();
}

namespace
{
/// Facts for the header, needed before the first point.
struct PointSummary
{
  size_t count = 0;
  bool hasVariance = false;
  CellExtent extent;
};

PointSummary summarizePoints(const CellMap& map, const std::string& path, const StateSet& states)
{
  PointSummary summary;
  map.visitCells(
      [&](const CellIndex& cell, const CellEstimate& estimate)
      {
        if (!states.has(estimate.state)) return;
        if (summary.count++ == 0) summary.extent = {cell, cell};
        summary.extent.include(cell);
        summary.hasVariance |= estimate.variance.has_value();
      });
  if (summary.count == 0)
    throw std::runtime_error(path +
                             ": the map has no cell of the states asked for, there is no point to write");
  return summary;
}

mrpt::img::TColor heightColor(const CellIndex& cell, const CellExtent& extent)
{
  const double span = static_cast<double>(extent.last.z) - extent.first.z;
  return paletteColor(Palette::Height,
                      span == 0 ? 0.5 : (static_cast<double>(cell.z) - extent.first.z) / span);
}
}  // namespace

void writePly(const CellMap& map, const std::string& path, const StateSet& states)
{
  const PointSummary points = summarizePoints(map, path, states);
  FileOutput out(path);
  out.append(
      "ply\nformat binary_little_endian 1.0\ncomment cells of a " + map.className() + ", edge " +
      shortest(map.resolution()) + " m\nelement vertex " + std::to_string(points.count) +
      "\nproperty double x\nproperty double y\nproperty double z\nproperty uchar red\nproperty uchar green\n"
      "property uchar blue\nproperty float prob\n" +
      (points.hasVariance ? "property float variance\n" : "") + "property uchar state\nend_header\n");
  forEachCell(map, states,
              [&](const CellIndex& cell, const Eigen::Vector3d& centre, const CellEstimate& estimate)
              {
                out.appendBytes(std::array<double, 3>{centre.x(), centre.y(), centre.z()});
                const auto color = heightColor(cell, points.extent);
                out.appendBytes(std::array<uint8_t, 3>{color.R, color.G, color.B});
                out.appendBytes(static_cast<float>(estimate.prob));
                if (points.hasVariance)
                  out.appendBytes(estimate.variance ? static_cast<float>(*estimate.variance)
                                                    : std::numeric_limits<float>::quiet_NaN());
                out.appendBytes(static_cast<uint8_t>(estimate.state));
              });
  out.commit();
}

void writePcd(const CellMap& map, const std::string& path, const StateSet& states)
{
  const PointSummary points = summarizePoints(map, path, states);
  requireFloatPrecision(map, path, points.extent.first, points.extent.last, "PCD's float coordinates");
  const std::string count = std::to_string(points.count);
  FileOutput out(path);
  out.append(
      "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z rgb intensity\nSIZE 4 4 4 4 4\n"
      "TYPE F F F F F\nCOUNT 1 1 1 1 1\nWIDTH " +
      count + "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + count + "\nDATA binary\n");
  forEachCell(map, states,
              [&](const CellIndex& cell, const Eigen::Vector3d& centre, const CellEstimate& estimate)
              {
                for (int axis = 0; axis < 3; ++axis) out.appendBytes(static_cast<float>(centre[axis]));
                const auto color = heightColor(cell, points.extent);
                out.appendBytes(uint32_t{color.R} << 16U | uint32_t{color.G} << 8U | uint32_t{color.B});
                out.appendBytes(static_cast<float>(estimate.prob));
              });
  out.commit();
}

}  // namespace lamap::tools
