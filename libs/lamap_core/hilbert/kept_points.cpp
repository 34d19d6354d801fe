#include <lamap_core/hilbert/kept_points.h>

#include <lamap_core/hilbert/model.h>

#include <algorithm>
#include <cmath>
#include <tuple>

namespace lamap
{
void KeptPoints::add(const HilbertTrainingSet& set, const HilbertFrame& frame, bool atCentres)
{
  const CellIndex& anchor = frame.cells.anchor();
  for (size_t i = 0; i < set.size(); ++i)
  {
    if (!atCentres)
    {
      points_.push_back({set.points[i] + cornerOf(frame.anchorSite, frame.spacing_m), set.labels[i],
                         set.weights[i],
                         set.covariances.empty() ? Eigen::Matrix3d::Zero() : set.covariances[i]});
      continue;
    }
    const Eigen::Vector3d local = (set.points[i] - frame.cellOrigin_m) / frame.cells.resolution_m();
    const CellIndex cell{
        anchor.x + static_cast<int32_t>(std::floor(local.x())),
        anchor.y + static_cast<int32_t>(std::floor(local.y())),
        frame.cells.planar() ? anchor.z : anchor.z + static_cast<int32_t>(std::floor(local.z()))};
    Weights& weights = cells_[cell];
    (set.labels[i] > 0.5f ? weights.hits : weights.frees) += set.weights[i];
  }
}

size_t KeptPoints::size() const
{
  size_t count = points_.size();
  for (const auto& [cell, weights] : cells_) count += (weights.hits > 0) + (weights.frees > 0);
  return count;
}

size_t KeptPoints::memoryBytes() const
{
  return cells_.bucket_count() * (sizeof(std::pair<CellIndex, Weights>) + 8) +
         points_.capacity() * sizeof(HilbertState::Point);
}

std::vector<HilbertState::CellPoints> KeptPoints::sortedCells() const
{
  std::vector<HilbertState::CellPoints> cells;
  cells.reserve(cells_.size());
  for (const auto& [cell, weights] : cells_) cells.push_back({cell, weights.hits, weights.frees});
  std::sort(cells.begin(), cells.end(),
            [](const auto& a, const auto& b) {
              return std::make_tuple(a.cell.z, a.cell.y, a.cell.x) <
                     std::make_tuple(b.cell.z, b.cell.y, b.cell.x);
            });
  return cells;
}

std::pair<HilbertFrame, HilbertTrainingSet> KeptPoints::trainingSet(const HilbertStructure& structure) const
{
  const std::vector<HilbertState::CellPoints> cells = sortedCells();
  const auto frame = cells.empty() ? HilbertFrame::inMap(points_.front().place, structure.resolution,
                                                         structure.latticeSpacing, structure.planarLayer())
                                   : HilbertFrame::atCell(cells.front().cell, structure.resolution,
                                                          structure.latticeSpacing, structure.planar);
  HilbertTrainingSet set;
  const CellIndex& anchor = frame->cells.anchor();
  for (const HilbertState::CellPoints& kept : cells)
  {
    const Eigen::Vector3d centre = frame->position({static_cast<double>(kept.cell.x) - anchor.x + 0.5,
                                                    static_cast<double>(kept.cell.y) - anchor.y + 0.5,
                                                    static_cast<double>(kept.cell.z) - anchor.z + 0.5});
    if (kept.hits > 0) set.add(centre, true, static_cast<double>(kept.hits));
    if (kept.frees > 0) set.add(centre, false, static_cast<double>(kept.frees));
  }
  const size_t certain = set.size();
  bool anyCovariance = false;
  for (const HilbertState::Point& point : points_)
  {
    set.add(point.place - cornerOf(frame->anchorSite, structure.latticeSpacing), point.label > 0.5f,
            static_cast<double>(point.weight));
    anyCovariance = anyCovariance || !point.covariance.isZero(0);
  }
  if (anyCovariance)
  {
    set.covariances.assign(certain, Eigen::Matrix3d::Zero());
    for (const HilbertState::Point& point : points_) set.covariances.push_back(point.covariance);
  }
  return {*frame, std::move(set)};
}

void KeptPoints::save(HilbertState& state) const
{
  state.cells = sortedCells();
  state.points = points_;
}

void KeptPoints::restore(const HilbertState& state, const HilbertStructure& structure)
{
  const auto isWeight = [](float weight) { return weight >= 0 && std::isfinite(weight); };
  cells_.clear();
  points_.clear();
  for (const HilbertState::CellPoints& kept : state.cells)
  {
    HilbertState::require(isWeight(kept.hits) && isWeight(kept.frees), "the weight of a cell is not legal");
    HilbertState::require(
        HilbertFrame::atCell(kept.cell, structure.resolution, structure.latticeSpacing, structure.planar)
            .has_value(),
        "a cell beyond what can be addressed");
    HilbertState::require(cells_.emplace(kept.cell, Weights{kept.hits, kept.frees}).second, "a cell twice");
  }
  for (const HilbertState::Point& point : state.points)
  {
    HilbertState::require(point.place.allFinite() && point.covariance.allFinite() && isWeight(point.weight) &&
                              (point.label == 0.0f || point.label == 1.0f),
                          "a training point is not legal");
    HilbertState::require(HilbertFrame::inMap(point.place, structure.resolution, structure.latticeSpacing,
                                              structure.planarLayer())
                              .has_value(),
                          "a training point beyond what can be addressed");
    points_.push_back(point);
  }
}

}  // namespace lamap
