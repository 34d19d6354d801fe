// The structured simulation of the thesis; needs LAMAP_DATA.
#include <gtest/gtest.h>
#include <lamap_core/hilbert/map.h>
#include <lamap_core/math/portable_math.h>
#include <support/hilbert_oracle.h>
#include <support/hilbert_states.h>
#include <support/logistic_oracle.h>
#include <support/pcd_points.h>

#include <algorithm>

namespace lamap::test
{
namespace
{
HilbertInference eightMetres()
{
  HilbertInference inference;
  inference.maxRange = 8.0;  // returns of the scans at 9.95 m are rays without one
  return inference;
}

struct Score
{
  double meanLoss = 0;
  double aucOfPoints = 0;
};

/// How well a map that did not see a scan says where that scan's training points are hits.
Score heldOutScore(const HilbertMap& map, const Scan& scan)
{
  const HilbertFrame frame = frameAround(scan, 0.1);
  const HilbertTrainingSet set =
      trainingSetOf(scan, eightMetres().rangeLimits(), HilbertSampling{}.rules(), frame);
  std::vector<std::pair<double, bool>> scored;
  Score score;
  for (size_t i = 0; i < set.size(); ++i)
  {
    const Eigen::Vector3d place =
        set.points[i] + 0.25 * Eigen::Vector3d(frame.anchorSite.x, frame.anchorSite.y, frame.anchorSite.z);
    const double f = map.logoddsAt(place).value_or(0.0);
    const bool hit = set.labels[i] > 0.5f;
    score.meanLoss += softplus(hit ? -f : f) / static_cast<double>(set.size());
    scored.emplace_back(f, hit);
  }
  std::sort(scored.begin(), scored.end());
  double ranks = 0, hits = 0;
  for (size_t i = 0; i < scored.size(); ++i)
    if (scored[i].second)
    {
      ranks += static_cast<double>(i) + 1;
      hits += 1;
    }
  score.aucOfPoints = (ranks - hits * (hits + 1) / 2) / (hits * (static_cast<double>(scored.size()) - hits));
  return score;
}

TEST(StructuredHilbert, TellsWhatAHeldOutScanWillSee)
{
  const auto folder = dataFolder();
  if (!folder) GTEST_SKIP() << "LAMAP_DATA does not name the folder of measuring data";
  const std::vector<Scan> scans = readStructuredScans(*folder, "sim_structured", 12);
  HilbertMap map;
  for (size_t i = 0; i < scans.size(); ++i)
    if (i != 2) map.insert(scans[i], eightMetres());
  const Score score = heldOutScore(map, scans[2]);
  EXPECT_GE(score.aucOfPoints, 0.99);
  EXPECT_LE(score.meanLoss, 0.2);
  EXPECT_GT(map.weightCount(), 10000u);
  EXPECT_LE(map.lattice().memoryBytes(), 12 * map.weightCount());
  EXPECT_LE(map.memoryBytes(), 40 * map.weightCount());  // with the cells that rays saw
  RecordProperty("auc", std::to_string(score.aucOfPoints));
  RecordProperty("loss", std::to_string(score.meanLoss));
}

TEST(StructuredHilbert, NumberOfThreadsDoesNotMatter)
{
  const auto folder = dataFolder();
  if (!folder) GTEST_SKIP() << "LAMAP_DATA does not name the folder of measuring data";
  const std::vector<Scan> scans = readStructuredScans(*folder, "sim_structured", 3);
  const auto mapOf = [&](unsigned threads)
  {
    HilbertMap map;
    for (const Scan& scan : scans) map.insert(scan, eightMetres(), nullptr, threads);
    return map;
  };
  EXPECT_EQ(differenceOf(mapOf(1).state(), mapOf(2).state()), "");
}
}  // namespace
}  // namespace lamap::test
