#include <lamap_core/learning/sgd.h>

#include <lamap_core/options/option_table.h>

#include <lamap_core/math/portable_math.h>
#include <lamap_core/math/wide_floats.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

namespace lamap
{
namespace
{
/** Cumulative L1 penalties: each weight has paid so much of what all owe. A weight may pay whenever it is
 * looked at, as long as it pays in the end.
 *
 * Some neighbouring weights pay what they still owe, as far as zero. @param paid by them so far */
template <int kLanes>
LAMAP_INLINED void payPenalty(float owed, float* paid, typename Wide<kLanes>::Floats& weights)
{
  using Floats = typename Wide<kLanes>::Floats;
  constexpr Floats kZero{};
  Floats before;
  Wide<kLanes>::load(paid, before);
  // A positive weight goes down by the one, a negative one up by the other, none beyond zero.
  Floats down = before + owed;
  Floats up = before - owed;
  down = down > kZero ? down : kZero;
  up = up < kZero ? up : kZero;
  Floats change = weights < down ? weights : down;
  change = change > up ? change : up;
  const Floats after = weights - change;
  before += after - weights;
  Wide<kLanes>::store(before, paid);
  weights = after;
}

/// Some neighbouring weights go down the slope and pay their penalty.
template <int kLanes>
LAMAP_INLINED void stepDown(const float* features, float factor, float owed, float* paid, float* weights)
{
  typename Wide<kLanes>::Floats held;
  typename Wide<kLanes>::Floats slope;
  Wide<kLanes>::load(weights, held);
  Wide<kLanes>::load(features, slope);
  held += factor * slope;
  payPenalty<kLanes>(owed, paid, held);
  Wide<kLanes>::store(held, weights);
}

/// FeatureRows::dot(): sixteen sums, added in the same order for any number of lanes.
/// @param count a multiple of four
template <int kLanes>
LAMAP_INLINED float dot(const float* features, const float* weights, size_t count)
{
  using Four = Wide<4>::Floats;
  typename Wide<kLanes>::Floats sums[16 / kLanes] = {};
  size_t k = 0;
  for (; k + 16 <= count; k += 16)
    for (size_t part = 0; part < 16 / kLanes; ++part)
    {
      typename Wide<kLanes>::Floats a;
      typename Wide<kLanes>::Floats b;
      Wide<kLanes>::load(features + k + part * kLanes, a);
      Wide<kLanes>::load(weights + k + part * kLanes, b);
      sums[part] += a * b;
    }
  Four quarters[4];
  std::memcpy(quarters, sums, sizeof(quarters));
  Four total = (quarters[0] + quarters[1]) + (quarters[2] + quarters[3]);
  for (; k < count; k += 4)
  {
    Four a;
    Four b;
    Wide<4>::load(features + k, a);
    Wide<4>::load(weights + k, b);
    total += a * b;
  }
  return (total[0] + total[1]) + (total[2] + total[3]);
}

/// A pass over dense rows, with L1.
struct DensePass
{
  const std::vector<uint32_t>& order;  ///< of the points
  const std::vector<const float*>& rows;
  const std::vector<float>& labels;
  const std::vector<float>& importance;  ///< of each point
  double alpha;
  double startTime;
  uint64_t time;  ///< steps before
  size_t count;   ///< of weights
  size_t bias;    ///< its number; count: there is none
};

/// @param owed so far. @return owed after it
template <int kLanes>
LAMAP_INLINED double learnPass(const DensePass& pass, double owed, float* paid, float* weights)
{
  constexpr size_t kFloatsALine = 16;
  constexpr size_t kAhead = 3;  ///< rows come from all over memory: they are asked for in time
  const size_t points = pass.order.size();
  const size_t count = pass.count;
  const size_t bias = pass.bias;
  for (size_t i = 0; i < points; ++i)
  {
    if (i + kAhead < points)
    {
      const float* later = pass.rows[pass.order[i + kAhead]];
      for (size_t k = 0; k < count; k += kFloatsALine) __builtin_prefetch(later + k);
    }
    const uint32_t point = pass.order[i];
    const float* features = pass.rows[point];
    const double rate = 1.0 / (pass.alpha * (pass.startTime + static_cast<double>(pass.time + i + 1)));
    const float error = pass.labels[point] - logistic(dot<kLanes>(features, weights, count));
    const auto factor = static_cast<float>(rate * static_cast<double>(pass.importance[point])) * error;
    owed += rate * pass.alpha;
    const auto owedNow = static_cast<float>(owed);
    const float newBias = bias < count ? weights[bias] + factor : 0.0f;
    size_t k = 0;
    for (; k + kLanes <= count; k += kLanes)
      stepDown<kLanes>(features + k, factor, owedNow, paid + k, weights + k);
    for (; k < count; k += 4) stepDown<4>(features + k, factor, owedNow, paid + k, weights + k);
    if (bias < count) weights[bias] = newBias;
  }
  return owed;
}

class SgdTrainer
{
 public:
  SgdTrainer(const FeatureRows& rows, const SgdOptions& options, std::vector<float>& u)
      : rows_(rows), options_(options), u_(u), paid_(options.penalty == SgdPenalty::L1 ? u.size() : 0, 0.0f)
  {
    const double first = std::sqrt(1.0 / std::sqrt(options.alpha));
    startTime_ = 1.0 / (first * options.alpha);
  }

