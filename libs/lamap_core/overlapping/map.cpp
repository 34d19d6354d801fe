#include <lamap_core/overlapping/map.h>

#include <lamap_core/math/portable_math.h>
#include <lamap_core/options/legal_range.h>
#include <lamap_core/overlapping/logodds_evidence.h>
#include <lamap_core/overlapping/model_fusion.h>
#include <lamap_core/scan/scan_frame.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace lamap
{
namespace
{
BlockShape blockShapeOf(const OverlappingStructure& structure)
{
  structure.validate();
  return BlockShape(structure.blockDepth - 1, structure.planar);
}

/// Where a scan's model is trained if nobody says.
Eigen::Isometry3d placeOf(const Scan& scan, double resolution_m)
{
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  for (const RayFan& fan : scan.fans)
  {
    if (!cellAt(fan.origin_map, resolution_m)) continue;
    pose.translation() = fan.origin_map;
    break;
  }
  return pose;
}

bool sameBlocks(const BlockGrid& a, const BlockGrid& b)
{
  const std::vector<BlockIndex> blocks = a.sortedBlocks();
  if (!(a.shape() == b.shape()) || blocks.size() != b.blockCount()) return false;
  return std::all_of(blocks.begin(), blocks.end(),
                     [&](const BlockIndex& index)
                     {
                       const EvidenceBlock& own = *a.find(index);
                       const EvidenceBlock* other = b.find(index);
                       return other != nullptr && own.wide() == other->wide() &&
                              own.pruned() == other->pruned() && own.words() == other->words();
                     });
}

bool sameModel(const PlacedModel& a, const PlacedModel& b)
{
  return a.pose == b.pose && *a.model == *b.model;
}

}  // namespace

struct OverlappingHilbertMap::LazyIndex
{
  std::mutex mutex;
  std::unique_ptr<const HilbertModelIndex> index;
};

OverlappingHilbertMap::OverlappingHilbertMap(const OverlappingStructure& structure)
    : structure_(structure),
      shape_((structure.validate(), structure)),
      planarLayer_(static_cast<int32_t>(std::floor(structure.planarHeight / structure.resolution))),
      grid_(blockShapeOf(structure)),
      written_(grid_.shape()),
      index_(std::make_unique<LazyIndex>())
{
}

OverlappingHilbertMap::OverlappingHilbertMap(const OverlappingHilbertMap& other)
    : structure_(other.structure_),
      shape_(other.shape_),
      planarLayer_(other.planarLayer_),
      grid_(other.grid_),
      written_(other.written_),
      models_(other.models_),
      pending_(other.pending_),
      index_(std::make_unique<LazyIndex>())
{
}

OverlappingHilbertMap& OverlappingHilbertMap::operator=(const OverlappingHilbertMap& other)
{
  if (this != &other) *this = OverlappingHilbertMap(other);
  return *this;
}

OverlappingHilbertMap::OverlappingHilbertMap(OverlappingHilbertMap&&) noexcept = default;
OverlappingHilbertMap& OverlappingHilbertMap::operator=(OverlappingHilbertMap&&) noexcept = default;
OverlappingHilbertMap::~OverlappingHilbertMap() = default;

void OverlappingHilbertMap::requireModels(const char* what) const
{
  if (!structure_.keepModels)
    throw std::logic_error(std::string("this map does not keep its models (keepModels = false): ") + what);
}

void OverlappingHilbertMap::dropIndex()
{
  index_->index.reset();
}

const HilbertModelIndex& OverlappingHilbertMap::index() const
{
  const std::lock_guard<std::mutex> lock(index_->mutex);
  if (!index_->index) index_->index = std::make_unique<const HilbertModelIndex>(models_, shape_);
  return *index_->index;
}

OctantRule OverlappingHilbertMap::ruleFor(const StateThresholds& thresholds) const
{
  if (structure_.pruning == Pruning::None) return {};
  if (structure_.pruning == Pruning::Lossless) return {Pruning::Lossless, mergeEqual};
  const auto merger =
      [this, thresholds](const DenseBlock& dense, uint32_t first, uint32_t count, Evidence& merged)
  {
    return mergeSameState(
        dense, first, count, merged, [&](Evidence& mean) { return meanLogodds(dense, first, count, mean); },
        [&](uint32_t /*offset*/, const Evidence& evidence) { return estimate(evidence, thresholds).state; });
  };
  return {Pruning::State, merger};
}

RayCounts OverlappingHilbertMap::insert(const Scan& scan, const OverlappingInference& inference,
                                        const std::optional<Eigen::Isometry3d>& pose,
                                        const HilbertUncertainty* uncertainty, unsigned threads)
{
  inference.validate();
  if (uncertainty != nullptr) uncertainty->validate();
  const bool isFirst = pending_.scans.empty();
  ModelPose frame = pending_.pose;
  if (isFirst)
    frame = ModelPose::of(pose.value_or(placeOf(scan, structure_.resolution)), structure_.resolution,
                          structure_.planar);
  RayCounts counts;
  ModelScan moved = toModelFrame(scan, inference, frame, shape_, counts);
  if (counts.used() == 0) return counts;
  if (uncertainty != nullptr && uncertainty->any())
    moved.uncertainty = toModelFrame(*uncertainty, frame, shape_);
  pending_.pose = frame;
  pending_.scans.push_back(std::move(moved));
  if (pending_.scans.size() < inference.scansPerModel) return counts;
  try
  {
    trainPending(inference, threads);
  }
  catch (...)
  {
    pending_.scans.pop_back();
    throw;
  }
  return counts;
}

bool OverlappingHilbertMap::trainPending(const OverlappingInference& inference, unsigned threads)
{
  if (pending_.scans.empty()) return false;
  inference.validate();
  if (!trainer_) trainer_ = std::make_unique<HilbertModelTrainer>();
  auto model = trainer_->train(pending_.scans, structure_, inference, Workers(threads));
  if (model)
  {
    const PlacedModel placed{pending_.pose, std::make_shared<const HilbertModel>(std::move(*model))};
    fuse(placed, inference.thresholds, nullptr, threads);
    if (structure_.keepModels) models_.push_back(placed);
    dropIndex();
  }
  pending_ = {};
  return true;
}

void OverlappingHilbertMap::fuse(const PlacedModel& placed, const StateThresholds& thresholds,
                                 const std::vector<BlockIndex>* wanted, unsigned threads)
{
  if (!fusion_) fusion_ = std::make_unique<ModelFusion>(shape_, planarLayer_);
  const Workers workers(threads);
  fusion_->choose(*placed.model, placed.pose, grid_.shape(), workers);
  const OctantRule rule = ruleFor(thresholds);
  fusion_->addTo(
      grid_, [&](const BlockIndex&) { return rule; }, wanted, workers);
}

void OverlappingHilbertMap::addGrid(const BlockGrid& from, BlockGrid& to, const OctantRule& rule) const
{
  const BlockShape& shape = grid_.shape();
  DenseBlock theirs(shape);
  LogoddsAdder adder(shape);
  for (const BlockIndex& index : from.sortedBlocks())
  {
    from.find(index)->unpack(shape, theirs);
    adder.clear();
    for (uint32_t offset = 0; offset < shape.cellCount(); ++offset)
      if (theirs.isObserved(offset)) adder.set(offset, theirs.at(offset));
    adder.addTo(to.findOrCreate(index), rule);
  }
}

void OverlappingHilbertMap::merge(const OverlappingHilbertMap& other, const StateThresholds& thresholds)
{
  OverlappingStructure theirs = other.structure_;
  theirs.pruning = structure_.pruning;
  if (!(theirs == structure_))
    throw std::invalid_argument("the other map was made with other creation options than this one");
  requireLegal(other.pending_.scans.empty(), "scans of the other map that wait for their model",
               static_cast<double>(other.pending_.scans.size()), "trained first");
  addGrid(other.grid_, grid_, ruleFor(thresholds));
  addGrid(other.written_, written_, {});
  models_.reserve(models_.size() + other.models_.size());
  for (size_t i = 0, count = other.models_.size(); i < count; ++i) models_.push_back(other.models_[i]);
  dropIndex();
}

void OverlappingHilbertMap::clear()
{
  grid_.clear();
  written_.clear();
  models_.clear();
  pending_ = {};
  dropIndex();
}

bool OverlappingHilbertMap::empty() const
{
  return grid_.blockCount() == 0 && models_.empty() && pending_.scans.empty();
}

CellEstimate OverlappingHilbertMap::estimate(const Evidence& evidence,
                                             const StateThresholds& thresholds) const
{
  CellEstimate cell;
  const double logodds = logoddsOf(evidence, structure_.outOfFieldLimit);
  cell.prob = logistic(logodds);
  cell.state = stateOf(cell.prob, thresholds);
  cell.evidence = {logodds, evidence.occupied != 0 ? 1.0 : 0.0};
  return cell;
}

std::optional<CellEstimate> OverlappingHilbertMap::cell(const CellIndex& index,
                                                        const StateThresholds& thresholds) const
{
  if (structure_.planar && index.z != planarLayer_) return std::nullopt;
  const Evidence evidence = grid_.evidence(index);
  if (!evidence.any()) return std::nullopt;
  return estimate(evidence, thresholds);
}

std::optional<CellEstimate> OverlappingHilbertMap::at(const Eigen::Vector3d& point_m,
                                                      const StateThresholds& thresholds) const
{
  auto index = cellAt(point_m, structure_.resolution);
  if (!index) return std::nullopt;
  if (structure_.planar) index->z = planarLayer_;
  return cell(*index, thresholds);
}

Evidence OverlappingHilbertMap::evidenceAt(const Eigen::Vector3d& point_m, const CellIndex& cell) const
{
  Evidence sum = written_.evidence(cell);
  const HilbertModelIndex& models = index();
  models.forEachNear(point_m,
                     [&](size_t number)
                     {
                       const auto& [pose, model] = models_[number];
                       const ScanFrame frame(structure_.resolution, pose.anchor, false);
                       const auto local = frame.toLocal(point_m);
                       if (!local) return;
                       Eigen::Vector3d p = pose.toModel(*local * structure_.resolution);
                       if (structure_.planar) p.z() = shape_.flatHeight();
                       sum = addLogodds(sum, model->evidenceAt(shape_, p, models.firstWeightsOf(number)));
                     });
  return sum;
}

std::optional<CellEstimate> OverlappingHilbertMap::continuousAt(const Eigen::Vector3d& point_m,
                                                                const StateThresholds& thresholds) const
{
  requireModels("there is no continuous map to be asked");
  Eigen::Vector3d point = point_m;
  if (structure_.planar) point.z() = 0;
  auto cell = cellAt(point, structure_.resolution);
  if (!cell) return std::nullopt;
  if (structure_.planar) cell->z = planarLayer_;
  const Evidence evidence = evidenceAt(point, *cell);
  if (!evidence.any()) return std::nullopt;
  return estimate(evidence, thresholds);
}

OverlappingHilbertMap OverlappingHilbertMap::resampled(double resolution_m, const StateThresholds& thresholds,
                                                       unsigned threads) const
{
  requireModels("it cannot be resampled");
  OverlappingStructure structure = structure_;
  structure.resolution = resolution_m;
  OverlappingHilbertMap map(structure);
  for (const auto& [pose, model] : models_)
  {
    const ModelPose moved =
        ModelPose::of(pose.isometry(structure_.resolution), resolution_m, structure.planar);
    map.models_.push_back({moved, model});
    map.fuse(map.models_.back(), thresholds, nullptr, threads);
  }
  return map;
}

void OverlappingHilbertMap::visitCells(const StateThresholds& thresholds, const CellVisitor& visitor) const
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

std::optional<std::pair<CellIndex, CellIndex>> OverlappingHilbertMap::extent() const
{
  constexpr int32_t kMost = std::numeric_limits<int32_t>::max();
  CellIndex low{kMost, kMost, kMost};
  CellIndex high{-kMost, -kMost, -kMost};
  bool any = false;
  visitCells({},
             [&](const CellIndex& cell, const CellEstimate&)
             {
               any = true;
               low = {std::min(low.x, cell.x), std::min(low.y, cell.y), std::min(low.z, cell.z)};
               high = {std::max(high.x, cell.x), std::max(high.y, cell.y), std::max(high.z, cell.z)};
             });
  if (!any) return std::nullopt;
  return std::make_pair(low, high);
}

void OverlappingHilbertMap::addEvidence(const CellIndex& index, double logodds,
                                        const StateThresholds& thresholds)
{
  requireLegal(std::abs(logodds) <= 1000, "logodds", logodds, "a number from -1000 to 1000");
  CellIndex cell = index;
  if (structure_.planar) cell.z = planarLayer_;
  LogoddsSums sums;
  sums.inField = static_cast<int64_t>(std::floor(logodds / kEvidenceUnit + 0.5));
  LogoddsAdder adder(grid_.shape());
  adder.set(grid_.shape().offsetOf(cell), sums.evidence());
  const BlockIndex block = grid_.blockOf(cell);
  adder.addTo(grid_.findOrCreate(block), ruleFor(thresholds));
  adder.addTo(written_.findOrCreate(block), {});
}

Eigen::Isometry3d OverlappingHilbertMap::modelPose(size_t model) const
{
  return models_.at(model).pose.isometry(structure_.resolution);
}

void OverlappingHilbertMap::setModelPoses(const std::vector<MovedModel>& moved,
                                          const StateThresholds& thresholds, unsigned threads)
{
  requireModels("none can be moved");
  std::vector<std::pair<size_t, ModelPose>> poses;
  for (const auto& [number, pose] : moved)
  {
    (void)models_.at(number);
    poses.emplace_back(number, ModelPose::of(pose, structure_.resolution, structure_.planar));
  }
  if (!fusion_) fusion_ = std::make_unique<ModelFusion>(shape_, planarLayer_);
  std::vector<BlockIndex> touched;
  const auto touch = [&](const HilbertModel& model, const ModelPose& pose)
  {
    fusion_->choose(model, pose, grid_.shape(), Workers(threads));
    touched.insert(touched.end(), fusion_->blocks().begin(), fusion_->blocks().end());
  };
  for (const auto& [number, pose] : poses)
  {
    touch(*models_[number].model, models_[number].pose);
    touch(*models_[number].model, pose);
  }
  std::sort(touched.begin(), touched.end());
  touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
  for (const auto& [number, pose] : poses) models_[number].pose = pose;
  dropIndex();
  fuseAnew(touched, thresholds, threads);
}

void OverlappingHilbertMap::fuseAnew(const std::vector<BlockIndex>& blocks, const StateThresholds& thresholds,
                                     unsigned threads)
{
  BlockGrid written(grid_.shape());
  for (const BlockIndex& block : blocks)
  {
    grid_.erase(block);
    if (const EvidenceBlock* told = written_.find(block)) written.findOrCreate(block) = *told;
  }
  addGrid(written, grid_, ruleFor(thresholds));
  for (const PlacedModel& placed : models_) fuse(placed, thresholds, &blocks, threads);
}

void OverlappingHilbertMap::restore(std::vector<PlacedModel> models, PendingScans pending)
{
  const auto checkPose = [&](const ModelPose& pose)
  {
    try
    {
      (void)ModelPose::of(pose.isometry(structure_.resolution), structure_.resolution, structure_.planar);
    }
    catch (const std::invalid_argument& problem)
    {
      throw std::runtime_error(std::string("the map is corrupt: ") + problem.what());
    }
  };
  if (!structure_.keepModels && !models.empty())
    throw std::runtime_error("the map is corrupt: it has models that it does not keep");
  for (const PlacedModel& placed : models)
  {
    checkPose(placed.pose);
    placed.model->check(shape_);
  }
  if (!pending.scans.empty()) checkPose(pending.pose);
  models_ = std::move(models);
  pending_ = std::move(pending);
  dropIndex();
}

size_t OverlappingHilbertMap::modelBytes() const
{
  size_t bytes = models_.capacity() * sizeof(PlacedModel);
  for (const PlacedModel& placed : models_) bytes += placed.model->memoryBytes();
  return bytes;
}

size_t OverlappingHilbertMap::memoryBytes() const
{
  return grid_.memoryBytes() + written_.memoryBytes() + modelBytes();
}

bool operator==(const OverlappingHilbertMap& a, const OverlappingHilbertMap& b)
{
  return a.structure_ == b.structure_ && sameBlocks(a.grid_, b.grid_) && sameBlocks(a.written_, b.written_) &&
         a.models_.size() == b.models_.size() &&
         std::equal(a.models_.begin(), a.models_.end(), b.models_.begin(), sameModel) &&
         a.pending_.scans == b.pending_.scans &&
         (a.pending_.scans.empty() || a.pending_.pose == b.pending_.pose);
}

}  // namespace lamap
