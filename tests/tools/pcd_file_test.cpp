#include <gtest/gtest.h>
#include <lamap_tools/inputs/pcd_file.h>
#include <lamap_tools/inputs/scan_source.h>
#include <lzf.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <stdexcept>

#include "support/temporary_folder.h"

namespace
{
using namespace lamap::tools;
using lamap::test::TemporaryFolder;

template <class Number>
std::string bytesOf(Number number)
{
  return {reinterpret_cast<const char*>(&number), sizeof(number)};
}

std::string header(const std::string& fields, const std::string& data, size_t points = 2)
{
  return "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\n" + fields + "WIDTH " +
         std::to_string(points) + "\nHEIGHT 1\nVIEWPOINT 1 2 3 1 0 0 0\nPOINTS " + std::to_string(points) +
         "\nDATA " + data + "\n";
}
const std::string kXyz = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n";
/// With other fields in between, of other types, one with three elements; z before x.
const std::string kMixed = "FIELDS z label x normal y\nSIZE 8 2 4 4 4\nTYPE F U F F I\nCOUNT 1 1 1 3 1\n";

std::string mixedPoint(double z, float x, int32_t y)
{
  return bytesOf(z) + bytesOf(uint16_t{7}) + bytesOf(x) + bytesOf(0.F) + bytesOf(0.F) + bytesOf(1.F) +
         bytesOf(y);
}

class PcdFile : public testing::Test
{
 protected:
  PcdCloud read(const std::string& content) const { return readPcdFile(folder_.write("a.pcd", content)); }
  std::string complaint(const std::string& content) const
  {
    try
    {
      (void)read(content);
    }
    catch (const std::runtime_error& error)
    {
      return error.what();
    }
    return "";
  }
  bool complains(const std::string& content, const std::string& about) const
  {
    const std::string text = complaint(content);
    const bool found = text.find(about) != std::string::npos && text.find("a.pcd") != std::string::npos;
    if (!found) ADD_FAILURE() << "\"" << text << "\" says nothing of \"" << about << "\"";
    return found;
  }

