// Laws that hold for all four maps.
#include <gtest/gtest.h>
#include <lamap_mrpt/compat/mrpt_compat.h>
#include <lamap_mrpt/observations/observation_rays.h>
#include <mrpt/opengl/CSetOfObjects.h>
#include <support/seeds.h>

#include <exception>
#include <limits>
#include <stdexcept>
#include <string>

#include "law_maps.h"

namespace lamap::test
{
namespace
{
TYPED_TEST_SUITE(MapLaws, AllMaps);

/// A random map, and what it was made of.
template <typename Map>
struct Case
{
  explicit Case(unsigned seed, Settings (*settingsFrom)(Random&) = randomSettings<Map>)
      : random(seed), settings(settingsFrom(random))
  {
    scans = randomScans(random, 4);
    // Cells with equal evidence, which lossless pruning holds once.
    scans.push_back(scans.front());
    name = "seed " + std::to_string(seed) + ": " + nameOf(settings);
  }

  [[nodiscard]] Map map() const { return mapOf<Map>(settings, scans); }

  Random random;
  Settings settings;
  std::vector<TakenScan> scans;
  std::string name;
};

// ---- Order, batches

TYPED_TEST(MapLaws, TheOrderOfScansDoesNotMatter)
{
  for (unsigned seed = 1; seed <= seeds(30); ++seed)
  {
    Case<TypeParam> trial(seed);
    SCOPED_TRACE(trial.name);
    const TypeParam reference = trial.map();
    trial.random.shuffle(trial.scans);
    const TypeParam shuffled = trial.map();
    if (Law<TypeParam>::kForgetsTheOrder)
    {
      ASSERT_EQ(bytesOf(shuffled), bytesOf(reference));
    }
    if (Law<TypeParam>::kAdds)
    {
      ASSERT_TRUE(cellsOf(shuffled) == cellsOf(reference));
    }
    else if (textOf(trial.settings, "creationOpts.features").empty())
    {
      // What is learned depends on it, but not of which cells something is known.
      const auto placesOf = [](const TypeParam& map)
      {
        std::vector<std::array<int32_t, 3>> places;
        for (const auto& cell : cellsOf(map)) places.push_back(std::get<0>(cell));
        return places;
      };
      ASSERT_EQ(placesOf(shuffled), placesOf(reference));
    }
  }
}

template <typename Map, typename = void>
constexpr bool kCanMerge = false;
template <typename Map>
constexpr bool kCanMerge<Map, std::void_t<decltype(std::declval<Map&>().merge(std::declval<const Map&>()))>> =
    true;

TYPED_TEST(MapLaws, BatchesThatAreMergedGiveTheSameMap)
{
  static_assert(kCanMerge<TypeParam> == Law<TypeParam>::kAdds);
  if constexpr (kCanMerge<TypeParam>)
    for (unsigned seed = 1; seed <= seeds(30); ++seed)
    {
      Case<TypeParam> trial(seed);
      SCOPED_TRACE(trial.name);
      const TypeParam reference = trial.map();
      // Not shuffled: the order of what is merged is that of the scans.
      const auto cut = trial.scans.begin() + trial.random.integer(0, static_cast<int>(trial.scans.size()));
      TypeParam merged = mapOf<TypeParam>(trial.settings, {trial.scans.begin(), cut});
      merged.merge(mapOf<TypeParam>(trial.settings, {cut, trial.scans.end()}));
      ASSERT_EQ(bytesOf(merged), bytesOf(reference));
      // In the other order.
      TypeParam other = mapOf<TypeParam>(trial.settings, {cut, trial.scans.end()});
      other.merge(mapOf<TypeParam>(trial.settings, {trial.scans.begin(), cut}));
      ASSERT_TRUE(cellsOf(other) == cellsOf(reference));
      // With itself: as with a copy.
      TypeParam twice = merged;
      twice.merge(reference);
      merged.merge(merged);
      ASSERT_EQ(bytesOf(merged), bytesOf(twice));
      const TypeParam coarser = made<TypeParam>({{"creationOpts.resolution", "0.2"}});
      ASSERT_THROW(merged.merge(coarser), std::invalid_argument);
    }
}

// ---- Translation

TYPED_TEST(MapLaws, MovingByWholeCellsMovesTheMap)
{
  for (unsigned seed = 1; seed <= seeds(30); ++seed)
  {
    Random random(seed);
    Settings settings = randomSettings<TypeParam>(random);
    // Exact numbers, and voxels that move onto voxels.
    set(settings, "creationOpts.resolution", "0.125");
    for (const char* const voxel : {"insertOpts.hitDownsampling", "insertOpts.freeDownsampling"})
      if (textOf(settings, voxel) == "0.25") set(settings, voxel, "0.125");
    // Components of one model of the whole map are a matter of rounding.
    if (std::is_same_v<TypeParam, CHilbertMap>) set(settings, "creationOpts.features", "");
    // Single points that are kept are places in the map, which are rounded far from its origin.
    if (textOf(settings, "creationOpts.training") == "batch") set(settings, "insertOpts.trainingPoints", "");
    SCOPED_TRACE("seed " + std::to_string(seed) + ": " + nameOf(settings));
    const bool planar = textOf(settings, "creationOpts.planar") == "true";
    const std::vector<TakenScan> scans = {roundCloud(random), roundCloud(random)};
    const Cells here = cellsOf(mapOf<TypeParam>(settings, scans));
    ASSERT_FALSE(here.empty());
    // Across the origin; 500 km away in every direction.
    for (CellIndex by : {CellIndex{1, 0, 0}, {-3, 5, -7}, {499999, 0, 0}, {-500001, 499999, -499997}})
    {
      const int step = Law<TypeParam>::kMove_cells;
      by = {by.x * step, by.y * step, planar ? 0 : by.z * step};
      std::vector<TakenScan> there;
      for (const TakenScan& scan : scans)
        there.push_back(moved(scan, 0.125 * by.x, 0.125 * by.y, 0.125 * by.z));
      ASSERT_TRUE(cellsFrom(mapOf<TypeParam>(settings, there), by) == here)
          << "moved by " << by.x << ", " << by.y << ", " << by.z << " cells";
    }
  }
}

// ---- Bad rays

template <typename Map>
int rayFact(const Map& map, const std::string& name)
{
  const auto facts = factsOf(map);
  const auto fact = facts.find(name);
  return fact == facts.end() ? 0 : std::stoi(fact->second);
}

TYPED_TEST(MapLaws, BadRaysAreCountedAndChangeNothing)
{
  for (unsigned seed = 1; seed <= seeds(30); ++seed)
  {
    Random random(seed);
    const Settings settings = with(randomSettings<TypeParam>(random), "insertOpts.rayDecimation", "");
    SCOPED_TRACE("seed " + std::to_string(seed) + ": " + nameOf(settings));
    const TakenScan good = randomCloud(random);
    size_t added = 0;
    const TakenScan bad = spoilt(random, good, added);
    const TypeParam clean = mapOf<TypeParam>(settings, {good});
    TypeParam same = made<TypeParam>(settings);
    same.setMinLoggingLevel(mrpt::system::LVL_ERROR);
    ASSERT_TRUE(same.insertObservation(*bad.observation, bad.robotPose_map));
    ASSERT_EQ(bytesOf(same), bytesOf(clean));
    ASSERT_EQ(rayFact(same, "rays with a hit"), rayFact(clean, "rays with a hit"));
    ASSERT_EQ(rayFact(same, "rays left out"), rayFact(clean, "rays left out") + static_cast<int>(added));
    // From nowhere.
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    for (const mrpt::poses::CPose3D& nowhere :
         {mrpt::poses::CPose3D(kNan, 0, 0, 0, 0, 0), {1e30, 0, 0, 0, 0, 0}, {0, 0, 0, kNan, 0, 0}})
      ASSERT_FALSE(same.insertObservation(*good.observation, nowhere)) << nowhere;
    ASSERT_EQ(bytesOf(same), bytesOf(clean));
  }
}

TYPED_TEST(MapLaws, AScanFromAPoseThatIsNoRigidMotionIsRefused)
{
  Random random(3);
  const TakenScan scan = randomCloud(random);
  TypeParam map = mapOf<TypeParam>({}, {scan});
  map.setMinLoggingLevel(mrpt::system::LVL_ERROR);
  const auto before = bytesOf(map);
  for (const Eigen::Vector3d& scales :
       {Eigen::Vector3d(2, 1, 1), Eigen::Vector3d(-1, 1, 1), Eigen::Vector3d(1, 1, 1.001)})
  {
    Scan stretched = raysOf(*scan.observation, scan.robotPose_map).value();
    stretched.sensorPose_map.linear() = stretched.sensorPose_map.linear() * scales.asDiagonal();
    auto core = map.core();
    EXPECT_THROW(core.insert(stretched, map.insertionOptions), std::invalid_argument);

    mrpt::math::CMatrixDouble33 rotation = scan.robotPose_map.getRotationMatrix();
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 3; ++column) rotation(row, column) *= scales[column];
    mrpt::poses::CPose3D pose = scan.robotPose_map;
    pose.setRotationMatrix(rotation);
    EXPECT_FALSE(map.insertObservation(*scan.observation, pose));
  }
  EXPECT_EQ(bytesOf(map), before);
}

// ---- Probabilities, and how far they reach

TYPED_TEST(MapLaws, ProbabilitiesAreThatAndEndWithTheSupport)
{
  for (unsigned seed = 1; seed <= seeds(30); ++seed)
  {
    const Case<TypeParam> trial(seed);
    SCOPED_TRACE(trial.name);
    const TypeParam map = trial.map();
    const double free = map.stateThresholds().free, occupied = map.stateThresholds().occupied;
    // All rays are shorter than 1.7 m, and start less than 0.9 m from the origin.
    // The whole kernel ends only where it is too small to be told from nothing.
    const bool isWholeKernel = textOf(trial.settings, "creationOpts.features") == "nystroem";
    const double farthest = 0.9 + 1.7 + (isWholeKernel ? 3.0 : Law<TypeParam>::kReach_m);
    map.visitCells(
        [&](const CellIndex& cell, const CellEstimate& estimate)
        {
          ASSERT_TRUE(estimate.prob >= 0 && estimate.prob <= 1) << estimate.prob;
          ASSERT_TRUE(!estimate.variance || (*estimate.variance >= 0 && std::isfinite(*estimate.variance)));
          ASSERT_TRUE(estimate.state != CellState::Occupied || estimate.prob > occupied);
          ASSERT_TRUE(estimate.state != CellState::Free || estimate.prob < free);
          Eigen::Vector3d centre = cellCentre(cell, map.resolution());
          if (map.planarLayer()) centre.z() = 0;
          ASSERT_LT(centre.norm(), farthest);
        });
    for (const mrpt::math::TPoint3D& far :
         {mrpt::math::TPoint3D(farthest + 0.2, 0, 0), {-1000, 0, 0}, {0, 1e300, 0}})
    {
      ASSERT_FALSE(map.estimateAt(far));
      double prob = -1;
      ASSERT_FALSE(map.getPointOccupancy(static_cast<float>(far.x), static_cast<float>(far.y), 0, prob));
      ASSERT_EQ(prob, -1);
    }
    ASSERT_FALSE(made<TypeParam>(trial.settings).estimateAt({0, 0, 0}));
  }
}

// ---- Files, copies

TYPED_TEST(MapLaws, SavedAndLoadedItIsTheSameAndGoesOn)
{
  for (unsigned seed = 1; seed <= seeds(30); ++seed)
  {
    Case<TypeParam> trial(seed, randomSettingsForFiles<TypeParam>);
    SCOPED_TRACE(trial.name);
    TypeParam map = trial.map();
    const auto bytes = bytesOf(map);
    const auto loaded = std::dynamic_pointer_cast<TypeParam>(objectFrom(bytes));
    ASSERT_TRUE(loaded);
    ASSERT_EQ(bytesOf(*loaded), bytes);
    ASSERT_TRUE(cellsOf(*loaded) == cellsOf(map));
    const TakenScan next = randomCloud(trial.random);
    for (TypeParam* each : {&map, loaded.get()})
      each->insertObservation(*next.observation, next.robotPose_map);
    ASSERT_NE(bytesOf(map), bytes);
    ASSERT_EQ(bytesOf(*loaded), bytesOf(map));
  }
}

/// @param message  what the refusal must contain
template <typename Action>
void expectRefusal(const std::string& message, const Action& action)
{
  try
  {
    action();
    ADD_FAILURE() << "not refused: " << message;
  }
  catch (const std::exception& error)
  {
    EXPECT_NE(compat::messageOf(error).find(message), std::string::npos) << error.what();
  }
}

// Otherwise a saved map could not be loaded again.
TYPED_TEST(MapLaws, AnIllegalOptionIsRefusedWhenItIsUsedAndWhenTheMapIsSaved)
{
  Random random(1);
  const TakenScan scan = randomCloud(random);
  const auto likelihood = [&](const TypeParam& map)
  { (void)map.computeObservationLikelihood(*scan.observation, scan.robotPose_map); };
  const auto save = [](const TypeParam& map) { (void)bytesOf(map); };
  const auto draw = [](const TypeParam& map)
  {
    mrpt::opengl::CSetOfObjects scene;
    map.getVisualizationInto(scene);
  };
  TypeParam map = made<TypeParam>();
  map.insertObservation(*scan.observation, scan.robotPose_map);
  likelihood(map);

  TypeParam changed = map;
  changed.insertionOptions.minRange = -1;
  expectRefusal("minRange = -1: must be", [&] { save(changed); });
  changed = map;
  changed.likelihoodOptions.decimation = 0;
  expectRefusal("decimation = 0: must be", [&] { likelihood(changed); });
  expectRefusal("decimation = 0: must be", [&] { save(changed); });
  changed = map;
  changed.likelihoodOptions.outlierProb = 7;
  expectRefusal("outlierProb = 7: must be", [&] { likelihood(changed); });
  changed = map;
  changed.renderingOptions.freeOpacity = 7;
  expectRefusal("freeOpacity = 7: must be", [&] { draw(changed); });
  expectRefusal("freeOpacity = 7: must be", [&] { save(changed); });
}

TYPED_TEST(MapLaws, EveryFlippedByteAndEveryCutIsNoticed)
{
  TypeParam map = made<TypeParam>();
  map.insertRay(0.5F, 0.1F, 0.1F, 0.0F, 0.0F, 0.1F);
  const auto bytes = bytesOf(map);
  const size_t header = 1 + std::string(map.GetRuntimeClass()->className).size();
  for (size_t i = header; i + 1 < bytes.size(); i += 3)
  {
    auto damaged = bytes;
    damaged[i] ^= 0x10;
    EXPECT_ANY_THROW((void)objectFrom(damaged)) << "byte " << i << " of " << bytes.size();
  }
  for (size_t length = 0; length + 1 < bytes.size(); length += 17)
    EXPECT_ANY_THROW((void)objectFrom({bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length)}))
        << length;
}

