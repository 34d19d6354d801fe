#pragma once

#include <lamap_core/scan/scan.h>
#include <lamap_core/training/hilbert_training.h>

#include <optional>

namespace lamap
{
/** How sure the places of a scan's points are, for a learner. Warns once in a process if the pose is to have
 * a covariance and has none.
 * @return nothing if they are certain */
[[nodiscard]] std::optional<HilbertUncertainty> uncertaintyOf(const UncertainInputs& inputs,
                                                              const Scan& scan);

}  // namespace lamap
