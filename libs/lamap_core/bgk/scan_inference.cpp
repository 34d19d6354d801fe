#include <lamap_core/bgk/scan_inference.h>

#include <lamap_core/bgk/cell_stencil.h>
#include <lamap_core/bgk/evidence_table.h>
#include <lamap_core/bgk/point_sums.h>
#include <lamap_core/bgk/wide_cells.h>
#include <lamap_core/grid/block_lists.h>
#include <lamap_core/grid/evidence_draft.h>
#include <lamap_core/training/sampler.h>
#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <stdexcept>

namespace lamap
{
namespace
{
constexpr int kEdge = kScanBlockEdge;

/** How much free evidence counts in cells that no ray of the scan passed (3D, `beamWidth` = spacing).
 *
 * Kernels fill the gaps between samples, but reach beyond the open space, too: into the floor below the
 * lowest beam, or into a wall that was not hit. A cell of a flat surface has no more free cells around it
 * than the half-space before it; what is not clearly more says almost nothing. Both numbers were chosen by
 * the log loss of simulated surfaces and solids. */
class UnseenSpace
{
 public:
  explicit UnseenSpace(const CellStencil& free)
  {
    const uint64_t beside = free.scale().evidence(free.sumBesidePlane());
    least_ = beside + beside / 8;
  }
  /// @param evidence of kernels alone, in units of cells. @return what of it counts; positive if it is
  [[nodiscard]] uint64_t counted(uint64_t evidence) const
  {
    if (evidence == 0 || evidence >= least_) return evidence;
    return std::max<uint64_t>(1, (evidence + kShare / 2) / kShare);
  }

 private:
  static constexpr uint64_t kShare = 128;
  uint64_t least_;
};

/// Kernels and stencils in cells, for one set of options.
struct Weights
{
  Weights(const BgkInference& options, double resolution_m, bool isPlanar)
      : inference(options),
        resolution(resolution_m),
        planar(isPlanar),
        kernels(options.kernel, lengthInCells(*options.kernelSupport, resolution_m), options.kernelScale,
                isPlanar),
        hitStencil(kernels.sharp(), 1.0, isPlanar)
  {
    if (options.freeWeight > 0)
    {
      freeStencil.emplace(kernels.sharp(), options.freeWeight, isPlanar);
      if (options.noEchoWeight > 0)
        silentStencil.emplace(kernels.sharp(), options.freeWeight * options.noEchoWeight, isPlanar,
                              freeStencil->scale());
      if (!isPlanar && options.keepsUnseenSpace()) unseen.emplace(*freeStencil);
    }
    if (!EvidenceTable::isTabulable(hitStencil)) return;
    if (freeStencil && !EvidenceTable::isTabulable(*freeStencil)) return;
    hitTable.emplace(hitStencil, isPlanar);
    if (freeStencil) freeTable.emplace(*freeStencil, isPlanar);
  }

  [[nodiscard]] bool areFor(const BgkInference& options, double resolution_m, bool isPlanar) const
  {
    return options == inference && resolution_m == resolution && isPlanar == planar;
  }

