// Hilbert maps of one model: what they learn, what they answer, what they keep.
#include <gtest/gtest.h>
#include <lamap_core/hilbert/map.h>
#include <lamap_core/math/portable_math.h>
#include <support/hilbert_oracle.h>
#include <support/hilbert_states.h>
#include <support/seeded_scans.h>
#include <support/seeds.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <tuple>

namespace lamap::test
{
namespace
{
HilbertInference nearInference()
{
  HilbertInference inference;
  inference.maxRange = 2.0;
  return inference;
}

HilbertMap learned(const HilbertStructure& structure, const std::vector<Scan>& scans,
                   const HilbertInference& inference = nearInference(), unsigned threads = 1)
{
  HilbertMap map(structure);
  for (const Scan& scan : scans) map.insert(scan, inference, nullptr, threads);
  return map;
}

std::vector<Scan> roomScans(unsigned seed, int count, int rays = 150)
{
  Random random(seed);
  std::vector<Scan> scans;
  for (int i = 0; i < count; ++i) scans.push_back(roomScan(random, random.inCube(0.7), rays));
  return scans;
}

// Each scan: Newton's method to convergence over all features there are, from the last posterior.
TEST(HilbertMapProperty, IncrementalPosteriorIsThatOfDenseLaplace)
{
  for (unsigned seed = 1; seed <= seeds(2); ++seed)
  {
    SCOPED_TRACE(seed);
    HilbertInference inference = nearInference();
    inference.iterations = 400;
    HilbertStructure structure;
    HilbertMap map(structure);
    using Site = std::tuple<int, int, int>;
    std::map<Site, SitePosterior> oracle;
    for (const Scan& scan : roomScans(seed, 3, 25))
    {
      map.insert(scan, inference, nullptr, 1);

      const HilbertFrame frame = frameAround(scan, 0.1);
      HilbertTrainingSet set = trainingSetOf(scan, inference.rangeLimits(), inference.rules(), frame);
      for (Eigen::Vector3d& point : set.points)
      {
        point += 0.25 * Eigen::Vector3d(frame.anchorSite.x, frame.anchorSite.y, frame.anchorSite.z);
        const auto site = [&](int axis) { return static_cast<int>(std::floor(point[axis] / 0.25 + 1e-6)); };
        oracle.emplace(Site{site(2), site(1), site(0)}, SitePosterior{0.0f, 0.1f});
      }
      std::vector<Eigen::Vector3d> centres;
      DensePosterior prior{Eigen::VectorXd(oracle.size()), Eigen::VectorXd(oracle.size())};
      for (const auto& [site, posterior] : oracle)
      {
        const auto& [z, y, x] = site;
        prior.mean[static_cast<long>(centres.size())] = posterior.mean;
        prior.precision[static_cast<long>(centres.size())] = posterior.precision;
        centres.push_back(0.25 * Eigen::Vector3d(x + 0.5, y + 0.5, z + 0.5));
      }
      const DensePosterior posterior =
          denseLaplace(denseCompactFeatures(set.points, centres, 14, 0.03), set, prior);
      long j = 0;
      for (auto& [site, weight] : oracle)
      {
        weight = {static_cast<float>(posterior.mean[j]), static_cast<float>(posterior.precision[j])};
        ++j;
      }
      ASSERT_EQ(map.weightCount(), oracle.size());
      for (const auto& [site, weight] : oracle)
      {
        const auto& [z, y, x] = site;
        const SitePosterior* is = map.lattice().find(CellIndex{x, y, z});
        ASSERT_NE(is, nullptr);
        ASSERT_NEAR(is->mean, weight.mean, 0.03);
        ASSERT_NEAR(is->precision, weight.precision, 0.02 * static_cast<double>(weight.precision));
      }
    }
  }
}

TEST(HilbertMapProperty, AnswersAgreeHoweverTheyAreAskedFor)
{
  for (HilbertStructure structure : allHilbertStructures())
    for (const double resolution : {0.1, 0.15})
      for (const bool planar : {false, true})
      {
        structure.resolution = resolution;
        structure.planar = planar;
        structure.planarHeight = 0.32;
        SCOPED_TRACE(nameOf(structure));
        const HilbertMap map = learned(structure, roomScans(3, 2));
        const int32_t layer = structure.planarLayer().value_or(-8);
        const CellIndex first{-23, -22, layer};
        const std::array<int, 3> counts{45, 44, planar ? 1 : 17};
        std::vector<ReachedLogodds> block, list;
        map.logoddsOf(first, counts, block);
        std::map<std::tuple<int, int, int>, double> visited;
        map.visitCells([&](const CellIndex& cell, double f)
                       { ASSERT_TRUE(visited.emplace(std::make_tuple(cell.x, cell.y, cell.z), f).second); });
        const auto bounds = map.cellBounds();
        ASSERT_TRUE(bounds);
        std::vector<Eigen::Vector3d> points;
        size_t reached = 0, i = 0;
        for (int z = 0; z < counts[2]; ++z)
          for (int y = 0; y < counts[1]; ++y)
            for (int x = 0; x < counts[0]; ++x, ++i)
            {
              const CellIndex cell{first.x + x, first.y + y, first.z + z};
              points.push_back(cellCentre(cell, resolution));
              const auto single = map.logoddsOf(cell), atPoint = map.logoddsAt(points.back());
              ASSERT_EQ(single.has_value(), block[i].reached);
              ASSERT_EQ(atPoint.has_value(), block[i].reached);
              const auto found = visited.find(std::make_tuple(cell.x, cell.y, cell.z));
              ASSERT_EQ(found != visited.end(), block[i].reached);
              if (!single)
              {
                ASSERT_EQ(block[i].logodds, 0.0f);
                continue;
              }
              ++reached;
              ASSERT_NEAR(*single, block[i].logodds, 1e-3);
              ASSERT_NEAR(*atPoint, block[i].logodds, 1e-3);
              ASSERT_EQ(found->second, block[i].logodds);
              ASSERT_TRUE(cell.x >= bounds->first.x && cell.x <= bounds->second.x &&
                          cell.z >= bounds->first.z && cell.z <= bounds->second.z);
            }
        EXPECT_GT(reached, 500u);
        map.logoddsAt(points, list);
        for (i = 0; i < list.size(); ++i)
        {
          ASSERT_NEAR(list[i].logodds, block[i].logodds, 1e-3);
          ASSERT_EQ(list[i].reached, block[i].reached);
        }
      }
}

// No data, no opinion: p = 0.5 exactly where no training voxel's feature reaches.
TEST(HilbertMapProperty, SaysNothingWhereNoFeatureReaches)
{
  const HilbertMap map = learned({}, roomScans(5, 2));
  const double support = map.structure().kernel().support_m();
  std::vector<Eigen::Vector3d> centres;
  for (const BlockIndex& index : map.lattice().sortedBlocks())
    for (uint32_t offset = 0; offset < 512; ++offset)
      if (map.lattice().find(index)->has(offset))
        centres.push_back(0.25 * Eigen::Vector3d(index.x * 8 + static_cast<int>(offset % 8) + 0.5,
                                                 index.y * 8 + static_cast<int>(offset / 8 % 8) + 0.5,
                                                 index.z * 8 + static_cast<int>(offset / 64) + 0.5));
  Random random(6);
  int beyond = 0;
  for (int i = 0; i < 3000; ++i)
  {
    const Eigen::Vector3d point = random.inCube(2.6);
    double nearest = 1e9;
    for (const auto& centre : centres) nearest = std::min(nearest, (centre - point).norm());
    if (std::abs(nearest - support) < 1e-6) continue;
    const auto logodds = map.logoddsAt(point);
    ASSERT_EQ(logodds.has_value(), nearest < support) << nearest;
    beyond += !logodds;
  }
  EXPECT_GT(beyond, 100);
  EXPECT_FALSE(HilbertMap().logoddsAt(Eigen::Vector3d(0, 0, 0)));
  EXPECT_FALSE(map.logoddsAt(Eigen::Vector3d(std::nan(""), 0, 0)));
  EXPECT_FALSE(map.logoddsAt(Eigen::Vector3d(1e300, 0, 0)));
}

TEST(HilbertMap, EveryKindOfTrainingTellsWallsFromRoom)
{
  for (const HilbertStructure& structure : allHilbertStructures())
  {
    SCOPED_TRACE(nameOf(structure));
    HilbertInference inference = nearInference();
    if (structure.training == HilbertTraining::Sgd) inference.alpha = 1e-4;
    const HilbertMap map = learned(structure, roomScans(7, 6, 400), inference);
    Random random(8);
    int right = 0;
    constexpr int kAsked = 1000;
    for (int i = 0; i < kAsked; ++i)
    {
      const bool wall = i % 2 == 0;
      Eigen::Vector3d point = random.inCube(wall ? 0.9 : 0.7);
      if (wall) point[random.integer(0, 2)] = random.chance(0.5) ? 1.2 : -1.2;
      const auto logodds = map.logoddsAt(point);
      right += logodds && (*logodds > 0) == wall;
    }
    EXPECT_GE(right, structure.features == HilbertFeatures::Compact ? 900 : 700);
  }
}

/// A laser in a room of 6 m that a thin pole may stand in, at (1.03, 0.04).
Scan scanWithPole(double y, bool withPole)
{
  const Eigen::Vector3d origin(-1.5, y, 0);
  const Eigen::Vector3d pole(1.03, 0.04, 0);
  constexpr double kRadius_m = 0.03;
  Scan scan;
  scan.fans.emplace_back();
  scan.fans[0].centre = origin;
  for (int degrees = -180; degrees < 180; ++degrees)
    for (const double part : {0.1, 0.6})
    {
      const double azimuth = (degrees + part) * M_PI / 180;
      const Eigen::Vector3d direction(std::cos(azimuth), std::sin(azimuth), 0);
      double range = 1e9;
      for (int axis = 0; axis < 2; ++axis)
        range = std::min(range, ((direction[axis] > 0 ? 3.02 : -3.02) - origin[axis]) / direction[axis]);
      const double along = (pole - origin).dot(direction);
      const double aside = (pole - origin - along * direction).norm();
      if (withPole && along > 0 && aside < kRadius_m)
        range = along - std::sqrt(kRadius_m * kRadius_m - aside * aside);
      scan.fans[0].addReturn(origin + range * direction);
    }
  return scan;
}

HilbertMap mapWithPole(const HilbertStructure& structure, HilbertInference inference, int with, int without)
{
  inference.maxRange = 10;
  HilbertMap map(structure);
  for (int i = 0; i < with + without; ++i)
    map.insert(scanWithPole(0.1 * (i % 7) - 0.3, i < with), inference, nullptr, 1);
  return map;
}

TEST(HilbertMap, APoleThatScansHitIsNotFreeWithOneAndOccupiedWithMore)
{
  const Eigen::Vector3d pole(1.005, 0.045, 0);
  const Eigen::Vector3d inItsCell(1.09, 0.01, 0);
  const auto cell = cellAt(pole, 0.1);
  for (HilbertStructure structure : allHilbertStructures())
  {
    structure.planar = true;
    SCOPED_TRACE(nameOf(structure));
    for (const auto& [scans, least] : {std::pair{1, 0.3}, {3, 0.55}, {20, 0.8}})
    {
      const HilbertMap map = mapWithPole(structure, {}, scans, 0);
      for (const auto& said : {map.logoddsOf(*cell), map.logoddsAt(pole), map.logoddsAt(inItsCell),
                               map.logoddsAt(pole, Eigen::Matrix3d::Zero())})
      {
        ASSERT_TRUE(said);
        EXPECT_GE(logistic(*said), least) << scans;
      }
      std::vector<ReachedLogodds> box;
      map.logoddsOf({cell->x - 5, cell->y - 9, cell->z}, {7, 12, 1}, box);
      EXPECT_NEAR(box[9 * 7 + 5].logodds, *map.logoddsOf(*cell), 1e-5);
    }
  }
  // Without its rays the pole is lost, else the test would say nothing.
  HilbertStructure planar;
  planar.planar = true;
  HilbertState state = mapWithPole(planar, {}, 20, 0).state();
  state.seen.clear();
  HilbertMap smooth(planar);
  smooth.restore(state);
  EXPECT_LT(*smooth.logoddsAt(pole), 0.5);
}

// By hand: 20 hits and 4 passes are worth (1.5·20 + 4)/(1 + 0.1·23) of the prior's 2 scans.
TEST(HilbertMap, HitsAndPassesOfACellMeetTheModelAsABetaPrior)
{
  HilbertStructure planar;
  planar.planar = true;
  HilbertState state = mapWithPole(planar, {}, 2, 0).state();
  const CellIndex cell = *cellAt({1.005, 0.045, 0}, 0.1);
  const auto saidWith = [&](uint8_t hits, uint8_t passes)
  {
    HilbertState::SeenBlock seen{SiteSet::blockOf(cell), {}, {hits}, {passes}};
    const uint32_t offset = SiteSet::offsetOf(cell);
    seen.bits[offset / 64] = uint64_t{1} << (offset % 64);
    state.seen.clear();
    if (hits + passes > 0) state.seen.push_back(seen);
    HilbertMap map(planar);
    map.restore(state);
    return logistic(*map.logoddsOf(cell));
  };
  const double model = saidWith(0, 0);
  EXPECT_NEAR(saidWith(8 * 20, 8 * 4), (2 * model + 30 / 3.3) / (2 + 34 / 3.3), 1e-6);
  EXPECT_NEAR(saidWith(8, 0), (2 * model + 1.5) / 3.5, 1e-6);
  EXPECT_NEAR(saidWith(0, 16), 2 * model / (2 + 2 / 1.1), 1e-6);
  EXPECT_NEAR(saidWith(4, 0), (2 * model + 0.75) / 2.75, 1e-6);
}

TEST(HilbertMap, PassesBeforeTheFirstHitCountAsThoseAfterIt)
{
  const CellIndex cell = *cellAt({1.005, 0.045, 0}, 0.1);
  HilbertStructure planar;
  planar.planar = true;
  HilbertInference inference;
  inference.maxRange = 10;
  const auto scansOf = [&](bool hitsFirst)
  {
    HilbertMap map(planar);
    for (int i = 0; i < 12; ++i)
      map.insert(scanWithPole(0.1 * (i % 3) - 0.1, hitsFirst ? i < 3 : i >= 9), inference, nullptr, 1);
    std::pair<int, int> scans{0, 0};
    for (const HilbertState::SeenBlock& block : map.state().seen)
    {
      size_t place = 0;
      SiteBits::forEach(block.bits, block.index,
                        [&](const CellIndex& seen)
                        {
                          if (seen == cell) scans = {block.hits[place], block.passes[place]};
                          ++place;
                        });
    }
    return scans;
  };
  EXPECT_EQ(scansOf(true), scansOf(false));
  EXPECT_EQ(scansOf(true).first, 3 * 8);
  EXPECT_GT(scansOf(true).second, 0);
}

TEST(HilbertMap, AScanFromAPoseUncertainByMoreThanSomeCellsIsNoScanOfItsCells)
{
  HilbertStructure planar;
  planar.planar = true;
  HilbertInference inference;
  inference.maxRange = 10;
  for (const double std_m : {0.17, 0.18})  // times √2: 2.4 and 2.55 cells
  {
    HilbertUncertainty uncertainty;
    uncertainty.pose.diagonal().head<3>().setConstant(std_m * std_m);
    HilbertMap map(planar);
    map.insert(scanWithPole(0, true), inference, &uncertainty, 1);
    EXPECT_EQ(map.state().seen.empty(), std_m > 0.175);
  }
}

// The 31 scans that are kept go on like a mean of the last ones.
TEST(HilbertMap, ManyScansOfACellFade)
{
  if (shareOfCases() < 0.5) GTEST_SKIP() << "takes minutes with sanitizers; LAMAP_SEEDS=1 runs it";
  HilbertStructure planar;
  planar.planar = true;
  const Eigen::Vector3d pole(1.005, 0.045, 0);
  const HilbertMap map = mapWithPole(planar, {}, 300, 0);
  for (const HilbertState::SeenBlock& block : map.state().seen)
    for (size_t i = 0; i < block.hits.size(); ++i) ASSERT_LT(block.hits[i] + block.passes[i], 8 * 32);
  const double standing = *map.logoddsAt(pole);
  EXPECT_NEAR(standing, *mapWithPole(planar, {}, 60, 0).logoddsAt(pole), 0.3);
  EXPECT_LT(*mapWithPole(planar, {}, 60, 60).logoddsAt(pole), -1);
}

TEST(HilbertMap, APoleThatIsGoneBecomesFree)
{
  const Eigen::Vector3d pole(1.005, 0.045, 0);
  HilbertStructure planar;
  planar.planar = true;
  EXPECT_GE(*mapWithPole(planar, {}, 6, 4).logoddsAt(pole), 0);
  EXPECT_LT(*mapWithPole(planar, {}, 6, 20).logoddsAt(pole), -1);
}

TEST(HilbertMap, NoCellIsSeenWhereTrainingPointsAreNoCells)
{
  HilbertStructure planar;
  planar.planar = true;
  HilbertInference points;
  points.trainingPoints = HilbertPoints::Points;
  EXPECT_TRUE(mapWithPole(planar, points, 3, 0).state().seen.empty());
}

TEST(HilbertMapProperty, StateSurvivesARoundTripAndLearningGoesOnAsIfThereHadBeenNone)
{
  for (HilbertStructure structure : allHilbertStructures())
    for (const bool uncertain : {false, true})
    {
      SCOPED_TRACE(nameOf(structure));
      const std::vector<Scan> scans = roomScans(9, 4, 60);
      HilbertUncertainty uncertainty;
      uncertainty.point = Eigen::Matrix3d::Identity() * (uncertain ? 0.01 : 0.0);
      HilbertMap whole(structure), first(structure), resumed(structure);
      for (size_t i = 0; i < scans.size(); ++i)
      {
        whole.insert(scans[i], nearInference(), &uncertainty, 1);
        (i < 2 ? first : resumed).insert(scans[i], nearInference(), &uncertainty, 1);
        if (i != 1) continue;
        const HilbertState saved = first.state();
        resumed.restore(saved);
        ASSERT_EQ(differenceOf(resumed.state(), saved), "");
        EXPECT_EQ(resumed.empty(), false);
        Random random(10);
        for (int k = 0; k < 200; ++k)
        {
          const Eigen::Vector3d point = random.inCube(1.5);
          ASSERT_EQ(resumed.logoddsAt(point), first.logoddsAt(point));
        }
      }
      EXPECT_EQ(differenceOf(whole.state(), resumed.state()), "");
      const HilbertMap copy = whole;
      EXPECT_EQ(differenceOf(copy.state(), whole.state()), "");
      EXPECT_GT(whole.memoryBytes(), 0u);
      whole.clear();
      EXPECT_TRUE(whole.empty());
      EXPECT_FALSE(whole.cellBounds());
      EXPECT_FALSE(copy.empty());
    }
}

TEST(HilbertMap, RefusesStatesThatAreNone)
{
  const HilbertMap map = learned({}, roomScans(11, 1));
  const auto refused = [&](auto&& change, const HilbertStructure& structure = {})
  {
    HilbertState state = map.state();
    change(state);
    HilbertMap other(structure);
    EXPECT_THROW(other.restore(state), std::invalid_argument);
    EXPECT_TRUE(other.empty());
  };
  refused([](HilbertState& s) { s.blocks[0].weights.pop_back(); });
  refused([](HilbertState& s) { s.blocks[0].weights[0].mean = std::nanf(""); });
  refused([](HilbertState& s) { s.blocks[0].weights[0].precision = -1; });
  refused([](HilbertState& s) { s.blocks.push_back(s.blocks[0]); });
  refused([](HilbertState& s) { s.blocks[0].index.x = std::numeric_limits<int32_t>::max(); });
  refused([](HilbertState& s) { s.seen[0].hits.pop_back(); });
  refused([](HilbertState& s) { s.seen[0].passes.push_back(1); });
  refused([](HilbertState& s) { s.seen[0].hits[0] = s.seen[0].passes[0] = 0; });
  refused([](HilbertState& s) { s.seen[0].hits[0] = s.seen[0].passes[0] = 128; });
  refused([](HilbertState& s) { s.seen[0] = {s.seen[0].index, {}, {}, {}}; });
  refused([](HilbertState& s) { s.seen.push_back(s.seen[0]); });
  const HilbertState::WidthBlock width{{0, 0, 0}, {1}, {1}, {0.1f}};
  refused([&](HilbertState& s) { s.widths = {width, width}; });
  refused([&](HilbertState& s) { s.widths = {{{0, 0, 0}, {3}, {1}, {0.1f}}}; });
  refused([&](HilbertState& s) { s.widths = {{{0, 0, 0}, {1}, {1}, {}}}; });
  refused([&](HilbertState& s) { s.widths = {{{0, 0, 0}, {1}, {1}, {-1}}}; });
  refused([&](HilbertState& s) { s.widths = {{{0, 0, 0}, {1}, {std::nanf("")}, {1}}}; });
  refused([](HilbertState& s) { s.inducing.push_back({0, 0, 0}); });
  refused([](HilbertState& s) { s.classifier = {1, 2}; });
  refused([](HilbertState& s) { s.cells.push_back({{0, 0, 0}, 1, 0}); });
  HilbertStructure batch;
  batch.training = HilbertTraining::Batch;
  refused([](HilbertState& s) { s.cells = {{{0, 0, 0}, 1, 0}, {{0, 0, 0}, 1, 0}}; }, batch);
  refused([](HilbertState& s) { s.points.emplace_back().weight = std::nanf(""); }, batch);
  refused([](HilbertState& s) { s.points.emplace_back().place = {1e300, 0, 0}; }, batch);
  HilbertStructure planar;
  planar.planar = true;
  refused(
      [](HilbertState& s)
      {
        s.blocks.clear();
        s.seen = {{{0, 0, 0}, {0, 1}, {8}, {0}}};
      },
      planar);
  HilbertStructure fine = batch;  // its sites cannot be counted as far as cells
  fine.latticeSpacing = 0.04;
  fine.gamma = 400;
  refused(
      [](HilbertState& s)
      {
        s.blocks.clear();
        s.cells = {{{std::numeric_limits<int32_t>::max(), 0, 0}, 1, 0}};
      },
      fine);
  refused(
      [](HilbertState& s)
      {
        s.blocks.clear();
        s.seen = {{{std::numeric_limits<int32_t>::max() / 8, 0, 0}, {1}, {8}, {0}}};
      },
      fine);
  HilbertStructure nystroem = batch;
  nystroem.features = HilbertFeatures::Nystroem;
  refused([](HilbertState& s) { s.inducing.push_back({0, 0, 0}); }, nystroem);
}

/// Empty where map `there` is map `here` moved by whole sites.
std::string differenceAfterMove(const HilbertMap& here, const HilbertMap& there, const CellIndex& by)
{
  if (here.weightCount() != there.weightCount()) return "numbers of weights";
  for (const BlockIndex& index : here.lattice().sortedBlocks())
  {
    const auto* block = here.lattice().find(index);
    for (uint32_t offset = 0; offset < 512; ++offset)
    {
      if (!block->has(offset)) continue;
      const CellIndex site{index.x * 8 + static_cast<int>(offset % 8) + by.x,
                           index.y * 8 + static_cast<int>(offset / 8 % 8) + by.y,
                           index.z * 8 + static_cast<int>(offset / 64) + by.z};
      const SitePosterior* moved = there.lattice().find(site);
      if (moved == nullptr) return "a site is missing";
      if (!(*moved == block->weights[block->placeOf(offset)])) return "weights";
    }
  }
  const double cellsASite = here.structure().latticeSpacing / here.structure().resolution;
  const auto cells = [&](int32_t sites) { return static_cast<int32_t>(std::lround(sites * cellsASite)); };
  std::string difference;
  for (const HilbertState::SeenBlock& block : here.state().seen)
    SiteBits::forEach(block.bits, block.index,
                      [&](const CellIndex& cell)
                      {
                        const auto moved = there.logoddsOf(
                            {cell.x + cells(by.x), cell.y + cells(by.y), cell.z + cells(by.z)});
                        if (moved != here.logoddsOf(cell)) difference = "log-odds of a seen cell";
                      });
  return difference;
}

TEST(HilbertMapProperty, WholeCellsThatAreWholeSitesMoveTheMapBitByBit)
{
  struct Grid
  {
    double resolution;
    int sitesAStep;  ///< the smallest move of whole cells and whole sites
  };
  for (const Grid grid : {Grid{0.125, 1}, Grid{0.0625, 1}, Grid{0.1, 2}, Grid{0.05, 1}, Grid{0.2, 4}})
    for (unsigned seed = 1; seed <= seeds(6); ++seed)
    {
      HilbertStructure structure;
      structure.resolution = grid.resolution;
      structure.training = seed % 3 == 0 ? HilbertTraining::Sgd : HilbertTraining::Incremental;
      SCOPED_TRACE(std::to_string(grid.resolution) + " m, seed " + std::to_string(seed));
      std::vector<Scan> scans = roomScans(seed, 2, 60);
      const bool exact = grid.resolution == 0.125 || grid.resolution == 0.0625;
      for (Scan& scan : scans)
        if (exact) scan = quantized(scan, 20);
      const HilbertMap here = learned(structure, scans);
      for (const CellIndex& steps :
           {CellIndex{1, 0, 0}, {-3, 5, -7}, {-11, -13, 9}, {1999999, -7, 1}, {3, -2000001, 5}})
      {
        const CellIndex by{steps.x * grid.sitesAStep, steps.y * grid.sitesAStep, steps.z * grid.sitesAStep};
        std::vector<Scan> there;
        for (const Scan& scan : scans) there.push_back(moved(scan, 0.25 * Eigen::Vector3d(by.x, by.y, by.z)));
        ASSERT_EQ(differenceAfterMove(here, learned(structure, there), by), "")
            << "moved by " << by.x << ", " << by.y << ", " << by.z << " sites";
      }
    }
}

TEST(HilbertMap, VisitsAllOfItsCellsWhereverTheyLie)
{
  HilbertStructure structure;
  structure.resolution = 0.125;
  std::vector<Scan> scans = roomScans(2, 2, 60);
  for (Scan& scan : scans) scan = quantized(scan, 20);
  const auto cellsOf = [&](const std::vector<Scan>& taught)
  {
    size_t cells = 0;
    learned(structure, taught).visitCells({}, [&](const CellIndex&, const CellEstimate&) { ++cells; });
    return cells;
  };
  const size_t cells = cellsOf(scans);
  EXPECT_GT(cells, 1000u);
  for (int axis = 0; axis < 3; ++axis)
    for (const double by_m : {-10.25, 10.25})
    {
      std::vector<Scan> there;
      for (const Scan& scan : scans) there.push_back(moved(scan, by_m * Eigen::Vector3d::Unit(axis)));
      EXPECT_EQ(cellsOf(there), cells) << "axis " << axis << ", moved by " << by_m << " m";
    }
}

TEST(HilbertMap, OddScansGiveFiniteMaps)
{
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  std::map<std::string, std::vector<Scan>> cases;
  const auto scanOf = [](const Eigen::Vector3d& origin, const std::vector<Eigen::Vector3d>& ends)
  { return scanWith({fanOf(origin, ends)}); };
  cases["a single point"] = {scanOf({0, 0, 0}, {{1, 0, 0}})};
  cases["hits only, no room for free space"] = {scanOf({0, 0, 0}, {{0.05, 0, 0}, {0, 0.08, 0}, {0, 0, 0.1}})};
  cases["all points coincide"] = {scanOf({0, 0, 0}, std::vector<Eigen::Vector3d>(200, {1, 1, 0}))};
  cases["far from all others"] = {scanOf({0, 0, 0}, {{1, 0, 0}}),
                                  scanOf({3e5, -2e5, 10}, {{3e5 + 1, -2e5, 10}})};
  Scan contradiction = scanOf({0, 0, 0}, {{1, 0, 0}, {2, 0, 0}, {3, 0, 0}});
  cases["contradictory labels"] = std::vector<Scan>(30, contradiction);
  cases["unusable among usable"] = {
      scanOf({0, 0, 0}, {{nan, 0, 0}, {inf, 0, 0}, {0, 0, 0}, {1, 0.5, 0}, {1e300, 0, 0}})};
  const Scan freeOnly = scanWith({fanOf({0, 0, 0}, {}, {{1, 0, 0}, {0, 1, 0}})});
  cases["free space only"] = {freeOnly};
  for (const auto& [name, scans] : cases)
    for (const HilbertStructure& structure : allHilbertStructures())
      for (const HilbertPoints points : {HilbertPoints::Cells, HilbertPoints::Points})
      {
        SCOPED_TRACE(name + ": " + nameOf(structure));
        HilbertInference inference = nearInference();
        inference.trainingPoints = points;
        const HilbertMap map = learned(structure, scans, inference);
        size_t cells = 0;
        map.visitCells(
            [&](const CellIndex&, double f)
            {
              ++cells;
              ASSERT_TRUE(std::isfinite(f));
              ASSERT_LT(std::abs(f), 1e4);
            });
        EXPECT_GT(cells, 0u);
        const auto end = endsOf(scans[0].fans[0]);
        if (name == "a single point" && structure.training != HilbertTraining::Sgd)
        {
          ASSERT_TRUE(map.logoddsAt(end[0]));
          EXPECT_GT(*map.logoddsAt(end[0]), 0);
        }
      }
  // Nothing usable changes nothing.
  HilbertMap map;
  const RayCounts counts = map.insert(scanOf({0, 0, 0}, {{nan, 0, 0}, {0, 0, 0}}), nearInference());
  EXPECT_EQ(counts.used(), 0u);
  EXPECT_EQ(counts.leftOut(), 2u);
  EXPECT_TRUE(map.empty());
  EXPECT_EQ(map.insert(scanOf({nan, 0, 0}, {{1, 0, 0}}), nearInference()).notFinite, 1u);
  EXPECT_EQ(map.insert(Scan{}, nearInference()).used(), 0u);
  EXPECT_TRUE(map.empty());
}

// Points of equal place and label are one with the sum of their weights: the same minimum.
TEST(HilbertMap, BatchTrainsOnAllPointsWhenItIsAsked)
{
  HilbertStructure structure;
  structure.training = HilbertTraining::Batch;
  const std::vector<Scan> scans = roomScans(12, 3, 80);
  HilbertInference inference = nearInference();
  inference.iterations = 300;
  HilbertMap map(structure);
  HilbertTrainingSet all;
  for (const Scan& scan : scans)
  {
    map.insert(scan, inference, nullptr, 1);
    EXPECT_TRUE(map.isStale());
    const HilbertFrame frame = frameAround(scan, 0.1);
    const HilbertTrainingSet set = trainingSetOf(scan, inference.rangeLimits(), inference.rules(), frame);
    for (size_t i = 0; i < set.size(); ++i)
      all.add(
          set.points[i] + 0.25 * Eigen::Vector3d(frame.anchorSite.x, frame.anchorSite.y, frame.anchorSite.z),
          set.labels[i] > 0.5f, static_cast<double>(set.weights[i]));
  }
  EXPECT_LT(map.trainingPointCount(), all.size());
  map.train();
  EXPECT_FALSE(map.isStale());
  std::vector<Eigen::Vector3d> centres;
  std::vector<double> weights;
  const HilbertState state = map.state();
  for (const HilbertState::Block& block : state.blocks)
  {
    size_t place = 0;
    for (int offset = 0; offset < 512; ++offset)
      if ((block.bits[static_cast<size_t>(offset / 64)] >> (offset % 64) & 1) != 0)
      {
        centres.push_back(0.25 * Eigen::Vector3d(block.index.x * 8 + offset % 8 + 0.5,
                                                 block.index.y * 8 + offset / 8 % 8 + 0.5,
                                                 block.index.z * 8 + offset / 64 + 0.5));
        weights.push_back(static_cast<double>(block.weights[place++].mean));
      }
  }
  const auto count = static_cast<long>(centres.size());
  const DensePosterior prior{Eigen::VectorXd::Zero(count), Eigen::VectorXd::Constant(count, 0.1)};
  const Eigen::MatrixXd features = denseCompactFeatures(all.points, centres, 14, 0.03);
  const DensePosterior oracle = denseLaplace(features, all, prior);
  const double least = denseObjective(features, all, prior, oracle.mean);
  EXPECT_LE(denseObjective(features, all, prior, Eigen::Map<Eigen::VectorXd>(weights.data(), count)),
            least * (1 + 1e-4));
}

// Blurred features are smaller, so that a scan makes weights less sure, the less the less is known of its
// pose.
TEST(HilbertMap, UncertainScansSayLess)
{
  const std::vector<Scan> scans = roomScans(13, 2, 300);
  const auto mapOf = [&](const HilbertStructure& structure, double std_m)
  {
    HilbertMap map(structure);
    HilbertUncertainty uncertainty;
    uncertainty.pose.topLeftCorner<3, 3>().diagonal().setConstant(std_m * std_m);
    uncertainty.pose(5, 5) = std_m * std_m / 4;
    for (const Scan& scan : scans)
    {
      uncertainty.centre = scan.fans[0].centre;
      map.insert(scan, nearInference(), &uncertainty, 1);
    }
    return map;
  };
  double last = std::numeric_limits<double>::infinity();
  for (const double std_m : {0.0, 0.05, 0.1, 0.2, 0.3})
  {
    double precision = 0;
    const HilbertState state = mapOf({}, std_m).state();
    for (const HilbertState::Block& block : state.blocks)
      for (const SitePosterior& weight : block.weights)
        precision += static_cast<double>(weight.precision) - 0.1;
    EXPECT_LT(precision, 0.95 * last) << std_m;
    last = precision;
  }
  // Hardly uncertain is certain.
  for (const HilbertStructure& structure : allHilbertStructures())
  {
    if (structure.training == HilbertTraining::Sgd || structure.features == HilbertFeatures::Nystroem)
      continue;
    SCOPED_TRACE(nameOf(structure));
    const HilbertMap certain = mapOf(structure, 0), hardly = mapOf(structure, 1e-5);
    for (const auto& end : endsOf(scans[0].fans[0]))
      EXPECT_NEAR(*certain.logoddsAt(end), *hardly.logoddsAt(end), 0.1);
  }
  // On the side of the question too: an uncertain place is less surely a wall.
  for (const HilbertStructure& structure : allHilbertStructures())
  {
    if (structure.training == HilbertTraining::Sgd) continue;
    SCOPED_TRACE(nameOf(structure));
    const HilbertMap map = mapOf(structure, 0);
    double sharp = 0, blurred = 0;
    for (const auto& end : endsOf(scans[0].fans[0]))
    {
      sharp += *map.logoddsAt(end);
      blurred += map.logoddsAt(end, Eigen::Matrix3d::Identity() * 0.04).value_or(0.0);
      EXPECT_NEAR(*map.logoddsAt(end, Eigen::Matrix3d::Zero()), *map.logoddsAt(end), 1e-3);
    }
    EXPECT_LT(blurred, 0.9 * sharp);
  }
  // So uncertain that nothing is said.
  HilbertMap nothing;
  HilbertUncertainty hopeless;
  hopeless.point = Eigen::Matrix3d::Identity() * 100;
  nothing.insert(scans[0], nearInference(), &hopeless, 1);
  EXPECT_TRUE(nothing.empty());
}

/// The map of a room, scanned twice from poses whose positions have this standard deviation.
HilbertMap mapOfUncertainPoses(const HilbertStructure& structure, const std::vector<double>& stds_m)
{
  const std::vector<Scan> scans = roomScans(13, static_cast<int>(stds_m.size()), 200);
  HilbertMap map(structure);
  for (size_t i = 0; i < scans.size(); ++i)
  {
    HilbertUncertainty uncertainty;
    uncertainty.pose.topLeftCorner<3, 3>().diagonal().setConstant(stds_m[i] * stds_m[i]);
    map.insert(scans[i], nearInference(), &uncertainty, 1);
  }
  return map;
}

TEST(HilbertMap, AQuestionIsAsUncertainAsTheTrainingPointsNearIt)
{
  constexpr double kStd_m = 0.15;
  for (HilbertStructure structure : allHilbertStructures())
    for (const bool planar : {false, true})
    {
      structure.planar = planar;
      SCOPED_TRACE(nameOf(structure));
      const HilbertMap map = mapOfUncertainPoses(structure, {kStd_m, kStd_m});
      HilbertState state = map.state();
      EXPECT_FALSE(state.widths.empty());
      state.widths.clear();
      HilbertMap sharp(structure);
      sharp.restore(state);
      Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity() * kStd_m * kStd_m;
      Random random(11);
      double surer = 0;
      size_t asked = 0;
      for (int i = 0; i < 300; ++i)
      {
        const Eigen::Vector3d point = random.inCube(1.5);
        if (!sharp.logoddsAt(point) || !sharp.logoddsAt(point, covariance)) continue;
        ++asked;
        EXPECT_NEAR(*map.logoddsAt(point), *sharp.logoddsAt(point, covariance), 1e-3);
        surer += std::abs(*sharp.logoddsAt(point)) - std::abs(*map.logoddsAt(point));
        const CellIndex cell = *cellAt(planar ? Eigen::Vector3d(point.x(), point.y(), 0) : point, 0.1);
        std::vector<ReachedLogodds> box;
        map.logoddsOf({cell.x - 1, cell.y, cell.z}, {3, 1, 1}, box);
        EXPECT_EQ(box[1].reached, map.logoddsOf(cell).has_value());
        if (box[1].reached)
        {
          EXPECT_NEAR(box[1].logodds, *map.logoddsOf(cell), 1e-4);
        }
      }
      EXPECT_GT(asked, 100u);
      EXPECT_GT(surer, 0);
    }
}

TEST(HilbertMap, CertainScansMakeQuestionsSharper)
{
  const auto meanVariance = [](const HilbertMap& map)
  {
    double weights = 0, variances = 0;
    for (const HilbertState::WidthBlock& block : map.state().widths)
      for (size_t i = 0; i < block.weights.size(); ++i)
      {
        weights += static_cast<double>(block.weights[i]);
        variances += static_cast<double>(block.variances[i]);
      }
    return variances / weights;
  };
  const double uncertain = meanVariance(mapOfUncertainPoses({}, {0.2}));
  EXPECT_NEAR(uncertain, 0.04, 1e-5);
  const double mixed = meanVariance(mapOfUncertainPoses({}, {0.2, 0, 0}));
  EXPECT_LT(mixed, 0.5 * uncertain);
  EXPECT_GT(mixed, 0);
  EXPECT_TRUE(mapOfUncertainPoses({}, {0, 0}).state().widths.empty());
}

TEST(HilbertMap, RefusesBadOptionsByName)
{
  const auto refused = [](const std::string& name, auto&& change)
  {
    HilbertStructure structure;
    HilbertInference inference;
    change(structure, inference);
    try
    {
      HilbertMap map(structure);
      map.insert(Scan{}, inference);
      ADD_FAILURE() << name << " is taken";
    }
    catch (const std::invalid_argument& error)
    {
      EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << error.what();
    }
  };
  using S = HilbertStructure;
  using I = HilbertInference;
  refused("resolution", [](S& s, I&) { s.resolution = 0; });
  refused("gamma", [](S& s, I&) { s.gamma = -1; });
  refused("cutoff", [](S& s, I&) { s.cutoff = 1; });
  refused("latticeSpacing", [](S& s, I&) { s.latticeSpacing = 0.01; });
  refused("latticeSpacing", [](S& s, I&) { s.latticeSpacing = 0.6; });  // gaps
  refused("gamma", [](S& s, I&) { s.resolution = 0.001; });             // 500 cells in a kernel
  refused("maxRange",
          [](S&, I& i)
          {
            i.minRange = 7;
            i.maxRange = 6;
          });
  refused("components", [](S& s, I&) { s.components = 0; });
  refused("priorPrecision", [](S& s, I&) { s.priorPrecision = 0; });
  refused("nystroem", [](S& s, I&) { s.features = HilbertFeatures::Nystroem; });
  refused("solver", [](S&, I& i) { i.solver = HilbertSolver::SgdL1; });
  refused("solver",
          [](S& s, I& i)
          {
            s.training = HilbertTraining::Sgd;
            i.solver = HilbertSolver::Lbfgs;
          });
  refused("iterations", [](S&, I& i) { i.iterations = 0; });
  refused("alpha", [](S&, I& i) { i.alpha = 0; });
  refused("epochs", [](S&, I& i) { i.epochs = 0; });
  refused("hitWeight", [](S&, I& i) { i.hitWeight = std::nan(""); });
  refused("maxRange", [](S&, I& i) { i.maxRange = -1; });
  refused("rayDecimation", [](S&, I& i) { i.rayDecimation = 0; });
}

// Invariant 5, for what is a posterior: equal scans make it surer, and never another opinion.
TEST(HilbertMap, EqualScansMakeSurer)
{
  const std::vector<Scan> scans = roomScans(14, 1, 300);
  HilbertMap map;
  double last = 0;
  float lastPrecision = 0;
  for (int i = 0; i < 20; ++i)
  {
    map.insert(scans[0], nearInference(), nullptr, 1);
    double sum = 0;
    for (const auto& end : endsOf(scans[0].fans[0]))
      sum += map.logoddsAt(end).value_or(0);  // 0: beyond the range
    EXPECT_GT(sum, last) << i;
    last = sum;
    float precision = 0;
    const HilbertState state = map.state();
    for (const auto& weight : state.blocks[0].weights) precision += weight.precision;
    EXPECT_GT(precision, lastPrecision);
    lastPrecision = precision;
  }
}

/// FNV-1a over the weights of a state.
uint64_t checksumOf(const HilbertState& state)
{
  uint64_t hash = 0xcbf29ce484222325;
  const auto add = [&](float number)
  {
    uint32_t bits = 0;
    std::memcpy(&bits, &number, sizeof(bits));
    for (int i = 0; i < 4; ++i, bits >>= 8) hash = (hash ^ (bits & 0xFF)) * 0x100000001b3;
  };
  for (const HilbertState::Block& block : state.blocks)
    for (const SitePosterior& weight : block.weights)
    {
      add(weight.mean);
      add(weight.precision);
    }
  for (const float weight : state.classifier) add(weight);
  return hash;
}

// Whatever the compiler, its optimization and the processor: a change of these numbers is a change of all
// maps.
TEST(HilbertMap, TheBytesAreAlwaysThese)
{
  const std::vector<Scan> scans = roomScans(15, 3, 120);
  const std::vector<HilbertStructure> structures = allHilbertStructures();
  const std::vector<uint64_t> expected{17531746860090725503u, 2335297342253818764u, 804666357558942365u,
                                       2164558590451835847u, 3567248852607017219u};
  for (size_t i = 0; i < structures.size(); ++i)
    EXPECT_EQ(checksumOf(learned(structures[i], scans).state()), expected[i]) << nameOf(structures[i]);
}
}  // namespace
}  // namespace lamap::test
