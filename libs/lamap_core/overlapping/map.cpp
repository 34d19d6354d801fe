#include <lamap_core/overlapping/map.h>

#include <lamap_core/grid/cell_accessor_members.h>
#include <lamap_core/grid/evidence_map_members.h>
#include <lamap_core/options/legal_range.h>
#include <lamap_core/overlapping/model_fusion.h>
#include <lamap_core/overlapping/model_trainer.h>
#include <lamap_core/overlapping/reading_numbers.h>
#include <lamap_core/scan/scan_frame.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <stdexcept>
#include <string>
#include <utility>

namespace lamap
{
namespace
{
OctantRule noPruning(const BlockIndex& /*block*/)
{
  return {};
}

bool sameModel(const PlacedModel& a, const PlacedModel& b)
{
  return a.pose == b.pose && *a.model == *b.model;
}

/// @throws std::out_of_range naming the number and how many there are
const PlacedModel& modelAt(const std::vector<PlacedModel>& models, size_t number)
{
  if (number < models.size()) return models[number];
  throw std::out_of_range("model " + std::to_string(number) + ": the map has " +
                          std::to_string(models.size()) + " models, numbered from 0");
}
}  // namespace

template class EvidenceMap<OverlappingReading>;
template class CellAccessor<OverlappingReading>;

struct OverlappingHilbertMap::LazyIndex
{
  std::mutex mutex;
  std::unique_ptr<const HilbertModelIndex> index;
};

OverlappingHilbertMap::OverlappingHilbertMap(const OverlappingStructure& structure)
    : EvidenceMap(structure),
      shape_(structure),
      written_(evidence().shape(), evidence().kind()),
      index_(std::make_shared<LazyIndex>())
{
}

void OverlappingHilbertMap::requireModels(const char* what) const
{
  if (!structure().keepModels)
    throw std::logic_error(std::string("this map does not keep its models (keepModels = false): ") + what);
}

const HilbertModelIndex& OverlappingHilbertMap::index() const
{
  const std::lock_guard<std::mutex> lock(index_->mutex);
  if (!index_->index)
    index_->index = std::make_unique<const HilbertModelIndex>(models_, shape_, planarLayer());
  return *index_->index;
}

RayCounts OverlappingHilbertMap::insert(const Scan& scan, const OverlappingInference& inference,
                                        const HilbertUncertainty* uncertainty, unsigned threads)
{
  inference.validate();
  if (uncertainty != nullptr) uncertainty->validate();
  const SelectedRays selected = selectRays(scan, inference.rangeLimits(), structure().resolution);
  if (selected.counts.used() == 0) return selected.counts;
  const ModelPose frame =
      pending_.scans.empty() ? modelFrameOf(selected.scan, shape_).value_or(ModelPose{}) : pending_.pose;
  ModelScan moved = scanInModel(selected, uncertainty, frame, shape_);
  const RayCounts counts = moved.rays.counts;
  if (counts.used() == 0) return counts;
  const ModelPose poseBefore = pending_.pose;
  if (moved.uncertainty) moved.uncertainty->validate();
  pending_.scans.push_back(std::move(moved));
  pending_.pose = frame;
  try
  {
    if (pending_.scans.size() < inference.scansPerModel)
      requireTrainable(inference, workers_.with(threads));
    else
      trainPending(inference, threads);
  }
  catch (...)
  {
    pending_.scans.pop_back();
    pending_.pose = poseBefore;
    throw;
  }
  return counts;
}

bool OverlappingHilbertMap::trainPending(const OverlappingInference& inference, unsigned threads)
{
  if (pending_.scans.empty()) return false;
  inference.validate();
  const Workers& workers = workers_.with(threads);
  auto model = trainer_.get().train(pending_.scans, structure(), inference, workers);
  if (model)
  {
    auto index = std::make_shared<LazyIndex>();
    EvidenceChange change =
        EvidenceChange::addition(mutableEvidence(), inferModel(*model, pending_.pose, nullptr, workers),
                                 ruleFor(inference.thresholds), workers);
    model->keepWeakHits(fusion_.get(shape_, planarLayer()).hitLogodds());
    if (structure().keepModels)
      models_.push_back({pending_.pose, std::make_shared<const HilbertModel>(std::move(*model))});
    change.commit();
    index_ = std::move(index);
  }
  pending_ = {};
  return true;
}

void OverlappingHilbertMap::requireTrainable(const OverlappingInference& inference, const Workers& workers)
{
  if (isSurelyTrainable(pending_, structure(), inference)) return;
  // Whether there is room does not depend on how well the model is trained.
  OverlappingInference quick = inference;
  quick.solver = HilbertSolver::Lbfgs;
  quick.iterations = 1;
  const auto model = trainer_.get().train(pending_.scans, structure(), quick, workers);
  if (model) fusion_.get(shape_, planarLayer()).choose(*model, pending_.pose, evidence().shape(), workers);
}

size_t OverlappingHilbertMap::dropUntrainable(const OverlappingInference& inference, unsigned threads)
{
  try
  {
    requireTrainable(inference, workers_.with(threads));
    return 0;
  }
  catch (const std::length_error&)
  {
    return std::exchange(pending_, {}).scans.size();
  }
}

Evidence OverlappingHilbertMap::inferModel(const HilbertModel& model, const ModelPose& pose,
                                           const std::vector<BlockIndex>* wanted, const Workers& workers)
{
  ModelFusion& fusion = fusion_.get(shape_, planarLayer());
  fusion.choose(model, pose, evidence().shape(), workers);
  return fusion.infer(wanted, workers);
}

void OverlappingHilbertMap::merge(const OverlappingHilbertMap& other, const StateThresholds& thresholds)
{
  reading().requireAddable(other.reading());
  requireLegal(other.pending_.scans.empty(), "scans of the other map that wait for their model",
               static_cast<double>(other.pending_.scans.size()), "trained first");
  const Workers workers(1);
  auto index = std::make_shared<LazyIndex>();
  EvidenceChange cells =
      EvidenceChange::addition(mutableEvidence(), other.evidence(), ruleFor(thresholds), workers);
  EvidenceChange written = EvidenceChange::addition(written_, other.written_, noPruning, workers);
  models_.reserve(models_.size() + other.models_.size());
  cells.commit();
  written.commit();
  for (size_t i = 0, count = other.models_.size(); i < count; ++i) models_.push_back(other.models_[i]);
  index_ = std::move(index);
}

void OverlappingHilbertMap::clear()
{
  auto index = std::make_shared<LazyIndex>();
  EvidenceMap::clear();
  written_.clear();
  models_.clear();
  pending_ = {};
  index_ = std::move(index);
}

bool OverlappingHilbertMap::empty() const
{
  return EvidenceMap::empty() && models_.empty() && pending_.scans.empty();
}

CellSums OverlappingHilbertMap::sumsAt(const Eigen::Vector3d& point_m, const CellIndex& cell) const
{
  CellSums sum = written_.at(cell);
  const HilbertModelIndex& models = index();
  models.forEachNear(point_m,
                     [&](size_t number)
                     {
                       const auto& [pose, model] = models_[number];
                       const ScanFrame frame(structure().resolution, pose.anchor, false);
                       const auto local = frame.toLocal(point_m);
                       if (!local) return;
                       Eigen::Vector3d p = pose.toModel(*local * structure().resolution);
                       if (structure().planar) p.z() = shape_.flatHeight();
                       sum = addSums(written_.kind(), sum,
                                     model->evidenceAt(shape_, p, models.isHit(number, cell)));
                     });
  return sum;
}

std::optional<CellEstimate> OverlappingHilbertMap::continuousAt(const Eigen::Vector3d& point_m,
                                                                const StateThresholds& thresholds) const
{
  requireModels("there is no continuous map to be asked");
  Eigen::Vector3d point = point_m;
  if (structure().planar) point.z() = 0;
  auto cell = cellAt(point, structure().resolution);
  if (!cell) return std::nullopt;
  if (structure().planar) cell->z = planarLayer();
  const CellSums sums = sumsAt(point, *cell);
  if (!sums.any()) return std::nullopt;
  return reading().read(*cell, sums, thresholds);
}

OverlappingHilbertMap OverlappingHilbertMap::resampled(double resolution_m, const StateThresholds& thresholds,
                                                       unsigned threads) const
{
  requireModels("it cannot be resampled");
  OverlappingStructure other = structure();
  other.resolution = resolution_m;
  OverlappingHilbertMap map(other);
  const Workers workers(threads);
  for (const auto& [pose, model] : models_)
  {
    const ModelPose moved = ModelPose::of(pose.isometry(structure().resolution), resolution_m, other.planar);
    map.models_.push_back({moved, model});
    map.add(map.inferModel(*model, moved, nullptr, workers), thresholds, workers);
  }
  return map;
}

void OverlappingHilbertMap::addEvidence(const CellIndex& index, double logodds,
                                        const StateThresholds& thresholds)
{
  requireLegal(std::abs(logodds) <= 1000, "logodds", logodds, "a number from -1000 to 1000");
  const CellSums sums = SignedSums{inEvidenceUnits(logodds), std::nullopt}.coded();
  const Workers workers(1);
  EvidenceChange cells =
      EvidenceChange::addition(mutableEvidence(), evidenceOf(index, sums), ruleFor(thresholds), workers);
  EvidenceChange written = EvidenceChange::addition(written_, evidenceOf(index, sums), noPruning, workers);
  cells.commit();
  written.commit();
}

Eigen::Isometry3d OverlappingHilbertMap::modelPose(size_t model) const
{
  return modelAt(models_, model).pose.isometry(structure().resolution);
}

void OverlappingHilbertMap::setModelPoses(const std::vector<MovedModel>& moved,
                                          const StateThresholds& thresholds, unsigned threads)
{
  requireModels("none can be moved");
  std::vector<std::pair<size_t, ModelPose>> poses;
  for (const auto& [number, pose] : moved)
  {
    (void)modelAt(models_, number);
    poses.emplace_back(number, ModelPose::of(pose, structure().resolution, structure().planar));
  }
  const Workers& workers = workers_.with(threads);
  std::vector<PlacedModel> models = models_;
  std::vector<BlockIndex> touched;
  const auto touch = [&](const PlacedModel& placed)
  {
    ModelFusion& fusion = fusion_.get(shape_, planarLayer());
    fusion.choose(*placed.model, placed.pose, evidence().shape(), workers);
    touched.insert(touched.end(), fusion.blocks().begin(), fusion.blocks().end());
  };
  for (const auto& [number, pose] : poses)
  {
    touch(models[number]);
    models[number].pose = pose;
    touch(models[number]);
  }
  std::sort(touched.begin(), touched.end());
  touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
  auto index = std::make_shared<LazyIndex>();
  EvidenceChange change = EvidenceChange::replacement(mutableEvidence(), touched,
                                                      fusedAnew(models, touched, thresholds, workers));
  change.commit();
  models_.swap(models);
  index_ = std::move(index);
}

/// What some blocks hold, from what was written to cells and from these models.
Evidence OverlappingHilbertMap::fusedAnew(const std::vector<PlacedModel>& models,
                                          const std::vector<BlockIndex>& blocks,
                                          const StateThresholds& thresholds, const Workers& workers)
{
  Evidence fused(evidence().shape(), evidence().kind());
  const auto add = [&](Evidence&& said)
  { EvidenceChange::addition(fused, std::move(said), ruleFor(thresholds), workers).commit(); };
  Evidence written(evidence().shape(), evidence().kind());
  for (const BlockIndex& block : blocks)
    if (const EvidenceBlock* told = written_.find(block)) written.findOrCreate(block) = *told;
  add(std::move(written));
  for (const auto& [pose, model] : models) add(inferModel(*model, pose, &blocks, workers));
  return fused;
}

void OverlappingHilbertMap::restoreEvidence(Evidence&& evidence, Evidence&& written)
{
  if (!(written.shape() == written_.shape()) || written.kind() != written_.kind())
    throw std::invalid_argument("the written evidence is not that of such a map: its blocks or sums differ");
  EvidenceMap::restoreEvidence(std::move(evidence));
  written_ = std::move(written);
}

void OverlappingHilbertMap::restore(std::vector<PlacedModel> models, PendingScans pending)
{
  if (!structure().keepModels && !models.empty())
    throw std::runtime_error("the map is corrupt: it has models that it does not keep");
  for (const PlacedModel& placed : models)
  {
    placed.pose.check(structure().resolution, structure().planar);
    placed.model->check(shape_);
  }
  if (!pending.scans.empty()) pending.pose.check(structure().resolution, structure().planar);
  for (const ModelScan& scan : pending.scans) scan.check(shape_);
  auto index = std::make_shared<LazyIndex>();
  models_ = std::move(models);
  pending_ = std::move(pending);
  index_ = std::move(index);
}

size_t OverlappingHilbertMap::modelBytes() const
{
  size_t bytes = models_.capacity() * sizeof(PlacedModel);
  for (const PlacedModel& placed : models_) bytes += placed.model->memoryBytes();
  return bytes;
}

size_t OverlappingHilbertMap::memoryBytes() const
{
  return evidence().memoryBytes() + written_.memoryBytes() + modelBytes();
}

bool operator==(const OverlappingHilbertMap& a, const OverlappingHilbertMap& b)
{
  return a.structure() == b.structure() && a.evidence() == b.evidence() && a.written_ == b.written_ &&
         a.models_.size() == b.models_.size() &&
         std::equal(a.models_.begin(), a.models_.end(), b.models_.begin(), sameModel) &&
         a.pending_.scans == b.pending_.scans &&
         (a.pending_.scans.empty() || a.pending_.pose == b.pending_.pose);
}

}  // namespace lamap
