#include <lamap_core/gp/scan_inference.h>

#include <lamap_core/gp/reading.h>
#include <lamap_core/gp/regression.h>
#include <lamap_core/grid/block_lists.h>
#include <lamap_core/grid/evidence_draft.h>
#include <lamap_core/scan/open_space.h>
#include <lamap_core/training/ray_widths.h>
#include <lamap_core/training/sampler.h>
#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

namespace lamap
{
namespace
{
/// First and last cell, along one axis and from the anchor, whose centre lies in [low, high].
std::pair<int32_t, int32_t> cellsBetween(double low, double high)
{
  return {static_cast<int32_t>(std::ceil(low - 0.5)), static_cast<int32_t>(std::floor(high - 0.5))};
}

/** Cuts points in two along the longest axis of their box until no part has more than `most`.
 * @param visit(first, count) for each part */
template <typename Visit>
void splitPoints(GpPoint* first, size_t count, size_t most, Visit&& visit)
{
  if (count <= most)
  {
    if (count > 0) visit(first, count);
    return;
  }
  Eigen::Vector3d low = first->place;
  Eigen::Vector3d high = first->place;
  for (size_t i = 1; i < count; ++i)
  {
    low = low.cwiseMin(first[i].place);
    high = high.cwiseMax(first[i].place);
  }
  Eigen::Index axis = 0;
  (high - low).maxCoeff(&axis);
  std::stable_sort(first, first + count,
                   [&](const GpPoint& a, const GpPoint& b) { return a.place[axis] < b.place[axis]; });
  splitPoints(first, count / 2, most, visit);
  splitPoints(first + count / 2, count - count / 2, most, visit);
}

/// A return is measured, free space beside a ray is inferred: chosen by the log loss of simulated surfaces.
constexpr double kLeastHits = 3;

/// The covariance for one set of options.
struct CovarianceFor
{
  CovarianceFor(const GpInference& inference, const GpStructure& structure, int farthest_cells)
      : lengthScale(inference.lengthScale),
        resolution(structure.resolution),
        signalVariance(structure.signalVariance),
        farthest(farthest_cells),
        covariance(lengthScale / resolution, signalVariance, farthest)
  {
  }
  [[nodiscard]] bool isFor(const GpInference& inference, const GpStructure& structure,
                           int farthest_cells) const
  {
    return lengthScale == inference.lengthScale && resolution == structure.resolution &&
           signalVariance == structure.signalVariance && farthest == farthest_cells;
  }

  double lengthScale;
  double resolution;
  double signalVariance;
  int farthest;
  GpCovariance covariance;
};

}  // namespace

class GpScanInference::Implementation
{
 public:
  Evidence infer(const Scan& scan, const GpInference& inference, const GpStructure& structure, int32_t layer,
                 const Workers& workers, RayCounts& counts);

 private:
  /// The training points of one block of the map.
  struct DataBlock
  {
    BlockIndex index;
    size_t begin;  ///< in points_
    size_t end;
    Eigen::Vector3d low;  ///< corners of the points' box [cells]
    Eigen::Vector3d high;
    size_t firstExpert = 0;  ///< in experts_, where GPs are nested
    size_t lastExpert = 0;
  };
  struct Labelled
  {
    BlockIndex block;
    GpPoint point;
  };
  /// Working memory of one thread.
  struct Worker
  {
    explicit Worker(const BlockShape& shape)
        : draft(shape), precision(shape.cellCount()), weighted(shape.cellCount()), touched(shape.maskWords())
    {
    }
    EvidenceDraft draft;
    std::vector<double> precision;  ///< Σ(1/σ² − 1/σ_f²); these are zero between blocks
    std::vector<double> weighted;   ///< Σ μ/σ²
    std::vector<uint64_t> touched;
    std::vector<GpPoint> points;
    GpExpert expert;
    GpExpert::Scratch scratch;
    GpExpert::Prediction prediction;
  };

  void labelPoints(const TrainingSet& training);
  [[nodiscard]] double noiseOf(const TrainingPoint& point) const;
  void listHitCells(const TrainingSet& training);
  void formDataBlocks();
  void findTargets();
  void trainExperts(tbb::enumerable_thread_specific<Worker>& workers);
  void inferBlock(size_t target, Worker& worker) const;
  void gatherAround(size_t target, const CellIndex& first, Worker& worker) const;
  void addExpert(const GpExpert& expert, const CellIndex& first, Worker& worker) const;
  void listViews(const SelectedRays& rays, const ScanFrame& frame);
  [[nodiscard]] bool isSeenFree(const CellIndex& local) const;
  void forgetUnseen(const CellIndex& first, Worker& worker) const;
  void keepHits(const BlockIndex& index, Worker& worker) const;
  void draftBlock(const BlockIndex& index, Worker& worker) const;

