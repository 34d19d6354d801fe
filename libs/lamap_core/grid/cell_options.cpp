#include <lamap_core/grid/cell_options.h>

#include <lamap_core/options/legal_range.h>

#include <cmath>
#include <tuple>

namespace lamap
{
std::optional<int32_t> CellOptions::planarLayer() const
{
  if (!planar) return std::nullopt;
  return static_cast<int32_t>(std::floor(planarHeight / resolution));
}

void CellOptions::validate() const
{
  requireLegal(resolution >= 1e-4 && resolution <= 1e4, "resolution", resolution,
               "a length from 0.0001 to 10000 m");
  requireLegal(std::abs(planarHeight) <= 1e9 * resolution, "planarHeight", planarHeight,
               "a finite height [m] within 1e9 cells");
}

bool operator==(const CellOptions& a, const CellOptions& b)
{
  return std::tie(a.resolution, a.planar, a.planarHeight) == std::tie(b.resolution, b.planar, b.planarHeight);
}

void BlockOptions::validate() const
{
  CellOptions::validate();
  requireLegal(blockDepth >= 2 && blockDepth <= 6, "blockDepth", blockDepth, "a whole number from 2 to 6");
}

bool operator==(const BlockOptions& a, const BlockOptions& b)
{
  return static_cast<const CellOptions&>(a) == static_cast<const CellOptions&>(b) &&
         std::tie(a.blockDepth, a.pruning) == std::tie(b.blockDepth, b.pruning);
}

}  // namespace lamap
