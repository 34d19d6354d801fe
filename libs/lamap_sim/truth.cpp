#include <lamap_core/options/legal_range.h>
#include <lamap_sim/label_grid.h>
#include <lamap_sim/truth.h>

namespace lamap::sim
{
std::vector<TrueCell> truthOf(const World& world, const TruthOptions& options,
                              const std::function<bool()>& shouldStop)
{
  requireLegal(options.depthCells >= 1 && options.depthCells <= 1000, "truth depth", options.depthCells,
               "between 1 and 1000 cells");
  LabelGrid grid(world, options.resolution_m, options.depthCells);
  if (!grid.labelAll(shouldStop)) return {};
  grid.dropDeepCells();
  std::vector<TrueCell> cells;
  grid.forEachCell(
      [&](const LabelGrid::Index3& cell)
      {
        const CellLabel label = grid.labelOf(cell);
        if (label == CellLabel::Open || label == CellLabel::Solid)
          cells.push_back({grid.indexOf(cell), label == CellLabel::Solid});
        return true;
      });
  return cells;
}

}  // namespace lamap::sim
