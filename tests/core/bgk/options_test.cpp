#include <gtest/gtest.h>
#include <lamap_core/bgk/map.h>
#include <lamap_core/bgk/options.h>
#include <support/seeded_scans.h>

#include <functional>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

namespace lamap::test
{
namespace
{
const double kNan = std::numeric_limits<double>::quiet_NaN();
const double kInf = std::numeric_limits<double>::infinity();

void expectMessage(const std::function<void()>& validate, const std::string& name, const std::string& printed)
{
  try
  {
    validate();
    ADD_FAILURE() << name << " = " << printed << " is taken";
  }
  catch (const std::invalid_argument& error)
  {
    const std::string message = error.what();
    EXPECT_EQ(message.find(name), 0u) << message;
    EXPECT_NE(message.find(printed), std::string::npos) << message;
    EXPECT_NE(message.find("must be"), std::string::npos) << message;
  }
}

void expectStructureRefused(double BgkStructure::*option, const std::string& name,
                            const std::vector<std::pair<double, std::string>>& bad)
{
  for (const auto& [illegal, printed] : bad)
  {
    BgkStructure structure;
    structure.*option = illegal;
    expectMessage([&] { structure.validate(); }, name, printed);
    expectMessage([&] { BgkMap map(structure); }, name, printed);
  }
}

template <typename Group, typename Member>
void expectInferenceRefused(Member Group::*option, const std::string& name,
                            const std::vector<std::pair<double, std::string>>& bad)
{
  for (const auto& [illegal, printed] : bad)
  {
    BgkInference inference;
    inference.*option = static_cast<Member>(illegal);
    expectMessage([&] { inference.validate(0.1); }, name, printed);
    BgkMap map;
    const Scan scan = scanWith({fanOf({0.05, 0.05, 0.05}, {{1.05, 0.05, 0.05}})});
    expectMessage([&] { map.insert(scan, inference, 1); }, name, printed);
    EXPECT_TRUE(map.empty());
  }
}

TEST(BgkStructure, NamesEveryIllegalOptionItsValueAndTheRange)
{
  BgkStructure().validate();
  expectStructureRefused(
      &BgkStructure::resolution, "resolution",
      {{0, "0"}, {-0.25, "-0.25"}, {kNan, "nan"}, {kInf, "inf"}, {1e-300, "1"}, {1e300, "1"}});
  expectStructureRefused(&BgkStructure::planarHeight, "planarHeight",
                         {{kNan, "nan"}, {kInf, "inf"}, {-1e300, "-1"}});
  expectStructureRefused(&BgkStructure::priorAlpha, "priorAlpha",
                         {{0, "0"}, {-0.5, "-0.5"}, {kNan, "nan"}, {kInf, "inf"}});
  expectStructureRefused(&BgkStructure::priorBeta, "priorBeta",
                         {{0, "0"}, {-0.5, "-0.5"}, {kNan, "nan"}, {kInf, "inf"}});
  for (const int depth : {-1, 0, 1, 7, 31})
  {
    BgkStructure structure;
    structure.blockDepth = depth;
    expectMessage([&] { structure.validate(); }, "blockDepth", std::to_string(depth));
  }
  for (const int depth : {2, 3, 4, 5, 6})
  {
    BgkStructure structure;
    structure.blockDepth = depth;
    EXPECT_NO_THROW(structure.validate());
    EXPECT_EQ(BgkMap(structure).evidence().shape().edge(), 1 << (depth - 1));
  }
}

TEST(BgkInference, NamesEveryIllegalOptionItsValueAndTheRange)
{
  BgkInference().validate(0.1);
  const std::vector<std::pair<double, std::string>> notFiniteOrNegative{
      {-0.25, "-0.25"}, {kNan, "nan"}, {kInf, "inf"}};
  auto notPositive = notFiniteOrNegative;
  notPositive.emplace_back(0, "0");
  expectInferenceRefused(&BgkInference::freeResolution, "freeResolution", notPositive);
  expectInferenceRefused(&BgkInference::freeMargin, "freeMargin", notFiniteOrNegative);
  expectInferenceRefused(&BgkInference::freeWeight, "freeWeight", notFiniteOrNegative);
  expectInferenceRefused(&BgkInference::freeDownsampling, "freeDownsampling", notFiniteOrNegative);
  expectInferenceRefused(&BgkInference::hitDownsampling, "hitDownsampling", notFiniteOrNegative);
  expectInferenceRefused(&BgkInference::kernelSupport, "kernelSupport", notPositive);
  expectInferenceRefused(&BgkInference::kernelScale, "kernelScale", notPositive);
  expectInferenceRefused(&BgkInference::minRange, "minRange", notFiniteOrNegative);
  expectInferenceRefused(&BgkInference::maxRange, "maxRange", notFiniteOrNegative);
  expectInferenceRefused(&BgkInference::rayDecimation, "rayDecimation", {{0, "0"}});
}

TEST(BgkInference, RefusesLengthsThatWouldNeverEnd)
{
  expectInferenceRefused(&BgkInference::freeResolution, "freeResolution", {{1e-12, "e-"}, {1e-320, "e-"}});
  expectInferenceRefused(&BgkInference::hitDownsampling, "hitDownsampling", {{1e-9, "e-"}, {1e-320, "e-"}});
  expectInferenceRefused(&BgkInference::freeDownsampling, "freeDownsampling", {{1e-9, "e-"}, {1e-320, "e-"}});
  expectInferenceRefused(&BgkInference::kernelSupport, "kernelSupport", {{1e9, "1e9"}});
}

TEST(BgkInference, RefusesASupportWhoseSquareIsZero)
{
  expectInferenceRefused(&BgkInference::kernelSupport, "kernelSupport", {{1e-200, "e-200"}, {1e-320, "e-"}});
}

TEST(BgkInference, RefusesAMaximumRangeThatIsNotBeyondTheMinimum)
{
  BgkInference inference;
  inference.minRange = 5;
  inference.maxRange = 4;
  expectMessage([&] { inference.validate(0.1); }, "maxRange", "4");
  inference.maxRange = 6;
  EXPECT_NO_THROW(inference.validate(0.1));
}

TEST(BgkInference, NamesEveryIllegalThreshold)
{
  const auto expectRefused =
      [](double StateThresholds::*option, const std::string& name, double bad, const std::string& printed)
  {
    BgkInference inference;
    inference.thresholds.*option = bad;
    expectMessage([&] { inference.validate(0.1); }, name, printed);
  };
  for (const auto& [bad, printed] : std::vector<std::pair<double, std::string>>{
           {-0.25, "-0.25"}, {1.5, "1.5"}, {kNan, "nan"}, {kInf, "inf"}})
  {
    expectRefused(&StateThresholds::free, "freeThreshold", bad, printed);
    expectRefused(&StateThresholds::occupied, "occupiedThreshold", bad, printed);
  }
  // Each in its range, but crossed.
  expectRefused(&StateThresholds::occupied, "occupiedThreshold", 0.25, "0.25");
  for (const auto& [bad, printed] :
       std::vector<std::pair<double, std::string>>{{-0.25, "-0.25"}, {kNan, "nan"}, {kInf, "inf"}})
    expectRefused(&StateThresholds::variance, "varianceThreshold", bad, printed);
}

TEST(BgkInference, FillsInLengthsThatAreGivenInCells)
{
  const BgkInference resolved = BgkInference().resolved(0.25);
  EXPECT_EQ(resolved.freeResolution, 0.25);
  EXPECT_EQ(resolved.freeMargin, 0.125);
  EXPECT_EQ(resolved.hitDownsampling, 0.25);
  EXPECT_EQ(resolved.kernelSupport, 0.5);
  BgkInference own;
  own.freeResolution = 1.0, own.freeMargin = 0.0, own.hitDownsampling = 0.0, own.kernelSupport = 0.3;
  EXPECT_TRUE(own.resolved(0.25) == own);
}

TEST(BgkPreset, DefaultIsWhatWasMeasuredBest)
{
  const BgkOptions options = presetOptions(BgkPreset::Default);
  EXPECT_TRUE(options.structure == BgkStructure());
  EXPECT_TRUE(options.inference == BgkInference());
  EXPECT_EQ(options.structure.resolution, 0.1);
  EXPECT_EQ(options.structure.blockDepth, 4);
  EXPECT_EQ(options.structure.pruning, Pruning::Lossless);
  EXPECT_FALSE(options.structure.planar);
  EXPECT_EQ(options.structure.priorAlpha, 0.003);
  EXPECT_EQ(options.structure.priorBeta, 0.003);
  EXPECT_EQ(options.inference.freeSpace, FreeSpace::Samples);
  EXPECT_EQ(options.inference.trainingPoints, TrainingPoints::Cells);
  EXPECT_EQ(options.inference.freeWeight, 0.5);
  EXPECT_EQ(options.inference.protectHits, 2u);
  EXPECT_EQ(options.inference.kernel, KernelShape::Sparse);
  EXPECT_EQ(options.inference.kernelScale, 1.0);
  EXPECT_EQ(options.inference.minRange, 0.0);
  EXPECT_EQ(options.inference.maxRange, 0.0);
  EXPECT_TRUE(options.inference.considerInvalidRangesAsFreeSpace);
  EXPECT_EQ(options.inference.rayDecimation, 1u);
  EXPECT_EQ(options.inference.thresholds.free, 0.3);
  EXPECT_EQ(options.inference.beamWidth, BeamWidth::Spacing);
  EXPECT_FALSE(options.inference.usePoseCovariance);
  EXPECT_EQ(options.inference.thresholds.occupied, 0.55);
  EXPECT_EQ(options.inference.thresholds.variance, 0.0);
}

TEST(BgkPreset, ThesisIsChapterFour)
{
  const BgkOptions options = presetOptions(BgkPreset::Thesis);
  options.structure.validate();
  options.inference.validate(options.structure.resolution);
  EXPECT_EQ(options.structure.resolution, 0.1);
  EXPECT_EQ(options.structure.blockDepth, 3);
  EXPECT_EQ(options.structure.pruning, Pruning::State);
  EXPECT_EQ(options.structure.priorAlpha, 0.001);
  EXPECT_EQ(options.structure.priorBeta, 0.001);
  EXPECT_EQ(options.inference.trainingPoints, TrainingPoints::Centroids);
  EXPECT_EQ(options.inference.freeSpace, FreeSpace::Samples);
  EXPECT_EQ(options.inference.freeResolution, 0.5);
  EXPECT_EQ(options.inference.freeMargin, 0.0);
  EXPECT_EQ(options.inference.freeWeight, 1.0);
  EXPECT_EQ(options.inference.freeDownsampling, 0.0);
  EXPECT_EQ(options.inference.protectHits, 0u);
  EXPECT_EQ(options.inference.kernel, KernelShape::Sparse);
  EXPECT_EQ(options.inference.kernelSupport, 0.3);
  EXPECT_EQ(options.inference.kernelScale, 10.0);
  EXPECT_EQ(options.inference.beamWidth, BeamWidth::None);
  EXPECT_EQ(options.inference.thresholds.occupied, 0.7);
  EXPECT_FALSE(options.inference.considerInvalidRangesAsFreeSpace);
}

TEST(BgkPreset, La3dmIsItsShippedConfiguration)
{
  const BgkOptions options = presetOptions(BgkPreset::La3dm);
  options.structure.validate();
  options.inference.validate(options.structure.resolution);
  EXPECT_EQ(options.structure.blockDepth, 3);
  EXPECT_EQ(options.structure.priorAlpha, 0.001);
  EXPECT_EQ(options.structure.priorBeta, 0.001);
  EXPECT_EQ(options.inference.trainingPoints, TrainingPoints::Centroids);
  EXPECT_EQ(options.inference.freeSpace, FreeSpace::Samples);
  EXPECT_EQ(options.inference.freeResolution, 0.5);
  EXPECT_EQ(options.inference.hitDownsampling, 0.1);
  EXPECT_EQ(options.inference.freeDownsampling, 0.1);
  EXPECT_EQ(options.inference.freeMargin, 0.0);
  EXPECT_EQ(options.inference.freeWeight, 1.0);
  EXPECT_EQ(options.inference.protectHits, 0u);
  EXPECT_EQ(options.inference.kernel, KernelShape::Sparse);
  EXPECT_EQ(options.inference.kernelSupport, 0.2);
  EXPECT_EQ(options.inference.kernelScale, 1.0);
}
}  // namespace
}  // namespace lamap::test