  Sampler sampler_;
  std::optional<CovarianceFor> covariance_;
  // Of the scan of which evidence is made.
  const Workers* workers_ = nullptr;
  BlockShape shape_{1, false};
  GpInference inference_;
  GpStructure structure_;
  CellIndex anchor_;
  double support_ = 0;  ///< [cells]
  std::vector<Labelled> labelled_;
  /// What one fan of rays saw, in the axes of the sensor.
  struct View
  {
    Eigen::Vector3d origin;  ///< [cells] from the anchor
    OpenSpace space;
  };
  std::vector<View> views_;
  Eigen::Matrix3d toSensor_;
  const TrainingSet* training_ = nullptr;
  std::vector<std::pair<BlockIndex, uint32_t>> hitCells_;  ///< by block: offsets of cells in which rays ended
  std::vector<GpPoint> points_;
  std::vector<DataBlock> dataBlocks_;
  std::vector<std::pair<size_t, size_t>> parts_;  ///< of points_, one an expert
  std::vector<GpExpert> experts_;
  ScanBlocks targets_;
  BlockLists targetLists_;  ///< data blocks that reach a target
};

GpScanInference::GpScanInference() : implementation_(std::make_unique<Implementation>()) {}
GpScanInference::~GpScanInference() = default;

Evidence GpScanInference::infer(const Scan& scan, const GpInference& inference, const GpStructure& structure,
                                int32_t layer, const Workers& workers, RayCounts& counts)
{
  return implementation_->infer(scan, inference, structure, layer, workers, counts);
}

Evidence GpScanInference::Implementation::infer(const Scan& scan, const GpInference& inference,
                                                const GpStructure& structure, int32_t layer,
                                                const Workers& workers, RayCounts& counts)
{
  inference_ = inference;
  structure_ = structure;
  workers_ = &workers;
  const SelectedRays rays = selectRays(scan, inference.rangeLimits(), structure.resolution);
  const ScanFrame frame = ScanFrame::around(rays.scan, structure.resolution,
                                            structure.planar ? std::optional(layer) : std::nullopt);
  anchor_ = frame.anchor();

  support_ = lengthInCells(*inference.kernelSupport, structure.resolution);
  shape_ = BlockShape(structure.blockDepth - 1, structure.planar);
  const bool inCells = inference.trainingPoints == TrainingPoints::Cells;
  const int farthest = inCells ? shape_.edge() + 2 * static_cast<int>(support_) + 2 : 0;
  if (!covariance_ || !covariance_->isFor(inference, structure, farthest))
    covariance_.emplace(inference, structure, farthest);

  const TrainingSet& training =
      sampler_.sample(rays, inference.samplingRules(), frame, BlockOffset(anchor_), workers.threads());
  counts = training.counts;
  training_ = &training;
  listViews(rays, frame);
  labelPoints(training);
  listHitCells(training);
  formDataBlocks();
  findTargets();

  tbb::enumerable_thread_specific<Worker> own([&] { return Worker(shape_); });
  if (inference.nested) trainExperts(own);
  workers.forEach(targets_.blocks().size(), [&](size_t target) { inferBlock(target, own.local()); });
  return collectEvidence(shape_, SumKind::Signed, own);
}

/// The scan's training points, in an order that depends on neither threads nor the place on the map.
void GpScanInference::Implementation::labelPoints(const TrainingSet& training)
{
  labelled_.clear();
  training.forEachPoint(
      [&](const TrainingPoint& point)
      {
        const CellIndex local = cellOfLocal(point.place);
        const CellIndex cell{anchor_.x + local.x, anchor_.y + local.y, anchor_.z + local.z};
        labelled_.push_back(
            {shape_.blockOf(cell), {point.place, point.occupied ? 1.0 : -1.0, noiseOf(point)}});
      });
  const auto orderOf = [](const Labelled& one)
  {
    const Eigen::Vector3d& place = one.point.place;
    return std::make_tuple(one.block.z, one.block.y, one.block.x, place.z(), place.y(), place.x(),
                           -one.point.label);
  };
  std::sort(labelled_.begin(), labelled_.end(),
            [&](const Labelled& a, const Labelled& b) { return orderOf(a) < orderOf(b); });
}

/** What a point adds to the noise of its label. A weight w makes it σ_n²/w, as w labels of this noise have it
 * together. An uncertain place adds its variance along each axis times that of the slope, which is 3σ_f²/l²
 * for the Matérn covariance with ν = 3/2. @param point [cells] */
double GpScanInference::Implementation::noiseOf(const TrainingPoint& point) const
{
  const double slope = 3 * structure_.signalVariance * structure_.resolution * structure_.resolution /
                       (inference_.lengthScale * inference_.lengthScale);
  const double ofWidth = (structure_.planar ? 2 : 3) * slope * point.width * point.width;
  return ofWidth + structure_.noiseVariance * (1 / point.weight - 1);
}

void GpScanInference::Implementation::listHitCells(const TrainingSet& training)
{
  hitCells_.clear();
  if (inference_.protectHits == 0) return;
  training.forEachCell(&BlockMasks::ended,
                       [&](const CellIndex& local)
                       {
                         const CellIndex cell{anchor_.x + local.x, anchor_.y + local.y, anchor_.z + local.z};
                         hitCells_.emplace_back(shape_.blockOf(cell), shape_.offsetOf(cell));
                       });
  std::sort(hitCells_.begin(), hitCells_.end());
}

void GpScanInference::Implementation::formDataBlocks()
{
  points_.clear();
  dataBlocks_.clear();
  for (const Labelled& one : labelled_)
  {
    if (dataBlocks_.empty() || !(dataBlocks_.back().index == one.block))
    {
      const size_t begin = points_.size();
      dataBlocks_.push_back({one.block, begin, begin, one.point.place, one.point.place});
    }
    DataBlock& block = dataBlocks_.back();
    points_.push_back(one.point);
    block.end = points_.size();
    block.low = block.low.cwiseMin(one.point.place);
    block.high = block.high.cwiseMax(one.point.place);
  }
}

/// The blocks of the map that have cells within the support of a data block's box.
void GpScanInference::Implementation::findTargets()
{
  std::vector<std::pair<BlockIndex, BlockIndex>> boxes;
  boxes.reserve(dataBlocks_.size());
  BlockIndex low;
  BlockIndex high;
  for (const DataBlock& block : dataBlocks_)
  {
    CellIndex first = anchor_;
    CellIndex last = anchor_;
    const auto reach = [&](Eigen::Index axis, int32_t CellIndex::*member)
    {
      const auto [from, to] = cellsBetween(block.low[axis] - support_, block.high[axis] + support_);
      first.*member += from;
      last.*member += to;
    };
    reach(0, &CellIndex::x);
    reach(1, &CellIndex::y);
    if (!structure_.planar) reach(2, &CellIndex::z);
    // Between the centres of cells a small support may reach none.
    last = {std::max(first.x, last.x), std::max(first.y, last.y), std::max(first.z, last.z)};
    const auto& [from, to] = boxes.emplace_back(shape_.blockOf(first), shape_.blockOf(last));
    const bool isFirst = boxes.size() == 1;
    low = isFirst ? from
                  : BlockIndex{std::min(low.x, from.x), std::min(low.y, from.y), std::min(low.z, from.z)};
    high = isFirst ? to : BlockIndex{std::max(high.x, to.x), std::max(high.y, to.y), std::max(high.z, to.z)};
  }
  targets_.reset(low, high);
  targetLists_.clear();
  for (size_t i = 0; i < boxes.size(); ++i)
  {
    const auto& [from, to] = boxes[i];
    forEachBlock(from, to,
                 [&, item = static_cast<uint32_t>(i)](const BlockIndex& target)
                 { targetLists_.add(targets_.findOrAdd(target), item); });
  }
  targetLists_.sort(targets_.blocks().size());
}

void GpScanInference::Implementation::trainExperts(tbb::enumerable_thread_specific<Worker>& workers)
{
  parts_.clear();
  for (DataBlock& block : dataBlocks_)
  {
    block.firstExpert = parts_.size();
    splitPoints(points_.data() + block.begin, block.end - block.begin, inference_.maxPoints,
                [&](const GpPoint* first, size_t count)
                { parts_.emplace_back(static_cast<size_t>(first - points_.data()), count); });
    block.lastExpert = parts_.size();
  }
  experts_.resize(parts_.size());
  workers_->forEach(parts_.size(),
                    [&](size_t i)
                    {
                      experts_[i].train(points_.data() + parts_[i].first, parts_[i].second,
                                        covariance_->covariance, structure_.noiseVariance,
                                        workers.local().scratch);
                    });
}

/// All training points within the support of the block: of the box of its cells' centres.
void GpScanInference::Implementation::gatherAround(size_t target, const CellIndex& first,
                                                   Worker& worker) const
{
  worker.points.clear();
  const Eigen::Vector3d low(first.x + 0.5, first.y + 0.5, first.z + 0.5);
  const double width = shape_.edge() - 1;
  const Eigen::Vector3d high = low + Eigen::Vector3d(width, width, shape_.planar() ? 0.0 : width);
  for (const uint32_t i : targetLists_.of(target))
  {
    for (size_t p = dataBlocks_[i].begin; p < dataBlocks_[i].end; ++p)
    {
      const Eigen::Vector3d& place = points_[p].place;
      const Eigen::Vector3d outside = (low - place).cwiseMax(place - high).cwiseMax(0.0);
      if (outside.squaredNorm() < support_ * support_) worker.points.push_back(points_[p]);
    }
  }
}

void GpScanInference::Implementation::inferBlock(size_t target, Worker& worker) const
{
  const BlockIndex& index = targets_.blocks()[target];
  const CellIndex cell = shape_.firstCellOf(index);
  const CellIndex first{cell.x - anchor_.x, cell.y - anchor_.y, cell.z - anchor_.z};
  if (inference_.nested)
  {
    for (const uint32_t i : targetLists_.of(target))
      for (size_t e = dataBlocks_[i].firstExpert; e < dataBlocks_[i].lastExpert; ++e)
        addExpert(experts_[e], first, worker);
  }
  else
  {
    gatherAround(target, first, worker);
    splitPoints(worker.points.data(), worker.points.size(), inference_.maxPoints,
                [&](const GpPoint* part, size_t count)
                {
                  worker.expert.train(part, count, covariance_->covariance, structure_.noiseVariance,
                                      worker.scratch);
                  addExpert(worker.expert, first, worker);
                });
  }
  if (inference_.protectHits > 0) forgetUnseen(first, worker);
  keepHits(index, worker);
  draftBlock(index, worker);
}

/// Adds what an expert says of the cells of a block. @param first cell of the block, from the anchor
void GpScanInference::Implementation::addExpert(const GpExpert& expert, const CellIndex& first,
                                                Worker& worker) const
{
  std::array<std::pair<int32_t, int32_t>, 3> box;
  for (Eigen::Index axis = 0; axis < 3; ++axis)
  {
    const int32_t from = axis == 0 ? first.x : axis == 1 ? first.y : first.z;
    auto [low, high] = cellsBetween(expert.low()[axis] - support_, expert.high()[axis] + support_);
    const int32_t last = axis == 2 && shape_.planar() ? 0 : shape_.edge() - 1;
    box[static_cast<size_t>(axis)] = {std::max(low - from, 0), std::min(high - from, last)};
  }
  constexpr size_t kTile = std::tuple_size_v<GpTile>;
  const double squaredSupport = support_ * support_;
  const double priorPrecision = 1.0 / structure_.signalVariance;
  GpPlaces places;
  std::array<uint32_t, kTile> offsets;
  size_t used = 0;
  const auto flush = [&]
  {
    if (used == 0) return;
    for (size_t c = used; c < kTile; ++c)
    {
      places.x[c] = places.x[used - 1];
      places.y[c] = places.y[used - 1];
      places.z[c] = places.z[used - 1];
    }
    GpExpert::Prediction& said = worker.prediction;
    if (expert.predict(places, squaredSupport, covariance_->covariance, worker.scratch, said))
    {
      for (size_t c = 0; c < used; ++c)
      {
        if (!(said.nearest[c] < squaredSupport)) continue;
        const uint32_t offset = offsets[c];
        const double precision = 1.0 / said.variance[c];
        worker.precision[offset] += precision - priorPrecision;  // Eq. (2.29)
        worker.weighted[offset] += precision * said.mean[c];     // Eq. (2.28)
        worker.touched[offset >> 6] |= uint64_t{1} << (offset & 63);
      }
    }
    used = 0;
  };
  for (int32_t z = box[2].first; z <= box[2].second; ++z)
    for (int32_t y = box[1].first; y <= box[1].second; ++y)
      for (int32_t x = box[0].first; x <= box[0].second; ++x)
      {
        places.x[used] = first.x + x + 0.5;
        places.y[used] = first.y + y + 0.5;
        places.z[used] = first.z + z + 0.5;
        offsets[used] = shape_.offsetOfLocal(static_cast<uint32_t>(x), static_cast<uint32_t>(y),
                                             static_cast<uint32_t>(z));
        if (++used == kTile) flush();
      }
  flush();
}

void GpScanInference::Implementation::listViews(const SelectedRays& rays, const ScanFrame& frame)
{
  views_.clear();
  if (inference_.protectHits == 0) return;
  // Of a planar map in the plane of the map, else in the axes of the sensor, along which rays are regular.
  const Scan& scan = rays.scan;
  const bool planar = structure_.planar;
  toSensor_ =
      planar ? Eigen::Matrix3d::Identity() : Eigen::Matrix3d(scan.sensorPose_map.linear().transpose());
  for (const RayFan& fan : scan.fans)
  {
    const auto origin = frame.toLocal(scan.inMap(fan.centre));
    if (!origin || fan.rays.empty()) continue;
    const BeamCone cone = coneOf(scan, fan, inference_.beamWidth, planar);
    std::vector<Eigen::Vector3d> ends;
    ends.reserve(fan.rays.size());
    std::vector<Eigen::Vector3d> bundle;
    for (const Ray& ray : fan.rays)
    {
      cone.spreadByAngle(fan.directionOf(ray), bundle);
      for (const Eigen::Vector3d& end : bundle)
      {
        ends.push_back(planar ? scan.turnedToMap(end) : end);
        if (planar) ends.back().z() = 0;
      }
    }
    views_.push_back({*origin, OpenSpace::between(ends)});
  }
}

/// Whether a ray passes through a cell, or the rays on all its sides reach farther. Not so of one that the
/// echo of a wide beam may have come from.
bool GpScanInference::Implementation::isSeenFree(const CellIndex& local) const
{
  const bool isInCap =
      training_->isIn(&BlockMasks::protectedHit, local) && !training_->isIn(&BlockMasks::ended, local);
  if (isInCap) return false;
  if (training_->holdsFree(local)) return true;
  const Eigen::Vector3d centre(local.x + 0.5, local.y + 0.5, local.z + 0.5);
  return std::any_of(views_.begin(), views_.end(),
                     [&](const View& view)
                     {
                       const Eigen::Vector3d place =
                           toSensor_ * ((centre - view.origin) * structure_.resolution);
                       return view.space.reaches(place);
                     });
}

/** Forgets what the block's processes said of cells that they call free though no ray saw them free: a floor
 * between the rings of a lidar, which lies behind the ends of the rays below it. */
void GpScanInference::Implementation::forgetUnseen(const CellIndex& first, Worker& worker) const
{
  const int layers = shape_.planar() ? 1 : shape_.edge();
  for (int z = 0; z < layers; ++z)
    for (int y = 0; y < shape_.edge(); ++y)
      for (int x = 0; x < shape_.edge(); ++x)
      {
        const uint32_t offset = shape_.offsetOfLocal(static_cast<uint32_t>(x), static_cast<uint32_t>(y),
                                                     static_cast<uint32_t>(z));
        if (worker.weighted[offset] >= 0 || isSeenFree({first.x + x, first.y + y, first.z + z})) continue;
        worker.precision[offset] = worker.weighted[offset] = 0;
        worker.touched[offset >> 6] &= ~(uint64_t{1} << (offset & 63));
      }
}

/** Cells in which rays of the scan ended say at least what a GP says that knows kLeastHits hits there and
 * nothing else: Σ(1/σ² − 1/σ_f²) and Σ μ/σ² are kLeastHits/σ_n². Else the free space around a thin thing,
 * which is far more, would call it free by smoothness alone. */
void GpScanInference::Implementation::keepHits(const BlockIndex& index, Worker& worker) const
{
  const double hitPrecision = kLeastHits / structure_.noiseVariance;
  const auto first = std::lower_bound(hitCells_.begin(), hitCells_.end(), std::make_pair(index, uint32_t{0}));
  for (auto hit = first; hit != hitCells_.end() && hit->first == index; ++hit)
  {
    const uint32_t offset = hit->second;
    worker.precision[offset] = std::max(worker.precision[offset], hitPrecision);
    worker.weighted[offset] = std::max(worker.weighted[offset], hitPrecision);
    worker.touched[offset >> 6] |= uint64_t{1} << (offset & 63);
  }
}

/// Rounds the block's sums, drafts its evidence, and makes them zero again.
void GpScanInference::Implementation::draftBlock(const BlockIndex& index, Worker& worker) const
{
  for (size_t word = 0; word < worker.touched.size(); ++word)
  {
    for (uint64_t rest = std::exchange(worker.touched[word], 0); rest != 0; rest &= rest - 1)
    {
      const auto offset = static_cast<uint32_t>(word * 64 + static_cast<size_t>(__builtin_ctzll(rest)));
      const double precision = std::exchange(worker.precision[offset], 0.0);
      const double weighted = std::exchange(worker.weighted[offset], 0.0);
      worker.draft.set(offset, GpReading::sumsOf(structure_, precision, weighted).coded());
    }
  }
  worker.draft.finishBlock(index);
}

}  // namespace lamap
