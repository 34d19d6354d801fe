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
/// Cumulative L1 penalties: each weight has paid so much of what all owe.
class CumulativePenalty
{
 public:
  explicit CumulativePenalty(size_t weights) : paid_(weights, 0.0) {}
  void grow(double by) { owed_ += by; }
  void payFor(size_t j, float& weight)
  {
    const double before = weight;
    double after = before;
    if (before > 0)
      after = std::max(0.0, before - (owed_ + paid_[j]));
    else if (before < 0)
      after = std::min(0.0, before + (owed_ - paid_[j]));
    weight = static_cast<float>(after);
    paid_[j] += static_cast<double>(weight) - before;
  }

 private:
  double owed_ = 0;
  std::vector<double> paid_;
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
    rows_.addTo(point, static_cast<float>(downhill / scale_), u_.data());
    if (options_.penalty == SgdPenalty::L1)
    {
      penalty_.grow(rate * options_.alpha);
      rows_.forEachRun(point,
                       [&](const FeatureRows::Run& run)
                       {
                         for (uint32_t k = 0; k < static_cast<uint32_t>(rows_.width()); ++k)
                           if (run.values[k] != 0.0f) payFor(run.first + k);
                       });
    }
  }

  /// What is left to be done for all weights.
  void finish()
  {
    if (options_.penalty == SgdPenalty::L1)
      for (const uint32_t j : rows_.used()) payFor(j);
    applyScale();
  }

 private:
  void payFor(uint32_t j)
  {
    if (rows_.bias() != j) penalty_.payFor(j, u_[j]);
  }
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
    for (const uint32_t i : order) trainer.learn(i, labels[i], weights[i], ++time);
  }
  trainer.finish();
  return time;
}

}  // namespace lamap
