#pragma once

#include <lamap_core/gp/options.h>
#include <support/seeded_scans.h>

#include <string>

namespace lamap::test
{
inline GpStructure randomGpStructure(Random& random)
{
  GpStructure structure;
  structure.blockDepth = random.integer(2, 4);
  structure.planar = random.chance(0.2);
  structure.planarHeight = 0.03;
  structure.pruning = random.pick<Pruning>({Pruning::None, Pruning::Lossless});
  structure.signalVariance = random.pick<double>({1.0, 0.5, 2.0});
  structure.noiseVariance = random.pick<double>({0.01, 0.1, 0.5});
  if (random.chance(0.5)) structure.minVariance = random.uniform(0.001, 0.1);
  structure.squashGain = random.pick<double>({1.0, 10.0, 30.0});
  return structure;
}

/// Legal options of every kind; lengths fit a world of some ten cells.
inline GpInference randomGpInference(Random& random, double resolution_m)
{
  GpInference inference;
  inference.nested = random.chance(0.5);
  inference.freeSpace = random.chance(0.85) ? GpFreeSpace::Samples : GpFreeSpace::None;
  inference.trainingPoints = random.chance(0.5) ? TrainingPoints::Cells : TrainingPoints::Centroids;
  if (random.chance(0.6)) inference.freeResolution = random.uniform(0.7, 3.5) * resolution_m;
  if (random.chance(0.6)) inference.freeMargin = random.pick<double>({0.0, 0.4, 2.3}) * resolution_m;
  if (random.chance(0.6)) inference.hitDownsampling = random.pick<double>({0.0, 0.7, 2.5}) * resolution_m;
  if (random.chance(0.4)) inference.freeDownsampling = random.uniform(0.5, 2.5) * resolution_m;
  inference.protectHits = static_cast<uint32_t>(random.integer(0, 3));
  if (random.chance(0.6)) inference.kernelSupport = random.uniform(0.4, 3.5) * resolution_m;
  inference.lengthScale = random.uniform(0.5, 12) * resolution_m;
  if (random.chance(0.3)) inference.rayDecimation = static_cast<uint32_t>(random.integer(2, 3));
  if (random.chance(0.3)) inference.minRange = random.uniform(0, 2) * resolution_m;
  if (random.chance(0.5)) inference.maxRange = random.uniform(3, 9) * resolution_m;
  inference.considerInvalidRangesAsFreeSpace = random.chance(0.7);
  return inference;
}

inline std::string nameOf(const GpStructure& structure, const GpInference& inference)
{
  return std::string(inference.nested ? "nested" : "exact") + ", " +
         (inference.trainingPoints == TrainingPoints::Cells ? "cells" : "centroids") +
         (structure.planar ? ", planar" : "") + ", depth " + std::to_string(structure.blockDepth);
}

}  // namespace lamap::test
