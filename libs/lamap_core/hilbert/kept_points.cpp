#include <lamap_core/hilbert/kept_points.h>

#include <lamap_core/hilbert/model.h>

#include <algorithm>
#include <cmath>
#include <tuple>

namespace lamap
{
namespace
{
CellIndex cellAround(const Eigen::Vector3d& point, const HilbertFrame& frame)
{
  const CellIndex& anchor = frame.cells.anchor();
  const Eigen::Vector3d local = (point - frame.cellOrigin_m) / frame.cells.resolution_m();
  return {anchor.x + static_cast<int32_t>(std::floor(local.x())),
          anchor.y + static_cast<int32_t>(std::floor(local.y())),
          frame.cells.planar() ? anchor.z : anchor.z + static_cast<int32_t>(std::floor(local.z()))};
}
}  // namespace

void KeptPoints::add(const HilbertTrainingSet& set, const HilbertFrame& frame, bool atCentres)
{
  if (atCentres)
    addCells(set, frame);
  else
    addPoints(set, frame);
}

void KeptPoints::addCells(const HilbertTrainingSet& set, const HilbertFrame& frame)
{
  std::vector<CellIndex> cells;
  cells.reserve(set.size());
  for (const Eigen::Vector3d& point : set.points) cells.push_back(cellAround(point, frame));
  for (const CellIndex& cell : cells) cells_.try_emplace(cell);
  // Nothing fails from here on.
  for (size_t i = 0; i < set.size(); ++i)
  {
    Weights& weights = cells_.find(cells[i]).value();
    (set.labels[i] > 0.5f ? weights.hits : weights.frees) += set.weights[i];
  }
}

void KeptPoints::addPoints(const HilbertTrainingSet& set, const HilbertFrame& frame)
{
  std::vector<HilbertState::Point> added;
  added.reserve(set.size());
  for (size_t i = 0; i < set.size(); ++i)
    added.push_back({set.points[i] + cornerOf(frame.anchorSite, frame.spacing_m), set.labels[i],
                     set.weights[i], set.covariances.empty() ? Eigen::Matrix3d::Zero() : set.covariances[i],
                     i < set.variances.size() ? static_cast<double>(set.variances[i]) : 0.0});
  points_.insert(points_.end(), added.begin(), added.end());
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
  for (const auto& [cell, weights] : cells_)
    if (weights.hits > 0 || weights.frees > 0) cells.push_back({cell, weights.hits, weights.frees});
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
    set.variances.assign(certain, 0.0f);
    for (const HilbertState::Point& point : points_)
    {
      set.covariances.push_back(point.covariance);
      set.variances.push_back(static_cast<float>(point.variance));
    }
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
    HilbertState::require(!structure.planar || kept.cell.z == *structure.planarLayer(),
                          "a cell beside the plane");
    HilbertState::require(cells_.emplace(kept.cell, Weights{kept.hits, kept.frees}).second, "a cell twice");
  }
  for (const HilbertState::Point& point : state.points)
  {
    HilbertState::require(point.place.allFinite() && point.covariance.allFinite() && isWeight(point.weight) &&
                              isWeight(static_cast<float>(point.variance)) &&
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
