#include <gtest/gtest.h>
#include <lamap_tools/files/text_fields.h>
#include <lamap_tools/files/usage_error.h>
#include <lamap_tools/inputs/scan_source.h>
#include <mrpt/core/format.h>

#include <cmath>
#include <stdexcept>

#include "support/seeded_scans.h"
#include "support/small_logs.h"
#include "support/temporary_folder.h"

namespace
{
using namespace lamap::tools;
using namespace lamap::test;

using Points = std::vector<Eigen::Vector3d>;

const std::string kNoTurn = "0 0 0 1 0 0 0";

/// A file of points with all their digits.
std::string pcd(const Points& points, const std::string& viewpoint = kNoTurn)
{
  const std::string count = std::to_string(points.size());
  std::string text = "VERSION 0.7\nFIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nCOUNT 1 1 1\nWIDTH " + count +
                     "\nHEIGHT 1\nVIEWPOINT " + viewpoint + "\nPOINTS " + count + "\nDATA ascii\n";
  for (const Eigen::Vector3d& point : points)
    text += mrpt::format("%.17g %.17g %.17g\n", point.x(), point.y(), point.z());
  return text;
}

/// A part of a wall, as a sensor that looks along x has it.
Points wallAhead()
{
  Points points;
  for (int y = -20; y <= 20; ++y)
    for (int z = -5; z <= 5; ++z) points.emplace_back(3, 0.1 * y, 0.1 * z);
  return points;
}

/// What a sensor at this place sees of a box of 12 x 8 x 3 m about the origin: one ray in each of many
/// directions.
Points roomSeenFrom(const Eigen::Vector3d& place)
{
  Points points;
  const Eigen::Vector3d half(6, 4, 1.5);
  for (int azimuth = 0; azimuth < 360; azimuth += 3)
    for (int elevation = -15; elevation <= 15; elevation += 3)
    {
      const double a = azimuth * M_PI / 180;
      const double e = elevation * M_PI / 180;
      const Eigen::Vector3d ray(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e));
      double length = 100;
      for (int axis = 0; axis < 3; ++axis)
        if (ray[axis] != 0)
          length = std::min(length, (std::copysign(half[axis], ray[axis]) - place[axis]) / ray[axis]);
      points.push_back(place + length * ray);
    }
  return points;
}

Points movedBy(Points points, const Eigen::Isometry3d& motion)
{
  for (Eigen::Vector3d& point : points) point = motion * point;
  return points;
}

Eigen::Isometry3d poseAt(double x, double y, double z, double yaw)
{
  Eigen::Isometry3d pose(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()));
  pose.translation() = Eigen::Vector3d(x, y, z);
  return pose;
}

std::string kittiLine(const Eigen::Isometry3d& pose)
{
  std::string line;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column) line += mrpt::format("%.12g ", pose.matrix()(row, column));
  return line + "\n";
}

std::string tumLine(const std::string& time, const Eigen::Isometry3d& pose)
{
  const Eigen::Quaterniond turn(pose.linear());
  return time + mrpt::format(" %.9g %.9g %.9g %.9g %.9g %.9g %.9g\n", pose.translation().x(),
                             pose.translation().y(), pose.translation().z(), turn.x(), turn.y(), turn.z(),
                             turn.w());
}

/// An input read to its end.
struct Reading
{
  std::vector<lamap::Scan> scans;
  std::vector<std::string> leftOut;
  std::string notes;
  std::string jointNotes;
  std::string damages;
};

Reading readAll(const InputOptions& options)
{
  Reading reading;
  for (const auto& source : openInputs(options))
  {
    while (const auto item = source->next())
    {
      if (const auto* scan = std::get_if<PointScan>(&*item)) reading.scans.push_back(scan->scan);
      if (const auto* left = std::get_if<LeftOutScan>(&*item)) reading.leftOut.push_back(left->reason);
    }
    for (const std::string& note : source->notes()) reading.notes += note + "\n";
    for (const std::string& note : source->jointNotes()) reading.jointNotes += note + "\n";
    for (const std::string& damage : source->damages()) reading.damages += damage + "\n";
  }
  return reading;
}

