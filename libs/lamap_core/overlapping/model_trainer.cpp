#include <lamap_core/overlapping/model_trainer.h>

#include <lamap_core/scan/scan_frame.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace lamap
{
namespace
{
Eigen::Vector3d rounded(const Eigen::Vector3d& p)
{
  // Far from the map's origin coordinates carry the rounding of their terms; 2^-24 m does not see it.
  const auto along = [&](int axis) { return std::floor(p[axis] * 0x1p24 + 0.5) * 0x1p-24; };
  return {along(0), along(1), along(2)};
}

double rangeMaxOf(const RayFan& fan, double maxRange_m)
{
  const double range = maxRange_m > 0 ? maxRange_m : fan.statedRangeMax_m;
  return range > 0 ? range : std::numeric_limits<double>::infinity();
}

/// Moves fans into a model's frame.
class FanMover
{
 public:
  FanMover(const ModelPose& pose, const ModelShape& shape)
      : pose_(pose),
        planar_(shape.planar),
        resolution_m_(shape.resolution_m),
        frame_(shape.resolution_m, pose.anchor, false)
  {
  }

  SelectedFan move(const SelectedFan& fan, RayCounts& counts) const
  {
    SelectedFan moved;
    const auto origin = place(fan.origin_map);
    if (!origin)
    {
      countOutside(fan.hitEnds_map.size(), counts.hits, counts);
      countOutside(fan.freeRays_map.size(), counts.freeOnly, counts);
      return moved;
    }
    moved.origin_map = *origin;
    moved.hitEnds_map.reserve(fan.hitEnds_map.size());
    for (const Eigen::Vector3d& end : fan.hitEnds_map)
    {
      const auto at = place(end);
      if (!at)
        countOutside(1, counts.hits, counts);
      else if (isPoint(*at - *origin))
        countTooNear(counts.hits, counts);
      else
        moved.hitEnds_map.push_back(*at);
    }
    for (const Eigen::Vector3d& ray : fan.freeRays_map)
    {
      const Eigen::Vector3d turned = rounded(pose_.turnedBack(ray));
      if (!isNear(*origin + turned))
        countOutside(1, counts.freeOnly, counts);
      else if (isPoint(turned))
        countTooNear(counts.freeOnly, counts);
      else
        moved.freeRays_map.push_back(turned);
    }
    return moved;
  }

 private:
  /// Half of what a frame of cells can hold, so that nothing on the way meets its end.
  [[nodiscard]] bool isNear(const Eigen::Vector3d& p) const
  {
    return p.cwiseAbs().maxCoeff() < 0.5 * ScanFrame::kReach_cells * resolution_m_;
  }
  [[nodiscard]] bool isPoint(const Eigen::Vector3d& ray) const
  {
    return ray.x() == 0 && ray.y() == 0 && (planar_ || ray.z() == 0);
  }
  [[nodiscard]] std::optional<Eigen::Vector3d> place(Eigen::Vector3d p_map) const
  {
    if (planar_) p_map.z() = 0;
    const auto local = frame_.toLocal(p_map);
    if (!local) return std::nullopt;
    const Eigen::Vector3d p = rounded(pose_.toModel(*local * resolution_m_));
    if (!isNear(p)) return std::nullopt;
    return p;
  }
  static void countOutside(size_t rays, size_t& used, RayCounts& counts)
  {
    used -= rays;
    counts.outside += rays;
  }
  static void countTooNear(size_t& used, RayCounts& counts)
  {
    --used;
    ++counts.tooNear;
  }

  const ModelPose& pose_;
  bool planar_;
  double resolution_m_;
  ScanFrame frame_;
};

/// The views of several scans; fans from the same place share one.
std::vector<DepthView> viewsOf(const std::vector<ModelScan>& scans, const FieldRules& rules, bool planar)
{
  std::vector<DepthView> views;
  for (const ModelScan& scan : scans)
    for (const ModelScan::Fan& fan : scan.fans)
    {
      const SelectedFan& rays = fan.rays;
      if (rays.hitEnds_map.empty() && rays.freeRays_map.empty()) continue;
      const auto same = std::find_if(
          views.begin(), views.end(),
          [&](const DepthView& view)
          { return view.image().sensor == rays.origin_map && view.image().rangeMax_m == fan.rangeMax_m; });
      DepthView& view =
          same != views.end() ? *same : views.emplace_back(rays.origin_map, fan.rangeMax_m, rules, planar);
      for (const Eigen::Vector3d& end : rays.hitEnds_map) view.addRay(end - rays.origin_map);
      for (const Eigen::Vector3d& ray : rays.freeRays_map) view.addRay(ray);
    }
  for (DepthView& view : views) view.finish();
  return views;
}

/** The box of the training points, a share left out at each of its ends, and a cell and a half more: the
 * cells that hold points whatever the frames' turn, and their neighbours, for the scan of a planar laser is
 * flat. */
void setBox(const HilbertTrainingSet& set, double quantile, double resolution_m, HilbertModel& model)
{
  const size_t count = set.size();
  const auto leftOut = std::min((count - 1) / 2, static_cast<size_t>(quantile * static_cast<double>(count)));
  const double margin_m = 1.5 * resolution_m;
  std::vector<double> along(count);
  for (int axis = 0; axis < 3; ++axis)
  {
    for (size_t i = 0; i < count; ++i) along[i] = set.points[i][axis];
    const auto low = along.begin() + static_cast<long>(leftOut);
    const auto high = along.end() - 1 - static_cast<long>(leftOut);
    std::nth_element(along.begin(), low, along.end());
    model.boxLow[axis] = *low - margin_m;
    std::nth_element(low, high, along.end());
    model.boxHigh[axis] = *high + margin_m;
  }
}

Eigen::Matrix3d covarianceOf(const ModelScan& scan, const Eigen::Vector3d& point,
                             const Eigen::Vector3d& sensor, bool planar)
{
  if (!scan.uncertainty) return Eigen::Matrix3d::Zero();
  const Eigen::Matrix3d covariance = scan.uncertainty->of(point, sensor);
  return planar ? inPlane(covariance) : covariance;
}

/// Rᵀ·M·R, in an order of operations that is always the same.
Eigen::Matrix3d turnedBack(const ModelPose& pose, const Eigen::Matrix3d& matrix)
{
  Eigen::Matrix3d half;
  for (int column = 0; column < 3; ++column) half.col(column) = pose.turnedBack(matrix.col(column));
  Eigen::Matrix3d turned;
  for (int row = 0; row < 3; ++row) turned.row(row) = pose.turnedBack(half.row(row).transpose()).transpose();
  return turned;
}

/// Finite, so that the sum of any of them is.
float bounded(float weight)
{
  constexpr float kLargestWeight = 1e6f;
  return std::isnan(weight) ? 0.0f : std::clamp(weight, -kLargestWeight, kLargestWeight);
}

float notZero(float weight)
{
  constexpr float kSmallest = HilbertModel::kSmallestWeight;
  if (std::abs(weight) >= kSmallest) return weight;
  return weight < 0 ? -kSmallest : kSmallest;
}

}  // namespace

bool operator==(const ModelScan::Fan& a, const ModelScan::Fan& b)
{
  return a.rangeMax_m == b.rangeMax_m && a.rays.origin_map == b.rays.origin_map &&
         a.rays.hitEnds_map == b.rays.hitEnds_map && a.rays.freeRays_map == b.rays.freeRays_map;
}

bool operator==(const ModelScan& a, const ModelScan& b)
{
  if (!(a.fans == b.fans) || a.uncertainty.has_value() != b.uncertainty.has_value()) return false;
  return !a.uncertainty ||
         (a.uncertainty->pose == b.uncertainty->pose && a.uncertainty->centre == b.uncertainty->centre &&
          a.uncertainty->rangeStd_m == b.uncertainty->rangeStd_m &&
          a.uncertainty->point == b.uncertainty->point);
}

HilbertUncertainty toModelFrame(const HilbertUncertainty& uncertainty, const ModelPose& pose,
                                const ModelShape& shape)
{
  HilbertUncertainty turned = uncertainty;
  for (const int row : {0, 3})
    for (const int column : {0, 3})
      turned.pose.block<3, 3>(row, column) = turnedBack(pose, uncertainty.pose.block<3, 3>(row, column));
  turned.point = turnedBack(pose, uncertainty.point);
  const Eigen::Vector3d anchor = Eigen::Vector3d(pose.anchor.x, pose.anchor.y, pose.anchor.z);
  turned.centre = rounded(pose.toModel(uncertainty.centre - anchor * shape.resolution_m));
  if (shape.planar) turned.centre.z() = shape.flatHeight();
  return turned;
}

ModelScan toModelFrame(const Scan& scan, const OverlappingInference& inference, const ModelPose& pose,
                       const ModelShape& shape, RayCounts& counts)
{
  const SelectedRays selected = selectRays(scan, inference.rangeLimits());
  counts = selected.counts;
  ModelScan moved;
  const FanMover mover(pose, shape);
  for (size_t i = 0; i < selected.fans.size(); ++i)
    moved.fans.push_back(
        {mover.move(selected.fans[i], counts), rangeMaxOf(scan.fans[i], inference.maxRange)});
  return moved;
}

const HilbertTrainingSet& HilbertModelTrainer::sample(const std::vector<ModelScan>& scans,
                                                      const ModelShape& shape,
                                                      const OverlappingInference& inference)
{
  const HilbertFrame frame = HilbertFrame::ofModel(shape.resolution_m, shape.spacing_m, shape.planar);
  const bool uncertain = std::any_of(scans.begin(), scans.end(),
                                     [](const ModelScan& scan) { return scan.uncertainty.has_value(); });
  set_.clear();
  for (const ModelScan& scan : scans)
  {
    SelectedRays rays;
    for (const ModelScan::Fan& fan : scan.fans)
    {
      rays.fans.push_back(fan.rays);
      rays.counts.hits += fan.rays.hitEnds_map.size();
      rays.counts.freeOnly += fan.rays.freeRays_map.size();
    }
    const HilbertTrainingSet& own = sampler_.sample(rays, inference, frame);
    set_.points.insert(set_.points.end(), own.points.begin(), own.points.end());
    set_.labels.insert(set_.labels.end(), own.labels.begin(), own.labels.end());
    set_.weights.insert(set_.weights.end(), own.weights.begin(), own.weights.end());
    if (!uncertain) continue;
    const Eigen::Vector3d sensor = scan.fans.front().rays.origin_map;
    for (const Eigen::Vector3d& point : own.points)
      set_.covariances.push_back(covarianceOf(scan, point, sensor, shape.planar));
  }
  return set_;
}

std::optional<HilbertModel> HilbertModelTrainer::train(const std::vector<ModelScan>& scans,
                                                       const OverlappingStructure& structure,
                                                       const OverlappingInference& inference,
                                                       const Workers& workers)
{
  const ModelShape shape(structure);
  const HilbertTrainingSet& set = sample(scans, shape, inference);
  if (set.size() == 0) return std::nullopt;

  HilbertModel model;
  setBox(set, inference.boxQuantile, shape.resolution_m, model);
  model.views =
      viewsOf(scans, {inference.fieldNear, inference.fieldDepth, inference.fieldAngle}, shape.planar);
  model.fieldWeight = inference.fieldWeight;
  model.scans = static_cast<uint32_t>(scans.size());
  if (shape.compact())
    trainCompact(set, shape, structure, inference, workers, model);
  else
    trainNystroem(set, structure, inference, workers, model);
  return model;
}

void HilbertModelTrainer::findWeights(FeatureRows& rows, const HilbertTrainingSet& set,
                                      const OverlappingStructure& structure,
                                      const OverlappingInference& inference, const Workers& workers)
{
  weights_.assign(rows.weights(), 0.0f);
  mean_.assign(rows.weights(), 0.0f);
  precision_.assign(rows.weights(), 0.0f);
  for (const uint32_t j : rows.used())
    if (rows.bias() != j) precision_[j] = static_cast<float>(structure.priorPrecision);
  const SolverSettings settings{inference.solver, inference.iterations, inference, structure.seed};
  solver_.solve({rows, set.labels, set.weights, mean_, precision_}, settings, 0, weights_, workers);
}

void HilbertModelTrainer::trainCompact(const HilbertTrainingSet& set, const ModelShape& shape,
                                       const OverlappingStructure& structure,
                                       const OverlappingInference& inference, const Workers& workers,
                                       HilbertModel& model)
{
  compact_.findSites(set, structure.kernel(), shape.spacing_m, shape.planar, {});
  compact_.build(set, workers);
  findWeights(compact_.rows(), set, structure, inference, workers);

  const SiteSet& sites = compact_.sites();
  model.sites.weights.reserve(compact_.numbers().used().size());
  for (const size_t number : sites.sortedBlocks())
  {
    const BlockIndex& block = sites.blocks()[number];
    model.sites.blocks.push_back(block);
    model.sites.bits.push_back(sites.bits(number));
    SiteBits::forEach(
        sites.bits(number), block,
        [&](const CellIndex& site)
        {
          const int64_t weight = compact_.numbers().numberOf(site);
          model.sites.weights.push_back(notZero(bounded(weights_[static_cast<size_t>(weight)])));
        });
  }
  model.sites.number();
}

void HilbertModelTrainer::trainNystroem(const HilbertTrainingSet& set, const OverlappingStructure& structure,
                                        const OverlappingInference& inference, const Workers& workers,
                                        HilbertModel& model)
{
  const NystroemFeatures features(set.points, structure.components, structure.resolvedGamma(),
                                  structure.seed);
  features.rowsOf(set, nystroemRows_, workers);
  findWeights(nystroemRows_, set, structure, inference, workers);
  const NystroemFeatures::Folded folded = features.fold(weights_);
  model.inducing = features.inducing();
  model.kernelWeights.reserve(folded.kernelWeights.size());
  for (const float weight : folded.kernelWeights) model.kernelWeights.push_back(bounded(weight));
  model.bias = bounded(folded.bias);
}

}  // namespace lamap
