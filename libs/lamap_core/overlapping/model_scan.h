#pragma once

#include <lamap_core/overlapping/model.h>
#include <lamap_core/scan/ray_selection.h>
#include <lamap_core/training/hilbert_sampling.h>

#include <optional>
#include <vector>

namespace lamap
{
/// The usable rays of a scan in a model's frame.
struct ModelScan
{
  /// Its pose is the identity, because its frame is the model's. Of each fan the returns come first.
  SelectedRays rays;
  /// How sure the places of its points are, in the model's frame; empty: certain.
  std::optional<HilbertUncertainty> uncertainty;

  /// @throws std::runtime_error if scanInModel() could not have made it, e.g. one from a file.
  void check(const ModelShape& shape) const;

  friend bool operator==(const ModelScan& a, const ModelScan& b);
};

/** The frame of a model that is trained on a scan: the sensor's, with its origin where the rays of the first
 * fan come from that cells can address. In a planar map it turns about the vertical only.
 * @return nothing if no fan has usable rays. @throws std::invalid_argument if the scan's pose is not rigid
 */
[[nodiscard]] std::optional<ModelPose> modelFrameOf(const Scan& selected, const ModelShape& shape);

/** Puts the usable rays of a scan into a model's frame; if that is the scan's own, they stay as they are.
 * @param uncertainty axes and centre in the map; null: certain
 * @return among its counts are those that the frame cannot hold, or that a planar map sees as points */
[[nodiscard]] ModelScan scanInModel(const SelectedRays& selected, const HilbertUncertainty* uncertainty,
                                    const ModelPose& frame, const ModelShape& shape);

}  // namespace lamap
