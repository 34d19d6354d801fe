#pragma once

#include <lamap_core/features/nystroem.h>
#include <lamap_core/features/rows.h>
#include <lamap_core/learning/solver.h>
#include <lamap_core/math/workers.h>
#include <lamap_core/overlapping/model.h>
#include <lamap_core/overlapping/model_scan.h>
#include <lamap_core/training/hilbert_training.h>
#include <lamap_core/training/sampler.h>

#include <memory>
#include <optional>
#include <vector>

namespace lamap
{
/// Trains models; keeps its working memory between them.
class HilbertModelTrainer
{
 public:
  /** @return nothing if there is no training point
   *  @throws std::length_error as Sampler::sample() */
  std::optional<HilbertModel> train(const std::vector<ModelScan>& scans,
                                    const OverlappingStructure& structure,
                                    const OverlappingInference& inference, const Workers& workers);

 private:
  void trainCompact(const HilbertTrainingSet& set, const ModelShape& shape,
                    const OverlappingStructure& structure, const OverlappingInference& inference,
                    const Workers& workers, HilbertModel& model);
  void trainNystroem(const HilbertTrainingSet& set, const ModelShape& shape,
                     const OverlappingStructure& structure, const OverlappingInference& inference,
                     const Workers& workers, HilbertModel& model);
  void findWeights(FeatureRows& rows, const HilbertTrainingSet& set, const OverlappingStructure& structure,
                   const OverlappingInference& inference, const Workers& workers);

  /// Of all scans, one after the other.
  const HilbertTrainingSet& sample(const std::vector<ModelScan>& scans, const ModelShape& shape,
                                   const OverlappingInference& inference);

  Sampler sampler_;
  HilbertTrainingSet set_;
  CompactRows compact_;
  FeatureRows nystroemRows_;
  Solver solver_;
  std::vector<float> weights_, mean_, precision_;
};

}  // namespace lamap