  BgkInference inference;
  double resolution;
  bool planar;
  KernelsByWidth kernels;
  CellStencil hitStencil;
  std::optional<CellStencil> freeStencil;
  std::optional<CellStencil> silentStencil;  ///< its sums are in the unit of those of freeStencil
  std::optional<UnseenSpace> unseen;         ///< missing: free evidence counts wherever it reaches
  std::optional<EvidenceTable> hitTable;     ///< missing: the stencils cannot be tabulated
  std::optional<EvidenceTable> freeTable;
};

/// First and last cell of a block that carry a mark, along each axis; nothing if none does.
std::optional<std::pair<CellIndex, CellIndex>> markedBox(const BlockMasks& masks)
{
  uint64_t all = 0;
  int zFirst = kEdge;
  int zLast = -1;
  for (int z = 0; z < kEdge; ++z)
  {
    const auto layer = static_cast<size_t>(z);
    const uint64_t word = masks.hit[layer] | masks.free[layer] | masks.silent[layer];
    if (word == 0) continue;
    all |= word;
    zFirst = std::min(zFirst, z);
    zLast = z;
  }
  if (all == 0) return std::nullopt;
  uint64_t columns = all;
  for (int shift = 32; shift >= 8; shift /= 2) columns |= columns >> shift;
  columns &= 0xFF;
  const int lowest = __builtin_ctzll(all);
  const int highest = 63 - __builtin_clzll(all);
  return std::make_pair(CellIndex{__builtin_ctzll(columns), lowest / kEdge, zFirst},
                        CellIndex{63 - __builtin_clzll(columns), highest / kEdge, zLast});
}

/// Calls visit(cell) for each marked cell, by its place among a block's sums.
template <typename Visit>
void forEachCell(const CellMask& mask, Visit&& visit)
{
  for (size_t z = 0; z < mask.size(); ++z)
    for (uint64_t rest = mask[z]; rest != 0; rest &= rest - 1)
      visit(z * kEdge * kEdge + static_cast<size_t>(__builtin_ctzll(rest)));
}

void clearSums(const Layers& layers, BlockSums& sums)
{
  if (!layers.any()) return;
  constexpr int kLayer = kEdge * kEdge;
  std::fill(sums.begin() + layers.begin * kLayer, sums.begin() + layers.end * kLayer, int64_t{0});
}

/** Adds the sums of wide points, rounded to 1/4096 of a sharp point's weight at its own cell: finer digits
 * are beyond what widths are known to, but would double the size of map files. */
Layers addWide(const WideCells::Sums* wide, double factor, const WeightScale& scale, BlockSums& sums)
{
  if (wide == nullptr) return {};
  constexpr double kUnit = 1.0 / 4096;
  Layers reached;
  for (size_t cell = 0; cell < sums.size(); ++cell)
  {
    const auto units = static_cast<int64_t>(factor * (*wide)[cell] / kUnit + 0.5);
    if (units == 0) continue;
    sums[cell] += scale.quantized(static_cast<double>(units) * kUnit);
    const int z = static_cast<int>(cell) / (kEdge * kEdge);
    reached.include({z, z + 1});
  }
  return reached;
}

BlockIndex operator+(const BlockIndex& a, const BlockIndex& b)
{
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}

}  // namespace

class BgkScanInference::Implementation
{
 public:
  Evidence infer(const Scan& scan, const BgkInference& inference, const BgkStructure& structure,
                 int32_t layer, const Workers& workers, RayCounts& counts);

 private:
  /// Working memory of one thread.
  struct Worker
  {
    explicit Worker(const BlockShape& shape) : draft(shape) {}
    BlockSums occupied{};  ///< all zero between blocks
    BlockSums free{};
    EvidenceTable::BlockEvidence occupiedEvidence{};  ///< all zero between blocks
    EvidenceTable::BlockEvidence freeEvidence{};
    std::array<uint64_t, kScanBlockCells> cells{};
    EvidenceDraft draft;
    std::vector<const BlockMasks*> neighbours;
    MaskNeighbourhood neighbourhood;
  };

  [[nodiscard]] bool sumWideCells(const Workers& workers);
  [[nodiscard]] double farthestReach() const;
  void findTargets();
  void addTargetsAround(const BlockIndex& block, const CellIndex& first, const CellIndex& last);
  void addTargetsAround(const std::vector<PlacedPoint>& points, BlockLists& lists);
  void addTargetsAround(const std::vector<FreeSegment>& segments);
  void addTargetsBetween(const Eigen::Vector3d& low, const Eigen::Vector3d& high, BlockLists& lists,
                         uint32_t item);
  void groupTargets(int log2BlockEdge);
  void tabulatePartOffsets(const BlockShape& shape);
  template <typename Visit>
  void forEachUnseen(int32_t block, const Layers& layers, Visit&& visit) const;
  Layers sumBlock(size_t target, Worker& worker) const;
  void findNeighbours(const BlockIndex& block, Worker& worker) const;
  bool findMarked(CellMask BlockMasks::*mask, bool BlockMasks::*any, Worker& worker) const;
  [[nodiscard]] bool isTabulated(const BlockIndex& target, const BlockShape& shape) const;
  void inferByTable(const BlockIndex& target, const BlockShape& shape, Worker& worker) const;
  Layers addPoints(const std::vector<PlacedPoint>& points, const BlockLists::Range& list,
                   const WeightedKernels& weights, const BlockPlace& place, BlockSums& sums) const;
  Layers addSegments(const BlockLists::Range& list, const WeightedKernels& weights, const BlockPlace& place,
                     const BlockMasks* masks, BlockSums& sums) const;
  void inferGroup(const BlockGroups::Group& group, const BlockShape& shape, Worker& worker) const;
  void draftPart(const CellIndex& from, int part, const Layers& layers, uint32_t base, Worker& worker) const;
  [[nodiscard]] BlockPlace placeOf(const BlockIndex& target) const;
  [[nodiscard]] CellIndex firstCellOf(const BlockIndex& target) const;

