#pragma once

#include <lamap_core/hilbert/map.h>
#include <lamap_core/hilbert/state.h>
#include <support/seeded_scans.h>

#include <cstring>
#include <string>

namespace lamap::test
{
/// Empty where two states have the same bytes; blocks of the second may be moved by whole blocks of sites.
inline std::string differenceOf(const HilbertState& a, const HilbertState& b)
{
  const auto same = [](const auto& left, const auto& right)
  {
    return left.size() == right.size() &&
           (left.empty() || std::memcmp(left.data(), right.data(), left.size() * sizeof(left[0])) == 0);
  };
  if (a.blocks.size() != b.blocks.size()) return "numbers of blocks";
  for (size_t i = 0; i < a.blocks.size(); ++i)
  {
    if (!(a.blocks[i].index == b.blocks[i].index)) return "block " + std::to_string(i);
    if (a.blocks[i].bits != b.blocks[i].bits) return "sites of block " + std::to_string(i);
    if (!same(a.blocks[i].weights, b.blocks[i].weights)) return "weights of block " + std::to_string(i);
  }
  if (a.seen.size() != b.seen.size()) return "numbers of blocks of seen cells";
  for (size_t i = 0; i < a.seen.size(); ++i)
    if (!(a.seen[i].index == b.seen[i].index) || a.seen[i].bits != b.seen[i].bits ||
        a.seen[i].hits != b.seen[i].hits || a.seen[i].passes != b.seen[i].passes)
      return "seen cells of block " + std::to_string(i);
  if (a.widths.size() != b.widths.size()) return "numbers of blocks of widths";
  for (size_t i = 0; i < a.widths.size(); ++i)
    if (!(a.widths[i].index == b.widths[i].index) || a.widths[i].bits != b.widths[i].bits ||
        a.widths[i].weights != b.widths[i].weights || a.widths[i].variances != b.widths[i].variances)
      return "widths of block " + std::to_string(i);
  if (a.sgdSteps != b.sgdSteps) return "steps of SGD";
  if (!same(a.inducing, b.inducing)) return "inducing points";
  if (!same(a.classifier, b.classifier)) return "classifiers";
  if (!same(a.cells, b.cells)) return "cells kept";
  if (!same(a.points, b.points)) return "points kept";
  return "";
}

/// Structures of every kind of training and features.
inline std::vector<HilbertStructure> allHilbertStructures()
{
  std::vector<HilbertStructure> structures(5);
  structures[1].training = HilbertTraining::Batch;
  structures[2].training = HilbertTraining::Batch;
  structures[2].features = HilbertFeatures::Nystroem;
  structures[2].components = 30;
  structures[3].training = HilbertTraining::Sgd;
  structures[4].training = HilbertTraining::Sgd;
  structures[4].features = HilbertFeatures::Nystroem;
  structures[4].components = 30;
  return structures;
}

inline std::string nameOf(const HilbertStructure& structure)
{
  static const char* const kTraining[] = {"incremental", "batch", "sgd"};
  return std::string(kTraining[static_cast<int>(structure.training)]) +
         (structure.features == HilbertFeatures::Compact ? ", compact" : ", nystroem") +
         (structure.planar ? ", planar" : "");
}

/// A sensor in the middle of a room that sees its walls, with some noise.
inline Scan roomScan(Random& random, const Eigen::Vector3d& origin, int rays, double halfEdge_m = 1.2)
{
  Scan scan;
  scan.fans.emplace_back();
  scan.fans[0].centre = origin;
  for (int i = 0; i < rays; ++i)
  {
    const Eigen::Vector3d direction = random.inCube(1.0);
    double t = 1e9;
    for (int axis = 0; axis < 3; ++axis)
      if (direction[axis] != 0)
        t = std::min(t, ((direction[axis] > 0 ? halfEdge_m : -halfEdge_m) - origin[axis]) / direction[axis]);
    if (random.chance(0.1))
      scan.fans[0].add(RayEnd::NoReturn, direction);
    else
      scan.fans[0].addReturn(origin + direction * (t + random.uniform(-0.01, 0.01)));
  }
  return scan;
}

}  // namespace lamap::test
