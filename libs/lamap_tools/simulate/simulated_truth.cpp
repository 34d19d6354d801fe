#include <lamap_tools/simulate/simulated_truth.h>

#include <lamap_tools/cells/octomap_file.h>

#include <algorithm>

namespace lamap::tools
{
namespace
{
/// A truth as a map with probabilities of 0 and 1.
class TruthCells : public CellMap
{
 public:
  TruthCells(const std::vector<sim::TrueCell>& cells, double resolution_m)
      : cells_(cells), resolution_m_(resolution_m)
  {
  }

  [[nodiscard]] std::string className() const override { return "truth"; }
  [[nodiscard]] double resolution() const override { return resolution_m_; }
  [[nodiscard]] std::vector<std::string> evidenceNames() const override { return {"label"}; }

  [[nodiscard]] std::optional<CellEstimate> estimateAt(const mrpt::math::TPoint3D& point_map) const override
  {
    const auto index = cellAt({point_map.x, point_map.y, point_map.z}, resolution_m_);
    if (!index) return std::nullopt;
    const auto found = std::find_if(cells_.begin(), cells_.end(),
                                    [&](const sim::TrueCell& cell) { return cell.index == *index; });
    if (found == cells_.end()) return std::nullopt;
    return estimateOf(*found);
  }

  void visitCells(const CellVisitor& visitor) const override
  {
    for (const sim::TrueCell& cell : cells_) visitor(cell.index, estimateOf(cell));
  }

 private:
  static CellEstimate estimateOf(const sim::TrueCell& cell)
  {
    CellEstimate estimate;
    estimate.prob = cell.solid ? 1 : 0;
    estimate.state = cell.solid ? CellState::Occupied : CellState::Free;
    estimate.evidence = {estimate.prob, 0};
    return estimate;
  }

  const std::vector<sim::TrueCell>& cells_;
  double resolution_m_;
};
}  // namespace

bool writeTruthCsv(const std::vector<sim::TrueCell>& cells, double resolution_m, FileOutput& file,
                   const std::function<bool(size_t)>& goOn)
{
  file.append("x,y,z,label\n");
  size_t count = 0;
  for (const sim::TrueCell& cell : cells)
  {
    constexpr size_t kBetweenQuestions = 1U << 16U;
    if (++count % kBetweenQuestions == 0 && !goOn(count)) return false;
    const Eigen::Vector3d centre = cellCentre(cell.index, resolution_m);
    for (int axis = 0; axis < 3; ++axis)
    {
      file.append(centre[axis]);
      file.append(",");
    }
    file.append(cell.solid ? "1\n" : "0\n");
  }
  return true;
}

void writeTruthOctree(const std::vector<sim::TrueCell>& cells, double resolution_m, const std::string& path)
{
  writeOctomapFile(TruthCells(cells, resolution_m), path);
}

}  // namespace lamap::tools
