#pragma once

#include <lamap_core/features/rows.h>
#include <lamap_core/learning/solver_options.h>

#include <cstdint>
#include <vector>

namespace lamap
{
/// What SGD keeps small beside the loss.
enum class SgdPenalty
{
  L1,  ///< α·Σ|u|, thesis eq. 2.34, as cumulative penalties (Tsuruoka, Tsujii and Ananiadou 2009)
  L2   ///< α·½Σu²
};

struct SgdOptions : public DescentOptions
{
  SgdPenalty penalty = SgdPenalty::L1;
  uint64_t seed = 1;  ///< of the order of points in each pass
};

/** Minimizes (1/n)·Σᵢ wᵢ·Lᵢ + α·penalty (thesis eq. 2.34) from u, point by point in random order. The step is
 * 1/(α(t₀ + t)) in step t, Bottou's choice and scikit-learn's. The bias, where there is one, is not
 * penalized.
 * @param stepsBefore t at the start, for a classifier that learns on; @return t at the end
 * @throws std::invalid_argument naming an illegal option. */
uint64_t trainSgd(const FeatureRows& rows, const std::vector<float>& labels,
                  const std::vector<float>& weights, const SgdOptions& options, uint64_t stepsBefore,
                  std::vector<float>& u);

}  // namespace lamap
