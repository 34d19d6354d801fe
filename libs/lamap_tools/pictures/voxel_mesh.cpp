#include <lamap_tools/pictures/voxel_mesh.h>

#include <lamap_tools/cells/cell_table.h>
#include <lamap_tools/pictures/palette.h>

#include <algorithm>

namespace lamap::tools
{
namespace
{
CellIndex moved(CellIndex cell, int axis, int step)
{
  (axis == 0 ? cell.x : axis == 1 ? cell.y : cell.z) += step;
  return cell;
}
}  // namespace

VoxelMesh::VoxelMesh(std::vector<CellIndex> cells, double edge) : cells_(std::move(cells)), edge_(edge)
{
  std::sort(cells_.begin(), cells_.end(), inTableOrder);
  cells_.erase(std::unique(cells_.begin(), cells_.end()), cells_.end());
}

bool VoxelMesh::has(const CellIndex& cell) const
{
  return std::binary_search(cells_.begin(), cells_.end(), cell, inTableOrder);
}

size_t VoxelMesh::faceCount() const
{
  size_t count = 0;
  for (const CellIndex& cell : cells_)
    for (int axis = 0; axis < 3; ++axis)
      for (const int side : {-1, 1}) count += has(moved(cell, axis, side)) ? 0 : 1;
  return count;
}

int VoxelMesh::openness(const CellIndex& before, int axisU, int stepU, int axisV, int stepV) const
{
  const bool u = has(moved(before, axisU, stepU));
  const bool v = has(moved(before, axisV, stepV));
  if (u && v) return 0;
  const bool corner = has(moved(moved(before, axisU, stepU), axisV, stepV));
  return 3 - (u ? 1 : 0) - (v ? 1 : 0) - (corner ? 1 : 0);
}

void VoxelMesh::appendFace(mrpt::opengl::CSetOfTriangles& mesh, const CellIndex& cell, int axis, int side,
                           const mrpt::img::TColor& color) const
{
  // Light from above and slightly from -y, so that walls of different directions differ.
  constexpr std::array<std::array<double, 2>, 3> kBrightness = {{{0.70, 0.76}, {0.86, 0.62}, {0.50, 1.00}}};
  constexpr std::array<double, 4> kOcclusion = {0.55, 0.72, 0.87, 1.00};
  const int axisU = (axis + 1) % 3;
  const int axisV = (axis + 2) % 3;
  const CellIndex before = moved(cell, axis, side);
  const double brightness = kBrightness[static_cast<size_t>(axis)][side > 0 ? 1 : 0];

  std::array<mrpt::opengl::TTriangle::Vertex, 4> corners;
  std::array<int, 4> open{};
  constexpr std::array<std::array<int, 2>, 4> kSteps = {{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}};
  for (size_t i = 0; i < 4; ++i)
  {
    CellIndex corner = cell;
    if (side > 0) corner = moved(corner, axis, 1);
    if (kSteps[i][0] > 0) corner = moved(corner, axisU, 1);
    if (kSteps[i][1] > 0) corner = moved(corner, axisV, 1);
    corners[i].xyzrgba.pt = {static_cast<float>(corner.x * edge_), static_cast<float>(corner.y * edge_),
                             static_cast<float>(corner.z * edge_)};
    open[i] = openness(before, axisU, kSteps[i][0], axisV, kSteps[i][1]);
    corners[i].setColor(darkened(color, brightness * kOcclusion[static_cast<size_t>(open[i])]));
  }
  // Split along the diagonal that does not smear a dark corner over the face.
  const size_t first = open[0] + open[2] >= open[1] + open[3] ? 0 : 1;
  for (const size_t turn : {size_t{1}, size_t{2}})
  {
    mrpt::opengl::TTriangle triangle;
    triangle.vertices = {corners[first], corners[(first + turn) % 4], corners[(first + turn + 1) % 4]};
    mesh.insertTriangle(triangle);
  }
}

mrpt::opengl::CSetOfTriangles::Ptr VoxelMesh::triangles(const ColorOf& colorOf) const
{
  auto mesh = mrpt::opengl::CSetOfTriangles::Create();
  mesh->enableLight(false);
  for (const CellIndex& cell : cells_)
  {
    const mrpt::img::TColor color = colorOf(cell);
    for (int axis = 0; axis < 3; ++axis)
      for (const int side : {-1, 1})
        if (!has(moved(cell, axis, side))) appendFace(*mesh, cell, axis, side, color);
  }
  return mesh;
}

}  // namespace lamap::tools
