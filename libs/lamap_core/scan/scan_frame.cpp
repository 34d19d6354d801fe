#include <lamap_core/scan/scan_frame.h>

namespace lamap
{
ScanFrame ScanFrame::around(const Scan& scan, double resolution_m, std::optional<int32_t> layer)
{
  std::optional<CellIndex> anchor;
  for (const RayFan& fan : scan.fans)
    if (!anchor) anchor = cellAt(scan.inMap(fan.centre), resolution_m);
  if (!anchor) anchor = CellIndex{};
  if (layer) anchor->z = *layer;
  return {resolution_m, *anchor, layer.has_value()};
}

}  // namespace lamap
