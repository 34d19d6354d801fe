#include <lamap_core/hilbert/map.h>

#include <lamap_core/hilbert/kept_points.h>
#include <lamap_core/hilbert/model.h>
#include <lamap_core/hilbert/reached_cells.h>
#include <lamap_core/hilbert/seen_cells.h>
#include <lamap_core/math/portable_math.h>
#include <lamap_core/math/workers.h>
#include <lamap_core/training/sampler.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>

namespace lamap
{
namespace
{
CellEstimate estimateOf(double logodds, const StateThresholds& thresholds)
{
  CellEstimate cell;
  cell.prob = logistic(logodds);
  cell.state = stateOf(cell.prob, thresholds);
  cell.evidence = {logodds, 0};
  return cell;
}

std::optional<double> logoddsOrNothing(const ReachedLogodds& answer)
{
  return answer.reached ? std::optional<double>(answer.logodds) : std::nullopt;
}

}  // namespace

struct HilbertMap::Learned
{
  explicit Learned(const HilbertStructure& structure) : model(MapModel::make(structure)) {}
  Learned(const Learned& other)
      : model(other.model->clone()),
        seenCells(other.seenCells),
        kept(other.kept),
        extent(other.extent),
        lastInference(other.lastInference),
        lastThreads(other.lastThreads),
        stale(other.stale.load())
  {
  }
  Learned& operator=(const Learned&) = delete;

  /// Batch: keeps a set for the next training, which then cannot fail for want of room; if this fails,
  /// nothing is changed. @throws std::length_error if there is no room
  void keep(const HilbertTrainingSet& set, const HilbertFrame& frame, const HilbertInference& inference,
            const HilbertStructure& structure, unsigned threads)
  {
    const bool atCentres = inference.trainingPoints == HilbertPoints::Cells && set.covariances.empty();
    MapModel::Extent all = extent;
    all.extend(model->extentOf(set, frame));
    if (!model->isSurelyRoomFor(kept.size() + set.size(), all))
    {
      KeptPoints together = kept;
      together.add(set, frame, atCentres);
      const auto [jointFrame, jointSet] = together.trainingSet(structure);
      model->requireRoomFor(jointSet, jointFrame);
    }
    kept.add(set, frame, atCentres);
    extent = all;
    lastInference = inference;
    lastThreads = threads;
    stale = true;
  }

