#include <lamap_core/options/legal_range.h>
#include <lamap_core/scan/ray_selection.h>
#include <lamap_core/training/sampler.h>
#include <lamap_core/training/scan_labels.h>

#include <algorithm>
#include <cmath>
#include <tuple>

namespace lamap
{
namespace
{
SamplingRules samplingRulesOf(const LabelRules& rules)
{
  SamplingRules sampling;
  sampling.samplesFrom = SamplesFrom::End;
  sampling.freeResolution = rules.resolution_m;
  sampling.freeMargin = rules.freeMargin_m.value_or(2 * rules.resolution_m);
  sampling.sensorMargin = rules.resolution_m / 2;
  sampling.protectHits = 1;
  return sampling;
}

void sort(std::vector<CellIndex>& cells)
{
  std::sort(cells.begin(), cells.end(),
            [](const CellIndex& a, const CellIndex& b)
            { return std::tie(a.z, a.y, a.x) < std::tie(b.z, b.y, b.x); });
}
}  // namespace

ScanLabels labelCells(const Scan& scan, const LabelRules& rules)
{
  requireLegal(rules.resolution_m > 0 && std::isfinite(rules.resolution_m), "resolution", rules.resolution_m,
               "a finite length > 0");
  const SamplingRules sampling = samplingRulesOf(rules);
  requireLegal(sampling.freeMargin >= 0 && std::isfinite(sampling.freeMargin), "freeMargin",
               sampling.freeMargin, "a finite length >= 0");
  RangeOptions limits;
  limits.maxRange = rules.maxRange_m;
  limits.considerInvalidRangesAsFreeSpace = rules.noReturnIsFree;
  const SelectedRays rays = selectRays(scan, limits, rules.resolution_m);
  const ScanFrame frame = ScanFrame::around(rays.scan, rules.resolution_m, rules.layer);
  ScanLabels labels;
  Sampler sampler;
  sampler.sample(rays, sampling, frame, {}, 1)
      .forEachPoint(
          [&](const TrainingPoint& point)
          {
            const CellIndex local = cellOfLocal(point.place);
            const CellIndex& anchor = frame.anchor();
            (point.occupied ? labels.occupied : labels.free)
                .push_back({anchor.x + local.x, anchor.y + local.y, anchor.z + local.z});
          });
  sort(labels.occupied);
  sort(labels.free);
  return labels;
}

}  // namespace lamap
