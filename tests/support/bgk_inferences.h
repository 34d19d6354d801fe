#pragma once

#include <lamap_core/bgk/options.h>

#include <vector>

namespace lamap::test
{
/// Each kind of training points with each kind of free space along rays.
inline std::vector<BgkInference> inferencesWith(BeamWidth beamWidth)
{
  std::vector<BgkInference> all;
  for (const TrainingPoints points : {TrainingPoints::Cells, TrainingPoints::Centroids})
    for (const FreeSpace free : {FreeSpace::Samples, FreeSpace::Line})
    {
      BgkInference& inference = all.emplace_back();
      inference.trainingPoints = points;
      inference.freeSpace = free;
      inference.beamWidth = beamWidth;
    }
  return all;
}

}  // namespace lamap::test
