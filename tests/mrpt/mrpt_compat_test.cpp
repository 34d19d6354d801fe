#include <gtest/gtest.h>
#include <lamap_mrpt/compat/mrpt_compat.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/math/CMatrixDynamic.h>
#include <mrpt/math/TPoint3D.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>

#include <vector>

// The branches for newer versions of MRPT are compiled and run here with substitutes that have those
// versions' members.
namespace
{
namespace compat = lamap::compat;

template <typename Action>
std::string messageOfThrown(const Action& action)
{
  try
  {
    action();
  }
  catch (const std::exception& error)
  {
    return compat::messageOf(error);
  }
  return "nothing thrown";
}

void throwWithinMrpt()
{
  THROW_EXCEPTION("the [inner] reason");
}

TEST(MrptCompat, MessagesComeWithoutPlaceAndCallStack)
{
  EXPECT_EQ(messageOfThrown(throwWithinMrpt), "the [inner] reason");
  EXPECT_EQ(messageOfThrown([] { ASSERTMSG_(false, "said so"); }), "said so");
  EXPECT_EQ(messageOfThrown([] { throw std::runtime_error("plain: [text] stays"); }), "plain: [text] stays");
  EXPECT_EQ(messageOfThrown([] { throw std::runtime_error(""); }), "");
  EXPECT_EQ(messageOfThrown(
                []
                {
                  MRPT_START
                  throwWithinMrpt();
                  MRPT_END
                }),
            "the [inner] reason");
}

TEST(MrptCompat, HandsMapsOver)
{
  const mrpt::maps::CMetricMap::Ptr map(compat::handOver(std::make_unique<mrpt::maps::CSimplePointsMap>()));
  EXPECT_TRUE(std::dynamic_pointer_cast<mrpt::maps::CSimplePointsMap>(map));
}

TEST(MrptCompat, ReadsKeyframesOfASimpleMap)
{
  mrpt::maps::CSimpleMap map;
  const auto pose = mrpt::poses::CPose3DPDFGaussian::Create(mrpt::poses::CPose3D(1, 2, 3, 0, 0, 0));
  const auto frame = mrpt::obs::CSensoryFrame::Create();
  map.insert(pose, frame);
  const compat::Keyframe keyframe = compat::keyframeAt(map, 0);
  ASSERT_TRUE(keyframe.pose && keyframe.frame);
  EXPECT_EQ(keyframe.pose->getMeanVal().x(), 1);
  EXPECT_THROW(static_cast<void>(compat::keyframeAt(map, 1)), std::exception);
}

struct NewerSimpleMap
{
  struct Keyframe
  {
    mrpt::poses::CPose3DPDF::Ptr pose;
    mrpt::obs::CSensoryFrame::Ptr sf;
    double localTwist = 0;
  };
  std::vector<Keyframe> keyframes;
  [[nodiscard]] const Keyframe& get(std::size_t index) const { return keyframes.at(index); }
};

TEST(MrptCompat, ReadsKeyframesOfANewerSimpleMap)
{
  NewerSimpleMap map;
  map.keyframes.push_back({mrpt::poses::CPose3DPDFGaussian::Create(), mrpt::obs::CSensoryFrame::Create()});
  const compat::Keyframe keyframe = compat::keyframeAt(map, 0);
  EXPECT_EQ(keyframe.pose, map.keyframes[0].pose);
  EXPECT_EQ(keyframe.frame, map.keyframes[0].sf);
}

struct NewerRotatingScan
{
  mrpt::math::CMatrix_u16 rangeImage{0, 0};
  mrpt::math::CMatrixDynamic<mrpt::math::TPoint3Df> organizedPoints{0, 0};
  bool external = false;
  [[nodiscard]] bool isExternallyStored() const { return external; }
};

TEST(MrptCompat, TakesOrganizedPointsWhereMrptHasThem)
{
  NewerRotatingScan rotating;
  EXPECT_FALSE(compat::hasOrganizedPoints(rotating));
  rotating.external = true;
  EXPECT_TRUE(compat::isExternallyStored(rotating));
  EXPECT_TRUE(compat::hasOrganizedPoints(rotating)) << "they may be in the external file";

  rotating.rangeImage.setZero(2, 2);
  rotating.rangeImage(1, 0) = 7;
  rotating.organizedPoints.resize(2, 2);
  rotating.organizedPoints(1, 0) = {1, 2, 3};
  std::vector<Eigen::Vector3d> visited;
  const auto collect = [&](const Eigen::Vector3d& point) { visited.push_back(point); };
  compat::forEachOrganizedPoint(rotating, collect);
  ASSERT_EQ(visited.size(), 1u) << "a point without range is none";
  EXPECT_EQ(visited[0], Eigen::Vector3d(1, 2, 3));

  rotating.organizedPoints.resize(2, 3);
  EXPECT_THROW(compat::forEachOrganizedPoint(rotating, collect), std::runtime_error);
}

}  // namespace