  void learn(size_t point, float label, float weight, uint64_t time)
  {
    const double rate = 1.0 / (options_.alpha * (startTime_ + static_cast<double>(time)));
    const auto f = static_cast<float>(scale_ * static_cast<double>(rows_.dot(point, u_.data())));
    const float error = label - logistic(f);
    if (options_.penalty == SgdPenalty::L2) shrink(1.0 - rate * options_.alpha);
    const auto factor = static_cast<float>(rate * static_cast<double>(weight) / scale_) * error;
    if (options_.penalty == SgdPenalty::L2) return rows_.addTo(point, factor, u_.data());
    owed_ += rate * options_.alpha;
    const float bias = rows_.bias() ? u_[*rows_.bias()] + factor : 0.0f;
    rows_.forEachRun(point,
                     [&](const FeatureRows::Run& run)
                     {
                       const auto width = static_cast<size_t>(rows_.width());
                       for (size_t k = 0; k < width; k += 4)
                         stepDown<4>(run.values + k, factor, static_cast<float>(owed_),
                                     paid_.data() + run.first + k, u_.data() + run.first + k);
                     });
    if (rows_.bias()) u_[*rows_.bias()] = bias;
  }

  [[nodiscard]] bool takesWholePasses() const { return options_.penalty == SgdPenalty::L1 && rows_.dense(); }

  /// learn() of all points in their order. @param rows of each point
  void learnPass(const std::vector<uint32_t>& order, const std::vector<const float*>& rows,
                 const std::vector<float>& labels, const std::vector<float>& weights, uint64_t time)
  {
    const DensePass pass{order,   rows,           labels,
                         weights, options_.alpha, startTime_,
                         time,    u_.size(),      rows_.bias().value_or(static_cast<uint32_t>(u_.size()))};
    owed_ = withRegisters(
        [&](auto r) LAMAP_INLINED_LAMBDA
        { return lamap::learnPass<decltype(r)::kFloats>(pass, owed_, paid_.data(), u_.data()); });
  }

  /// What is left to be done for all weights.
  void finish()
  {
    applyScale();
    if (options_.penalty != SgdPenalty::L1) return;
    const float bias = rows_.bias() ? u_[*rows_.bias()] : 0.0f;
    // The last four may overlap those before: who has paid pays nothing more.
    for (size_t j = 0; u_.size() >= 4 && j < u_.size(); j += 4)
    {
      const size_t first = std::min(j, u_.size() - 4);
      Wide<4>::Floats weights;
      Wide<4>::load(u_.data() + first, weights);
      payPenalty<4>(static_cast<float>(owed_), paid_.data() + first, weights);
      Wide<4>::store(weights, u_.data() + first);
    }
    if (rows_.bias()) u_[*rows_.bias()] = bias;
  }

 private:
  /// @param by in (0, 1): the rate times α is below 1 / t
  void shrink(double by)
  {
    constexpr double kSmallestScale = 1e-6;
    if (rows_.bias()) u_[*rows_.bias()] /= static_cast<float>(by);
    scale_ *= by;
    if (scale_ < kSmallestScale) applyScale();
  }
  void applyScale()
  {
    for (float& weight : u_) weight *= static_cast<float>(scale_);
    scale_ = 1.0;
  }

  const FeatureRows& rows_;
  const SgdOptions& options_;
  std::vector<float>& u_;  ///< times scale_
  double scale_ = 1.0;
  double owed_ = 0;          ///< of the penalty, by each weight
  std::vector<float> paid_;  ///< of it
  double startTime_;
};

/// The same on every platform, as std::shuffle need not be.
void shuffle(std::vector<uint32_t>& order, std::mt19937_64& generator)
{
  for (size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[generator() % i]);
}

}  // namespace

uint64_t trainSgd(const FeatureRows& rows, const std::vector<float>& labels,
                  const std::vector<float>& weights, const SgdOptions& options, uint64_t stepsBefore,
                  std::vector<float>& u)
{
  requireLegalOptions<DescentOptions>(options, std::nullopt);
  SgdTrainer trainer(rows, options, u);
  std::vector<uint32_t> order(rows.points());
  std::iota(order.begin(), order.end(), 0u);
  std::mt19937_64 generator(options.seed + stepsBefore);
  uint64_t time = stepsBefore;
  std::vector<const float*> values(trainer.takesWholePasses() ? rows.points() : 0);
  for (size_t i = 0; i < values.size(); ++i) values[i] = rows.valuesOf(i);
  for (int epoch = 0; epoch < options.epochs; ++epoch)
  {
    shuffle(order, generator);
    if (trainer.takesWholePasses())
    {
      trainer.learnPass(order, values, labels, weights, time);
      time += order.size();
      continue;
    }
    for (size_t k = 0; k < order.size(); ++k)
    {
      // Rows come from all over memory: the next but one is asked for in time.
      if (k + 2 < order.size()) rows.prefetch(order[k + 2]);
      trainer.learn(order[k], labels[order[k]], weights[order[k]], ++time);
    }
  }
  trainer.finish();
  return time;
}

}  // namespace lamap
