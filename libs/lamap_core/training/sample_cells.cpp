#include <lamap_core/math/registers.h>
#include <lamap_core/scan/scan_frame.h>
#include <lamap_core/training/sample_cells.h>

#include <cstddef>

namespace lamap
{
namespace
{
using Cells = std::array<std::array<int32_t, SampleCells::kMost>, 3>;

LAMAP_INLINED void findCells(const SampledRay& ray, double from, int count, Cells& cells)
{
  std::array<double, SampleCells::kMost> along;
  for (int i = 0; i < count; ++i)
  {
    double t = ray.first + (from + i) * ray.step;
    t = t < ray.last ? t : ray.last;
    along[static_cast<size_t>(i)] = t > 0 ? t : 0;
  }
  for (int axis = 0; axis < 3; ++axis)
  {
    const double origin = ray.origin[axis];
    const double direction = ray.direction[axis];
    std::array<int32_t, SampleCells::kMost>& cell = cells[static_cast<size_t>(axis)];
    for (int i = 0; i < count; ++i)
      cell[static_cast<size_t>(i)] = localCell(origin + along[static_cast<size_t>(i)] * direction);
  }
}

}  // namespace

void SampleCells::find(const SampledRay& ray, int64_t from, int count)
{
  withRegisters([&](auto /*r*/) LAMAP_INLINED_LAMBDA
                { findCells(ray, static_cast<double>(from), count, cells_); });
}

}  // namespace lamap
