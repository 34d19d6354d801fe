#include <lamap_core/options/legal_range.h>
#include <lamap_core/scan/ray_selection.h>
#include <lamap_core/scan/scan_labels.h>

#include <algorithm>
#include <cmath>
#include <tuple>

namespace lamap
{
namespace
{
bool comesBefore(const CellIndex& a, const CellIndex& b)
{
  return std::tie(a.z, a.y, a.x) < std::tie(b.z, b.y, b.x);
}

void sortAndKeepOne(std::vector<CellIndex>& cells)
{
  std::sort(cells.begin(), cells.end(), comesBefore);
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
}

class Labeller
{
 public:
  explicit Labeller(const LabelRules& rules)
      : rules_(rules), margin_m_(rules.freeMargin_m.value_or(2 * rules.resolution_m))
  {
    requireLegal(rules.resolution_m > 0 && std::isfinite(rules.resolution_m), "resolution",
                 rules.resolution_m, "a finite length > 0");
    requireLegal(margin_m_ >= 0 && std::isfinite(margin_m_), "freeMargin", margin_m_, "a finite length >= 0");
  }

  void add(const SelectedFan& fan)
  {
    struct Hit
    {
      CellIndex cell;
      size_t ray;
    };
    std::vector<Hit> hits;
    hits.reserve(fan.hitEnds_map.size());
    for (size_t i = 0; i < fan.hitEnds_map.size(); ++i)
      if (const auto cell = cellOf(fan.hitEnds_map[i])) hits.push_back({*cell, i});
    // The first ray of each cell comes first among its rays.
    std::stable_sort(hits.begin(), hits.end(),
                     [](const Hit& a, const Hit& b) { return comesBefore(a.cell, b.cell); });
    for (size_t i = 0; i < hits.size(); ++i)
    {
      if (i > 0 && hits[i].cell == hits[i - 1].cell) continue;
      labels_.occupied.push_back(hits[i].cell);
      followBack(fan.origin_map, fan.hitEnds_map[hits[i].ray] - fan.origin_map, margin_m_);
    }
    for (const Eigen::Vector3d& ray : fan.freeRays_map) followBack(fan.origin_map, ray, 0);
  }

  ScanLabels take()
  {
    sortAndKeepOne(labels_.occupied);
    sortAndKeepOne(labels_.free);
    std::vector<CellIndex> freeOnly;
    std::set_difference(labels_.free.begin(), labels_.free.end(), labels_.occupied.begin(),
                        labels_.occupied.end(), std::back_inserter(freeOnly), comesBefore);
    labels_.free = std::move(freeOnly);
    return std::move(labels_);
  }

 private:
  std::optional<CellIndex> cellOf(const Eigen::Vector3d& point) const
  {
    auto cell = cellAt(point, rules_.resolution_m);
    if (cell && rules_.layer) cell->z = *rules_.layer;
    return cell;
  }

  void followBack(const Eigen::Vector3d& origin, Eigen::Vector3d ray, double margin_m)
  {
    if (rules_.layer) ray.z() = 0;
    const double length_m = ray.norm();
    if (!(length_m > 0)) return;
    const Eigen::Vector3d direction = ray / length_m;
    for (double at_m = length_m - margin_m; at_m > rules_.resolution_m / 2; at_m -= rules_.resolution_m)
      if (const auto cell = cellOf(origin + at_m * direction)) labels_.free.push_back(*cell);
    // Rays near the sensor share their cells: joined before they fill the memory.
    if (labels_.free.size() < joinAt_) return;
    sortAndKeepOne(labels_.free);
    joinAt_ = std::max(joinAt_, 2 * labels_.free.size());
  }

  LabelRules rules_;
  double margin_m_;
  ScanLabels labels_;
  size_t joinAt_ = 1U << 22U;
};
}  // namespace

ScanLabels labelCells(const Scan& scan, const LabelRules& rules)
{
  RangeLimits limits;
  limits.max_m = rules.maxRange_m;
  Labeller labeller(rules);
  for (const SelectedFan& fan : selectRays(scan, limits).fans) labeller.add(fan);
  return labeller.take();
}

}  // namespace lamap