  Sampler sampler_;
  std::optional<Weights> weights_;
  const TrainingSet* training_ = nullptr;
  std::optional<ScanFrame> frame_;
  int32_t layer_ = 0;
  ScanBlocks targets_;
  BlockLists hitLists_;
  BlockLists freeLists_;
  BlockGroups groups_;
  bool anySilent_ = false;  ///< of the scan's masks
  WideCells wideHits_;
  WideCells wideFree_;
  std::array<uint32_t, kScanBlockCells>
      partOffsets_{};  ///< Morton numbers of cells (x, y, z), at (z·8 + y)·8 + x
  std::array<uint16_t, kScanBlockCells> cellsByMorton_{};  ///< the inverse
  WeightScale pointScale_{1.0, 1.0};
  WeightScale occupiedScale_{1.0, 1.0};
  WeightScale freeScale_{1.0, 1.0};
};

BgkScanInference::BgkScanInference() : implementation_(std::make_unique<Implementation>()) {}
BgkScanInference::~BgkScanInference() = default;

Evidence BgkScanInference::infer(const Scan& scan, const BgkInference& inference,
                                 const BgkStructure& structure, int32_t layer, const Workers& workers,
                                 RayCounts& counts)
{
  return implementation_->infer(scan, inference, structure, layer, workers, counts);
}

Evidence BgkScanInference::Implementation::infer(const Scan& scan, const BgkInference& inference,
                                                 const BgkStructure& structure, int32_t layer,
                                                 const Workers& workers, RayCounts& counts)
{
  const SelectedRays rays = selectRays(scan, inference.rangeLimits(), structure.resolution);
  frame_.emplace(ScanFrame::around(rays.scan, structure.resolution,
                                   structure.planar ? std::optional(layer) : std::nullopt));
  layer_ = layer;
  if (!weights_ || !weights_->areFor(inference, structure.resolution, structure.planar))
    weights_.emplace(inference, structure.resolution, structure.planar);

  workers.run(
      [&]
      {
        training_ = &sampler_.sample(rays, inference.samplingRules(), *frame_, BlockOffset(frame_->anchor()),
                                     workers.threads());
      });
  counts = training_->counts;
  if (!sumWideCells(workers))
  {
    if (inference.beamWidth != BeamWidth::Spacing)
      throw std::length_error(
          "the wide points of a scan reach more than 67 million cells: set maxRange, or leave out what makes "
          "them wide (beamWidth, usePoseCovariance)");
    BgkInference narrowed = inference;
    narrowed.beamWidth = BeamWidth::Observation;
    Evidence evidence = infer(scan, narrowed, structure, layer, workers, counts);
    counts.narrowed = counts.used();
    return evidence;
  }
  findTargets();
  const BlockShape shape(structure.blockDepth - 1, structure.planar);
  tabulatePartOffsets(shape);
  groupTargets(shape.log2Edge());

  tbb::enumerable_thread_specific<Worker> own([&] { return Worker(shape); });
  workers.forEach(groups_.all().size(), [&](size_t i) { inferGroup(groups_.all()[i], shape, own.local()); });
  return collectEvidence(shape, SumKind::Counts, own);
}

CellIndex BgkScanInference::Implementation::firstCellOf(const BlockIndex& target) const
{
  const CellIndex& anchor = frame_->anchor();
  const BlockOffset offset(anchor);
  return {anchor.x - offset.x + target.x * kEdge, anchor.y - offset.y + target.y * kEdge,
          anchor.z - offset.z + target.z * kEdge};
}

BlockPlace BgkScanInference::Implementation::placeOf(const BlockIndex& target) const
{
  const BlockOffset offset(frame_->anchor());
  BlockPlace place;
  place.firstCell = {static_cast<double>(target.x * kEdge - offset.x),
                     static_cast<double>(target.y * kEdge - offset.y),
                     static_cast<double>(target.z * kEdge - offset.z)};
  place.planar = weights_->planar;
  place.layer = offset.z - target.z * kEdge;
  return place;
}

/// @return whether there is room for them
bool BgkScanInference::Implementation::sumWideCells(const Workers& workers)
{
  const std::vector<ExpectedKernel>& kernels = weights_->kernels.wide();
  return wideFree_.compute(*training_, kernels, &WideMasks::free, &WideMasks::anyFree, weights_->planar,
                           workers) &&
         wideHits_.compute(*training_, kernels, &WideMasks::hit, &WideMasks::anyHit, weights_->planar,
                           workers);
}

/// How far from its place a point of the scan may have a weight [cells].
double BgkScanInference::Implementation::farthestReach() const
{
  const KernelsByWidth& kernels = weights_->kernels;
  double widest = 0;
  for (const std::vector<PlacedPoint>* points : {&training_->hitPoints, &training_->freePoints})
    for (const PlacedPoint& point : *points) widest = std::max(widest, point.width);
  double reach = kernels.supportOf(kernels.levelOf(widest * widest));
  for (size_t level = 0; level < kWideLevels; ++level)
    if (!training_->wideMasks[level].empty()) reach = std::max(reach, kernels.supportOf(level + 1));
  for (const FreeSegment& segment : training_->freeSegments)
    reach = std::max(reach, supportOf(kernels, segment));
  return reach + 2;
}

void BgkScanInference::Implementation::findTargets()
{
  const int blocks = static_cast<int>(farthestReach()) / kEdge + 1;
  const BlockIndex& low = training_->blocks.low();
  const BlockIndex& high = training_->blocks.high();
  targets_.reset({low.x - blocks, low.y - blocks, low.z - blocks},
                 {high.x + blocks, high.y + blocks, high.z + blocks});
  hitLists_.clear();
  freeLists_.clear();

  anySilent_ = std::any_of(training_->masks.begin(), training_->masks.end(),
                           [](const BlockMasks& masks) { return masks.anySilent; });
  for (size_t i = 0; i < training_->masks.size(); ++i)
  {
    if (const auto box = markedBox(training_->masks[i]))
      addTargetsAround(training_->blocks.blocks()[i], box->first, box->second);
  }
  for (const WideCells* wide : {&wideHits_, &wideFree_})
    for (const BlockIndex& block : wide->blocks()) (void)targets_.findOrAdd(block);
  addTargetsAround(training_->hitPoints, hitLists_);
  addTargetsAround(training_->freePoints, freeLists_);
  addTargetsAround(training_->freeSegments);
  hitLists_.sort(targets_.blocks().size());
  freeLists_.sort(targets_.blocks().size());

  const auto points = static_cast<double>(training_->hitPoints.size() + training_->freePoints.size() +
                                          training_->freeSegments.size());
  pointScale_ = WeightScale(weights_->kernels.sharp().scale() * std::max(1.0, weights_->inference.freeWeight),
                            points + 1.0);
  const BgkInference& inference = weights_->inference;
  const bool asCells = inference.trainingPoints == TrainingPoints::Cells;
  occupiedScale_ = asCells ? weights_->hitStencil.scale() : pointScale_;
  freeScale_ = asCells && weights_->freeStencil && inference.freeSpace == FreeSpace::Samples
                   ? weights_->freeStencil->scale()
                   : pointScale_;
}

void BgkScanInference::Implementation::addTargetsAround(const BlockIndex& block, const CellIndex& first,
                                                        const CellIndex& last)
{
  const int reach = weights_->hitStencil.reach();
  const int reachZ = weights_->planar ? 0 : reach;
  const BlockIndex low{(first.x - reach) >> kScanBlockLog2Edge, (first.y - reach) >> kScanBlockLog2Edge,
                       (first.z - reachZ) >> kScanBlockLog2Edge};
  const BlockIndex high{(last.x + reach) >> kScanBlockLog2Edge, (last.y + reach) >> kScanBlockLog2Edge,
                        (last.z + reachZ) >> kScanBlockLog2Edge};
  forEachBlock(block + low, block + high,
               [&](const BlockIndex& target) { (void)targets_.findOrAdd(target); });
}

void BgkScanInference::Implementation::addTargetsBetween(const Eigen::Vector3d& low,
                                                         const Eigen::Vector3d& high, BlockLists& lists,
                                                         uint32_t item)
{
  const BlockOffset offset(frame_->anchor());
  const auto blockAt = [&](const Eigen::Vector3d& local)
  {
    return BlockIndex{(localCell(local.x()) + offset.x) >> kScanBlockLog2Edge,
                      (localCell(local.y()) + offset.y) >> kScanBlockLog2Edge,
                      weights_->planar ? offset.z >> kScanBlockLog2Edge
                                       : (localCell(local.z()) + offset.z) >> kScanBlockLog2Edge};
  };
  forEachBlock(blockAt(low), blockAt(high),
               [&](const BlockIndex& target) { lists.add(targets_.findOrAdd(target), item); });
}

void BgkScanInference::Implementation::addTargetsAround(const std::vector<PlacedPoint>& points,
                                                        BlockLists& lists)
{
  // The centre of a cell within the support stands half a cell from the cell's faces.
  const KernelsByWidth& kernels = weights_->kernels;
  for (size_t i = 0; i < points.size(); ++i)
  {
    const PlacedPoint& point = points[i];
    const Eigen::Vector3d reach =
        Eigen::Vector3d::Constant(kernels.supportOf(kernels.levelOf(point.width * point.width)));
    addTargetsBetween(point.place - reach, point.place + reach, lists, static_cast<uint32_t>(i));
  }
}

void BgkScanInference::Implementation::addTargetsAround(const std::vector<FreeSegment>& segments)
{
  for (size_t i = 0; i < segments.size(); ++i)
  {
    // Piece by piece of about a block's length. A block that two pieces reach must list the ray once.
    const FreeSegment& segment = segments[i];
    const Eigen::Vector3d reach = Eigen::Vector3d::Constant(supportOf(weights_->kernels, segment));
    const Eigen::Vector3d ray = segment.end - segment.begin;
    const int pieces = static_cast<int>(ray.norm() / kEdge) + 1;
    BlockLists& lists = freeLists_;
    for (int piece = 0; piece < pieces; ++piece)
    {
      const Eigen::Vector3d p = segment.begin + ray * (static_cast<double>(piece) / pieces);
      const Eigen::Vector3d q = segment.begin + ray * (static_cast<double>(piece + 1) / pieces);
      const Eigen::Vector3d wider = reach.array() + 1e-6;
      addTargetsBetween(p.cwiseMin(q) - wider, p.cwiseMax(q) + wider, lists, static_cast<uint32_t>(i));
    }
  }
}

void BgkScanInference::Implementation::tabulatePartOffsets(const BlockShape& shape)
{
  const int part = std::min(kEdge, shape.edge());
  const int partZ = shape.planar() ? 1 : part;
  for (int z = 0; z < partZ; ++z)
  {
    for (int y = 0; y < part; ++y)
    {
      for (int x = 0; x < part; ++x)
      {
        const auto cell = static_cast<size_t>((z * kEdge + y) * kEdge + x);
        const uint32_t number =
            shape.offsetOfLocal(static_cast<uint32_t>(x), static_cast<uint32_t>(y), static_cast<uint32_t>(z));
        partOffsets_[cell] = number;
        cellsByMorton_[number] = static_cast<uint16_t>(cell);
      }
    }
  }
}

/// Puts targets together that share a block of the map.
void BgkScanInference::Implementation::groupTargets(int log2BlockEdge)
{
  const int log2Edge = std::max(kScanBlockLog2Edge, log2BlockEdge);
  groups_.form(targets_.blocks().size(), log2Edge == kScanBlockLog2Edge,
               [&](uint32_t target)
               {
                 const CellIndex cell = firstCellOf(targets_.blocks()[target]);
                 return BlockIndex{cell.x >> log2Edge, cell.y >> log2Edge, cell.z >> log2Edge};
               });
}

/// Looks up the blocks around one, as far as the stencils reach.
void BgkScanInference::Implementation::findNeighbours(const BlockIndex& block, Worker& worker) const
{
  const int n = std::max(1, weights_->hitStencil.blocksEachWay());
  worker.neighbours.clear();
  forEachBlock(
      {block.x - n, block.y - n, block.z - n}, {block.x + n, block.y + n, block.z + n},
      [&](const BlockIndex& neighbour)
      {
        const bool isReached = !weights_->planar || neighbour.z == block.z;
        const int32_t number = isReached ? training_->blocks.find(neighbour) : -1;
        const bool there = number >= 0 && static_cast<size_t>(number) < training_->masks.size();
        worker.neighbours.push_back(there ? &training_->masks[static_cast<size_t>(number)] : nullptr);
      });
  worker.neighbourhood.blocksEachWay = n;
  worker.neighbourhood.masks.resize(worker.neighbours.size());
}

/// Puts the masks of one kind into the neighbourhood. @return whether any has a mark
bool BgkScanInference::Implementation::findMarked(CellMask BlockMasks::*mask, bool BlockMasks::*any,
                                                  Worker& worker) const
{
  bool anyMarked = false;
  for (size_t i = 0; i < worker.neighbours.size(); ++i)
  {
    const BlockMasks* neighbour = worker.neighbours[i];
    const bool marked = neighbour && neighbour->*any;
    worker.neighbourhood.masks[i] = marked ? &(neighbour->*mask) : nullptr;
    anyMarked = anyMarked || marked;
  }
  return anyMarked;
}

/// @return the layers that the points reach, in units of the weights.
Layers BgkScanInference::Implementation::addPoints(const std::vector<PlacedPoint>& points,
                                                   const BlockLists::Range& list,
                                                   const WeightedKernels& weights, const BlockPlace& place,
                                                   BlockSums& sums) const
{
  PointSums added(weights, place, sums);
  for (const uint32_t i : list) added.addPoint(points[i]);
  return added.any() ? Layers{0, kEdge} : Layers{};
}

/// As addPoints(). A ray may stand in the list several times, one behind the other.
Layers BgkScanInference::Implementation::addSegments(const BlockLists::Range& list,
                                                     const WeightedKernels& weights, const BlockPlace& place,
                                                     const BlockMasks* masks, BlockSums& sums) const
{
  PointSums added(weights, place, sums);
  uint32_t last = UINT32_MAX;
  for (const uint32_t i : list)
  {
    if (i == last) continue;
    last = i;
    const FreeSegment& segment = training_->freeSegments[i];
    // A ray without a return says nothing of cells in which others ended.
    added.addSegment(segment, segment.hasHit || masks == nullptr ? nullptr : &masks->ended);
  }
  return added.any() ? Layers{0, kEdge} : Layers{};
}

/// Calls visit(cell) for each cell of some layers of a block, by its number, that holds no free sample.
template <typename Visit>
void BgkScanInference::Implementation::forEachUnseen(int32_t block, const Layers& layers, Visit&& visit) const
{
  if (!weights_->unseen) return;
  for (int z = layers.begin; z < layers.end; ++z)
  {
    const uint64_t seen =
        block < 0 ? 0 : training_->freeInLayer(static_cast<size_t>(block), static_cast<size_t>(z));
    for (uint64_t rest = ~seen; rest != 0; rest &= rest - 1)
      visit(static_cast<size_t>(z * kEdge * kEdge + __builtin_ctzll(rest)));
  }
}

/** The sums of one scan block, in worker.occupied and worker.free, in units of their weights.
 * @return the layers that evidence reaches */
Layers BgkScanInference::Implementation::sumBlock(size_t target, Worker& worker) const
{
  const BlockIndex& block = targets_.blocks()[target];
  const int32_t number = training_->blocks.find(block);
  const bool hasMasks = number >= 0 && static_cast<size_t>(number) < training_->masks.size();
  const BlockMasks* masks = hasMasks ? &training_->masks[static_cast<size_t>(number)] : nullptr;
  Layers reached;
  if (weights_->inference.trainingPoints == TrainingPoints::Cells)
  {
    findNeighbours(block, worker);
    if (findMarked(&BlockMasks::hit, &BlockMasks::anyHit, worker))
      reached.include(weights_->hitStencil.addUp(worker.neighbourhood, worker.occupied));
    if (weights_->freeStencil && weights_->inference.freeSpace == FreeSpace::Samples &&
        findMarked(&BlockMasks::free, &BlockMasks::anyFree, worker))
    {
      const Layers layers = weights_->freeStencil->addUp(worker.neighbourhood, worker.free);
      forEachUnseen(number, layers,
                    [&](size_t cell)
                    {
                      int64_t& sum = worker.free[cell];
                      sum = freeScale_.sumOf(weights_->unseen->counted(freeScale_.evidence(sum)));
                    });
      reached.include(layers);
    }
    if (weights_->silentStencil && findMarked(&BlockMasks::silent, &BlockMasks::anySilent, worker))
      reached.include(weights_->silentStencil->addUp(worker.neighbourhood, worker.free));
  }
  if (!hitLists_.empty())
    reached.include(addPoints(training_->hitPoints, hitLists_.of(target),
                              {weights_->kernels, 1.0, occupiedScale_}, placeOf(block), worker.occupied));
  if (!freeLists_.empty())
  {
    const WeightedKernels weights{weights_->kernels, weights_->inference.freeWeight, pointScale_};
    reached.include(
        training_->freeSegments.empty()
            ? addPoints(training_->freePoints, freeLists_.of(target), weights, placeOf(block), worker.free)
            : addSegments(freeLists_.of(target), weights, placeOf(block), masks, worker.free));
  }
  reached.include(addWide(wideHits_.at(block), 1.0, occupiedScale_, worker.occupied));
  reached.include(addWide(wideFree_.at(block), weights_->inference.freeWeight, freeScale_, worker.free));
  if (masks != nullptr) forEachCell(masks->protectedHit, [&](size_t cell) { worker.free[cell] = 0; });
  return reached;
}

/// Whether inferByTable() may be used.
bool BgkScanInference::Implementation::isTabulated(const BlockIndex& target, const BlockShape& shape) const
{
  return weights_->hitTable && !anySilent_ && weights_->inference.trainingPoints == TrainingPoints::Cells &&
         weights_->inference.freeSpace != FreeSpace::Line && shape.edge() == kEdge && hitLists_.empty() &&
         freeLists_.empty() && wideHits_.at(target) == nullptr && wideFree_.at(target) == nullptr;
}

/** The evidence of one scan block, which one block of the map holds, of cells without a width alone.
 * As sumBlock() and draftPart(), in a fraction of the time. */
void BgkScanInference::Implementation::inferByTable(const BlockIndex& target, const BlockShape& shape,
                                                    Worker& worker) const
{
  findNeighbours(target, worker);
  Layers reached;
  if (findMarked(&BlockMasks::hit, &BlockMasks::anyHit, worker))
    reached.include(weights_->hitTable->look(worker.neighbourhood, worker.occupiedEvidence));
  const int32_t number = training_->blocks.find(target);
  if (weights_->freeTable && findMarked(&BlockMasks::free, &BlockMasks::anyFree, worker))
  {
    const Layers layers = weights_->freeTable->look(worker.neighbourhood, worker.freeEvidence);
    forEachUnseen(number, layers,
                  [&](size_t cell)
                  {
                    uint32_t& evidence = worker.freeEvidence[cell];
                    evidence = static_cast<uint32_t>(weights_->unseen->counted(evidence));
                  });
    reached.include(layers);
  }
  if (!reached.any()) return;
  if (number >= 0 && static_cast<size_t>(number) < training_->masks.size())
    forEachCell(training_->masks[static_cast<size_t>(number)].protectedHit,
                [&](size_t cell) { worker.freeEvidence[cell] = 0; });

  constexpr size_t kLayer = kEdge * kEdge;
  const CellIndex first = firstCellOf(target);
  const size_t begin = shape.planar() ? static_cast<size_t>(layer_ - first.z) * kLayer : 0;
  for (size_t i = 0; i < shape.cellCount(); ++i)
  {
    const size_t cell = begin + cellsByMorton_[i];
    worker.cells[i] = worker.occupiedEvidence[cell] | uint64_t{worker.freeEvidence[cell]} << 32;
  }
  worker.draft.addBlock(shape.blockOf({first.x, first.y, shape.planar() ? layer_ : first.z}),
                        worker.cells.data());
  for (EvidenceTable::BlockEvidence* evidence : {&worker.occupiedEvidence, &worker.freeEvidence})
    std::fill(evidence->begin() + reached.begin * static_cast<int>(kLayer),
              evidence->begin() + reached.end * static_cast<int>(kLayer), 0u);
}

void BgkScanInference::Implementation::inferGroup(const BlockGroups::Group& group, const BlockShape& shape,
                                                  Worker& worker) const
{
  // The part of a scan block that one block of the map holds; a larger block of the map holds all of a group.
  const int part = std::min(kEdge, shape.edge());
  const bool holdsGroup = shape.edge() > kEdge;
  CellIndex corner;
  for (const uint32_t target : group)
  {
    const BlockIndex& place = targets_.blocks()[target];
    if (isTabulated(place, shape))
    {
      inferByTable(place, shape, worker);
      continue;
    }
    const CellIndex first = firstCellOf(place);
    const Layers reached = sumBlock(target, worker);
    Layers layers = reached;
    if (shape.planar()) layers = {layer_ - first.z, layer_ - first.z + 1};
    const int partZ = shape.planar() ? 1 : part;
    for (int z = shape.planar() ? layers.begin : layers.begin / part * part; z < layers.end; z += partZ)
    {
      for (int y = 0; y < kEdge; y += part)
      {
        for (int x = 0; x < kEdge; x += part)
        {
          corner = {first.x + x, first.y + y, first.z + z};
          draftPart({x, y, z}, part, {std::max(z, layers.begin), std::min(z + partZ, layers.end)},
                    shape.offsetOf(corner), worker);
          if (!holdsGroup) worker.draft.finishBlock(shape.blockOf(corner));
        }
      }
    }
    clearSums(reached, worker.occupied);
    clearSums(reached, worker.free);
  }
  if (holdsGroup) worker.draft.finishBlock(shape.blockOf(corner));
}

/** Rounds the sums of a part of a scan block to evidence, and hands it to the draft.
 * @param from first cell of the part in the scan block; @param layers of the part that evidence may be in
 * @param base Morton number of that first cell in the map's block */
void BgkScanInference::Implementation::draftPart(const CellIndex& from, int part, const Layers& layers,
                                                 uint32_t base, Worker& worker) const
{
  const WeightScale occupiedScale = occupiedScale_;  // here, no store can change them
  const WeightScale freeScale = freeScale_;
  for (int z = layers.begin; z < layers.end; ++z)
  {
    for (int y = 0; y < part; ++y)
    {
      const auto row = static_cast<size_t>((z * kEdge + from.y + y) * kEdge + from.x);
      const auto partRow = static_cast<size_t>(((z - from.z) * kEdge + y) * kEdge);
      for (int x = 0; x < part; ++x)
      {
        const int64_t occupied = worker.occupied[row + static_cast<size_t>(x)];
        const int64_t free = worker.free[row + static_cast<size_t>(x)];
        if ((occupied | free) == 0) continue;
        worker.draft.set(base | partOffsets_[partRow + static_cast<size_t>(x)],
                         {occupiedScale.evidence(occupied), freeScale.evidence(free)});
      }
    }
  }
}

}  // namespace lamap
