#include <lamap_core/bgk/map.h>

#include <lamap_core/bgk/scan_inference.h>
#include <lamap_core/options/legal_range.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <thread>

namespace lamap
{
namespace
{
BlockShape shapeOf(const BgkStructure& structure)
{
  structure.validate();
  return BlockShape(structure.blockDepth - 1, structure.planar);
}

uint64_t roundedMean(uint64_t sumHigh, uint64_t sumLow, uint32_t count)
{
  // Counts may have 63 bits: their sum is kept in two parts of 32 bits each.
  const uint64_t high = sumHigh / count;
  const uint64_t rest = ((sumHigh % count) << 32) + sumLow;
  return (high << 32) + (rest + count / 2) / count;
}

/// Mean evidence of the cells of an octant.
Evidence meanOf(const DenseBlock& block, uint32_t first, uint32_t count)
{
  uint64_t occupiedHigh = 0;
  uint64_t occupiedLow = 0;
  uint64_t freeHigh = 0;
  uint64_t freeLow = 0;
  constexpr uint64_t kLow = 0xFFFFFFFFu;
  for (uint32_t i = first; i < first + count; ++i)
  {
    const Evidence evidence = block.at(i);
    occupiedHigh += evidence.occupied >> 32;
    occupiedLow += evidence.occupied & kLow;
    freeHigh += evidence.free >> 32;
    freeLow += evidence.free & kLow;
  }
  Evidence mean{roundedMean(occupiedHigh, occupiedLow, count), roundedMean(freeHigh, freeLow, count)};
  if (!mean.any()) (occupiedLow > freeLow ? mean.occupied : mean.free) = 1;
  return mean;
}

/// More threads than the machine has would only take turns.
unsigned usefulThreads(unsigned threads)
{
  const unsigned all = std::max(1u, std::thread::hardware_concurrency());
  return threads > 0 ? std::min(threads, all) : all;
}

}  // namespace

double bgkMean(double alpha, double beta)
{
  return alpha / (alpha + beta);
}  // Eq. (4.1)

double bgkVariance(double alpha, double beta)  // Eq. (4.2)
{
  const double sum = alpha + beta;
  return (alpha / sum) * (beta / sum) / (sum + 1.0);
}

CellState bgkState(double mean, double variance, const StateThresholds& thresholds)  // Eq. (4.9)
{
  if (thresholds.variance > 0 && !(variance < thresholds.variance)) return CellState::Unknown;
  return stateOf(mean, thresholds);
}

BgkMap::BgkMap(const BgkStructure& structure)
    : structure_(structure),
      planarLayer_(static_cast<int32_t>(std::floor(structure.planarHeight / structure.resolution))),
      grid_(shapeOf(structure))
{
}

BgkMap::BgkMap(const BgkMap& other)
    : structure_(other.structure_),
      planarLayer_(other.planarLayer_),
      grid_(other.grid_),
      priorMap_(other.priorMap_)
{
}

BgkMap& BgkMap::operator=(const BgkMap& other)
{
  if (this != &other) *this = BgkMap(other);
  return *this;
}

BgkMap::BgkMap(BgkMap&&) noexcept = default;
BgkMap& BgkMap::operator=(BgkMap&&) noexcept = default;
BgkMap::~BgkMap() = default;

OctantRule BgkMap::ruleFor(const BlockIndex& block, const StateThresholds& thresholds) const
{
  switch (structure_.pruning)
  {
    case Pruning::None:
      return {};
    case Pruning::Lossless:
      return {Pruning::Lossless, mergeEqual};
    case Pruning::State:
      break;
  }
  const CellIndex first = grid_.firstCellOf(block);
  const auto merger =
      [this, first, thresholds](const DenseBlock& dense, uint32_t begin, uint32_t count, Evidence& merged)
  {
    const auto stateOf = [&](uint32_t offset, const Evidence& evidence)
    {
      const CellIndex local = grid_.shape().localOf(offset);
      return estimate(priorOf({first.x + local.x, first.y + local.y, first.z + local.z}), evidence,
                      thresholds)
          .state;
    };
    const auto setMean = [&](Evidence& mean)
    {
      mean = meanOf(dense, begin, count);
      return true;
    };
    return mergeSameState(dense, begin, count, merged, setMean, stateOf);
  };
  return {Pruning::State, merger};
}

RayCounts BgkMap::insert(const Scan& scan, const BgkInference& inference, unsigned threads)
{
  inference.validate(structure_.resolution);
  if (!inference_) inference_ = std::make_unique<BgkScanInference>();
  return inference_->addScan(
      scan, inference.resolved(structure_.resolution), structure_, planarLayer_, usefulThreads(threads),
      [&](const BlockIndex& block) { return ruleFor(block, inference.thresholds); }, grid_);
}

void BgkMap::merge(const BgkMap& other, const StateThresholds& thresholds)
{
  requireLegal(other.structure_.resolution == structure_.resolution, "resolution of the other map",
               other.structure_.resolution, "that of this map, " + std::to_string(structure_.resolution));
  requireLegal(other.structure_.blockDepth == structure_.blockDepth, "blockDepth of the other map",
               other.structure_.blockDepth, "that of this map, " + std::to_string(structure_.blockDepth));
  requireLegal(other.structure_.planar == structure_.planar && other.planarLayer_ == planarLayer_,
               "planarHeight of the other map", other.structure_.planarHeight, "in the layer of this map");
  const BlockShape& shape = grid_.shape();
  const DenseBlock empty(shape);
  DenseBlock theirs(shape);
  BlockAdder adder(shape);
  for (const BlockIndex& index : other.grid_.sortedBlocks())
  {
    other.grid_.find(index)->unpack(shape, theirs);
    adder.clear();
    for (uint32_t offset = 0; offset < shape.cellCount(); ++offset)
    {
      if (theirs.isObserved(offset)) adder.set(offset, theirs.at(offset));
    }
    adder.addTo(grid_.findOrCreate(index), ruleFor(index, thresholds));
  }
}

void BgkMap::clear()
{
  grid_.clear();
}

void BgkMap::setPriorMap(std::shared_ptr<const BgkMap> prior)
{
  if (prior)
  {
    requireLegal(prior->structure_.resolution == structure_.resolution, "resolution of the prior map",
                 prior->structure_.resolution, "that of this map, " + std::to_string(structure_.resolution));
    requireLegal(prior->structure_.planar == structure_.planar && prior->planarLayer_ == planarLayer_,
                 "planarHeight of the prior map", prior->structure_.planarHeight,
                 "in the layer of this map, both planar or neither");
  }
  priorMap_ = std::move(prior);
}

std::array<double, 2> BgkMap::priorOf(const CellIndex& index) const
{
  std::array<double, 2> prior = {structure_.priorAlpha, structure_.priorBeta};
  if (priorMap_)
  {
    if (const auto known = priorMap_->cell(index, {})) prior = known->evidence;
  }
  return prior;
}

CellEstimate BgkMap::estimate(const std::array<double, 2>& prior, const Evidence& evidence,
                              const StateThresholds& thresholds) const
{
  const double alpha = prior[0] + static_cast<double>(evidence.occupied) * kEvidenceUnit;
  const double beta = prior[1] + static_cast<double>(evidence.free) * kEvidenceUnit;
  CellEstimate cell;
  cell.prob = bgkMean(alpha, beta);
  cell.variance = bgkVariance(alpha, beta);
  cell.state = bgkState(cell.prob, *cell.variance, thresholds);
  cell.evidence = {alpha, beta};
  return cell;
}

std::optional<CellEstimate> BgkMap::cell(const CellIndex& index, const StateThresholds& thresholds) const
{
  if (structure_.planar && index.z != planarLayer_) return std::nullopt;
  const Evidence evidence = grid_.evidence(index);
  if (!priorMap_)
  {
    if (!evidence.any()) return std::nullopt;
    return estimate({structure_.priorAlpha, structure_.priorBeta}, evidence, thresholds);
  }
  const auto known = priorMap_->cell(index, thresholds);
  if (!known && !evidence.any()) return std::nullopt;
  const std::array<double, 2> own = {structure_.priorAlpha, structure_.priorBeta};
  return estimate(known ? known->evidence : own, evidence, thresholds);
}

std::optional<CellEstimate> BgkMap::at(const Eigen::Vector3d& point_m,
                                       const StateThresholds& thresholds) const
{
  auto index = cellAt(point_m, structure_.resolution);
  if (!index) return std::nullopt;
  if (structure_.planar) index->z = planarLayer_;
  return cell(*index, thresholds);
}

void BgkMap::visitCells(const StateThresholds& thresholds, const CellVisitor& visitor) const
{
  const BlockShape& shape = grid_.shape();
  for (const BlockIndex& index : grid_.sortedBlocks())
  {
    const CellIndex first = grid_.firstCellOf(index);
    grid_.find(index)->visitLeaves(
        shape,
        [&](uint32_t begin, uint32_t count, const Evidence& evidence)
        {
          for (uint32_t offset = begin; offset < begin + count; ++offset)
          {
            const CellIndex local = shape.localOf(offset);
            const CellIndex cell{first.x + local.x, first.y + local.y, first.z + local.z};
            visitor(cell, estimate(priorOf(cell), evidence, thresholds));
          }
        });
  }
  if (!priorMap_) return;
  priorMap_->visitCells(thresholds,
                        [&](const CellIndex& cell, const CellEstimate&)
                        {
                          if (!grid_.evidence(cell).any())
                            visitor(cell, estimate(priorOf(cell), {}, thresholds));
                        });
}

void BgkMap::addEvidence(const CellIndex& index, double alpha, double beta, const StateThresholds& thresholds)
{
  constexpr double kMaxCount = 1e12;
  requireLegal(alpha >= 0 && alpha <= kMaxCount, "alpha", alpha, "a number from 0 to 1e12");
  requireLegal(beta >= 0 && beta <= kMaxCount, "beta", beta, "a number from 0 to 1e12");
  CellIndex cell = index;
  if (structure_.planar) cell.z = planarLayer_;
  const auto units = [](double count) { return static_cast<uint64_t>(count / kEvidenceUnit + 0.5); };
  const Evidence evidence{units(alpha), units(beta)};
  if (!evidence.any()) return;
  BlockAdder adder(grid_.shape());
  adder.set(grid_.shape().offsetOf(cell), evidence);
  const BlockIndex block = grid_.blockOf(cell);
  adder.addTo(grid_.findOrCreate(block), ruleFor(block, thresholds));
}

}  // namespace lamap
