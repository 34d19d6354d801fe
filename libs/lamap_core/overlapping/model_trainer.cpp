#include <lamap_core/features/logodds.h>
#include <lamap_core/overlapping/model_trainer.h>
#include <lamap_core/scan/beam_spacing.h>
#include <lamap_core/training/ray_widths.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace lamap
{
namespace
{
/// The fans that several scans sent from one place.
struct FansOfPlace
{
  Eigen::Vector3d centre;
  double rangeMax_m;
  std::vector<std::pair<const ModelScan*, const RayFan*>> fans;
};

std::vector<FansOfPlace> fansByPlace(const std::vector<ModelScan>& scans)
{
  std::vector<FansOfPlace> places;
  for (const ModelScan& scan : scans)
    for (const RayFan& fan : scan.rays.scan.fans)
    {
      if (fan.rays.empty()) continue;
      const double rangeMax_m =
          fan.statedRangeMax_m > 0 ? fan.statedRangeMax_m : std::numeric_limits<double>::infinity();
      const auto same = std::find_if(places.begin(), places.end(),
                                     [&](const FansOfPlace& place) {
                                       return place.centre == fan.centre && place.rangeMax_m == rangeMax_m;
                                     });
      FansOfPlace& place =
          same != places.end() ? *same : places.emplace_back(FansOfPlace{fan.centre, rangeMax_m, {}});
      place.fans.emplace_back(&scan, &fan);
    }
  return places;
}

/** Width of the bins of a view [degrees], from the distance between its neighbouring beams: wide enough for
 * neighbours to meet, and no wider, because a bin knows but one depth. Chosen by log loss. */
double angleBetweenBeams_deg(const FansOfPlace& place)
{
  constexpr double kOfSpacing = 1.25;
  constexpr double kFinest_deg = 0.5;
  constexpr double kCoarsest_deg = 10;
  constexpr double kOfLoneBeams_deg = 2.5;
  constexpr double kDegreesPerRadian = 180 / 3.141592653589793;
  RayFan all;
  all.centre = place.centre;
  for (const auto& [scan, fan] : place.fans)
    all.rays.insert(all.rays.end(), fan->rays.begin(), fan->rays.end());
  std::vector<float> spacing = beamSpacing(all);
  const auto median = spacing.begin() + static_cast<std::ptrdiff_t>(spacing.size() / 2);
  std::nth_element(spacing.begin(), median, spacing.end());
  if (!(*median > 0)) return kOfLoneBeams_deg;
  return std::clamp(kOfSpacing * kDegreesPerRadian * static_cast<double>(*median), kFinest_deg,
                    kCoarsest_deg);
}

/// The views of several scans; fans from the same place share one.
std::vector<DepthView> viewsOf(const std::vector<ModelScan>& scans, const FieldRules& rules,
                               BeamWidth beamWidth, bool planar)
{
  std::vector<DepthView> views;
  std::vector<Eigen::Vector3d> bundle;
  for (const FansOfPlace& place : fansByPlace(scans))
  {
    FieldRules own = rules;
    if (!(rules.angle_deg > 0)) own.angle_deg = angleBetweenBeams_deg(place);
    DepthView& view = views.emplace_back(place.centre, place.rangeMax_m, own, planar);
    for (const auto& [scan, fan] : place.fans)
    {
      const BeamCone cone = coneOf(scan->rays.scan, *fan, beamWidth, planar);
      for (const Ray& ray : fan->rays)
      {
        cone.spreadByAngle(fan->directionOf(ray), bundle);
        for (const Eigen::Vector3d& each : bundle) view.addRay(each);
      }
    }
    view.finish();
  }
  return views;
}

/// Does a ray that ended at a place of the model count in its cell?
bool isHitKept(const ModelScan& scan, const Eigen::Vector3d& place, const ModelShape& shape)
{
  if (!scan.uncertainty) return true;
  return countsInItsCell(scan.uncertainty->of(place, scan.rays.firstCentre_map()), shape.resolution_m,
                         shape.planar);
}

/// Of the points' errors, by their weights [m²].
double meanVariance(const HilbertTrainingSet& set)
{
  double weights = 0;
  double variances = 0;
  for (size_t i = 0; i < set.variances.size(); ++i)
  {
    const double weight = static_cast<double>(set.weights[i]);
    weights += weight;
    variances += weight * static_cast<double>(set.variances[i]);
  }
  return weights > 0 ? variances / weights : 0.0;
}

/// Where narrow rays ended; the echo of a wide beam may have come from elsewhere.
std::vector<Eigen::Vector3f> hitsOf(const std::vector<ModelScan>& scans, BeamWidth beamWidth,
                                    const ModelShape& shape)
{
  std::vector<Eigen::Vector3f> hits;
  for (const ModelScan& scan : scans)
    for (const RayFan& fan : scan.rays.scan.fans)
    {
      const BeamCone cone = coneOf(scan.rays.scan, fan, beamWidth, shape.planar);
      for (const Ray& ray : fan.rays)
        if (ray.meaning == RayEnd::Return && !cone.isWide(fan.directionOf(ray), shape.resolution_m) &&
            isHitKept(scan, ray.end, shape))
          hits.push_back(ray.end.cast<float>());
    }
  return hits;
}

/** The box of the training points, a share left out at each of its ends, and a cell and a half more: the
 * cells that hold points whatever the frames' turn, and their neighbours, because the scan of a planar laser
 * is flat. */
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

float notZero(float weight)
{
  constexpr float kSmallest = HilbertModel::kSmallestWeight;
  if (std::abs(weight) >= kSmallest) return weight;
  return weight < 0 ? -kSmallest : kSmallest;
}

}  // namespace

const HilbertTrainingSet& HilbertModelTrainer::sample(const std::vector<ModelScan>& scans,
                                                      const ModelShape& shape,
                                                      const OverlappingInference& inference)
{
  const HilbertFrame frame = HilbertFrame::ofModel(shape.resolution_m, shape.spacing_m, shape.planar);
  set_.clear();
  for (const ModelScan& scan : scans)
  {
    const size_t first = set_.size();
    set_.append(sampler_.sample(scan.rays, inference.rules(), frame.cells, {}, 1), frame);
    if (scan.uncertainty)
      set_.blur(first, *scan.uncertainty, scan.rays.firstCentre_map(), shape.gamma, shape.planar);
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
  model.views = viewsOf(scans, {inference.fieldNear, inference.fieldDepth, inference.fieldAngle},
                        inference.beamWidth, shape.planar);
  model.fieldWeight = inference.fieldWeight;
  model.scans = static_cast<uint32_t>(scans.size());
  model.variance = shape.askable(meanVariance(set));
  if (inference.rules().protectHits > 0) model.hits = hitsOf(scans, inference.beamWidth, shape);
  if (shape.compact())
    trainCompact(set, shape, structure, inference, workers, model);
  else
    trainNystroem(set, shape, structure, inference, workers, model);
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
  const double share = shape.shareOf(model.variance);
  model.sites.weights.reserve(compact_.numbers().used().size());
  for (const size_t number : sites.sortedBlocks())
  {
    const BlockIndex& block = sites.blocks()[number];
    model.sites.blocks.push_back(block);
    model.sites.bits.push_back(sites.bits(number));
    SiteBits::forEach(sites.bits(number), block,
                      [&](const CellIndex& site)
                      {
                        const int64_t weight = compact_.numbers().numberOf(site);
                        model.sites.weights.push_back(notZero(boundedWeight(
                            static_cast<float>(share) * weights_[static_cast<size_t>(weight)])));
                      });
  }
  model.sites.number();
}

void HilbertModelTrainer::trainNystroem(const HilbertTrainingSet& set, const ModelShape& shape,
                                        const OverlappingStructure& structure,
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
  const double share = shape.shareOf(model.variance);
  for (const float weight : folded.kernelWeights)
    model.kernelWeights.push_back(boundedWeight(static_cast<float>(share) * weight));
  model.bias = boundedWeight(folded.bias);
}

}  // namespace lamap
