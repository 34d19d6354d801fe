#pragma once

#include <lamap_core/scan/scan.h>
#include <lamap_core/training/hilbert_training.h>

#include <optional>

namespace lamap
{
/// The uncertainty of a scan's points. @return nothing if the points are certain
[[nodiscard]] std::optional<HilbertUncertainty> uncertaintyOf(const UncertainInputs& inputs,
                                                              const Scan& scan);

}  // namespace lamap
