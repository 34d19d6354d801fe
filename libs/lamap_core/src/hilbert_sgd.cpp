#include <lamap_core/hilbert_trainers.h>

#include <lamap_core/legal_range.h>
#include <lamap_core/portable_math.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

namespace lamap
{
namespace
{
using Four = Eigen::Array4f;

/** Cumulative L1 penalties: each weight has paid so much of what all owe. A weight may pay whenever it is
 * looked at, as long as it pays in the end. */
class CumulativePenalty
{
 public:
  explicit CumulativePenalty(size_t weights) : paid_(weights, 0.0f) {}
  void grow(double by) { owed_ += by; }

  /// Four weights from number j pay what they still owe, as far as zero.
  Four paidFor(size_t j, const Four& weights)
  {
    Eigen::Map<Four> paid(paid_.data() + j);
    const auto owed = static_cast<float>(owed_);
    const Four zero = Four::Zero();
    // Of the two that follow one is 0: which one, the sign of the weight decides.
    const Four ofPositive = (paid + owed).max(zero);
    const Four ofNegative = (owed - paid).max(zero);
    const Four positive = (weights - ofPositive).max(zero);
    const Four negative = (weights + ofNegative).min(zero);
    const Four after = positive + negative;
    paid += after - weights;
    return after;
  }

 private:
  double owed_ = 0;
  std::vector<float> paid_;
};

class SgdTrainer
{
 public:
  SgdTrainer(const FeatureRows& rows, const SgdOptions& options, std::vector<float>& u)
      : rows_(rows), options_(options), u_(u), penalty_(options.penalty == SgdPenalty::L1 ? u.size() : 0)
  {
    const double first = std::sqrt(1.0 / std::sqrt(options.alpha));
    startTime_ = 1.0 / (first * options.alpha);
  }

  void learn(size_t point, float label, float weight, uint64_t time)
  {
    const double rate = 1.0 / (options_.alpha * (startTime_ + static_cast<double>(time)));
    const double f = scale_ * static_cast<double>(rows_.dot(point, u_.data()));
    const double downhill = rate * static_cast<double>(weight) * (label - logistic(f));
    if (options_.penalty == SgdPenalty::L2) shrink(1.0 - rate * options_.alpha);
    const auto factor = static_cast<float>(downhill / scale_);
    if (options_.penalty == SgdPenalty::L2) return rows_.addTo(point, factor, u_.data());
    penalty_.grow(rate * options_.alpha);
    const float bias = rows_.bias() ? u_[*rows_.bias()] + factor : 0.0f;
    rows_.forEachRun(point,
                     [&](const FeatureRows::Run& run)
                     {
                       for (int k = 0; k < rows_.width(); k += 4)
                       {
                         Eigen::Map<Four> weights(u_.data() + run.first + k);
                         const Four change = factor * Eigen::Map<const Four>(run.values + k);
                         weights = penalty_.paidFor(run.first + static_cast<uint32_t>(k), weights + change);
                       }
                     });
    if (rows_.bias()) u_[*rows_.bias()] = bias;
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
      Eigen::Map<Four> weights(u_.data() + first);
      weights = penalty_.paidFor(first, weights);
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
  CumulativePenalty penalty_;
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
  requireLegal(options.alpha >= 1e-12 && options.alpha <= 1e6, "alpha", options.alpha,
               "a number from 1e-12 to 1e6");
  requireLegal(options.epochs >= 1, "epochs", options.epochs, "a whole number >= 1");
  SgdTrainer trainer(rows, options, u);
  std::vector<uint32_t> order(rows.points());
  std::iota(order.begin(), order.end(), 0u);
  std::mt19937_64 generator(options.seed + stepsBefore);
  uint64_t time = stepsBefore;
  for (int epoch = 0; epoch < options.epochs; ++epoch)
  {
    shuffle(order, generator);
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
