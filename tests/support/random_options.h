#pragma once

#include <lamap_core/bgk/options.h>
#include <support/seeded_scans.h>

#include <string>

namespace lamap::test
{
const std::vector<FreeSpace> kAllFreeSpaces{FreeSpace::Samples, FreeSpace::Line, FreeSpace::None};
const std::vector<TrainingPoints> kAllTrainingPoints{TrainingPoints::Cells, TrainingPoints::Centroids};
const std::vector<KernelShape> kAllKernels{KernelShape::Sparse, KernelShape::SparseMatern32,
                                           KernelShape::WendlandC2};

/// Random legal options; lengths suit a world of about ten cells.
inline BgkInference randomInference(Random& random, double resolution_m)
{
  BgkInference inference;
  inference.freeSpace = random.pick(kAllFreeSpaces);
  inference.trainingPoints = random.pick(kAllTrainingPoints);
  inference.kernel = random.pick(kAllKernels);
  if (random.chance(0.6)) inference.freeResolution = random.uniform(0.5, 2.5) * resolution_m;
  if (random.chance(0.6)) inference.freeMargin = random.pick<double>({0.0, 0.4, 2.3}) * resolution_m;
  if (random.chance(0.6)) inference.hitDownsampling = random.pick<double>({0.0, 0.7, 2.5}) * resolution_m;
  if (random.chance(0.4)) inference.freeDownsampling = random.uniform(0.5, 2.5) * resolution_m;
  if (random.chance(0.6)) inference.freeWeight = random.uniform(0.1, 2.0);
  if (random.chance(0.6)) inference.kernelSupport = random.uniform(0.4, 3.5) * resolution_m;
  if (random.chance(0.4)) inference.kernelScale = random.uniform(0.2, 10.0);
  inference.protectHits = static_cast<uint32_t>(random.integer(0, 3));
  if (random.chance(0.3)) inference.rayDecimation = static_cast<uint32_t>(random.integer(2, 3));
  if (random.chance(0.3)) inference.minRange = random.uniform(0, 2) * resolution_m;
  if (random.chance(0.5)) inference.maxRange = random.uniform(3, 9) * resolution_m;
  inference.considerInvalidRangesAsFreeSpace = random.chance(0.7);
  inference.beamWidth = BeamWidth::None;  // the oracle knows no widths
  return inference;
}

inline std::string nameOf(const BgkInference& inference)
{
  static const char* const kFreeSpaceNames[] = {"samples", "line", "none"};
  static const char* const kTrainingNames[] = {"cells", "centroids"};
  static const char* const kKernelNames[] = {"sparse", "sparseMatern32", "wendlandC2"};
  return std::string(kFreeSpaceNames[static_cast<int>(inference.freeSpace)]) + ", " +
         kTrainingNames[static_cast<int>(inference.trainingPoints)] + ", " +
         kKernelNames[static_cast<int>(inference.kernel)];
}

}  // namespace lamap::test
