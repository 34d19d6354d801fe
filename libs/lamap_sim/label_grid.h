#pragma once

#include <lamap_core/grid/cell.h>
#include <lamap_sim/world.h>

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

namespace lamap::sim
{
/// How a cell of a world lies relative to its solids.
enum class CellLabel : uint8_t
{
  Outside,  ///< open, but not wholly in the interior
  Open,     ///< in the interior, without any solid
  Mixed,    ///< holds a surface
  Solid,
  Deep  ///< solid, but too far behind any surface: see dropDeepCells()
};

/** The labels of all cells of a world, and of a margin around its interior. Of a flat world, one layer at
 * z index 0. Belongs to one thread. */
class LabelGrid
{
 public:
  using Index3 = std::array<int32_t, 3>;  ///< of a cell of the grid, from 0

  /// @param margin  in cells, around the interior
  /// @throws std::invalid_argument if there would be more than 10⁹ cells
  LabelGrid(const World& world, double resolution_m, int margin);

  /// @return false if it was stopped
  bool labelAll(const std::function<bool()>& shouldStop);

  /// Removes solid cells that have only solid cells within the margin around them.
  void dropDeepCells();

  [[nodiscard]] CellLabel labelOf(const Index3& cell) const { return labels_[at(cell)]; }
  [[nodiscard]] size_t at(const Index3& cell) const;
  [[nodiscard]] size_t count() const { return labels_.size(); }
  [[nodiscard]] CellIndex indexOf(const Index3& cell) const;
  /// The inverse; empty beyond the grid.
  [[nodiscard]] std::optional<Index3> cellOf(const CellIndex& index) const;
  /// Around all cells.
  [[nodiscard]] Eigen::AlignedBox3d box() const { return boxBetween({0, 0, 0}, size_); }
  [[nodiscard]] Eigen::AlignedBox3d boxOf(const Index3& cell) const;

  /** Whether a cell holds a surface: it is mixed, or it is solid and shares a face with an open one, so that
   * the surface lies exactly on the face. */
  [[nodiscard]] bool holdsSurface(const Index3& cell) const;

  /// Calls visit(cell) for all cells, sorted by z, y, x, until it returns false.
  /// @return false if it did
  template <class Visit>
  bool forEachCell(const Visit& visit) const
  {
    return forEachPart({0, 0, 0}, size_, 1, visit);
  }

 private:
  static constexpr int32_t kBlock = 16;
  static constexpr int kSplits = 3;

  template <class Visit>
  static bool forEachPart(const Index3& begin, const Index3& end, int32_t edge, const Visit& visit)
  {
    for (int32_t z = begin[2]; z < end[2]; z += edge)
      for (int32_t y = begin[1]; y < end[1]; y += edge)
        for (int32_t x = begin[0]; x < end[0]; x += edge)
          if (!visit(Index3{x, y, z})) return false;
    return true;
  }

  /// Labels the cells begin .. begin+edge-1, all together if they agree.
  bool label(const Index3& begin, int32_t edge, const std::function<bool()>& shouldStop);
  [[nodiscard]] Eigen::AlignedBox3d boxBetween(const Index3& begin, const Index3& end) const;
  /// Whether a cell overlaps the interior.
  [[nodiscard]] bool isInInterior(const Index3& begin) const;
  void fill(const Index3& begin, const Index3& end, CellLabel label);
  /// Sets near[i] where a cell within the margin along an axis was set.
  void spread(std::vector<uint8_t>& near, size_t axis) const;

  const World& world_;
  double resolution_m_;
  int margin_;
  Index3 first_{};
  Index3 size_{};
  std::vector<CellLabel> labels_;
};

}  // namespace lamap::sim
