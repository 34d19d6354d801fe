#include <lamap_mrpt/observations/isometry.h>
#include <lamap_tools/inputs/pose_track.h>
#include <lamap_tools/report/counted.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace lamap::tools
{
using mrpt::poses::CPose3D;

namespace
{
constexpr size_t kKittiColumns = 12;

/// fraction 0 is the first pose, 1 the second.
CPose3D interpolated(const CPose3D& first, const CPose3D& second, double fraction)
{
  const Eigen::Isometry3d from = isometryOf(first);
  const Eigen::Isometry3d to = isometryOf(second);
  const Eigen::Quaterniond rotation =
      Eigen::Quaterniond(from.linear()).slerp(fraction, Eigen::Quaterniond(to.linear()));
  return poseFrom(rotation, from.translation() + fraction * (to.translation() - from.translation()));
}

std::vector<double> numbersOf(const std::string& line, const std::string& place)
{
  std::istringstream words(line);
  std::vector<double> numbers;
  for (std::string word; words >> word;)
  {
    char* end = nullptr;
    const double number = std::strtod(word.c_str(), &end);
    if (end == word.c_str() || *end != '\0' || !std::isfinite(number))
      throw std::runtime_error(place + ": \"" + word + "\" is not a finite number");
    numbers.push_back(number);
  }
  return numbers;
}

CPose3D poseOfMatrix(const std::vector<double>& rowByRow, const std::string& place)
{
  using Matrix = Eigen::Matrix<double, 3, 4, Eigen::RowMajor>;
  const Matrix matrix = Eigen::Map<const Matrix>(rowByRow.data());
  const Eigen::Matrix3d turn = matrix.leftCols<3>();
  constexpr double kTolerance = 0.01;  // as for quaternions
  if (!(turn * turn.transpose()).isIdentity(kTolerance) || turn.determinant() < 0)
    throw std::runtime_error(place +
                             ": the left 3x3 part of the twelve numbers (KITTI: a 3x4 matrix, row by row) is "
                             "not a rotation");
  return poseFrom(Eigen::Quaterniond(turn), matrix.col(3));
}

CPose3D poseOfColumns(const std::vector<double>& columns, const std::string& place)
{
  if (columns.size() == kKittiColumns) return poseOfMatrix(columns, place);
  if (columns.size() == 4) return CPose3D(columns[1], columns[2], 0, columns[3], 0, 0);
  if (columns.size() == 7)
    return CPose3D(columns[1], columns[2], columns[3], columns[4], columns[5], columns[6]);
  const Eigen::Quaterniond rotation(columns[7], columns[4], columns[5], columns[6]);
  if (!isUnit(rotation))
    throw std::runtime_error(place + ": the quaternion (qx qy qz qw) has the length " +
                             std::to_string(rotation.norm()) + " and not 1");
  return poseFrom(rotation, {columns[1], columns[2], columns[3]});
}
}  // namespace

bool isUnit(const Eigen::Quaterniond& rotation)
{
  return std::abs(rotation.norm() - 1) < 0.01;  // false for NaN
}

CPose3D poseFrom(const Eigen::Quaterniond& rotation, const Eigen::Vector3d& translation)
{
  Eigen::Isometry3d isometry(rotation.normalized());
  isometry.translation() = translation;
  return poseOf(isometry);
}

PoseTrack::PoseTrack(std::vector<TimedPose> poses) : poses_(std::move(poses))
{
  const auto earlier = [](const TimedPose& a, const TimedPose& b) { return a.time < b.time; };
  std::stable_sort(poses_.begin(), poses_.end(), earlier);
  // Backwards, so that unique keeps the last pose of each time.
  const auto sameTime = [](const TimedPose& a, const TimedPose& b) { return a.time == b.time; };
  const auto kept = std::unique(poses_.rbegin(), poses_.rend(), sameTime);
  poses_.erase(poses_.begin(), kept.base());
}

std::optional<CPose3D> PoseTrack::at(mrpt::Clock::time_point time) const
{
  const auto after =
      std::lower_bound(poses_.begin(), poses_.end(), time,
                       [](const TimedPose& pose, mrpt::Clock::time_point t) { return pose.time < t; });
  if (after == poses_.end()) return std::nullopt;
  if (after->time == time) return after->pose_map;
  if (after == poses_.begin()) return std::nullopt;
  const auto before = std::prev(after);
  const double fraction = static_cast<double>((time - before->time).count()) /
                          static_cast<double>((after->time - before->time).count());
  return interpolated(before->pose_map, after->pose_map, fraction);
}

std::vector<TimedPose> readPoseFile(const std::string& path)
{
  std::ifstream file(path);
  if (!file) throw std::runtime_error(path + ": cannot be read");
  std::vector<TimedPose> poses;
  size_t columnCount = 0;
  size_t lineNumber = 0;
  for (std::string line; std::getline(file, line);)
  {
    const std::string place = path + ", line " + std::to_string(++lineNumber);
    const size_t first = line.find_first_not_of(" \t\r");
    if (first == std::string::npos || line[first] == '#' || line[first] == '%') continue;
    const std::vector<double> columns = numbersOf(line, place);
    const size_t count = columns.size();
    if (count != 4 && count != 7 && count != 8 && count != kKittiColumns)
      throw std::runtime_error(place + ": " + counted(count, "column") +
                               "; expected 8 (TUM: time tx ty tz qx qy qz qw), 7 (MRPT: time x y z "
                               "yaw pitch roll), 4 (MRPT: time x y phi) or 12 (KITTI: a 3x4 matrix, row by "
                               "row)");
    if (columnCount == 0) columnCount = count;
    if (count != columnCount)
      throw std::runtime_error(place + ": " + counted(count, "column") + " where the lines before have " +
                               std::to_string(columnCount));
    if (count == kKittiColumns)
    {
      poses.push_back({INVALID_TIMESTAMP, poseOfColumns(columns, place)});
      continue;
    }
    constexpr double kLatestTime_s = 1e11;  // the year 5138; later ones would overflow MRPT's clock
    if (std::abs(columns[0]) > kLatestTime_s)
      throw std::runtime_error(place + ": the time is not in seconds");
    poses.push_back({mrpt::Clock::fromDouble(columns[0]), poseOfColumns(columns, place)});
  }
  if (poses.empty()) throw std::runtime_error(path + ": holds no pose");
  return poses;
}

}  // namespace lamap::tools
