#include <lamap_core/grid/state_thresholds.h>

#include <lamap_core/options/legal_range.h>

#include <cmath>

namespace lamap
{
void StateThresholds::validate() const
{
  requireLegal(free >= 0 && free <= 1, "freeThreshold", free, "from 0 to 1");
  requireLegal(occupied >= free && occupied <= 1, "occupiedThreshold", occupied,
               "from freeThreshold, " + shortText(free) + ", to 1");
  requireLegal(variance >= 0 && std::isfinite(variance), "varianceThreshold", variance,
               "a finite number >= 0");
}

}  // namespace lamap