TYPED_TEST(MapLaws, CopiesAreEqualAndIndependent)
{
  for (unsigned seed = 1; seed <= seeds(10); ++seed)
  {
    Case<TypeParam> trial(seed, randomSettingsForFiles<TypeParam>);
    SCOPED_TRACE(trial.name);
    TypeParam map = trial.map();
    const auto bytes = bytesOf(map);
    const TypeParam copy(map);
    TypeParam assigned = made<TypeParam>();
    assigned = map;
    const std::unique_ptr<mrpt::rtti::CObject> clone(map.clone());
    map.insertionOptions.thresholds.occupied = 0.9;
    const TakenScan next = randomCloud(trial.random);
    map.insertObservation(*next.observation, next.robotPose_map);
    ASSERT_NE(bytesOf(map), bytes);
    ASSERT_EQ(bytesOf(copy), bytes);
    ASSERT_EQ(bytesOf(assigned), bytes);
    ASSERT_EQ(bytesOf(dynamic_cast<const TypeParam&>(*clone)), bytes);
    assigned.insertionOptions.thresholds.occupied = 0.9;
    assigned.insertObservation(*next.observation, next.robotPose_map);
    const TypeParam taken = std::move(assigned);
    ASSERT_EQ(bytesOf(taken), bytesOf(map));
    // Cleared, it starts anew.
    map.insertionOptions.thresholds.occupied = copy.insertionOptions.thresholds.occupied;
    map.clear();
    ASSERT_TRUE(map.isEmpty());
    ASSERT_TRUE(cellsOf(map).empty());
    ASSERT_EQ(bytesOf(map), bytesOf(made<TypeParam>(trial.settings)));
    for (const TakenScan& scan : trial.scans) map.insertObservation(*scan.observation, scan.robotPose_map);
    ASSERT_EQ(bytesOf(map), bytes);
  }
}

