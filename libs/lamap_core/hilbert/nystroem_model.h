#pragma once

#include <lamap_core/features/nystroem.h>
#include <lamap_core/hilbert/model.h>

#include <memory>
#include <vector>

namespace lamap
{
/** Nyström's features, with the inducing points of the first set that was learned.
 *
 * The lattice says only where there is evidence: where a site that held a training point is no more than the
 * kernel's support away along each axis. */
class NystroemMapModel final : public MapModel
{
 public:
  explicit NystroemMapModel(const HilbertStructure& structure);
  /// How many sites along an axis evidence reaches from the site of a training point.
  [[nodiscard]] static int reachInSites(const HilbertStructure& structure);
  [[nodiscard]] std::unique_ptr<MapModel> clone() const override
  {
    return std::make_unique<NystroemMapModel>(*this);
  }

  void learnWeights(HilbertTrainingSet& set, const HilbertFrame& frame, const HilbertInference& inference,
                    const Workers& workers) override;

  [[nodiscard]] bool isSurelyRoomFor(size_t points, const Extent& extent) const override;
  void requireRoomFor(const HilbertTrainingSet& set, const HilbertFrame& frame) override;

  [[nodiscard]] ReachedLogodds saidAt(const PointAtSite& point) const override;
  [[nodiscard]] ReachedLogodds saidAt(const PointAtSite& point,
                                      const Eigen::Matrix3d& covariance) const override;
  void saidAtRegular(const CellIndex& anchorSite, const RegularPoints& points,
                     std::vector<ReachedLogodds>& out) const override;

  [[nodiscard]] size_t weightCount() const override { return features_.components(); }
  [[nodiscard]] size_t memoryBytes() const override;
  void save(HilbertState& state) const override;
  void restore(const HilbertState& state) override;

 private:
  /// Whether a site that held a training point is near enough to a site.
  [[nodiscard]] bool reaches(const CellIndex& site) const;
  [[nodiscard]] bool reaches(const PointAtSite& point) const;
  [[nodiscard]] Eigen::Vector3d inMap(const PointAtSite& point) const;

  void requireFewFeatures(size_t points) const;

  int reach_sites_;
  NystroemFeatures features_;
  std::vector<float> classifier_;
  NystroemFeatures::Folded folded_;
};

}  // namespace lamap
