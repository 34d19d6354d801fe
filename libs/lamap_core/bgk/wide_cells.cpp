#include <lamap_core/bgk/wide_cells.h>

#include <algorithm>

namespace lamap
{
namespace
{
constexpr int kEdge = kScanBlockEdge;
constexpr size_t kRow = kEdge;
constexpr size_t kLayer = kRow * kRow;

/// Weights of cells by their distance along an axis, zero beyond the reach: at distance d at [d + middle].
struct AxisWeights
{
  AxisWeights(const std::vector<float>& weights, double factor)
      : reach(static_cast<int>(weights.size()) / 2), middle(reach + 2 * kEdge), padded(2 * middle + 1, 0.0F)
  {
    for (size_t i = 0; i < weights.size(); ++i)
      padded[i + 2 * kRow] = static_cast<float>(factor * weights[i]);
  }
  [[nodiscard]] int blocksEachWay() const { return (reach + kEdge - 1) / kEdge; }
  [[nodiscard]] const float* from(int distance) const
  {
    return &padded[static_cast<size_t>(distance + middle)];
  }

  int reach;
  int middle;
  std::vector<float> padded;
};

BlockIndex moved(const BlockIndex& block, const BlockIndex& axis, int steps)
{
  return {block.x + axis.x * steps, block.y + axis.y * steps, block.z + axis.z * steps};
}

constexpr BlockIndex kAlongX{1, 0, 0};
constexpr BlockIndex kAlongY{0, 1, 0};
constexpr BlockIndex kAlongZ{0, 0, 1};

int blocksEachWay(const ExpectedKernel& kernel)
{
  return (kernel.reach() + kEdge - 1) / kEdge;
}

/// Adds the blocks from which others can be reached along an axis. @return whether there is room for them
bool addReached(const std::vector<BlockIndex>& others, const BlockIndex& axis, int blocksEachWay,
                ScanBlocks& blocks)
{
  for (const BlockIndex& other : others)
  {
    for (int step = -blocksEachWay; step <= blocksEachWay; ++step)
      (void)blocks.findOrAdd(moved(other, axis, step));
    if (blocks.blocks().size() > WideCells::kMaxBlocks) return false;
  }
  return true;
}

std::vector<BlockIndex> markedBlocks(const ScanBlocks& blocks, const std::vector<WideMasks>& level,
                                     CellMask WideMasks::*mask)
{
  const auto isEmpty = [](const CellMask& cells)
  { return std::all_of(cells.begin(), cells.end(), [](uint64_t word) { return word == 0; }); };
  std::vector<BlockIndex> marked;
  for (size_t number = 0; number < level.size(); ++number)
    if (!isEmpty(level[number].*mask)) marked.push_back(blocks.blocks()[number]);
  return marked;
}

void addScaled(const float* from, float weight, size_t count, float* to)
{
  for (size_t i = 0; i < count; ++i)
  {
    const float product = weight * from[i];
    to[i] += product;
  }
}

}  // namespace

bool WideCells::findBlocks(const TrainingSet& training, const std::vector<WideMasks>& level,
                           CellMask WideMasks::*mask, const ExpectedKernel& kernel, bool planar)
{
  const int n = blocksEachWay(kernel);
  alongX_.blocks.reset(low_, high_);
  alongXy_.blocks.reset(low_, high_);
  return addReached(markedBlocks(training.blocks, level, mask), kAlongX, n, alongX_.blocks) &&
         addReached(alongX_.blocks.blocks(), kAlongY, n, alongXy_.blocks) &&
         addReached(alongXy_.blocks.blocks(), kAlongZ, planar ? 0 : n, total_.blocks);
}

bool WideCells::compute(const TrainingSet& training, const std::vector<ExpectedKernel>& kernels,
                        CellMask WideMasks::*mask, bool WideMasks::*any, bool planar, const Workers& workers)
{
  std::vector<size_t> levels;
  int farthest = 0;
  for (size_t level = 0; level < kWideLevels; ++level)
  {
    const std::vector<WideMasks>& masks = training.wideMasks[level];
    if (std::none_of(masks.begin(), masks.end(), [&](const WideMasks& block) { return block.*any; }))
      continue;
    levels.push_back(level);
    farthest = std::max(farthest, blocksEachWay(kernels[level]));
  }
  const BlockIndex& low = training.blocks.low();
  const BlockIndex& high = training.blocks.high();
  low_ = {low.x - farthest, low.y - farthest, low.z - farthest};
  high_ = {high.x + farthest, high.y + farthest, high.z + farthest};
  total_.blocks.reset(low_, high_);
  const auto findBlocksOf = [&](size_t level)
  { return findBlocks(training, training.wideMasks[level], mask, kernels[level], planar); };
  if (!std::all_of(levels.begin(), levels.end(), findBlocksOf)) return false;

  total_.sums.assign(total_.blocks.blocks().size(), Sums{});
  for (const size_t level : levels)
  {
    (void)findBlocksOf(level);
    for (const ExpectedKernel::Term& term : kernels[level].terms())
    {
      sumAlongX(training, training.wideMasks[level], mask, term, workers);
      sumAlongY(term, workers);
      if (planar)
        addLayers(term.factor);
      else
        addAlongZ(term, workers);
    }
  }
  return true;
}

void WideCells::sumAlongX(const TrainingSet& training, const std::vector<WideMasks>& level,
                          CellMask WideMasks::*mask, const ExpectedKernel::Term& term, const Workers& workers)
{
  const AxisWeights weights(term.weights, 1.0);
  const int n = weights.blocksEachWay();
  alongX_.sums.assign(alongX_.blocks.blocks().size(), Sums{});
  workers.forEach(alongX_.sums.size(),
                  [&](size_t i)
                  {
                    Sums& sums = alongX_.sums[i];
                    for (int step = -n; step <= n; ++step)
                    {
                      const int32_t number =
                          training.blocks.find(moved(alongX_.blocks.blocks()[i], kAlongX, step));
                      if (number < 0 || static_cast<size_t>(number) >= level.size()) continue;
                      const CellMask& cells = level[static_cast<size_t>(number)].*mask;
                      for (size_t z = 0; z < cells.size(); ++z)
                        for (uint64_t rest = cells[z]; rest != 0; rest &= rest - 1)
                        {
                          const int bit = __builtin_ctzll(rest);
                          const float* const weight = weights.from(-(step * kEdge + bit % kEdge));
                          float* const row = &sums[z * kLayer + static_cast<size_t>(bit / kEdge) * kRow];
                          for (size_t x = 0; x < kRow; ++x) row[x] += weight[x];
                        }
                    }
                  });
}

void WideCells::sumAlongY(const ExpectedKernel::Term& term, const Workers& workers)
{
  const AxisWeights weights(term.weights, 1.0);
  const int n = weights.blocksEachWay();
  alongXy_.sums.assign(alongXy_.blocks.blocks().size(), Sums{});
  workers.forEach(alongXy_.sums.size(),
                  [&](size_t i)
                  {
                    Sums& sums = alongXy_.sums[i];
                    for (int step = -n; step <= n; ++step)
                    {
                      const Sums* const from =
                          alongX_.find(moved(alongXy_.blocks.blocks()[i], kAlongY, step));
                      if (from == nullptr) continue;
                      for (int fromY = 0; fromY < kEdge; ++fromY)
                        for (int y = 0; y < kEdge; ++y)
                        {
                          const float weight = *weights.from(y - fromY - step * kEdge);
                          if (weight == 0) continue;
                          for (size_t z = 0; z < kRow; ++z)
                            addScaled(&(*from)[z * kLayer + static_cast<size_t>(fromY) * kRow], weight, kRow,
                                      &sums[z * kLayer + static_cast<size_t>(y) * kRow]);
                        }
                    }
                  });
}

void WideCells::addAlongZ(const ExpectedKernel::Term& term, const Workers& workers)
{
  const AxisWeights weights(term.weights, term.factor);
  const int n = weights.blocksEachWay();
  workers.forEach(total_.sums.size(),
                  [&](size_t i)
                  {
                    Sums& sums = total_.sums[i];
                    for (int step = -n; step <= n; ++step)
                    {
                      const Sums* const from = alongXy_.find(moved(total_.blocks.blocks()[i], kAlongZ, step));
                      if (from == nullptr) continue;
                      for (int fromZ = 0; fromZ < kEdge; ++fromZ)
                        for (int z = 0; z < kEdge; ++z)
                        {
                          const float weight = *weights.from(z - fromZ - step * kEdge);
                          if (weight != 0)
                            addScaled(&(*from)[static_cast<size_t>(fromZ) * kLayer], weight, kLayer,
                                      &sums[static_cast<size_t>(z) * kLayer]);
                        }
                    }
                  });
}

/// As addAlongZ(), where cells have no weight but in their own layer.
void WideCells::addLayers(double factor)
{
  for (size_t i = 0; i < alongXy_.sums.size(); ++i)
  {
    const auto number = static_cast<size_t>(total_.blocks.find(alongXy_.blocks.blocks()[i]));
    addScaled(alongXy_.sums[i].data(), static_cast<float>(factor), kScanBlockCells,
              total_.sums[number].data());
  }
}

}  // namespace lamap
