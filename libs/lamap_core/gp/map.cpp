#include <lamap_core/gp/map.h>

#include <lamap_core/gp/scan_inference.h>
#include <lamap_core/grid/octant_rule.h>
#include <lamap_core/grid/signed_evidence.h>
#include <lamap_core/math/portable_math.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace lamap
{
namespace
{
BlockShape shapeOf(const GpStructure& structure)
{
  structure.validate();
  return BlockShape(structure.blockDepth - 1, structure.planar);
}

double sumOf(uint64_t code)
{
  return static_cast<double>(decodedSum(code).value_or(0)) * kEvidenceUnit;
}
}  // namespace

GpMap::GpMap(const GpStructure& structure)
    : structure_(structure),
      planarLayer_(static_cast<int32_t>(std::floor(structure.planarHeight / structure.resolution))),
      grid_(shapeOf(structure))
{
  structure_.minVariance = structure.resolvedMinVariance();
}

GpMap::GpMap(const GpMap& other)
    : structure_(other.structure_), planarLayer_(other.planarLayer_), grid_(other.grid_)
{
}

GpMap& GpMap::operator=(const GpMap& other)
{
  if (this != &other) *this = GpMap(other);
  return *this;
}

GpMap::GpMap(GpMap&&) noexcept = default;
GpMap& GpMap::operator=(GpMap&&) noexcept = default;
GpMap::~GpMap() = default;

OctantRule GpMap::ruleFor(const StateThresholds& thresholds) const
{
  if (structure_.pruning == Pruning::None) return {};
  if (structure_.pruning == Pruning::Lossless) return {Pruning::Lossless, mergeEqual};
  const auto merger =
      [this, thresholds](const DenseBlock& dense, uint32_t first, uint32_t count, Evidence& merged)
  {
    const auto setMean = [&](Evidence& mean)
    {
      mean = meanSigned(dense, first, count);
      return true;
    };
    return mergeSameState(dense, first, count, merged, setMean,
                          [&](uint32_t /*offset*/, const Evidence& evidence)
                          { return estimate(evidence, thresholds).state; });
  };
  return {Pruning::State, merger};
}

RayCounts GpMap::insert(const Scan& scan, const GpInference& inference, unsigned threads)
{
  inference.validate(structure_.resolution);
  if (!inference_) inference_ = std::make_unique<GpScanInference>();
  const GpInference resolved = inference.resolved(structure_.resolution);
  const OctantRule rule = ruleFor(resolved.thresholds);
  return inference_->addScan(
      scan, resolved, structure_, planarLayer_, threads, [&](const BlockIndex&) { return rule; }, grid_);
}

void GpMap::merge(const GpMap& other, const StateThresholds& thresholds)
{
  GpStructure theirs = other.structure_;
  theirs.pruning = structure_.pruning;
  if (!(theirs == structure_))
    throw std::invalid_argument("the other map was made with other creation options than this one");
  const BlockShape& shape = grid_.shape();
  const OctantRule rule = ruleFor(thresholds);
  DenseBlock added(shape);
  SignedAdder adder(shape);
  for (const BlockIndex& index : other.grid_.sortedBlocks())
  {
    other.grid_.find(index)->unpack(shape, added);
    adder.clear();
    for (uint32_t offset = 0; offset < shape.cellCount(); ++offset)
      if (added.isObserved(offset)) adder.set(offset, added.at(offset));
    adder.addTo(grid_.findOrCreate(index), rule);
  }
}

CellEstimate GpMap::estimate(const Evidence& evidence, const StateThresholds& thresholds) const
{
  CellEstimate cell;
  if (structure_.fusion == GpFusion::Bayes)
  {
    const double logodds = sumOf(evidence.free);
    cell.prob = logistic(logodds);
    cell.evidence = {logodds, 0.0};
    cell.state = stateOf(cell.prob, thresholds);
    return cell;
  }
  const double precision = 1.0 / structure_.signalVariance + std::max(sumOf(evidence.occupied), 0.0);
  const double weighted = sumOf(evidence.free);
  cell.variance = 1.0 / precision;                       // Eq. (2.29)
  cell.evidence = {precision, weighted / precision};     // Eq. (2.28)
  cell.prob = logistic(structure_.squash() * weighted);  // Eq. (2.25): ω is σ²_min·mean/variance
  if (!(thresholds.variance > 0) || *cell.variance < thresholds.variance)
    cell.state = stateOf(cell.prob, thresholds);
  return cell;
}

std::optional<CellEstimate> GpMap::cell(const CellIndex& index, const StateThresholds& thresholds) const
{
  if (structure_.planar && index.z != planarLayer_) return std::nullopt;
  const Evidence evidence = grid_.evidence(index);
  if (!evidence.any()) return std::nullopt;
  return estimate(evidence, thresholds);
}

std::optional<CellEstimate> GpMap::at(const Eigen::Vector3d& point_m, const StateThresholds& thresholds) const
{
  auto index = cellAt(point_m, structure_.resolution);
  if (!index) return std::nullopt;
  if (structure_.planar) index->z = planarLayer_;
  return cell(*index, thresholds);
}

void GpMap::visitCells(const StateThresholds& thresholds, const CellVisitor& visitor) const
{
  const BlockShape& shape = grid_.shape();
  for (const BlockIndex& index : grid_.sortedBlocks())
  {
    const CellIndex first = grid_.firstCellOf(index);
    grid_.find(index)->visitLeaves(
        shape,
        [&](uint32_t begin, uint32_t count, const Evidence& evidence)
        {
          const CellEstimate leaf = estimate(evidence, thresholds);
          for (uint32_t offset = begin; offset < begin + count; ++offset)
          {
            const CellIndex local = shape.localOf(offset);
            visitor({first.x + local.x, first.y + local.y, first.z + local.z}, leaf);
          }
        });
  }
}

void GpMap::addObservation(const CellIndex& index, bool occupied, const StateThresholds& thresholds)
{
  CellIndex cell = index;
  if (structure_.planar) cell.z = planarLayer_;
  // Variance σ_f²·σ_n²/(σ_f² + σ_n²) and mean ±σ_f²/(σ_f² + σ_n²).
  const double precision = 1.0 / structure_.noiseVariance;
  const double weighted = occupied ? precision : -precision;
  const auto units = [](double sum) { return static_cast<int64_t>(std::floor(sum / kEvidenceUnit + 0.5)); };
  SignedAdder adder(grid_.shape());
  const Evidence evidence = structure_.fusion == GpFusion::Bcm
                                ? Evidence{encodedSum(units(precision)), encodedSum(units(weighted))}
                                : Evidence{0, encodedSum(units(structure_.squash() * weighted))};
  adder.set(grid_.shape().offsetOf(cell), evidence);
  adder.addTo(grid_.findOrCreate(grid_.blockOf(cell)), ruleFor(thresholds));
}

}  // namespace lamap