// ---- Planar maps

TYPED_TEST(MapLaws, APlanarMapIsOneLayerAtAllHeights)
{
  for (unsigned seed = 1; seed <= seeds(10); ++seed)
  {
    Case<TypeParam> trial(seed);
    set(trial.settings, "creationOpts.planar", "true");
    set(trial.settings, "creationOpts.planarHeight", "0.52");
    set(trial.settings, "insertOpts.rangeStd", "");  // along rays whose direction is rounded
    SCOPED_TRACE(trial.name);
    const TypeParam map = trial.map();
    ASSERT_EQ(map.planarLayer(), 5);
    size_t cells = 0;
    map.visitCells(
        [&](const CellIndex& cell, const CellEstimate& estimate)
        {
          ++cells;
          ASSERT_EQ(cell.z, 5);
          const Eigen::Vector3d centre = cellCentre(cell, map.resolution());
          for (const double z : {-100.0, 0.0, 100.0})
          {
            const auto there = map.estimateAt({centre.x(), centre.y(), z});
            ASSERT_TRUE(there);
            ASSERT_NEAR(there->prob, estimate.prob, 1e-4);
          }
        });
    ASSERT_GT(cells, 20U);
    // Distances are in the plane: a robot that stands elsewhere in height sees the same.
    std::vector<TakenScan> higher;
    for (TakenScan scan : trial.scans)
    {
      mrpt::poses::CPose3D& pose = scan.robotPose_map;
      pose.setFromValues(pose.x(), pose.y(), 0, pose.yaw(), 0, 0);
      higher.push_back(scan);
    }
    const Cells low = cellsOf(mapOf<TypeParam>(trial.settings, higher));
    for (TakenScan& scan : higher) scan = moved(scan, 0, 0, 1024);
    ASSERT_TRUE(cellsOf(mapOf<TypeParam>(trial.settings, higher)) == low);
  }
}

