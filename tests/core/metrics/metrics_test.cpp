#include <gtest/gtest.h>
#include <lamap_core/metrics/metrics.h>
#include <support/seeds.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <map>
#include <random>
#include <stdexcept>
#include <string>

#include "support/temporary_folder.h"

namespace lamap::test
{
namespace
{
struct Cell
{
  double prob;
  bool occupied;
};

RankedPredictions ranked(const std::vector<Cell>& cells)
{
  std::vector<PredictedCells> predictions;
  for (const Cell& cell : cells)
    predictions.push_back({cell.prob, cell.occupied ? 1U : 0U, cell.occupied ? 0U : 1U});
  return RankedPredictions(predictions);
}

/// Few distinct probabilities, so that there are ties within and across the classes.
std::vector<Cell> randomCells(unsigned seed, size_t count = 200)
{
  std::mt19937 random(seed);
  std::vector<Cell> cells;
  for (size_t i = 0; i < count; ++i)
  {
    const double prob = 0.05 * static_cast<double>(random() % 21);
    cells.push_back({prob, static_cast<double>(random() % 1000) < 100 + 800 * prob});
  }
  cells.push_back({0.4, true});
  cells.push_back({0.6, false});
  return cells;
}

// Four cells: free .1, occupied .35, free .4, occupied .8. One of the four pairs is in the wrong order.
const std::vector<Cell> kFour{{0.1, false}, {0.35, true}, {0.4, false}, {0.8, true}};

TEST(Metrics, MatchHandWorkedScoresOfFourCells)
{
  const RankedPredictions four = ranked(kFour);
  EXPECT_DOUBLE_EQ(*areaUnderRoc(four), 0.75);
  // From the top: .8 is right (1/1), .4 is not, .35 is right (2/3): (1 + 2/3)/2.
  EXPECT_DOUBLE_EQ(*averagePrecision(four), 5.0 / 6);
  EXPECT_DOUBLE_EQ(*logLoss(four), -(std::log(0.9) + std::log(0.35) + std::log(0.6) + std::log(0.8)) / 4);
  EXPECT_DOUBLE_EQ(*brierScore(four), (0.01 + 0.65 * 0.65 + 0.16 + 0.04) / 4);
  // Bins of .1: .1 | .35 | .4 | .8, each alone: (.1 + .65 + .4 + .2)/4.
  EXPECT_NEAR(*expectedCalibrationError(four), 1.35 / 4, 1e-15);
  // Two bins: [0, .5) has mean .85/3 and one of three occupied, [.5, 1] .8 and one of one.
  EXPECT_NEAR(*expectedCalibrationError(four, 2), (std::abs(0.85 / 3 - 1.0 / 3) * 3 + 0.2) / 4, 1e-15);
}

TEST(Metrics, TiesCountHalf)
{
  EXPECT_DOUBLE_EQ(*areaUnderRoc(ranked({{0.5, true}, {0.5, false}})), 0.5);
  // Pairs: (.7, .5) won, (.7, .7) tied, (.5, .5) tied, (.5, .7) lost.
  EXPECT_DOUBLE_EQ(*areaUnderRoc(ranked({{0.7, true}, {0.7, false}, {0.5, true}, {0.5, false}})), 0.5);
  EXPECT_DOUBLE_EQ(*areaUnderRoc(ranked({{0.7, true}, {0.7, false}, {0.7, true}, {0.5, false}})), 0.75);
  // A tie is one threshold: precision 2/4 at full recall.
  EXPECT_DOUBLE_EQ(*averagePrecision(ranked({{0.5, true}, {0.5, false}, {0.5, true}, {0.5, false}})), 0.5);
}

TEST(Metrics, ThresholdsAreStrictOrNotAndForgiveRoundingOfFloats)
{
  const double asFloat = 1 - 1 / (1 + std::exp(static_cast<double>(static_cast<float>(std::log(0.7 / 0.3)))));
  ASSERT_NE(asFloat, 0.7);
  for (const double atThreshold : {0.7, asFloat, 1.4 - asFloat})
  {
    const RankedPredictions cells =
        ranked({{0.2, true}, {atThreshold, true}, {atThreshold, false}, {0.9, true}, {0.71, true}});
    const auto above = precisionRecall(cells, 0.7, ThresholdRule::Above);
    EXPECT_DOUBLE_EQ(*above.precision, 1);
    EXPECT_DOUBLE_EQ(*above.recall, 0.5);
    const auto atLeast = precisionRecall(cells, 0.7, ThresholdRule::AtLeast);
    EXPECT_DOUBLE_EQ(*atLeast.precision, 0.75);
    EXPECT_DOUBLE_EQ(*atLeast.recall, 0.75);
  }
}

TEST(Metrics, WhatIsUndefinedIsNotANumber)
{
  const RankedPredictions none(std::vector<PredictedCells>{});
  EXPECT_FALSE(areaUnderRoc(none) || averagePrecision(none) || logLoss(none) || brierScore(none) ||
               expectedCalibrationError(none));
  EXPECT_TRUE(rocCurve(none).empty());
  for (const bool occupied : {false, true})
  {
    const RankedPredictions one = ranked({{0.25, occupied}, {0.25, occupied}});
    EXPECT_FALSE(areaUnderRoc(one) || averagePrecision(one));
    EXPECT_TRUE(rocCurve(one).empty());
    EXPECT_DOUBLE_EQ(*logLoss(one), -std::log(occupied ? 0.25 : 0.75));
    EXPECT_DOUBLE_EQ(*brierScore(one), occupied ? 0.5625 : 0.0625);
    EXPECT_EQ(precisionRecall(one, 0.2, ThresholdRule::Above).recall.has_value(), occupied);
    EXPECT_EQ(precisionRecall(one, 0.3, ThresholdRule::Above).precision, std::nullopt);
  }
}

TEST(Metrics, RefuseWhatIsNoProbability)
{
  for (const double wrong :
       {-1e-9, 1 + 1e-9, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
    EXPECT_THROW((void)ranked({{wrong, true}, {0.5, false}}), std::invalid_argument) << wrong;
  for (const double clip : {0.0, 0.5, -1.0, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_THROW((void)logLoss(ranked(kFour), clip), std::invalid_argument) << clip;
  EXPECT_THROW((void)calibrationBins(ranked(kFour), 0), std::invalid_argument);
}

TEST(Metrics, CertainErrorsCostTheClip)
{
  EXPECT_NEAR(*logLoss(ranked({{0, true}})), -std::log(1e-6), 1e-9);
  EXPECT_NEAR(*logLoss(ranked({{1, false}})), -std::log(1e-6), 1e-9);
  EXPECT_NEAR(*logLoss(ranked({{1, false}}), 0.25), -std::log(0.25), 1e-12);
  EXPECT_NEAR(*logLoss(ranked({{1, true}, {0, false}})), 1e-6, 1e-9);
}

TEST(CalibrationBins, HoldTheirLowerEndAndTheLastOneHolds1)
{
  const auto bins =
      calibrationBins(ranked({{0, false}, {0.5, true}, {0.5, false}, {0.9, true}, {1, true}}), 2);
  ASSERT_EQ(bins.size(), 2U);
  EXPECT_EQ(bins[0].cells, 1U);
  EXPECT_EQ(bins[0].high, 0.5);
  EXPECT_EQ(bins[1].cells, 4U);
  EXPECT_DOUBLE_EQ(bins[1].meanProb, 2.9 / 4);
  EXPECT_DOUBLE_EQ(bins[1].occupiedShare, 0.75);
}

TEST(RocCurve, OfFourCellsByHand)
{
  const auto curve = rocCurve(ranked(kFour));
  ASSERT_EQ(curve.size(), 5U);
  const double expected[][3] = {{std::numeric_limits<double>::infinity(), 0, 0},
                                {0.8, 0, 0.5},
                                {0.4, 0.5, 0.5},
                                {0.35, 0.5, 1},
                                {0.1, 1, 1}};
  for (size_t i = 0; i < curve.size(); ++i)
  {
    EXPECT_EQ(curve[i].threshold, expected[i][0]);
    EXPECT_DOUBLE_EQ(curve[i].falsePositiveRate, expected[i][1]);
    EXPECT_DOUBLE_EQ(curve[i].truePositiveRate, expected[i][2]);
  }
}

TEST(RocCurve, LeavesOutPointsInsideOfStraightPieces)
{
  const auto curve = rocCurve(ranked({{0.9, true}, {0.8, true}, {0.7, true}, {0.3, false}, {0.2, false}}));
  ASSERT_EQ(curve.size(), 3U);
  EXPECT_EQ(curve[1].threshold, 0.7);
  EXPECT_EQ(curve[1].truePositiveRate, 1);
  EXPECT_EQ(curve[1].falsePositiveRate, 0);
}

double areaByPairs(const std::vector<Cell>& cells)
{
  double wins = 0, pairs = 0;
  for (const Cell& a : cells)
    for (const Cell& b : cells)
      if (a.occupied && !b.occupied)
      {
        wins += a.prob > b.prob ? 1 : a.prob == b.prob ? 0.5 : 0;
        ++pairs;
      }
  return wins / pairs;
}

double areaByTrapezoids(const std::vector<RocPoint>& curve)
{
  double area = 0;
  for (size_t i = 1; i < curve.size(); ++i)
    area += (curve[i].falsePositiveRate - curve[i - 1].falsePositiveRate) *
            (curve[i].truePositiveRate + curve[i - 1].truePositiveRate) / 2;
  return area;
}

TEST(MetricsProperty, AreaIsTheShareOfPairsInOrderAndTheAreaBelowTheCurve)
{
  for (unsigned seed = 1; seed <= seeds(20); ++seed)
  {
    SCOPED_TRACE(seed);
    const auto cells = randomCells(seed);
    const RankedPredictions predictions = ranked(cells);
    EXPECT_NEAR(*areaUnderRoc(predictions), areaByPairs(cells), 1e-12);
    EXPECT_NEAR(areaByTrapezoids(rocCurve(predictions)), areaByPairs(cells), 1e-12);
  }
}

TEST(MetricsProperty, OrderAndGroupingOfTheCellsDoNotMatter)
{
  for (unsigned seed = 1; seed <= seeds(20); ++seed)
  {
    SCOPED_TRACE(seed);
    auto cells = randomCells(seed);
    const RankedPredictions one = ranked(cells);
    std::mt19937 random(seed);
    std::shuffle(cells.begin(), cells.end(), random);
    const RankedPredictions shuffled = ranked(cells);
    const RankedPredictions regrouped(one.ascending());
    for (const RankedPredictions* other : {&shuffled, &regrouped})
    {
      EXPECT_EQ(areaUnderRoc(one), areaUnderRoc(*other));
      EXPECT_EQ(averagePrecision(one), averagePrecision(*other));
      EXPECT_EQ(logLoss(one), logLoss(*other));
      EXPECT_EQ(brierScore(one), brierScore(*other));
      EXPECT_EQ(expectedCalibrationError(one), expectedCalibrationError(*other));
    }
    EXPECT_LE(one.ascending().size(), 23U);
  }
}

TEST(MetricsProperty, RankScoresDependOnTheOrderOfProbabilitiesAlone)
{
  for (unsigned seed = 1; seed <= seeds(20); ++seed)
  {
    SCOPED_TRACE(seed);
    const auto cells = randomCells(seed);
    auto squared = cells, swapped = cells;
    for (Cell& cell : squared) cell.prob *= cell.prob;
    for (Cell& cell : swapped) cell = {1 - cell.prob, !cell.occupied};
    EXPECT_DOUBLE_EQ(*areaUnderRoc(ranked(cells)), *areaUnderRoc(ranked(squared)));
    EXPECT_DOUBLE_EQ(*averagePrecision(ranked(cells)), *averagePrecision(ranked(squared)));
    EXPECT_NE(*brierScore(ranked(cells)), *brierScore(ranked(squared)));
    // Occupied and free are symmetric for these.
    EXPECT_NEAR(*areaUnderRoc(ranked(cells)), *areaUnderRoc(ranked(swapped)), 1e-12);
    EXPECT_NEAR(*logLoss(ranked(cells)), *logLoss(ranked(swapped)), 1e-12);
    EXPECT_NEAR(*brierScore(ranked(cells)), *brierScore(ranked(swapped)), 1e-12);
  }
}

TEST(MetricsProperty, ProperScoresAreLeastForTheTrueShareAndCalibrationErrorIsZeroThere)
{
  for (unsigned occupied = 1; occupied < 20; ++occupied)
  {
    const auto predicted = [&](double prob) {
      return RankedPredictions(std::vector<PredictedCells>{{prob, occupied, 20 - occupied}});
    };
    const double share = occupied / 20.0;
    EXPECT_NEAR(*expectedCalibrationError(predicted(share)), 0, 1e-15);
    for (const double other : {share - 0.04, share + 0.04})
    {
      EXPECT_GT(*logLoss(predicted(other)), *logLoss(predicted(share)));
      EXPECT_GT(*brierScore(predicted(other)), *brierScore(predicted(share)));
      EXPECT_NEAR(*expectedCalibrationError(predicted(other)), 0.04, 1e-12);
    }
  }
}

// Debian's Python, which python3-sklearn is for, whatever comes first in PATH.
const std::string kPython = "/usr/bin/python3";

TEST(Metrics, AgreeWithScikitLearn)
{
  if (std::system((kPython + " -c 'import sklearn' > /dev/null 2>&1").c_str()) != 0)
    GTEST_SKIP() << "scikit-learn is not installed (Debian package python3-sklearn)";
  for (unsigned seed = 1; seed <= 2; ++seed)
  {
    SCOPED_TRACE(seed);
    const TemporaryFolder folder;
    // Thresholds of scikit-learn have no tolerance: 0.7 as 14 * 0.05 may lie above or below.
    auto cells = randomCells(seed, 3000);
    for (Cell& cell : cells) cell.prob = std::round(cell.prob * 20) / 20;
    std::mt19937 random(seed);
    for (int i = 0; i < 3000; ++i)
      cells.push_back({static_cast<double>(random() % 1000003) / 1000002.0, random() % 3 == 0});
    {
      std::ofstream file(folder / "cells.txt");
      file.precision(17);
      for (const Cell& cell : cells) file << cell.prob << " " << cell.occupied << "\n";
    }
    const std::string command = kPython + " " + LAMAP_REFERENCE_METRICS + " < " + (folder / "cells.txt") +
                                " > " + (folder / "scores.txt");
    ASSERT_EQ(std::system(command.c_str()), 0);
    std::map<std::string, double> reference;
    std::ifstream scores(folder / "scores.txt");
    std::string name;
    for (double score = 0; scores >> name >> score;) reference[name] = score;
    ASSERT_EQ(reference.size(), 9U);

    const RankedPredictions predictions = ranked(cells);
    const auto above = precisionRecall(predictions, 0.7, ThresholdRule::Above);
    const auto atLeast = precisionRecall(predictions, 0.7, ThresholdRule::AtLeast);
    EXPECT_NEAR(*areaUnderRoc(predictions), reference["areaUnderRoc"], 1e-12);
    EXPECT_NEAR(*averagePrecision(predictions), reference["averagePrecision"], 1e-12);
    EXPECT_NEAR(*logLoss(predictions), reference["logLoss"], 1e-9);
    EXPECT_NEAR(*brierScore(predictions), reference["brier"], 1e-12);
    EXPECT_NEAR(*above.precision, reference["abovePrecision"], 1e-12);
    EXPECT_NEAR(*above.recall, reference["aboveRecall"], 1e-12);
    EXPECT_NEAR(*atLeast.precision, reference["atLeastPrecision"], 1e-12);
    EXPECT_NEAR(*atLeast.recall, reference["atLeastRecall"], 1e-12);
    EXPECT_GT(*atLeast.recall, *above.recall) << "or there is nothing at the threshold";
    EXPECT_NEAR(areaByTrapezoids(rocCurve(predictions)), reference["areaBelowCurve"], 1e-12);
  }
}
}  // namespace
}  // namespace lamap::test
