#pragma once

#include <lamap_mrpt/maps/CBGKMap.h>
#include <lamap_mrpt/options/option_group.h>
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/maps/CMultiMetricMap.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/serialization/CArchive.h>
#include <mrpt/serialization/CSerializable.h>

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

namespace lamap::test
{
/// Two walls and a floor seen from (0.13, 0.07, 0.5), some rays without return, two hits at the same place.
inline Scan smallScan()
{
  RayFan fan;
  fan.centre = {0.13, 0.07, 0.5};
  for (int i = -6; i <= 6; ++i)
  {
    fan.addReturn({2.03, 0.11 * i, 0.52});
    fan.addReturn({0.09 * i, 1.57, 0.47});
    fan.addReturn({0.4 + 0.02 * i, -0.3, -0.01});
  }
  fan.addReturn({2.031, 0.0, 0.521});
  fan.addReturn({0.33, 0.07, 0.5});
  for (const Eigen::Vector3d& direction : {Eigen::Vector3d(-1, 0, 0), {-1, -1, 0.1}, {0, -1, 0.3}})
    fan.add(RayEnd::NoReturn, direction);
  fan.statedRangeMax_m = 3.0;
  Scan scan;
  scan.fans.push_back(fan);
  scan.poseCovariance = 0.04 * Scan::PoseCovariance::Identity();
  return scan;
}

/// A laser scan of a room from x = −2.95 to 3.15 and y = −2.05 to 2.05 [m], one ray in twelve without return.
inline mrpt::obs::CObservation2DRangeScan roomScan(size_t rays = 181)
{
  mrpt::obs::CObservation2DRangeScan scan;
  scan.aperture = static_cast<float>(1.5 * M_PI);
  scan.maxRange = 20.0f;
  scan.rightToLeft = true;
  scan.sensorPose = mrpt::poses::CPose3D(0.1, 0.0, 0.3, 0, 0, 0);
  scan.resizeScan(rays);
  for (size_t i = 0; i < rays; ++i)
  {
    const double angle = scan.aperture * (static_cast<double>(i) / static_cast<double>(rays - 1) - 0.5);
    const double toSide = 3.05 / std::max(1e-9, std::abs(std::cos(angle)));
    const double toEnd = 2.05 / std::max(1e-9, std::abs(std::sin(angle)));
    const bool returned = i % 12 != 0;
    scan.setScanRange(i, static_cast<float>(returned ? std::min(toSide, toEnd) : 20.0));
    scan.setScanRangeValidity(i, returned);
  }
  return scan;
}

/// Two pings of a wide beam: one with an echo, one without.
inline lamap::Scan coneScan()
{
  lamap::Scan scan;
  for (const double sideways : {-0.5, 0.5})
  {
    lamap::RayFan& fan = scan.fans.emplace_back();
    fan.beam.halfWidth_rad = fan.beam.halfHeight_rad = 0.15;
    fan.statedRangeMax_m = 2.5;
    if (sideways > 0)
      fan.addReturn({2, sideways, 0});
    else
      fan.add(lamap::RayEnd::NoReturn, {2, sideways, 0});
  }
  return scan;
}

/// The object as MRPT stores it.
inline std::vector<uint8_t> bytesOf(const mrpt::serialization::CSerializable& object)
{
  mrpt::io::CMemoryStream stream;
  auto archive = mrpt::serialization::archiveFrom(stream);
  archive << object;
  const auto* first = static_cast<const uint8_t*>(stream.getRawBufferData());
  return {first, first + stream.getTotalBytesCount()};
}

/// The object that was stored. @throws as MRPT and the object do.
inline mrpt::serialization::CSerializable::Ptr objectFrom(const std::vector<uint8_t>& bytes)
{
  mrpt::io::CMemoryStream stream;
  stream.assignMemoryNotOwn(bytes.data(), bytes.size());
  auto archive = mrpt::serialization::archiveFrom(stream);
  mrpt::serialization::CSerializable::Ptr object;
  archive >> object;
  return object;
}

/// Sets an option to a legal text that is not its default; relations between options are kept.
inline void setToAnother(const Option& option, TOptionGroup& group, int number)
{
  const std::string before = option.textOf(group);
  std::vector<std::string> candidates;
  if (option.type == OptionType::Choice)
    candidates = option.names;
  else if (option.type == OptionType::Flag)
    candidates = {"true", "false"};
  else if (option.type == OptionType::Text)
    candidates = {"another text"};
  else if (before.empty() || std::stod(before) == 0)
    candidates = {std::to_string(number + 1), std::to_string(0.25 + 0.015625 * number)};
  else
    candidates = {std::to_string(std::stoll(before) + 1), std::to_string(std::stod(before) * 1.25),
                  std::to_string(std::stod(before) * 0.75)};
  // Numbers that are not whole take the second or third.
  if (option.type == OptionType::Number) candidates.erase(candidates.begin());
  for (const std::string& candidate : candidates)
  {
    try
    {
      option.parse(group, candidate);
    }
    catch (const std::invalid_argument&)
    {
      continue;
    }
    if (option.textOf(group) != before) return;
  }
  throw std::logic_error("no other legal text for option " + option.key);
}

/// Sets every option of a group to something else than its default.
inline void setAllToOthers(TOptionGroup& group)
{
  int number = 0;
  for (const Option& option : group.optionTable().options()) setToAnother(option, group, number++);
}

/// A folder that is gone with the object.
class TemporaryFolder
{
 public:
  TemporaryFolder()
  {
    std::string pattern = (std::filesystem::temp_directory_path() / "lamap-test-XXXXXX").string();
    if (!mkdtemp(pattern.data())) throw std::runtime_error("no temporary folder");
    path_ = pattern;
  }
  ~TemporaryFolder() { std::filesystem::remove_all(path_); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  [[nodiscard]] std::string file(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

}  // namespace lamap::test
