#include <lamap_tools/scores/truth_cells.h>

#include <lamap_mrpt/learned_map/cell_hash.h>
#include <tsl/robin_map.h>

namespace lamap::tools
{
namespace
{
class TruthCells : public CellMap
{
 public:
  explicit TruthCells(const Truth& truth) : resolution_m_(truth.spacing_m.value())
  {
    for (const TrueCell& cell : truth.cells)
      if (const auto index = cellAt(cell.centre_map, resolution_m_)) occupied_[*index] = cell.occupied;
  }

  std::string className() const override { return "the truth"; }
  double resolution() const override { return resolution_m_; }
  std::vector<std::string> evidenceNames() const override { return {"label"}; }
  std::optional<CellEstimate> estimateAt(const mrpt::math::TPoint3D& point_map) const override
  {
    const auto index = cellAt({point_map.x, point_map.y, point_map.z}, resolution_m_);
    const auto found = index ? occupied_.find(*index) : occupied_.end();
    if (found == occupied_.end()) return std::nullopt;
    return estimateOf(found->second);
  }
  void visitCells(const CellVisitor& visitor) const override
  {
    for (const auto& [index, occupied] : occupied_) visitor(index, estimateOf(occupied));
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

  double resolution_m_;
  tsl::robin_map<CellIndex, bool, CellIndexHash> occupied_;
};
}  // namespace

std::unique_ptr<CellMap> cellsOf(const Truth& truth)
{
  if (!truth.spacing_m) return nullptr;
  return std::make_unique<TruthCells>(truth);
}

}  // namespace lamap::tools