template <class Error>
std::string complaintOf(const InputOptions& options)
{
  try
  {
    (void)readAll(options);
  }
  catch (const Error& error)
  {
    return error.what();
  }
  return "";
}

bool says(const std::string& text, const std::string& words)
{
  return text.find(words) != std::string::npos;
}

std::vector<double> xOfCentres(const std::vector<lamap::Scan>& scans)
{
  std::vector<double> places;
  for (const lamap::Scan& scan : scans) places.push_back(scan.inMap(scan.fans.at(0).centre).x());
  return places;
}

class PcdFolderOfScans : public testing::Test
{
 protected:
  void SetUp() override { options_.paths = {folder_.path()}; }

  TemporaryFolder folder_;
  TemporaryFolder poses_;
  InputOptions options_;
};

TEST_F(PcdFolderOfScans, InTheSensorsFrameKeepsItAndTakesThePoseOfTheScan)
{
  const Eigen::Isometry3d pose = poseAt(10, -2, 1, M_PI / 2);
  folder_.write("0.pcd", pcd({{3, 0.5, -0.25}, {0, 0, 0}}, "7 7 7 0 0 0 0"));  // VIEWPOINT does not matter
  options_.cloudFrame = CloudFrame::Sensor;
  options_.sensorOrigin = {0.5, 0, 0.25};
  for (const std::string& poses :
       {poses_.write("p.tum", tumLine("5", pose)), poses_.write("p.kitti", kittiLine(pose))})
  {
    SCOPED_TRACE(poses);
    options_.posesPath = poses;
    const Reading reading = readAll(options_);
    ASSERT_EQ(reading.scans.size(), 1U);
    const lamap::Scan& scan = reading.scans[0];
    EXPECT_LT((scan.sensorPose_map.matrix() - pose.matrix()).norm(), 1e-8);
    EXPECT_EQ(scan.fans.at(0).centre, options_.sensorOrigin);
    EXPECT_EQ(scan.fans[0].rays.at(0).end, Eigen::Vector3d(3, 0.5, -0.25));
    // By hand: turned by 90 degrees about z, (3, 0.5) is (-0.5, 3).
    EXPECT_LT((scan.inMap(scan.fans[0].rays[0].end) - Eigen::Vector3d(9.5, 1, 0.75)).norm(), 1e-8);
    EXPECT_LT((scan.inMap(scan.fans[0].centre) - Eigen::Vector3d(10, -1.5, 1.25)).norm(), 1e-8);
    EXPECT_TRUE(says(reading.notes, "clouds in the sensor's frame, poses from the given file"));
  }
}

TEST_F(PcdFolderOfScans, InTheSensorsFrameWithoutPosesTakesThatOfViewpoint)
{
  folder_.write("0.pcd", pcd({{3, 0, 0}}, "1 2 3 0.70710678118654757 0 0 0.70710678118654757"));
  options_.cloudFrame = CloudFrame::Sensor;
  const Reading reading = readAll(options_);
  ASSERT_EQ(reading.scans.size(), 1U);
  EXPECT_LT((reading.scans[0].inMap({3, 0, 0}) - Eigen::Vector3d(1, 5, 3)).norm(), 1e-12);
  EXPECT_TRUE(reading.scans[0].fans.at(0).centre.isZero(0));
}

