#include <lamap_core/scan/beam_spacing.h>
#include <lamap_core/scan/direction_bins.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace lamap
{
namespace
{
using Bin = DirectionBinOf<2>;

constexpr uint8_t kMostSteps = 60;  ///< bins; beams farther from each other are no neighbours
constexpr uint8_t kNoStep = 255;
constexpr auto kBin_rad = static_cast<float>(3.141592653589793 / 360);
constexpr size_t kColumns = Bin::kColumns;
constexpr size_t kWords = (kColumns + 63) / 64;
constexpr int kLastWordBits = static_cast<int>(kColumns - 64 * (kWords - 1));

/// A bit for each bin of a row.
using Row = std::array<uint64_t, kWords>;

enum class Towards
{
  Left,
  Right,
  Above,
  Below
};

/// @return the row with each bit moved by one column, round the circle.
Row turned(const Row& row, bool left)
{
  Row moved;
  for (size_t i = 0; i < kWords; ++i)
  {
    if (left)
      moved[i] = row[i] << 1 | (i == 0 ? row[kWords - 1] >> (kLastWordBits - 1) & 1 : row[i - 1] >> 63);
    else
      moved[i] = row[i] >> 1 | (i + 1 < kWords ? row[i + 1] << 63 : (row[0] & 1) << (kLastWordBits - 1));
  }
  moved[kWords - 1] &= (uint64_t{1} << kLastWordBits) - 1;
  return moved;
}

void unite(Row& row, const Row& other)
{
  for (size_t i = 0; i < kWords; ++i) row[i] |= other[i];
}

/** One angle for the distances of the beams along two directions.
 *
 * Beams on lines, such as the rings of a lidar, are as far from each other as the lines. Both rules were
 * chosen by log loss, on simulated and real scans with few beams. */
float together(float one, float other)
{
  constexpr float kOfLines = 6;
  constexpr float kBetweenLines = 1.25F;
  const float larger = std::max(one, other);
  if (std::min(one, other) * kOfLines <= larger) return kBetweenLines * larger;
  return std::sqrt((one * one + other * other) / 2);
}

/// The bins that the rays of a fan fall into, and how far these bins are from each other.
class SeenBins
{
 public:
  explicit SeenBins(const std::vector<Bin>& bins);

  /// 0 for a ray without direction.
  [[nodiscard]] float spacing_rad(const Bin& bin) const
  {
    return bin.isSomewhere() ? spacing_rad_[placeOf(bin)] : 0.0F;
  }

 private:
  [[nodiscard]] size_t placeOf(const Bin& bin) const
  {
    return static_cast<size_t>(bin.row - firstRow_) * kColumns + static_cast<size_t>(bin.column);
  }
  [[nodiscard]] std::vector<uint8_t> stepsTowards(Towards side, Towards opposite) const;
  [[nodiscard]] Row nextTo(int row, Towards side, const std::vector<Row>& quarters) const;
  void measure();

  int firstRow_ = 0;
  std::vector<Row> seen_;         ///< bins with rays
  std::vector<uint16_t> counts_;  ///< rays in each bin
  std::vector<float> spacing_rad_;
};

SeenBins::SeenBins(const std::vector<Bin>& bins)
{
  const auto [low, high] =
      std::minmax_element(bins.begin(), bins.end(), [](const Bin& a, const Bin& b) { return a.row < b.row; });
  firstRow_ = low->row;
  seen_.assign(static_cast<size_t>(high->row - low->row + 1), Row{});
  counts_.assign(seen_.size() * kColumns, 0);
  for (const Bin& bin : bins)
  {
    if (!bin.isSomewhere()) continue;
    const auto column = static_cast<size_t>(bin.column);
    seen_[static_cast<size_t>(bin.row - firstRow_)][column / 64] |= uint64_t{1} << (column % 64);
    uint16_t& count = counts_[placeOf(bin)];
    if (count < UINT16_MAX) ++count;
  }
  measure();
}

/// The bins of a row beside which, on one side, there are rays or others' quarters with rays.
Row SeenBins::nextTo(int row, Towards side, const std::vector<Row>& quarters) const
{
  const bool upright = side == Towards::Above || side == Towards::Below;
  const int middle = side == Towards::Above ? row + 1 : side == Towards::Below ? row - 1 : row;
  const int beside = upright ? 0 : 1;
  Row all{};
  for (int other = middle - beside; other <= middle + beside; ++other)
  {
    if (other < 0 || other >= static_cast<int>(seen_.size())) continue;
    unite(all, seen_[static_cast<size_t>(other)]);
    unite(all, quarters[static_cast<size_t>(other)]);
  }
  if (!upright) return turned(all, side == Towards::Right);
  Row wide = turned(all, true);
  unite(wide, turned(all, false));
  unite(wide, all);
  return wide;
}

/** How many bins it is from each bin with rays to the nearest other one, in the two quarters of all
 * directions that open towards one side and the opposite one; kNoStep if there is none.
 *
 * Step by step, for all bins of a row at once: what a quarter holds up to n steps away is what is next to the
 * bin, and what the quarters there hold up to n - 1 steps away. */
std::vector<uint8_t> SeenBins::stepsTowards(Towards side, Towards opposite) const
{
  std::vector<uint8_t> steps(counts_.size(), kNoStep);
  std::vector<Row> pending = seen_;
  std::vector<Row> quarters(seen_.size(), Row{});
  std::vector<Row> opposites(seen_.size(), Row{});
  std::vector<Row> wider(seen_.size());
  std::vector<Row> widerOpposites(seen_.size());
  bool anyPending = true;
  for (uint8_t step = 1; step <= kMostSteps && anyPending; ++step)
  {
    anyPending = false;
    for (size_t row = 0; row < seen_.size(); ++row)
    {
      wider[row] = nextTo(static_cast<int>(row), side, quarters);
      widerOpposites[row] = nextTo(static_cast<int>(row), opposite, opposites);
      Row both = wider[row];
      unite(both, widerOpposites[row]);
      for (size_t i = 0; i < kWords; ++i)
      {
        for (uint64_t found = pending[row][i] & both[i]; found != 0; found &= found - 1)
          steps[row * kColumns + i * 64 + static_cast<size_t>(__builtin_ctzll(found))] = step;
        pending[row][i] &= ~both[i];
        anyPending = anyPending || pending[row][i] != 0;
      }
    }
    quarters.swap(wider);
    opposites.swap(widerOpposites);
  }
  return steps;
}

void SeenBins::measure()
{
  const std::vector<uint8_t> beside = stepsTowards(Towards::Left, Towards::Right);
  const std::vector<uint8_t> upright = stepsTowards(Towards::Above, Towards::Below);
  spacing_rad_.assign(counts_.size(), 0);
  for (size_t row = 0; row < seen_.size(); ++row)
  {
    const float elevation = static_cast<float>(firstRow_ + static_cast<int>(row) - Bin::kRows / 2) * kBin_rad;
    const float xx = elevation * elevation;
    const float cosine = std::max(0.0F, 1 - xx * (1.0F / 2 - xx * (1.0F / 24 - xx * (1.0F / 720))));
    for (size_t place = row * kColumns; place < (row + 1) * kColumns; ++place)
    {
      if (counts_[place] == 0) continue;
      const auto count = static_cast<float>(counts_[place]);
      const auto distance = [&](uint8_t steps) { return steps == 1 ? 1 / count : static_cast<float>(steps); };
      const float along = beside[place] == kNoStep ? 0.0F : distance(beside[place]) * cosine;
      const float across = upright[place] == kNoStep ? 0.0F : distance(upright[place]);
      spacing_rad_[place] = together(along, across) * kBin_rad;
    }
  }
}

}  // namespace

std::vector<float> beamSpacing(const RayFan& fan)
{
  std::vector<float> spacing(fan.rays.size(), 0.0F);
  if (fan.rays.size() < 2) return spacing;
  std::vector<Bin> bins;
  Bin::ofAll(fan, bins);
  const SeenBins all(bins);
  std::transform(bins.begin(), bins.end(), spacing.begin(),
                 [&](const Bin& bin) { return all.spacing_rad(bin); });
  return spacing;
}

}  // namespace lamap
