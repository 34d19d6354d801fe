#include <gtest/gtest.h>
#include <lamap_tools/inputs/pose_track.h>

#include <Eigen/Core>
#include <cmath>
#include <stdexcept>

#include "support/small_logs.h"
#include "support/temporary_folder.h"

namespace
{
using namespace lamap::tools;
using lamap::test::at;
using mrpt::poses::CPose3D;

constexpr double kPi = 3.14159265358979323846;

void expectSamePose(const CPose3D& pose, const CPose3D& expected, double tolerance = 1e-12)
{
  EXPECT_LT((pose.getHomogeneousMatrixVal<mrpt::math::CMatrixDouble44>().asEigen() -
             expected.getHomogeneousMatrixVal<mrpt::math::CMatrixDouble44>().asEigen())
                .cwiseAbs()
                .maxCoeff(),
            tolerance)
      << pose.asString() << " instead of " << expected.asString();
}

std::string messageOf(const std::string& path)
{
  try
  {
    (void)readPoseFile(path);
  }
  catch (const std::runtime_error& error)
  {
    return error.what();
  }
  return "";
}

// By hand: a quarter of the way of 4 m is 1 m; a quarter of a turn by 90 degrees about z is 22.5 degrees.
TEST(PoseTrack, InterpolatesAtQuarterPoints)
{
  const PoseTrack track({{at(10), CPose3D(0, 0, 0, 0, 0, 0)}, {at(14), CPose3D(4, -8, 2, kPi / 2, 0, 0)}});
  expectSamePose(*track.at(at(11)), CPose3D(1, -2, 0.5, kPi / 8, 0, 0), 1e-9);
  expectSamePose(*track.at(at(12)), CPose3D(2, -4, 1, kPi / 4, 0, 0), 1e-9);
  expectSamePose(*track.at(at(13)), CPose3D(3, -6, 1.5, 3 * kPi / 8, 0, 0), 1e-9);
}

// From 170 to -170 degrees it is 20 degrees through 180, not 340 through 0.
TEST(PoseTrack, TurnsTheShorterWay)
{
  const double angle = 170 * kPi / 180;
  const PoseTrack track({{at(0), CPose3D(0, 0, 0, angle, 0, 0)}, {at(1), CPose3D(0, 0, 0, -angle, 0, 0)}});
  expectSamePose(*track.at(at(0.5)), CPose3D(0, 0, 0, kPi, 0, 0), 1e-9);
}

// A turn about an axis other than x, y or z: interpolating yaw, pitch and roll separately would differ.
TEST(PoseTrack, InterpolatesRotationsOnTheSphere)
{
  const CPose3D turned(0, 0, 0, kPi / 2, 0, kPi / 2);  // 120 degrees about (1, 1, 1)
  const PoseTrack track({{at(0), CPose3D()}, {at(1), turned}});
  const CPose3D half = *track.at(at(0.5));
  expectSamePose(half + half, turned, 1e-9);
}

TEST(PoseTrack, GivesPosesAtTheirOwnTimesUnchangedAndNoneOutside)
{
  const CPose3D first(1.1, 2.2, 3.3, 0.4, 0.5, 0.6);
  const PoseTrack track({{at(2), CPose3D(9, 9, 9, 0, 0, 0)}, {at(1), first}});  // in any order
  EXPECT_EQ(*track.at(at(1)), first);
  EXPECT_FALSE(track.at(at(0.999)).has_value());
  EXPECT_FALSE(track.at(at(2.001)).has_value());
  EXPECT_FALSE(PoseTrack({}).at(at(1)).has_value());
}

TEST(PoseTrack, TheLastOfSeveralPosesOfATimeCounts)
{
  const PoseTrack track({{at(1), CPose3D(1, 0, 0, 0, 0, 0)}, {at(1), CPose3D(2, 0, 0, 0, 0, 0)}});
  EXPECT_EQ(track.at(at(1))->x(), 2);
  EXPECT_EQ(track.poses().size(), 1U);
}

TEST(PoseFile, ReadsTum)
{
  const lamap::test::TemporaryFolder folder;
  const double half = std::sqrt(0.5);
  const auto poses =
      readPoseFile(folder.write("poses.tum", "# a comment\n\n1000000001.5 1 2 3 0 0 " + std::to_string(half) +
                                                 " " + std::to_string(half) + "\n"));
  ASSERT_EQ(poses.size(), 1U);
  EXPECT_EQ(poses[0].time, at(1.5));
  expectSamePose(poses[0].pose_map, CPose3D(1, 2, 3, kPi / 2, 0, 0), 1e-6);
}

TEST(PoseFile, ReadsBothPathTextsOfMrpt)
{
  const lamap::test::TemporaryFolder folder;
  const auto in3D =
      readPoseFile(folder.write("3d.txt", "% time x y z yaw pitch roll\n1000000002 1 2 3 0.1 0.2 0.3\n"));
  EXPECT_EQ(in3D.at(0).time, at(2));
  expectSamePose(in3D[0].pose_map, CPose3D(1, 2, 3, 0.1, 0.2, 0.3));
  const auto in2D = readPoseFile(folder.write("2d.txt", "1000000003 1 2 0.7\n"));
  expectSamePose(in2D.at(0).pose_map, CPose3D(1, 2, 0, 0.7, 0, 0));
}

// By hand: the columns of the rotation are where x, y and z of the robot point to.
TEST(PoseFile, ReadsKittisMatricesRowByRow)
{
  const lamap::test::TemporaryFolder folder;
  const auto poses = readPoseFile(folder.write("00.txt",
                                               "1 0 0 0 0 1 0 0 0 0 1 0\n0 -1 0 1.5 1 0 0 -2e0 0 0 1 3\n"
                                               "1.000e+00 0 0 0 0 0 -1 0 0 1 0 0\n"));
  ASSERT_EQ(poses.size(), 3U);
  EXPECT_EQ(poses[0].time, INVALID_TIMESTAMP);
  expectSamePose(poses[0].pose_map, CPose3D());
  expectSamePose(poses[1].pose_map, CPose3D(1.5, -2, 3, kPi / 2, 0, 0));
  expectSamePose(poses[2].pose_map, CPose3D(0, 0, 0, 0, 0, kPi / 2));
}

TEST(PoseFile, RefusesMatricesThatAreNoRotations)
{
  const lamap::test::TemporaryFolder folder;
  for (const std::string line : {"2 0 0 0 0 2 0 0 0 0 2 0", "1 0 0 0 0 1 0 0 0 0 -1 0",
                                 "0 0 0 0 0 0 0 0 0 0 0 0", "1 1 0 0 0 1 0 0 0 0 1 0"})
    EXPECT_NE(messageOf(folder.write("00.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n" + line + "\n"))
                  .find("line 2: the left 3x3 part of the twelve numbers"),
              std::string::npos)
        << line;
}

TEST(PoseFile, NamesTheLineAndWhatIsWrong)
{
  const lamap::test::TemporaryFolder folder;
  const auto complaint = [&](const std::string& content)
  { return messageOf(folder.write("p.tum", content)); };
  EXPECT_NE(
      complaint("1 0 0 0 0 0 0 1\n2 0 0 0 0 0 0\n").find("line 2: 7 columns where the lines before have 8"),
      std::string::npos);
  EXPECT_NE(complaint("1 0 0\n").find("line 1: 3 columns"), std::string::npos);
  EXPECT_NE(complaint("1 0 0 0 0 0 0 x\n").find("\"x\" is not a finite number"), std::string::npos);
  EXPECT_NE(complaint("1 0 0 0 0 0 nan 1\n").find("\"nan\" is not a finite number"), std::string::npos);
  EXPECT_NE(complaint("1 0 0 0 0 0 0 0\n").find("quaternion"), std::string::npos);
  EXPECT_NE(complaint("1e300 0 0 0 0 0 0 1\n").find("time"), std::string::npos);
  EXPECT_NE(complaint("# only a comment\n").find("holds no pose"), std::string::npos);
  EXPECT_NE(messageOf(folder / "none.tum").find("cannot be read"), std::string::npos);
}
}  // namespace