TEST_F(PcdFolderOfScans, RotationsOfViewpointMatterOnlyWhereTheyAreUsed)
{
  for (const std::string rotation : {"0 0 0 0", "2 0 0 0", "0.5 0 0 0.2"})
  {
    SCOPED_TRACE(rotation);
    folder_.write("0.pcd", pcd({{3, 0, 0}}, "1 2 3 " + rotation));
    options_ = {};
    options_.paths = {folder_.path()};
    Reading reading = readAll(options_);
    ASSERT_EQ(reading.scans.size(), 1U) << reading.damages;
    EXPECT_EQ(reading.scans[0].fans.at(0).centre, Eigen::Vector3d(1, 2, 3));
    options_.sensorOrigin = {0, 0, 1};
    reading = readAll(options_);
    EXPECT_TRUE(says(reading.damages, "0.pcd: the rotation of VIEWPOINT")) << reading.damages;
    EXPECT_TRUE(says(reading.damages, "--sensor-origin needs it")) << reading.damages;
    options_.cloudFrame = CloudFrame::Sensor;
    EXPECT_TRUE(says(readAll(options_).damages, "--cloud-frame sensor needs it"));
    options_.posesPath = poses_.write("p.tum", tumLine("5", poseAt(1, 0, 0, 0)));
    EXPECT_EQ(readAll(options_).scans.size(), 1U) << "replaced by a pose";
  }
}

TEST_F(PcdFolderOfScans, CloudsAboutTheirOwnOriginAreNoticedWhilePosesMove)
{
  const std::vector<Eigen::Isometry3d> path{poseAt(0, 0, 0, 0), poseAt(1, 0, 0, M_PI / 2),
                                            poseAt(2, 1, 0, M_PI)};
  std::string kitti;
  for (const auto& pose : path) kitti += kittiLine(pose);
  options_.posesPath = poses_.write("p.kitti", kitti);
  const auto notesOf = [&](const auto& cloudOf)
  {
    for (size_t i = 0; i < path.size(); ++i) folder_.write(std::to_string(i) + ".pcd", pcd(cloudOf(path[i])));
    return readAll(options_).notes;
  };
  const auto wall = [](const auto&) { return wallAhead(); };
  const auto room = [](const auto& pose)
  { return movedBy(roomSeenFrom(pose.translation()), pose.inverse()); };
  const auto wallInMap = [](const auto& pose) { return movedBy(wallAhead(), pose); };
  const auto roomInMap = [](const auto& pose) { return roomSeenFrom(pose.translation()); };
  const std::string notice = "clouds lie about their own origin while the poses move by 2.2 m";
  EXPECT_TRUE(says(notesOf(wall), notice));
  EXPECT_TRUE(says(notesOf(wall), "give --cloud-frame sensor"));
  EXPECT_TRUE(says(notesOf(room), notice));
  EXPECT_FALSE(says(notesOf(wallInMap), "own origin"));
  EXPECT_FALSE(says(notesOf(roomInMap), "own origin"));

  options_.cloudFrame = CloudFrame::Sensor;
  EXPECT_FALSE(says(notesOf(wall), "own origin")) << "it was said";
  EXPECT_TRUE(says(notesOf(roomInMap), "leave out --cloud-frame sensor"));
  options_.cloudFrame = CloudFrame::Map;
  options_.posesPath.clear();
  EXPECT_FALSE(says(notesOf(wall), "own origin")) << "nothing moves";
}

TEST_F(PcdFolderOfScans, CloudsFarFromTheOriginAreNotNoticed)
{
  for (int i = 0; i < 4; ++i)
  {
    // Without rotations: a camera that turns, far from the map's origin.
    const Eigen::Isometry3d pose = poseAt(448123.4 + i, 5412345.6, 310.2, i);
    folder_.write(
        std::to_string(i) + ".pcd",
        pcd(movedBy(wallAhead(), pose), mrpt::format("%.1f 5412345.6 310.2 0 0 0 0", 448123.4 + i)));
  }
  EXPECT_FALSE(says(readAll(options_).notes, "own origin"));
}

TEST_F(PcdFolderOfScans, SingleFilesWithViewpointsAreNoticedToo)
{
  options_.paths = {
      folder_.write("a.pcd", pcd(wallAhead())),
      folder_.write("b.pcd", pcd(wallAhead(), "4 0 0 1 0 0 0")),
      folder_.write("c.pcd", pcd(wallAhead(), "8 0 0 1 0 0 0")),
  };
  const Reading reading = readAll(options_);
  EXPECT_FALSE(says(reading.notes, "own origin")) << "it is not about one of them";
  EXPECT_TRUE(
      says(reading.jointNotes, firstFewOf(options_.paths) + ": all 3 clouds lie about their own origin"))
      << reading.jointNotes;
}