// ---- Pruning

TYPED_TEST(MapLaws, PruningChangesNoStateAndSplitsAgain)
{
  if constexpr (Law<TypeParam>::kPrunes)
    for (unsigned seed = 1; seed <= seeds(15); ++seed)
    {
      Case<TypeParam> trial(seed);
      SCOPED_TRACE(trial.name);
      const auto pruned = [&](const char* how, const std::vector<TakenScan>& scans)
      { return mapOf<TypeParam>(with(trial.settings, "creationOpts.pruning", how), scans); };
      ASSERT_TRUE(cellsOf(pruned("lossless", trial.scans)) == cellsOf(pruned("none", trial.scans)));

      // By state, after a single scan: later ones add to what was evened out.
      const std::vector<TakenScan> one = {trial.scans.front()};
      TypeParam byState = pruned("state", one);
      const auto statesOf = [](const TypeParam& map)
      {
        std::map<std::array<int32_t, 3>, CellState> states;
        for (const auto& [index, prob, state, evidence] : cellsOf(map)) states[index] = state;
        return states;
      };
      auto states = statesOf(byState);
      ASSERT_EQ(states, statesOf(pruned("none", one)));
      if (states.empty()) continue;
      // A cell that is told otherwise changes, and no other.
      const auto [index, state] = *std::next(states.begin(), static_cast<long>(states.size() / 2));
      const bool occupied = state != CellState::Occupied;
      const Eigen::Vector3d centre = cellCentre({index[2], index[1], index[0]}, byState.resolution());
      for (int i = 0; i < 1000; ++i) byState.updateVoxel(centre.x(), centre.y(), centre.z(), occupied);
      states[index] = occupied ? CellState::Occupied : CellState::Free;
      const auto now = statesOf(byState);
      ASSERT_EQ(now.size(), states.size());
      for (const auto& [place, due] : states)
        ASSERT_EQ(now.at(place), due)
            << place[2] << ", " << place[1] << ", " << place[0] << (place == index ? ", which was told" : "");
    }
}
}  // namespace
}  // namespace lamap::test
