#pragma once

#include <lamap_core/features/compact_sum.h>
#include <lamap_core/hilbert/model.h>

#include <memory>
#include <vector>

namespace lamap
{
/** Compact features: a weight for each site of the lattice.
 *
 * `Incremental`: sites hold a Gaussian posterior (μ, Λ), the next scan's prior: a scan minimizes
 * Σ w·loss + ½ΣΛⱼ(uⱼ − μⱼ)² from μ and then adds Σ w·p(1 − p)·F² to Λ, Laplace's approximation. Otherwise the
 * prior's precision stays what the structure says, and sites hold a mean alone. */
class CompactMapModel final : public MapModel
{
 public:
  explicit CompactMapModel(const HilbertStructure& structure)
      : MapModel(structure), sum_(kernel_, structure.latticeSpacing, structure.planar)
  {
  }
  [[nodiscard]] std::unique_ptr<MapModel> clone() const override
  {
    return std::make_unique<CompactMapModel>(*this);
  }

  void learnWeights(HilbertTrainingSet& set, const HilbertFrame& frame, const HilbertInference& inference,
                    const Workers& workers) override;

  void requireRoomFor(const HilbertTrainingSet& set, const HilbertFrame& frame) override;

  [[nodiscard]] ReachedLogodds saidAt(const PointAtSite& point) const override;
  [[nodiscard]] ReachedLogodds saidAt(const PointAtSite& point,
                                      const Eigen::Matrix3d& covariance) const override;
  void saidAtRegular(const CellIndex& anchorSite, const RegularPoints& points,
                     std::vector<ReachedLogodds>& out) const override;

  [[nodiscard]] size_t weightCount() const override { return lattice_.siteCount(); }
  void restore(const HilbertState& state) override;

 private:
  [[nodiscard]] bool keepsPrecision() const { return structure_.training == HilbertTraining::Incremental; }
  void addReachedSites(const HilbertFrame& frame);
  void readPrior(const HilbertFrame& frame);
  void keepPosterior(const HilbertFrame& frame);

  CompactSum sum_;
};

}  // namespace lamap