TEST_F(PcdFolderOfScans, HiddenFilesAndFoldersAreNoScans)
{
  folder_.write("1.pcd", pcd({{3, 0, 0}}));
  folder_.write("2.pcd", pcd({{4, 0, 0}}));
  folder_.write("._1.pcd", std::string("\0\5\26\7\0\2\0\0Mac OS X        ", 24));
  folder_.write(".partial-123-2.pcd", pcd({{9, 9, 9}}).substr(0, 40));
  folder_.write(".hidden.pcd", pcd({{9, 9, 9}}));
  folder_.write("1.pcd.bak", "no scan");
  folder_.write("times.txt", "no scan");
  std::filesystem::create_directory(folder_ / "old.pcd");
  std::filesystem::create_directory(folder_ / "more");
  std::ofstream(folder_ / "more/3.pcd") << pcd({{9, 9, 9}});
  options_.posesPath = poses_.write("p.tum", "0.5 10 0 0 0 0 0 1\n1.5 20 0 0 0 0 0 1\n");
  const Reading reading = readAll(options_);
  EXPECT_EQ(xOfCentres(reading.scans), (std::vector<double>{10, 20}));
  EXPECT_EQ(reading.damages, "");
  EXPECT_TRUE(says(reading.notes, "left out: 3 hidden files")) << reading.notes;
}

// The format does not say of what the numbers are; millimetres are common where they are whole.
TEST_F(PcdFolderOfScans, WholeNumbersAreTakenToBeMetresAndThatIsToldOnce)
{
  const std::string floats = pcd({{1, 2, 3}});
  std::string whole = floats;
  whole.replace(whole.find("TYPE F F F"), 10, "TYPE F F I");
  for (const char* name : {"11.pcd", "12.pcd"}) folder_.write(name, whole);
  const Reading reading = readAll(options_);
  EXPECT_TRUE(says(reading.jointNotes, "11.pcd, " + folder_ / "12.pcd" + ": whole numbers (TYPE I or U)"))
      << reading.jointNotes;
  EXPECT_TRUE(says(reading.jointNotes, "taken to be metres"));
  EXPECT_EQ(lamap::test::endsOf(reading.scans.back().fans.at(0)), (Points{{1, 2, 3}}));
}

TEST_F(PcdFolderOfScans, HiddenFilesAloneAreNoScans)
{
  folder_.write("._1.pcd", "?");
  EXPECT_TRUE(says(complaintOf<std::runtime_error>(options_),
                   "a folder without .pcd files; left out: 1 hidden file"));
}

TEST_F(PcdFolderOfScans, NamesThatAreTimesChooseThePose)
{
  const std::string poses =
      "1305031102.1000 10 0 0 0 0 0 1\n1305031102.175304 20 0 0 0 0 0 1\n1305031103.25 30 0 0 0 0 0 1\n"
      "1305031104 40 0 0 0 0 0 1\n";
  options_.posesPath = poses_.write("p.tum", poses);
  for (const std::vector<std::string>& names :
       std::vector<std::vector<std::string>>{{"1305031102.175304", "1305031104.000000"},
                                             {"1305031102175", "1305031104000"},
                                             {"1305031102175304", "1305031104000000"},
                                             {"1305031102175304000", "1305031104000000000"}})
  {
    SCOPED_TRACE(names[0]);
    const TemporaryFolder folder;
    for (const std::string& name : names) folder.write(name + ".pcd", pcd({{1, 0, 0}}));
    options_.paths = {folder.path()};
    const bool isWithin = names[0] != "1305031102175";  // 0.3 ms off: not the same time
    if (isWithin)
      EXPECT_EQ(xOfCentres(readAll(options_).scans), (std::vector<double>{20, 40}));
    else
      EXPECT_TRUE(says(complaintOf<std::runtime_error>(options_), "4 poses for 2 PCD files"));
  }
}

