// The structured simulation of the thesis; needs LAMAP_DATA.
#include <gtest/gtest.h>
#include <lamap_core/bgk/map.h>
#include <support/bgk_oracle.h>
#include <support/grid_words.h>
#include <support/pcd_points.h>
#include <support/seeded_scans.h>

#include <algorithm>

#define LAMAP_REQUIRE_DATA(folder)  \
  const auto folder = dataFolder(); \
  if (!folder) GTEST_SKIP() << "LAMAP_DATA does not name the folder of measuring data"

namespace lamap::test
{
namespace
{
BgkInference eightMetres(BgkPreset preset = BgkPreset::Default)
{
  BgkInference inference = presetOptions(preset).inference;
  inference.maxRange = 8.0;  // returns of the scans at 9.95 m are rays without one
  return inference;
}

// Thesis eq. (4.26): (α₀ + n·ȳ)/(α₀ + β₀ + n·k̄), with ȳ and k̄ of one scan.
TEST(StructuredLongTerm, MeanFollowsEquation426)
{
  LAMAP_REQUIRE_DATA(folder);
  const std::vector<Scan> scans = readStructuredScans(*folder, "sim_structured_long_term", 60);
  for (const BgkPreset preset : {BgkPreset::Default, BgkPreset::Thesis, BgkPreset::La3dm})
  {
    SCOPED_TRACE(static_cast<int>(preset));
    BgkStructure structure = presetOptions(preset).structure;
    if (structure.pruning == Pruning::State) structure.pruning = Pruning::Lossless;
    const BgkInference inference = eightMetres(preset);
    const OracleField oracle(scans.front(), structure, inference);
    BgkMap one(structure), map(structure);
    one.insert(scans.front(), inference);
    double n = 0, worst = 0, worstFromOracle = 0;
    for (const Scan& scan : scans)
    {
      map.insert(scan, inference);
      ++n;
      if (n != 1 && n != 7 && n != 60) continue;
      size_t cells = 0;
      map.visitCells(inference.thresholds,
                     [&](const CellIndex& cell, const CellEstimate& estimate)
                     {
                       ++cells;
                       const double a0 = structure.priorAlpha, b0 = structure.priorBeta;
                       const CellSums units = one.evidence().at(cell);
                       const double y = static_cast<double>(units.first) * kEvidenceUnit;
                       const double k = y + static_cast<double>(units.second) * kEvidenceUnit;
                       worst = std::max(worst, std::abs(estimate.prob - (a0 + n * y) / (a0 + b0 + n * k)));

                       // By brute force, where a unit of 2^-20 a scan is next to nothing beside the cell's
                       // evidence.
                       const OracleEvidence evidence = oracle.at({cell.x, cell.y, cell.z});
                       const double kOracle = evidence.occupied + evidence.free;
                       if (kOracle < 0.2) return;
                       const double mean = (a0 + n * evidence.occupied) / (a0 + b0 + n * kOracle);
                       worstFromOracle = std::max(worstFromOracle, std::abs(estimate.prob - mean));
                     });
      EXPECT_GT(cells, 10000u);
    }
    EXPECT_LE(worst, 1e-5);
    EXPECT_LE(worstFromOracle, 1e-5);
    RecordProperty("worst_deviation_of_mean_" + std::to_string(static_cast<int>(preset)),
                   std::to_string(worst * 1e15) + "e-15, from the oracle " +
                       std::to_string(worstFromOracle * 1e9) + "e-9");
  }
}

TEST(Structured, EvidenceIsTheBruteForceSumOfEquation410)
{
  LAMAP_REQUIRE_DATA(folder);
  const std::vector<Scan> scans = readStructuredScans(*folder, "sim_structured", 3);
  BgkStructure structure;
  BgkInference inference = eightMetres();
  inference.trainingPoints = TrainingPoints::Centroids;
  inference.hitDownsampling = 0.0;
  inference.freeSpace = FreeSpace::None;
  inference.kernelSupport = 0.3;
  BgkMap map(structure);
  std::vector<OracleField> fields;
  for (const Scan& scan : scans)
  {
    map.insert(scan, inference);
    fields.emplace_back(scan, structure, inference);
  }
  const Comparison comparison = compare(map, fields);
  EXPECT_EQ(comparison.firstDifference, "");
  EXPECT_GT(comparison.cells, 10000u);
  RecordProperty("worst_deviation_1e-9", std::to_string(comparison.worstDeviation * 1e9));
}

TEST(Structured, EvidenceIsTheBruteForceSumOfEveryPreset)
{
  LAMAP_REQUIRE_DATA(folder);
  const std::vector<Scan> scans = readStructuredScans(*folder, "sim_structured", 2);
  for (const BgkPreset preset : {BgkPreset::Default, BgkPreset::Thesis, BgkPreset::La3dm})
  {
    SCOPED_TRACE(static_cast<int>(preset));
    BgkStructure structure = presetOptions(preset).structure;
    structure.pruning = Pruning::None;
    const BgkInference inference = eightMetres(preset);
    BgkMap map(structure);
    std::vector<OracleField> fields;
    for (const Scan& scan : scans)
    {
      map.insert(scan, inference);
      fields.emplace_back(scan, structure, inference);
    }
    const Comparison comparison = compare(map, fields);
    EXPECT_EQ(comparison.firstDifference, "");
    EXPECT_GT(comparison.cells, 10000u);
    RecordProperty("worst_deviation_1e-9_preset_" + std::to_string(static_cast<int>(preset)),
                   std::to_string(comparison.worstDeviation * 1e9));
  }
}

TEST(Structured, AnyOrderAndNumberOfThreadsGivesTheSameWords)
{
  LAMAP_REQUIRE_DATA(folder);
  std::vector<Scan> scans = readStructuredScans(*folder, "sim_structured", 12);
  for (const BgkPreset preset : {BgkPreset::Default, BgkPreset::Thesis, BgkPreset::La3dm})
  {
    SCOPED_TRACE(static_cast<int>(preset));
    BgkStructure structure = presetOptions(preset).structure;
    if (structure.pruning == Pruning::State) structure.pruning = Pruning::Lossless;
    const BgkInference inference = eightMetres(preset);
    const auto mapOf = [&](unsigned threads)
    {
      BgkMap map(structure);
      for (const Scan& scan : scans) map.insert(scan, inference, threads);
      return map;
    };
    const BgkMap reference = mapOf(1);
    Random random(5);
    for (const unsigned threads : {1u, 2u, 3u, 4u, 0u})
    {
      random.shuffle(scans);
      EXPECT_EQ(differenceOf(reference.evidence(), mapOf(threads).evidence()), "") << threads << " threads";
    }
  }
}
}  // namespace
}  // namespace lamap::test