  std::unique_ptr<MapModel> model;
  SeenCells seenCells;
  // Batch: what the next training is to learn, and how.
  KeptPoints kept;
  MapModel::Extent extent;  ///< of these
  HilbertInference lastInference;
  unsigned lastThreads = 0;
  std::atomic<bool> stale{false};
  std::mutex training;
};

/// Working memory of insert().
struct HilbertMap::Sampling
{
  Sampler sampler;
  HilbertTrainingSet set;
};

HilbertMap::HilbertMap(const HilbertStructure& structure) : structure_(structure)
{
  structure_.validate();
  learned_ = std::make_unique<Learned>(structure_);
}

HilbertMap::HilbertMap(const HilbertMap& other) : structure_(other.structure_)
{
  const std::lock_guard<std::mutex> lock(other.learned_->training);
  learned_ = std::make_unique<Learned>(*other.learned_);
}

HilbertMap& HilbertMap::operator=(const HilbertMap& other)
{
  if (this != &other) *this = HilbertMap(other);
  return *this;
}

HilbertMap::HilbertMap(HilbertMap&&) noexcept = default;
HilbertMap& HilbertMap::operator=(HilbertMap&&) noexcept = default;
HilbertMap::~HilbertMap() = default;

RayCounts HilbertMap::insert(const Scan& scan, const HilbertInference& inference,
                             const HilbertUncertainty* uncertainty, unsigned threads)
{
  inference.validate(structure_);
  if (uncertainty != nullptr) uncertainty->validate();
  const SelectedRays rays = selectRays(scan, inference.rangeLimits(), structure_.resolution);
  const auto layer = structure_.planarLayer();
  auto frame = HilbertFrame::atCell(ScanFrame::around(rays.scan, structure_.resolution, layer).anchor(),
                                    structure_.resolution, structure_.latticeSpacing, structure_.planar);
  if (!frame)
    frame = HilbertFrame::atCell({0, 0, layer.value_or(0)}, structure_.resolution, structure_.latticeSpacing,
                                 structure_.planar);
  const CellIndex anchor = frame->cells.anchor();
  if (!sampling_) sampling_ = std::make_unique<Sampling>();
  const TrainingSet& taught =
      sampling_->sampler.sample(rays, inference.rules(inference), frame->cells, {}, 1);
  HilbertTrainingSet& set = sampling_->set;
  set.clear();
  set.append(taught, *frame);
  if (set.size() == 0) return taught.counts;
  SeenCells::IsCertain isCertain;
  HilbertUncertainty local;
  if (uncertainty != nullptr && uncertainty->any())
  {
    const Eigen::Vector3d corner = cornerOf(frame->anchorSite, frame->spacing_m);
    const Eigen::Vector3d sensor = rays.firstCentre_map() - corner;
    local = *uncertainty;
    local.centre -= corner;
    set.blur(0, local, sensor, structure_.resolvedGamma(), structure_.planar);
    isCertain = [&, sensor](const CellIndex& cell)
    {
      const Eigen::Vector3d fromAnchor(cell.x - anchor.x, cell.y - anchor.y, cell.z - anchor.z);
      const Eigen::Vector3d centre = frame->position(fromAnchor + Eigen::Vector3d::Constant(0.5));
      return countsInItsCell(local.of(centre, sensor), structure_.resolution, structure_.planar);
    };
  }

  const bool countsScans = inference.rules().protectHits > 0;
  if (countsScans) learned_->seenCells.makeRoomFor(taught, anchor, isCertain);
  if (structure_.training == HilbertTraining::Batch)
    learned_->keep(set, *frame, inference, structure_, threads);
  else
    learned_->model->learn(set, *frame, inference, Workers(threads));
  if (countsScans) learned_->seenCells.count(taught, anchor, isCertain);
  return taught.counts;
}

// ---- Batch

bool HilbertMap::isStale() const
{
  return learned_->stale.load(std::memory_order_acquire);
}

void HilbertMap::train(unsigned threads) const
{
  if (!isStale()) return;
  const std::lock_guard<std::mutex> lock(learned_->training);
  if (!isStale()) return;
  // Weights that are too small for their numbers are none: there may be nothing to learn.
  if (learned_->kept.size() > 0)
  {
    auto [frame, set] = learned_->kept.trainingSet(structure_);
    auto model = MapModel::make(structure_);
    model->learn(set, frame, learned_->lastInference, Workers(threads));
    model->freeWorkspace();
    learned_->model = std::move(model);
  }
  learned_->stale.store(false, std::memory_order_release);
}

const MapModel& HilbertMap::trained() const
{
  train(learned_->lastThreads);
  return *learned_->model;
}

void HilbertMap::clear()
{
  learned_ = std::make_unique<Learned>(structure_);
}

bool HilbertMap::empty() const
{
  return learned_->model->lattice().blockCount() == 0 && trainingPointCount() == 0;
}

// ---- Questions

/// Is a point so certain that its cell's rays speak of it?
std::optional<PointAtSite> HilbertMap::placeOf(const Eigen::Vector3d& point_map) const
{
  std::array<int32_t, 3> site{};
  PointAtSite point;
  for (int axis = 0; axis < (structure_.planar ? 2 : 3); ++axis)
  {
    constexpr double kLastSite = 1 << 30;
    const double number = std::floor(point_map[axis] / structure_.latticeSpacing);
    if (!(std::abs(number) < kLastSite)) return std::nullopt;
    site[static_cast<size_t>(axis)] = static_cast<int32_t>(number);
    point.place[axis] = point_map[axis] - number * structure_.latticeSpacing;
  }
  point.anchorSite = {site[0], site[1], site[2]};
  return point;
}

/// Adds what the rays of the cell that holds a point said.
void HilbertMap::addScansAt(const Eigen::Vector3d& point_map, ReachedLogodds& said) const
{
  Eigen::Vector3d place = point_map;
  if (structure_.planar) place.z() = 0;
  auto cell = cellAt(place, structure_.resolution);
  if (!cell) return;
  if (const auto layer = structure_.planarLayer()) cell->z = *layer;
  learned_->seenCells.addTo(*cell, said);
}

std::optional<double> HilbertMap::logoddsAt(const Eigen::Vector3d& point_map) const
{
  const MapModel& model = trained();
  const auto point = placeOf(point_map);
  if (!point) return std::nullopt;
  ReachedLogodds said = model.at(*point);
  addScansAt(point_map, said);
  return logoddsOrNothing(said);
}

std::optional<double> HilbertMap::logoddsAt(const Eigen::Vector3d& point_map,
                                            const Eigen::Matrix3d& covariance) const
{
  const MapModel& model = trained();
  const auto point = placeOf(point_map);
  if (!point) return std::nullopt;
  const Eigen::Matrix3d covered = structure_.planar ? inPlane(covariance) : covariance;
  ReachedLogodds said = model.at(*point, covered);
  if (countsInItsCell(covered, structure_.resolution, structure_.planar)) addScansAt(point_map, said);
  return logoddsOrNothing(said);
}

std::optional<double> HilbertMap::logoddsOf(const CellIndex& cell) const
{
  const MapModel& model = trained();
  if (structure_.planar && cell.z != *structure_.planarLayer()) return std::nullopt;
  const auto frame =
      HilbertFrame::atCell(cell, structure_.resolution, structure_.latticeSpacing, structure_.planar);
  if (!frame) return std::nullopt;
  ReachedLogodds said = model.at({frame->anchorSite, frame->position({0.5, 0.5, 0.5})});
  learned_->seenCells.addTo(cell, said);
  return logoddsOrNothing(said);
}

void HilbertMap::logoddsAt(const std::vector<Eigen::Vector3d>& points_map,
                           std::vector<ReachedLogodds>& out) const
{
  const MapModel& model = trained();
  out.assign(points_map.size(), {});
  for (size_t i = 0; i < points_map.size(); ++i)
  {
    const auto point = placeOf(points_map[i]);
    if (!point) continue;
    out[i] = model.at(*point);
    addScansAt(points_map[i], out[i]);
  }
}

void HilbertMap::logoddsOf(const CellIndex& first, const std::array<int, 3>& counts,
                           std::vector<ReachedLogodds>& out) const
{
  const MapModel& model = trained();
  const auto frame =
      HilbertFrame::atCell(first, structure_.resolution, structure_.latticeSpacing, structure_.planar);
  const RegularPoints points{frame ? frame->position({0.5, 0.5, 0.5}) : Eigen::Vector3d::Zero(),
                             structure_.resolution, counts};
  out.assign(points.size(), {});
  if (!frame || (structure_.planar && first.z != *structure_.planarLayer())) return;
  model.atRegular(frame->anchorSite, points, out);
  learned_->seenCells.addTo(first, counts, out);
}

// ---- Cells

void HilbertMap::visitCells(const CellVisitor& visitor, unsigned threads) const
{
  const std::vector<BlockIndex> blocks = ReachedCells(structure_, trained().lattice()).blocks();
  const Workers workers(threads);
  const std::array<int, 3> counts{kScanBlockEdge, kScanBlockEdge, structure_.planar ? 1 : kScanBlockEdge};
  const auto firstOf = [&](const BlockIndex& block)
  {
    return CellIndex{block.x * kScanBlockEdge, block.y * kScanBlockEdge,
                     structure_.planar ? block.z : block.z * kScanBlockEdge};
  };
  constexpr size_t kBatch = 256;  // blocks that are asked together, then visited in their order
  std::vector<std::vector<ReachedLogodds>> answers(std::min(kBatch, blocks.size()));
  for (size_t begin = 0; begin < blocks.size(); begin += kBatch)
  {
    const size_t count = std::min(kBatch, blocks.size() - begin);
    workers.forEach(count, [&](size_t i) { logoddsOf(firstOf(blocks[begin + i]), counts, answers[i]); });
    for (size_t block = 0; block < count; ++block)
    {
      const CellIndex first = firstOf(blocks[begin + block]);
      size_t i = 0;
      for (int z = 0; z < counts[2]; ++z)
        for (int y = 0; y < counts[1]; ++y)
          for (int x = 0; x < counts[0]; ++x, ++i)
          {
            const ReachedLogodds& answer = answers[block][i];
            if (answer.reached)
              visitor({first.x + x, first.y + y, first.z + z}, static_cast<double>(answer.logodds));
          }
    }
  }
}

std::optional<std::pair<CellIndex, CellIndex>> HilbertMap::cellBounds() const
{
  const MapModel& model = trained();
  std::array<int32_t, 3> low = model.reachedBox().low;
  std::array<int32_t, 3> high = model.reachedBox().high;
  if (model.isUncertain())
  {
    // Cells near uncertain points may be reached or not: whole layers without any are left off.
    const auto bounds = ReachedCells(structure_, model.lattice()).bounds();
    if (!bounds) return std::nullopt;
    low = {bounds->first.x, bounds->first.y, bounds->first.z};
    high = {bounds->second.x, bounds->second.y, bounds->second.z};
    for (size_t axis = 0; axis < 3; ++axis)
    {
      auto layer = high;
      while (low[axis] <= high[axis] && !isAnyReached(low, (layer[axis] = low[axis], layer))) ++low[axis];
      if (low[axis] > high[axis]) return std::nullopt;
      layer = low;
      while (!isAnyReached((layer[axis] = high[axis], layer), high)) --high[axis];
    }
  }
  else if (!model.reachedBox().any())
    return std::nullopt;
  return std::make_pair(CellIndex{low[0], low[1], low[2]}, CellIndex{high[0], high[1], high[2]});
}

/// Does a box hold a cell with evidence?
bool HilbertMap::isAnyReached(const std::array<int32_t, 3>& low, const std::array<int32_t, 3>& high) const
{
  constexpr int kEdge = kScanBlockEdge;
  std::vector<ReachedLogodds> answers;
  for (int32_t z = low[2]; z <= high[2]; z += kEdge)
    for (int32_t y = low[1]; y <= high[1]; y += kEdge)
      for (int32_t x = low[0]; x <= high[0]; x += kEdge)
      {
        logoddsOf({x, y, z},
                  {std::min(kEdge, high[0] - x + 1), std::min(kEdge, high[1] - y + 1),
                   std::min(kEdge, high[2] - z + 1)},
                  answers);
        if (std::any_of(answers.begin(), answers.end(),
                        [](const ReachedLogodds& answer) { return answer.reached; }))
          return true;
      }
  return false;
}

int HilbertMap::emptyAround(const CellIndex& cell) const
{
  return trained().emptyAround(cell);
}

// ---- What was learned

size_t HilbertMap::weightCount() const
{
  return trained().weightCount();
}

size_t HilbertMap::trainingPointCount() const
{
  return learned_->kept.size();
}

size_t HilbertMap::memoryBytes() const
{
  return learned_->model->memoryBytes() + learned_->seenCells.memoryBytes() + learned_->kept.memoryBytes();
}

const HilbertLattice<SitePosterior>& HilbertMap::lattice() const
{
  return trained().lattice();
}

HilbertState HilbertMap::state() const
{
  HilbertState state;
  trained().save(state);
  learned_->seenCells.save(state);
  learned_->kept.save(state);
  return state;
}

void HilbertMap::restore(const HilbertState& state)
{
  auto learned = std::make_unique<Learned>(structure_);
  learned->model->restore(state);
  HilbertState::require(
      structure_.training == HilbertTraining::Batch || (state.cells.empty() && state.points.empty()),
      "training points, though its training is not `batch`");
  learned->seenCells.restore(state, structure_);
  learned->kept.restore(state, structure_);
  if (learned->kept.size() > 0)
  {
    const auto [frame, set] = learned->kept.trainingSet(structure_);
    learned->extent = learned->model->extentOf(set, frame);
  }
  learned_ = std::move(learned);
}

std::optional<CellEstimate> HilbertMap::at(const Eigen::Vector3d& point_map,
                                           const StateThresholds& thresholds) const
{
  const auto logodds = logoddsAt(point_map);
  if (!logodds) return std::nullopt;
  return estimateOf(*logodds, thresholds);
}

std::optional<CellEstimate> HilbertMap::cell(const CellIndex& cell, const StateThresholds& thresholds) const
{
  const auto logodds = logoddsOf(cell);
  if (!logodds) return std::nullopt;
  return estimateOf(*logodds, thresholds);
}

void HilbertMap::visitCells(const StateThresholds& thresholds, const EstimateVisitor& visitor,
                            unsigned threads) const
{
  visitCells([&](const CellIndex& cell, double logodds) { visitor(cell, estimateOf(logodds, thresholds)); },
             threads);
}

}  // namespace lamap
