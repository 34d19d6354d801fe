#pragma once

#include <lamap_core/scan/scan.h>
#include <lamap_core/training/hilbert_training.h>

#include <optional>

namespace lamap
{
/// Warns once per process if the pose of a scan should have a covariance but has none.
void warnWithoutCovariance(const Scan& scan);

/** The uncertainty of a scan's points. Warns once per process if the pose should have a covariance but has
 * none.
 * @return nothing if the points are certain */
[[nodiscard]] std::optional<HilbertUncertainty> uncertaintyOf(const UncertainInputs& inputs,
                                                              const Scan& scan);

}  // namespace lamap