  TemporaryFolder folder_;
};

TEST_F(PcdFile, ReadsAsciiWithNan)
{
  const PcdCloud cloud = read(header(kXyz, "ascii", 3) + "1 2 3\nnan 5 6\n-7.5 8e-1 9\n");
  ASSERT_EQ(cloud.points.size(), 3U);
  EXPECT_EQ(cloud.points[0], Eigen::Vector3d(1, 2, 3));
  EXPECT_TRUE(std::isnan(cloud.points[1].x()));
  EXPECT_EQ(cloud.points[2], Eigen::Vector3d(-7.5, 0.8, 9));
  EXPECT_EQ(cloud.viewpoint.x(), 1);
  EXPECT_EQ(cloud.viewpoint.z(), 3);
}

TEST_F(PcdFile, ReadsFieldsInAnyOrderAndOfAnyType)
{
  const PcdCloud cloud =
      read(header(kMixed, "binary") + mixedPoint(3.25, 1.5F, -2) + mixedPoint(-1, 0, 70000));
  ASSERT_EQ(cloud.points.size(), 2U);
  EXPECT_EQ(cloud.points[0], Eigen::Vector3d(1.5, -2, 3.25));
  EXPECT_EQ(cloud.points[1], Eigen::Vector3d(0, 70000, -1));
  const PcdCloud ascii = read(header(kMixed, "ascii", 1) + "3.25 7 1.5 0 0 1 -2\n");
  EXPECT_EQ(ascii.points.at(0), Eigen::Vector3d(1.5, -2, 3.25));
}

TEST_F(PcdFile, ReadsCompressedFieldByField)
{
  std::string plain;
  constexpr size_t kPoints = 200;
  for (int axis = 0; axis < 3; ++axis)
    for (size_t i = 0; i < kPoints; ++i)
      plain += bytesOf(static_cast<float>(axis) + 0.5F * static_cast<float>(i % 4));
  std::string packed(plain.size(), '\0');
  const auto size = lzf_compress(plain.data(), static_cast<unsigned>(plain.size()), packed.data(),
                                 static_cast<unsigned>(packed.size()));
  ASSERT_GT(size, 0U);
  packed.resize(size);
  const std::string sizes =
      bytesOf(static_cast<uint32_t>(size)) + bytesOf(static_cast<uint32_t>(plain.size()));
  const std::string whole = header(kXyz, "binary_compressed", kPoints) + sizes + packed;
  const PcdCloud cloud = read(whole);
  ASSERT_EQ(cloud.points.size(), kPoints);
  EXPECT_EQ(cloud.points[0], Eigen::Vector3d(0, 1, 2));
  EXPECT_EQ(cloud.points[7], Eigen::Vector3d(1.5, 2.5, 3.5));
  EXPECT_TRUE(complains(whole.substr(0, whole.size() - 5), "cut short"));
  const std::string wrongSize = bytesOf(static_cast<uint32_t>(size)) + bytesOf(uint32_t{100});
  EXPECT_TRUE(complains(header(kXyz, "binary_compressed", kPoints) + wrongSize + packed,
                        "compressed points have 100"));
}

// Turned by 90 degrees about z: w = z = sqrt(1/2).
TEST_F(PcdFile, ReadsTheRotationOfTheViewpoint)
{
  std::string content = header(kXyz, "ascii", 1) + "1 2 3\n";
  const std::string identity = "VIEWPOINT 1 2 3 1 0 0 0";
  content.replace(content.find(identity), identity.size(), "VIEWPOINT 1 2 3 0.70710678 0 0 0.70710678");
  EXPECT_LT(read(content).viewpointRotation.angularDistance(
                Eigen::Quaterniond(Eigen::AngleAxisd(1.5707963, Eigen::Vector3d::UnitZ()))),
            1e-6);
}

TEST_F(PcdFile, RefusesWhatContradictsItself)
{
  const std::string points =
      bytesOf(1.F) + bytesOf(2.F) + bytesOf(3.F) + bytesOf(4.F) + bytesOf(5.F) + bytesOf(6.F);
  ASSERT_EQ(complaint(header(kXyz, "binary") + points), "");
  EXPECT_TRUE(complains(header(kXyz, "binary") + points.substr(0, 23),
                        "cut short: 23 bytes after the header instead of 24, for 2 points"));
  EXPECT_TRUE(complains(header(kXyz, "ascii") + "1 2 3\n", "holds 1 point; its header states 2"));
  EXPECT_TRUE(complains(header(kXyz, "ascii") + "1 2 3\n1 2\n", "point 2 has 2 numbers"));
  EXPECT_TRUE(complains(header(kXyz, "ascii") + "1 2 3\n1 2 three\n", "\"three\" is not a number"));
  EXPECT_TRUE(complains(header(kXyz, "zip") + "1 2 3\n", "DATA is \"zip\""));
  EXPECT_TRUE(complains(header("FIELDS x y\nSIZE 4 4\nTYPE F F\nCOUNT 1 1\n", "ascii"), "has no field z"));
  EXPECT_TRUE(complains(header("FIELDS x y z\nSIZE 4 4 3\nTYPE F F F\nCOUNT 1 1 1\n", "ascii"), "SIZE 3"));
  EXPECT_TRUE(
      complains(header("FIELDS x y z\nSIZE 4 4\nTYPE F F F\nCOUNT 1 1 1\n", "ascii"), "SIZE lacks a number"));
  EXPECT_TRUE(complains("hello", "not a PCD file"));
  EXPECT_TRUE(complains("", "not a PCD file"));
  EXPECT_TRUE(complains(std::string(200000, 'x'), "not a PCD file"));
  std::string wrongCount = header(kXyz, "ascii") + "1 2 3\n4 5 6\n";
  wrongCount.replace(wrongCount.find("WIDTH 2"), 7, "WIDTH 3");
  EXPECT_TRUE(complains(wrongCount, "POINTS is 2 but WIDTH x HEIGHT is 3"));
  std::string huge = header(kXyz, "binary", 4000000000000000000ULL);
  EXPECT_TRUE(complains(huge, "impossibly large"));
}

TEST_F(PcdFile, IgnoresWhatFollowsBinaryPoints)
{
  const std::string points = bytesOf(1.F) + bytesOf(2.F) + bytesOf(3.F);
  const std::string compressed = bytesOf(uint32_t{13}) + bytesOf(uint32_t{12}) + "\x0b" + points;
  for (const std::string& rest :
       {std::string(4000, '\0'), std::string("\n"), std::string("x"), std::string("CloudCompare was here\n"),
        std::string("\xff\0\x1a", 3), points})
  {
    EXPECT_EQ(read(header(kXyz, "binary", 1) + points + rest).points,
              (std::vector{Eigen::Vector3d(1, 2, 3)}));
    EXPECT_EQ(read(header(kXyz, "binary_compressed", 1) + compressed + rest).points,
              (std::vector{Eigen::Vector3d(1, 2, 3)}));
  }
}

// PCL lists fields of padding in the header of a compressed file, and leaves out their bytes.
TEST_F(PcdFile, ReadsCompressedPointsWithAndWithoutTheirPadding)
{
  const std::string axis = bytesOf(1.F) + bytesOf(2.F);
  const std::string bytes[] = {axis, axis + axis + bytesOf(uint16_t{1}) + bytesOf(uint16_t{2}),
                               std::string(2, '\0')};
  const std::string fields = "FIELDS x _ y z ring\nSIZE 4 1 4 4 2\nTYPE F U F F U\nCOUNT 1 1 1 1 1\n";
  for (const std::string& plain : {bytes[0] + bytes[1], bytes[0] + bytes[2] + bytes[1]})
  {
    // One run of literal bytes.
    const std::string packed = std::string(1, static_cast<char>(plain.size() - 1)) + plain;
    ASSERT_LE(plain.size(), 32U);
    const PcdCloud cloud =
        read(header(fields, "binary_compressed") + bytesOf(static_cast<uint32_t>(packed.size())) +
             bytesOf(static_cast<uint32_t>(plain.size())) + packed);
    EXPECT_EQ(cloud.points, (std::vector{Eigen::Vector3d(1, 1, 1), Eigen::Vector3d(2, 2, 2)}));
  }
}

TEST_F(PcdFile, ReadsTextWithAByteOrderMark)
{
  EXPECT_EQ(read("\xEF\xBB\xBF" + header(kXyz, "ascii", 1) + "1 2 3\n").points.size(), 1U);
}

TEST_F(PcdFile, KeepsTheRotationOfTheViewpointAsItIs)
{
  for (const std::string data : {"ascii", "binary"})
    for (const std::string rotation : {"0 0 0 0", "2 0 0 0", "0.1 0.2 0.3 0.4"})
    {
      std::string content = header(kXyz, data, 1);
      content.replace(content.find("1 0 0 0"), 7, rotation);
      content += data == "ascii" ? "1 2 3\n" : bytesOf(1.F) + bytesOf(2.F) + bytesOf(3.F);
      const PcdCloud cloud = read(content);
      EXPECT_EQ(cloud.points, (std::vector{Eigen::Vector3d(1, 2, 3)}));
      EXPECT_EQ(cloud.viewpoint, Eigen::Vector3d(1, 2, 3));
      EXPECT_EQ(cloud.viewpointRotation.w(), std::stod(rotation));
    }
}

TEST_F(PcdFile, RefusesAViewpointThatIsNotSevenNumbers)
{
  const auto complaintAbout = [&](const std::string& viewpoint)
  {
    std::string content = header(kXyz, "ascii", 1) + "1 2 3\n";
    content.replace(content.find("1 2 3 1 0 0 0"), 13, viewpoint);
    return complaint(content);
  };
  EXPECT_NE(complaintAbout("0 0 0").find("seven numbers, tx ty tz qw qx qy qz; number 4 is missing"),
            std::string::npos);
  EXPECT_NE(complaintAbout("").find("number 1 is missing"), std::string::npos);
  EXPECT_NE(complaintAbout("0 0 0 1 0 0").find("number 7 is missing"), std::string::npos);
  EXPECT_NE(complaintAbout("0,5 0 0 1 0 0 0").find("number 1 is \"0,5\""), std::string::npos);
  EXPECT_NE(complaintAbout("0 nan 0 1 0 0 0").find("number 2 is \"nan\""), std::string::npos);
}

// Truncated anywhere, it is refused, never read as a smaller cloud.
TEST_F(PcdFile, RefusesEveryCut)
{
  const std::string whole = header(kMixed, "binary") + mixedPoint(3.25, 1.5F, -2) + mixedPoint(-1, 0, 70000);
  for (size_t length = 0; length < whole.size(); ++length)
    EXPECT_NE(complaint(whole.substr(0, length)), "") << length << " bytes";
}

TEST(NaturalOrder, ComparesNumbersAsNumbers)
{
  std::vector<std::string> names{"s_10.pcd", "s_2.pcd", "s_1.pcd", "s_02b.pcd", "a", "s_2", "s_100.pcd"};
  std::sort(names.begin(), names.end(), inNaturalOrder);
  EXPECT_EQ(names, (std::vector<std::string>{"a", "s_1.pcd", "s_2", "s_2.pcd", "s_02b.pcd", "s_10.pcd",
                                             "s_100.pcd"}));
}
}  // namespace
