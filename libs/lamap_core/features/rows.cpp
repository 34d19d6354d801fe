#include <lamap_core/features/rows.h>

#include <algorithm>
#include <cmath>

namespace lamap
{
namespace
{
using Four = Eigen::Array4f;

inline Four load(const float* from)
{
  return Eigen::Map<const Four>(from);
}
inline void store(const Four& four, float* to)
{
  Eigen::Map<Four>{to} = four;
}
/// In an order that no instruction set decides.
inline float sum(const Four& four)
{
  return (four[0] + four[1]) + (four[2] + four[3]);
}

inline void addProduct(const float* values, const float* weights, int width, Four& total)
{
  int k = 0;
  if (width >= 16)
  {
    // Four sums side by side, so that the processor need not wait for each.
    std::array<Four, 4> sums{Four::Zero(), Four::Zero(), Four::Zero(), Four::Zero()};
    for (; k + 16 <= width; k += 16)
      for (int part = 0; part < 4; ++part)
      {
        const Four product = load(values + k + 4 * part) * load(weights + k + 4 * part);
        sums[static_cast<size_t>(part)] += product;
      }
    total += (sums[0] + sums[1]) + (sums[2] + sums[3]);
  }
  for (; k < width; k += 4)
  {
    const Four product = load(values + k) * load(weights + k);
    total += product;
  }
}

inline void addScaled(const float* values, float factor, int width, float* weights)
{
  for (int k = 0; k < width; k += 4)
  {
    const Four product = factor * load(values + k);
    store(load(weights + k) + product, weights + k);
  }
}

CellIndex siteAt(const Eigen::Vector3d& point, double spacing_m, bool planar)
{
  return {AxisReaches::siteOf(point.x(), spacing_m), AxisReaches::siteOf(point.y(), spacing_m),
          planar ? 0 : AxisReaches::siteOf(point.z(), spacing_m)};
}

}  // namespace

void FeatureRows::reset(int width, size_t points, size_t weights, std::vector<uint32_t> used)
{
  // Few enough chunks that their partial sums cost little, enough to share out.
  constexpr size_t kSmallestChunk = 2048;
  constexpr size_t kMostChunks = 16;
  width_ = width;
  points_ = points;
  weights_ = weights;
  used_ = std::move(used);
  bias_.reset();
  chunkSize_ = std::max(kSmallestChunk, (points + kMostChunks - 1) / kMostChunks);
  chunks_.resize((points + chunkSize_ - 1) / chunkSize_);
  for (Chunk& chunk : chunks_)
  {
    chunk.runEnds.clear();
    chunk.firsts.clear();
    chunk.values.clear();
  }
}

float* FeatureRows::addRun(size_t number, uint32_t first)
{
  Chunk& chunk = chunks_[number];
  chunk.firsts.push_back(first);
  const size_t begin = chunk.values.size();
  chunk.values.resize(begin + static_cast<size_t>(width_));
  return chunk.values.data() + begin;
}

void FeatureRows::endPoint(size_t number)
{
  Chunk& chunk = chunks_[number];
  chunk.runEnds.push_back(static_cast<uint32_t>(chunk.firsts.size()));
}

void FeatureRows::addPoint(size_t number, const std::vector<uint32_t>& firsts, const float* values)
{
  Chunk& chunk = chunks_[number];
  chunk.firsts.insert(chunk.firsts.end(), firsts.begin(), firsts.end());
  chunk.values.insert(chunk.values.end(), values, values + firsts.size() * static_cast<size_t>(width_));
  endPoint(number);
}

const float* FeatureRows::valuesOf(size_t point) const
{
  const size_t i = point % chunkSize_;
  const Chunk& chunk = chunks_[point / chunkSize_];
  return chunk.values.data() + (i == 0 ? 0 : chunk.runEnds[i - 1]) * static_cast<size_t>(width_);
}

bool FeatureRows::dense() const
{
  const auto isDense = [&](const Chunk& chunk)
  {
    return chunk.firsts.size() == chunk.runEnds.size() &&
           (chunk.runEnds.empty() || chunk.runEnds.front() == 1) &&
           std::adjacent_find(chunk.runEnds.begin(), chunk.runEnds.end()) == chunk.runEnds.end();
  };
  return static_cast<size_t>(width_) == weights_ && std::all_of(chunks_.begin(), chunks_.end(), isDense);
}

void FeatureRows::multiply(const float* u, float* f, const Workers& workers) const
{
  workers.forEach(chunks_.size(),
                  [&](size_t number)
                  {
                    const Chunk& chunk = chunks_[number];
                    const float* values = chunk.values.data();
                    float* out = f + firstPointOf(number);
                    size_t run = 0;
                    for (const uint32_t end : chunk.runEnds)
                    {
                      // Two sums, so that the processor need not wait for each.
                      Four total = Four::Zero();
                      Four other = Four::Zero();
                      if (width_ == 4)
                      {
                        for (; run + 2 <= end; run += 2, values += 8)
                        {
                          addProduct(values, u + chunk.firsts[run], 4, total);
                          addProduct(values + 4, u + chunk.firsts[run + 1], 4, other);
                        }
                      }
                      for (; run < end; ++run, values += width_)
                        addProduct(values, u + chunk.firsts[run], width_, total);
                      total += other;
                      *out++ = sum(total);
                    }
                  });
}

template <bool kSquared>
void FeatureRows::transposed(const float* r, float* g, const Workers& workers)
{
  workers.forEach(chunks_.size(),
                  [&](size_t number)
                  {
                    Chunk& chunk = chunks_[number];
                    chunk.sums.assign(weights_, 0.0f);
                    float* sums = chunk.sums.data();
                    const float* values = chunk.values.data();
                    const float* factor = r + firstPointOf(number);
                    size_t run = 0;
                    for (const uint32_t end : chunk.runEnds)
                    {
                      for (; run < end; ++run, values += width_)
                      {
                        float* weights = sums + chunk.firsts[run];
                        if constexpr (kSquared)
                        {
                          for (int k = 0; k < width_; k += 4)
                          {
                            const Four squares = load(values + k) * load(values + k);
                            const Four product = *factor * squares;
                            store(load(weights + k) + product, weights + k);
                          }
                        }
                        else if (width_ == 4)
                          addScaled(values, *factor, 4, weights);
                        else
                          addScaled(values, *factor, width_, weights);
                      }
                      ++factor;
                    }
                  });
  std::fill(g, g + weights_, 0.0f);
  for (const Chunk& chunk : chunks_)
    for (const uint32_t j : used_) g[j] += chunk.sums[j];
}

void FeatureRows::multiplyTransposed(const float* r, float* g, const Workers& workers)
{
  transposed<false>(r, g, workers);
}

void FeatureRows::addSquares(const float* c, float* d, const Workers& workers)
{
  transposed<true>(c, d, workers);
}

float FeatureRows::dot(size_t point, const float* u) const
{
  Four total = Four::Zero();
  forEachRun(point, [&](const Run& run) { addProduct(run.values, u + run.first, width_, total); });
  return sum(total);
}

void FeatureRows::addTo(size_t point, float factor, float* u) const
{
  forEachRun(point, [&](const Run& run) { addScaled(run.values, factor, width_, u + run.first); });
}

void FeatureRows::prefetch(size_t point) const
{
  const Chunk& chunk = chunks_[point / chunkSize_];
  const size_t i = point % chunkSize_;
  const auto width = static_cast<size_t>(width_);
  const float* begin = chunk.values.data() + (i == 0 ? 0 : chunk.runEnds[i - 1]) * width;
  const float* end = chunk.values.data() + chunk.runEnds[i] * width;
  constexpr int kFloatsALine = 16;
  for (; begin < end; begin += kFloatsALine) __builtin_prefetch(begin);
}

void CompactRows::findSites(const HilbertTrainingSet& set, const CompactKernel& kernel, double spacing_m,
                            bool planar, const CellIndex& shift)
{
  kernel_ = kernel;
  spacing_m_ = spacing_m;
  planar_ = planar;
  shift_ = shift;
  reaches_m_.clear();
  double farthest_m = kernel.support_m();
  for (const Eigen::Matrix3d& covariance : set.covariances)
  {
    reaches_m_.push_back(kernel.reach_m(GaussianBlur(covariance, kernel.gamma())));
    farthest_m = std::max(farthest_m, reaches_m_.back().maxCoeff());
  }
  reach_sites_ = static_cast<int>(std::floor(farthest_m / spacing_m + 0.5)) + 1;

  Eigen::Vector3d low = Eigen::Vector3d::Zero();
  Eigen::Vector3d high = Eigen::Vector3d::Zero();
  for (size_t i = 0; i < set.size(); ++i)
  {
    low = i == 0 ? set.points[i] : low.cwiseMin(set.points[i]);
    high = i == 0 ? set.points[i] : high.cwiseMax(set.points[i]);
  }
  const auto corner = [&](const Eigen::Vector3d& point, int margin)
  {
    const CellIndex site = siteAt(point, spacing_m, planar);
    return CellIndex{site.x + shift.x + margin, site.y + shift.y + margin, site.z + shift.z + margin};
  };
  sites_.reset(corner(low, -reach_sites_), corner(high, reach_sites_));
  for (size_t i = 0; i < set.size(); ++i)
  {
    if (!reaches_m_.empty() && !(reaches_m_[i].maxCoeff() > 0)) continue;
    sites_.insert(corner(set.points[i], 0));
  }
}

int CompactRows::runWidth(const HilbertTrainingSet& set) const
{
  // Cells lie regularly: often every point reaches four sites of a row where five could be reached.
  int32_t most = 1;
  AxisReaches reaches(kernel_, spacing_m_);
  for (size_t i = 0; i < set.size(); ++i)
  {
    if (reaches_m_.empty())
      most = std::max(most, reaches.of(set.points[i].x()).count());
    else
      most = std::max(most, static_cast<int32_t>(2 * reaches_m_[i].x() / spacing_m_) + 2);
  }
  return static_cast<int>((most + 3) / 4 * 4);
}

namespace
{
/** The numbers of the runs that windows along y and z have, for windows that begin at the same sites:
 * neighbours share them. */
class SharedRuns
{
 public:
  explicit SharedRuns(const SiteNumbers& numbers) : numbers_(numbers), entries_(kEntries) {}

