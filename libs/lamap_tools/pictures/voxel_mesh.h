#pragma once

#include <lamap_core/grid/cell.h>
#include <mrpt/img/TColor.h>
#include <mrpt/opengl/CSetOfTriangles.h>

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

namespace lamap::tools
{
/** The visible faces of a set of cells as triangles.
 *
 * Faces between two cells of the set are omitted. Light is part of the colours, because no single lamp would
 * show a wall's shape from every side: each direction has its own brightness, and corners between cells are
 * darker (ambient occlusion from the three cells around each corner of a face).
 */
class VoxelMesh
{
 public:
  /// Cells may repeat. @param edge  of a cell in the mesh's units.
  VoxelMesh(std::vector<CellIndex> cells, double edge);

  [[nodiscard]] size_t faceCount() const;

  using ColorOf = std::function<mrpt::img::TColor(const CellIndex&)>;
  /// The mesh, with cell (0, 0, 0) at the corner of its origin.
  [[nodiscard]] mrpt::opengl::CSetOfTriangles::Ptr triangles(const ColorOf& colorOf) const;

 private:
  [[nodiscard]] bool has(const CellIndex& cell) const;
  void appendFace(mrpt::opengl::CSetOfTriangles& mesh, const CellIndex& cell, int axis, int side,
                  const mrpt::img::TColor& color) const;
  /// Light that reaches a corner of a face, from 0 (enclosed) to 3 (open).
  [[nodiscard]] int openness(const CellIndex& before, int axisU, int stepU, int axisV, int stepV) const;

  std::vector<CellIndex> cells_;  ///< sorted
  double edge_;
};

}  // namespace lamap::tools
