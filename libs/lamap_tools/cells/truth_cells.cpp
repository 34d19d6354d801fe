#include <lamap_tools/cells/cell_table.h>
#include <lamap_tools/cells/truth_cells.h>

#include <algorithm>

namespace lamap::tools
{
namespace
{
bool labelledInOrder(const LabelledCell& a, const LabelledCell& b)
{
  return inTableOrder(a.first, b.first);
}

class TruthCells : public CellMap
{
 public:
  TruthCells(std::vector<LabelledCell> cells, double resolution_m)
      : cells_(std::move(cells)), resolution_m_(resolution_m)
  {
    std::sort(cells_.begin(), cells_.end(), labelledInOrder);
  }

  std::string className() const override { return "the truth"; }
  double resolution() const override { return resolution_m_; }
  std::vector<std::string> evidenceNames() const override { return {"label"}; }
  std::optional<CellEstimate> estimateAt(const mrpt::math::TPoint3D& point_map) const override
  {
    const auto index = cellAt({point_map.x, point_map.y, point_map.z}, resolution_m_);
    if (!index) return std::nullopt;
    const auto found =
        std::lower_bound(cells_.begin(), cells_.end(), LabelledCell(*index, false), labelledInOrder);
    if (found == cells_.end() || !(found->first == *index)) return std::nullopt;
    return estimateOf(found->second);
  }
  void visitCells(const CellVisitor& visitor) const override
  {
    for (const auto& [index, occupied] : cells_) visitor(index, estimateOf(occupied));
  }

 private:
  static CellEstimate estimateOf(bool occupied)
  {
    CellEstimate estimate;
    estimate.prob = occupied ? 1.0 : 0.0;
    estimate.state = occupied ? CellState::Occupied : CellState::Free;
    estimate.evidence[0] = estimate.prob;
    return estimate;
  }

  std::vector<LabelledCell> cells_;  ///< in table order
  double resolution_m_;
};
}  // namespace

std::unique_ptr<CellMap> cellsOf(std::vector<LabelledCell> cells, double resolution_m)
{
  return std::make_unique<TruthCells>(std::move(cells), resolution_m);
}

std::unique_ptr<CellMap> cellsOf(const Truth& truth)
{
  if (!truth.spacing_m) return nullptr;
  std::vector<LabelledCell> cells;
  cells.reserve(truth.cells.size());
  for (const TrueCell& cell : truth.cells)
    if (const auto index = cellAt(cell.centre_map, *truth.spacing_m))
      cells.emplace_back(*index, cell.occupied);
  return cellsOf(std::move(cells), *truth.spacing_m);
}

}  // namespace lamap::tools