  /// @param first site of the windows. @return by z, then y, with kEdge a row; −1 where there is no site.
  const int32_t* of(const CellIndex& first, int32_t countY, int32_t countZ)
  {
    const size_t hash = BlockIndexHash{}(BlockIndex{first.x, first.y, first.z});
    Entry& entry = entries_[hash % kEntries];
    if (!(entry.first == first) || entry.countY < countY || entry.countZ < countZ)
    {
      entry.first = first;
      entry.countY = countY;
      entry.countZ = countZ;
      entry.runs.resize(kEdge * static_cast<size_t>(countZ));
      for (int32_t k = 0; k < countZ; ++k)
        for (int32_t j = 0; j < countY; ++j)
          entry.runs[static_cast<size_t>(k) * kEdge + static_cast<size_t>(j)] =
              static_cast<int32_t>(numbers_.numberOfRun({first.x, first.y + j, first.z + k}));
    }
    return entry.runs.data();
  }
  static constexpr size_t kEdge = AxisReach::kMaxSites;

 private:
  struct Entry
  {
    CellIndex first;
    int32_t countY = 0;
    int32_t countZ = 0;
    std::vector<int32_t> runs;
  };
  static constexpr size_t kEntries = 256;
  const SiteNumbers& numbers_;
  std::vector<Entry> entries_;
};

}  // namespace

struct CompactRows::Builder
{
  Builder(const CompactKernel& kernel, double spacing_m, const SiteNumbers& numbers)
      : reaches{AxisReaches{kernel, spacing_m}, AxisReaches{kernel, spacing_m},
                AxisReaches{kernel, spacing_m}},
        shared(numbers),
        values(static_cast<size_t>(numbers.width()) * SharedRuns::kEdge * SharedRuns::kEdge)
  {
  }
  std::array<AxisReaches, 3> reaches;
  SharedRuns shared;
  std::vector<uint32_t> firsts;
  std::vector<float> values;
};

void CompactRows::build(const HilbertTrainingSet& set, const Workers& workers)
{
  numbers_.reset(sites_, runWidth(set));
  rows_.reset(numbers_.width(), set.size(), numbers_.count(), numbers_.used());
  workers.forEach(rows_.chunkCount(),
                  [&](size_t chunk)
                  {
                    Builder builder(kernel_, spacing_m_, numbers_);
                    for (size_t i = rows_.firstPointOf(chunk); i < rows_.endPointOf(chunk); ++i)
                    {
                      if (set.covariances.empty())
                      {
                        addCertain(set.points[i], chunk, builder);
                        continue;
                      }
                      addUncertain(set.points[i], GaussianBlur(set.covariances[i], kernel_.gamma()), chunk);
                      rows_.endPoint(chunk);
                    }
                  });
}

void CompactRows::addCertain(const Eigen::Vector3d& point, size_t chunk, Builder& builder)
{
  const AxisWindow x = builder.reaches[0].of(point.x());
  const AxisWindow y = builder.reaches[1].of(point.y());
  const AxisWindow z = planar_ ? AxisReaches::flat() : builder.reaches[2].of(point.z());
  const int32_t* runs =
      builder.shared.of({x.first + shift_.x, y.first + shift_.y, z.first + shift_.z}, y.count(), z.count());
  const auto width = static_cast<size_t>(rows_.width());
  const Four cutoff = Four::Constant(kernel_.cutoffF());
  const float* factors = x.reach->factors.data();
  builder.firsts.clear();
  float* values = builder.values.data();
  for (int32_t k = 0; k < z.count(); ++k)
    for (int32_t j = 0; j < y.count(); ++j)
    {
      const float yz = y.factor(j) * z.factor(k);
      const int32_t first = runs[static_cast<size_t>(k) * SharedRuns::kEdge + static_cast<size_t>(j)];
      if (first < 0 || !(kernel_.fromFactors(yz, x.reach->largest) > 0)) continue;
      builder.firsts.push_back(static_cast<uint32_t>(first));
      const float* isUsed = numbers_.isUsed() + first;
      for (size_t i = 0; i < width; i += 4, values += 4)
      {
        const Four product = yz * load(factors + i);
        const Four kernel = (product - cutoff).max(Four::Zero());
        store(kernel * load(isUsed + i), values);
      }
    }
  rows_.addPoint(chunk, builder.firsts, builder.values.data());
}

void CompactRows::addUncertain(const Eigen::Vector3d& point, const GaussianBlur& blur, size_t chunk)
{
  const Eigen::Vector3d reach = kernel_.reach_m(blur);
  if (!(reach.maxCoeff() > 0)) return;
  const auto firstAlong = [&](int axis)
  { return static_cast<int32_t>(std::ceil((point[axis] - reach[axis]) / spacing_m_ - 0.5)); };
  const auto lastAlong = [&](int axis)
  { return static_cast<int32_t>(std::floor((point[axis] + reach[axis]) / spacing_m_ - 0.5)); };
  const int32_t firstX = firstAlong(0);
  const int32_t countX = lastAlong(0) - firstX + 1;
  for (int32_t z = planar_ ? 0 : firstAlong(2); z <= (planar_ ? 0 : lastAlong(2)); ++z)
    for (int32_t y = firstAlong(1); y <= lastAlong(1); ++y)
    {
      const int64_t first = numbers_.numberOfRun({firstX + shift_.x, y + shift_.y, z + shift_.z});
      if (first < 0) continue;
      float* values = rows_.addRun(chunk, static_cast<uint32_t>(first));
      const float* isUsed = numbers_.isUsed() + first;
      for (int32_t i = 0; i < rows_.width(); ++i)
      {
        const Eigen::Vector3d centre((firstX + i + 0.5) * spacing_m_, (y + 0.5) * spacing_m_,
                                     (z + 0.5) * spacing_m_);
        values[i] = i < countX ? isUsed[i] * kernel_.at(point - centre, blur) : 0.0f;
      }
    }
}

}  // namespace lamap
