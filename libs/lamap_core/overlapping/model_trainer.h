#pragma once

#include <lamap_core/features/nystroem.h>
#include <lamap_core/features/rows.h>
#include <lamap_core/learning/solver.h>
#include <lamap_core/math/workers.h>
#include <lamap_core/overlapping/model.h>
#include <lamap_core/scan/ray_selection.h>
#include <lamap_core/training/hilbert_training.h>

#include <memory>
#include <optional>
#include <vector>

namespace lamap
{
/// The usable rays of a scan in a model's frame [m].
struct ModelScan
{
  struct Fan
  {
    SelectedFan rays;       ///< its `_map` members are in the model's frame here
    double rangeMax_m = 0;  ///< up to which it sees, infinite where there is no limit
    friend bool operator==(const Fan& a, const Fan& b);
  };
  std::vector<Fan> fans;
  /// How sure the places of its points are, in the model's frame; empty: certain.
  std::optional<HilbertUncertainty> uncertainty;

  friend bool operator==(const ModelScan& a, const ModelScan& b);
};

/// What is known in the map, in the axes of a model. @param uncertainty its centre [m] in the map
[[nodiscard]] HilbertUncertainty toModelFrame(const HilbertUncertainty& uncertainty, const ModelPose& pose,
                                              const ModelShape& shape);

/** Selects and cuts the rays of a scan and moves them into a model's frame.
 * @param counts of the rays, those that the frame cannot hold among the ones left out */
[[nodiscard]] ModelScan toModelFrame(const Scan& scan, const OverlappingInference& inference,
                                     const ModelPose& pose, const ModelShape& shape, RayCounts& counts);

/// Trains models; keeps its working memory between them.
class HilbertModelTrainer
{
 public:
  /** @return nothing if there is no training point
   *  @throws std::length_error as HilbertSampler::sample() */
  std::optional<HilbertModel> train(const std::vector<ModelScan>& scans,
                                    const OverlappingStructure& structure,
                                    const OverlappingInference& inference, const Workers& workers);

 private:
  void trainCompact(const HilbertTrainingSet& set, const ModelShape& shape,
                    const OverlappingStructure& structure, const OverlappingInference& inference,
                    const Workers& workers, HilbertModel& model);
  void trainNystroem(const HilbertTrainingSet& set, const OverlappingStructure& structure,
                     const OverlappingInference& inference, const Workers& workers, HilbertModel& model);
  void findWeights(FeatureRows& rows, const HilbertTrainingSet& set, const OverlappingStructure& structure,
                   const OverlappingInference& inference, const Workers& workers);

  /// Of all scans, one after the other.
  const HilbertTrainingSet& sample(const std::vector<ModelScan>& scans, const ModelShape& shape,
                                   const OverlappingInference& inference);

  HilbertSampler sampler_;
  HilbertTrainingSet set_;
  CompactRows compact_;
  FeatureRows nystroemRows_;
  Solver solver_;
  std::vector<float> weights_, mean_, precision_;
};

}  // namespace lamap