TEST_F(PcdFolderOfScans, ATimeWithoutPoseIsLeftOutAndSaid)
{
  for (const char* name : {"1305031102.1", "1305031102.2", "1305031102.3"})
    folder_.write(std::string(name) + ".pcd", pcd({{1, 0, 0}}));
  options_.posesPath =
      poses_.write("p.tum", "1305031102.1 10 0 0 0 0 0 1\n1305031102.3 30 0 0 0 0 0 1\n7 0 0 0 0 0 0 1\n");
  const Reading reading = readAll(options_);
  EXPECT_EQ(xOfCentres(reading.scans), (std::vector<double>{10, 30}));
  ASSERT_EQ(reading.leftOut.size(), 1U);
  EXPECT_TRUE(says(reading.leftOut[0], "no pose has the time"));
}

// Numbers of files are no times, even if some of them are equal to one.
TEST_F(PcdFolderOfScans, NumberedFilesTakePosesInTheirOrder)
{
  for (const char* name : {"000000", "000001", "000002"})
    folder_.write(std::string(name) + ".pcd", pcd({{1, 0, 0}}));
  options_.posesPath = poses_.write("p.tum", "0 10 0 0 0 0 0 1\n0.5 20 0 0 0 0 0 1\n1 30 0 0 0 0 0 1\n");
  const Reading reading = readAll(options_);
  EXPECT_EQ(xOfCentres(reading.scans), (std::vector<double>{10, 20, 30}));
  EXPECT_FALSE(says(reading.notes, "disagree") || says(reading.notes, "earlier")) << reading.notes;
}

TEST_F(PcdFolderOfScans, NamesThatAreTimesOfNoPoseAreNoticed)
{
  for (const char* name : {"1305031102.1", "1305031102.2"})
    folder_.write(std::string(name) + ".pcd", pcd({{1, 0, 0}}));
  options_.posesPath = poses_.write("p.tum", "1405031102.1 10 0 0 0 0 0 1\n1405031102.2 20 0 0 0 0 0 1\n");
  const Reading reading = readAll(options_);
  EXPECT_EQ(xOfCentres(reading.scans), (std::vector<double>{10, 20})) << "in their order";
  EXPECT_TRUE(says(reading.notes, "from the given file, the k-th for the k-th file")) << reading.notes;
  EXPECT_TRUE(says(reading.notes,
                   "its names look like times, 1305031102.1000 to 1305031102.2000 s, but are not those of "
                   "the poses, 1405031102.1000 to 1405031102.2000 s"))
      << reading.notes;
  options_.posesPath = poses_.write("q.tum", "1305031102.1 10 0 0 0 0 0 1\n1305031102.2 20 0 0 0 0 0 1\n");
  EXPECT_TRUE(says(readAll(options_).notes, "from the given file, by the times that are the names"));
  EXPECT_FALSE(says(readAll(options_).notes, "look like"));
}

// In natural order, 9 comes before 25; as decimals, .25 comes before .9.
TEST_F(PcdFolderOfScans, SaysWhereNaturalOrderAndTimesDisagree)
{
  for (const char* name : {"100.9", "100.25"}) folder_.write(std::string(name) + ".pcd", pcd({{1, 0, 0}}));
  options_.posesPath = poses_.write("p.tum", "100.25 10 0 0 0 0 0 1\n100.9 20 0 0 0 0 0 1\n");
  const Reading reading = readAll(options_);
  EXPECT_EQ(xOfCentres(reading.scans), (std::vector<double>{10, 20}));
  EXPECT_TRUE(says(reading.notes, "disagree (100.9.pcd comes before 100.25.pcd)")) << reading.notes;
}

