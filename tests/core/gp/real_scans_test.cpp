// The structured simulation of the thesis; needs LAMAP_DATA.
#include <gtest/gtest.h>
#include <lamap_core/bgk/map.h>
#include <lamap_core/gp/map.h>
#include <support/grid_words.h>
#include <support/pcd_points.h>
#include <support/seeded_scans.h>

#include <string>
#include <utility>

#define LAMAP_REQUIRE_DATA(folder)  \
  const auto folder = dataFolder(); \
  if (!folder) GTEST_SKIP() << "LAMAP_DATA does not name the folder of measuring data"

namespace lamap::test
{
namespace
{
// Thesis section 4.3.3 and figure 4.7: where a robot stands still the committee grows ever surer, and with it
// the walls; BGK settles. So does a committee whose evidence is limited, which is the default.
TEST(StructuredLongTerm, CommitteesGoOnGrowingWhereBgkSettles)
{
  LAMAP_REQUIRE_DATA(folder);
  const std::vector<Scan> scans = readStructuredScans(*folder, "sim_structured_long_term", 60);
  for (const auto& [preset, isLimited] :
       {std::pair{GpPreset::Default, false}, {GpPreset::La3dm, false}, {GpPreset::Default, true}})
  {
    const std::string name = std::to_string(static_cast<int>(preset)) + (isLimited ? "_limited" : "");
    SCOPED_TRACE(name);
    GpOptions options = presetOptions(preset);
    if (!isLimited) options.structure.maxEvidence = 0;
    GpInference inference = options.inference;
    inference.maxRange = 8.0;
    inference.thresholds.occupied = StateThresholds::kOccupiedInThesis;
    GpMap gp(options.structure);
    BgkInference bgkInference;
    bgkInference.maxRange = 8.0;
    bgkInference.thresholds.occupied = StateThresholds::kOccupiedInThesis;
    BgkMap bgk;
    std::vector<size_t> ofGp, ofBgk;
    for (size_t n = 1; n <= scans.size(); ++n)
    {
      gp.insert(scans[n - 1], inference);
      bgk.insert(scans[n - 1], bgkInference);
      if (n != 1 && n != 15 && n != 30 && n != 60) continue;
      const auto count = [](std::vector<size_t>& counts)
      {
        counts.push_back(0);
        return [&counts](const CellIndex&, const CellEstimate& cell)
        { counts.back() += cell.state == CellState::Occupied ? 1 : 0; };
      };
      gp.visitCells(inference.thresholds, count(ofGp));
      bgk.visitCells(bgkInference.thresholds, count(ofBgk));
    }
    for (size_t i = 0; i < 4; ++i)
      RecordProperty("occupied_" + name + "_" + std::to_string(i),
                     std::to_string(ofGp[i]) + " GP, " + std::to_string(ofBgk[i]) + " BGK");
    EXPECT_GT(ofGp[1], ofGp[0] * 21 / 20);
    if (isLimited)
    {
      EXPECT_NEAR(static_cast<double>(ofGp[3]), static_cast<double>(ofGp[1]),
                  0.01 * static_cast<double>(ofGp[1]));
    }
    else
    {
      EXPECT_GT(ofGp[2], ofGp[1]);
      EXPECT_GT(ofGp[3], ofGp[2]);
    }
    EXPECT_NEAR(static_cast<double>(ofBgk[3]), static_cast<double>(ofBgk[1]),
                0.01 * static_cast<double>(ofBgk[1]));
  }
}

TEST(Structured, ScansInAnyOrderGiveTheSameBytes)
{
  LAMAP_REQUIRE_DATA(folder);
  std::vector<Scan> scans = readStructuredScans(*folder, "sim_structured", 12);
  GpInference inference;
  inference.maxRange = 8.0;
  inference.nested = true;
  const auto mapOf = [&](unsigned threads)
  {
    GpMap map;
    for (const Scan& scan : scans) map.insert(scan, inference, threads);
    return map;
  };
  const GpMap reference = mapOf(1);
  Random random(1);
  random.shuffle(scans);
  EXPECT_EQ(differenceOf(reference.evidence(), mapOf(2).evidence()), "");
}

}  // namespace
}  // namespace lamap::test
