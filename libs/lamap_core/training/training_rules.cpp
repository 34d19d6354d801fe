#include <lamap_core/training/training_rules.h>

#include <lamap_core/options/legal_range.h>

namespace lamap
{
namespace
{
/// Smaller voxels hold a point each, which 0 says too, and their indices would overflow.
void requireVoxelEdge(const char* name, double edge_m, double resolution_m)
{
  requireLegal(edge_m == 0 || (edge_m >= 0.01 * resolution_m && edge_m <= 1e6), name, edge_m,
               "0, or a length [m] of at least 1/100 of the resolution");
}
}  // namespace

void TrainingRules::validate(double resolution_m) const
{
  // A point every thousandth of a cell is a mistake in the unit, and would not end.
  requireLegal(freeResolution >= 1e-3 * resolution_m && freeResolution <= 1e6, "freeResolution",
               freeResolution, "a length [m] of at least 1/1000 of the resolution");
  requireLegal(freeMargin >= 0 && std::isfinite(freeMargin), "freeMargin", freeMargin,
               "a finite number >= 0");
  requireVoxelEdge("freeDownsampling", freeDownsampling, resolution_m);
  requireVoxelEdge("hitDownsampling", hitDownsampling, resolution_m);
}

}  // namespace lamap