TEST_F(PcdFolderOfScans, SaysWherePosesTakenInOrderGoBackInTime)
{
  for (const char* name : {"a", "b", "c"}) folder_.write(std::string(name) + ".pcd", pcd({{1, 0, 0}}));
  options_.posesPath = poses_.write("p.tum", "1 10 0 0 0 0 0 1\n3 20 0 0 0 0 0 1\n2 30 0 0 0 0 0 1\n");
  const Reading reading = readAll(options_);
  EXPECT_EQ(xOfCentres(reading.scans), (std::vector<double>{10, 20, 30}));
  EXPECT_TRUE(says(reading.notes, "pose 3 of")) << reading.notes;
}

TEST_F(PcdFolderOfScans, PosesWithoutTimesAreNotForRawlogs)
{
  writeLog(folder_ / "a.rawlog", {laser(at(0)), laser(at(1))});
  options_.paths = {folder_ / "a.rawlog"};
  options_.posesPath = poses_.write("p.kitti", kittiLine(poseAt(0, 0, 0, 0)));
  EXPECT_TRUE(says(complaintOf<std::runtime_error>(options_), "p.kitti: its poses have no times"));
  options_.posesPath.clear();
  options_.standingStill = true;
  options_.cloudFrame = CloudFrame::Sensor;
  EXPECT_TRUE(says(complaintOf<UsageError>(options_), "--cloud-frame"));
}

/// Whether the only ray of a file ends at the sensor, and is so no return.
bool isAtSensor(const Reading& reading)
{
  const lamap::RayFan& fan = reading.scans.at(0).fans.at(0);
  return fan.rays.at(0).end == fan.centre;
}

std::string floatPcd(const Eigen::Vector3f& point, const std::string& viewpoint)
{
  std::string text =
      "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 1\nHEIGHT 1\nVIEWPOINT " +
      viewpoint + " 1 0 0 0\nPOINTS 1\nDATA binary\n";
  return text.append(reinterpret_cast<const char*>(point.data()), 12);
}

TEST_F(PcdFolderOfScans, APointThatRoundingPutsBesideTheSensorIsNoReturn)
{
  struct Case
  {
    std::string content;
    bool atSensor;
  };
  // UTM coordinates as floats are multiples of 0.5 m; six digits of 1234.567 are 1234.57.
  const std::vector<Case> cases{
      {floatPcd({12.345F, -3.21F, 0.75F}, "12.345 -3.21 0.75"), true},
      {floatPcd({448123.4F, 5412345.6F, 310.2F}, "448123.4 5412345.6 310.2"), true},
      {floatPcd({1234.5674F, 0.3F, 0}, "1234.57 0.3 0"), true},
      {pcd({{12.345, -3.21, 0.75}}, "12.3450004 -3.2100001 0.75 1 0 0 0"), true},
      {pcd({{12.345, -3.21, 0.751}}, "12.345 -3.21 0.75 1 0 0 0"), true},
      {floatPcd({12.345F, -3.21F, 0.76F}, "12.345 -3.21 0.75"), false},
      {floatPcd({1234.5674F, 0.3F, 0}, "1234.60 0.3 0"), false},
      {floatPcd({448123.4F, 5412347, 310.2F}, "448123.4 5412345.6 310.2"), false},
      {pcd({{448123.4, 5412345.6, 310.2}}, "448123.4 5412345.61 310.2 1 0 0 0"), false}};
  for (size_t i = 0; i < cases.size(); ++i)
  {
    options_.paths = {folder_.write("a.pcd", cases[i].content)};
    EXPECT_EQ(isAtSensor(readAll(options_)), cases[i].atSensor) << "case " << i;
  }
}

TEST_F(PcdFolderOfScans, RoundingIsThatOfGivenPosesAndOrigins)
{
  options_.paths = {folder_.write("a.pcd", floatPcd({450.1F, 20.2F, 1.5F}, "0 0 0"))};
  options_.posesPath = poses_.write("p.tum", "1 450.1 20.2 1 0 0 0.70710678 0.70710678\n");
  options_.sensorOrigin = {0, 0, 0.5};
  EXPECT_TRUE(isAtSensor(readAll(options_)));
  options_.sensorOrigin = {0, 0, 0.49};
  EXPECT_FALSE(isAtSensor(readAll(options_)));
}
}  // namespace
