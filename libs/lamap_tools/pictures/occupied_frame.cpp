#include <lamap_tools/pictures/occupied_frame.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <stdexcept>

namespace lamap::tools
{
namespace
{
/// Number of occupied cells at each index along one axis.
using Histogram = std::map<int32_t, size_t>;

void frameAxis(const Histogram& histogram, size_t total, int32_t& first, int32_t& last)
{
  constexpr double kLeftOut = 0.01;  // at either end
  const auto atShare = [&](double share)
  {
    const double wanted = share * static_cast<double>(total);
    double counted = 0;
    for (const auto& [index, count] : histogram)
    {
      counted += static_cast<double>(count);
      if (counted > wanted) return index;
    }
    return histogram.rbegin()->first;
  };
  const int32_t lowest = histogram.begin()->first;
  const int32_t highest = histogram.rbegin()->first;
  const double low = atShare(kLeftOut);
  const double high = atShare(1 - kLeftOut);
  const double room = std::ceil((high - low + 1) / 8);
  const double whole = static_cast<double>(highest) - lowest + 1;
  constexpr double kWorthCutting = 4.0 / 3.0;
  const bool cut = whole > kWorthCutting * (high - low + 1 + 2 * room);
  first = cut ? static_cast<int32_t>(std::max<double>(lowest, low - room)) : lowest;
  last = cut ? static_cast<int32_t>(std::min<double>(highest, high + room)) : highest;
}
}  // namespace

std::optional<CellExtent> occupiedFrame(const CellMap& map,
                                        const std::function<bool(const CellIndex&)>& shown)
{
  std::array<Histogram, 3> histograms;
  size_t total = 0;
  map.visitCells(
      [&](const CellIndex& cell, const CellEstimate& estimate)
      {
        if (estimate.state != CellState::Occupied || !shown(cell)) return;
        ++total;
        ++histograms[0][cell.x];
        ++histograms[1][cell.y];
        ++histograms[2][cell.z];
      });
  if (total == 0) return std::nullopt;
  CellExtent frame;
  frameAxis(histograms[0], total, frame.first.x, frame.last.x);
  frameAxis(histograms[1], total, frame.first.y, frame.last.y);
  frameAxis(histograms[2], total, frame.first.z, frame.last.z);
  return frame;
}

std::optional<CellExtent> cellsOfBox(const RenderOptions& options, double resolution_m)
{
  if (!options.box_map) return std::nullopt;
  // A box often ends on faces of cells, which rounding may put on either side.
  constexpr double kOnFace_cells = 1e-6;
  const auto cell = [&](double number) { return static_cast<int32_t>(std::clamp(number, -1e9, 1e9)); };
  const auto first = [&](double m) { return cell(std::floor(m / resolution_m + kOnFace_cells)); };
  const auto last = [&](double m) { return cell(std::ceil(m / resolution_m - kOnFace_cells) - 1); };
  const auto& [low, high] = *options.box_map;
  CellExtent extent{{first(low.x), first(low.y), first(low.z)}, {last(high.x), last(high.y), last(high.z)}};
  extent.include(extent.first);  // a box thinner than a cell
  return extent;
}

void failNothingToDraw(const CellMap& map, const std::string& missing)
{
  throw std::runtime_error((cellExtent(map) ? "the map has no " + missing : "the map is empty") +
                           "; there is nothing to draw");
}

}  // namespace lamap::tools
