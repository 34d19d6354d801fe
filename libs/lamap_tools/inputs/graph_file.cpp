#include <lamap_tools/inputs/graph_file.h>
#include <octomap/octomap_types.h>

#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>
#include <istream>
#include <stdexcept>

namespace lamap::tools
{
namespace
{
constexpr uint64_t kPointBytes = 12;

mrpt::poses::CPose3D poseOf(const octomap::pose6d& pose)
{
  const auto& q = pose.rot();
  Eigen::Quaterniond rotation(q.u(), q.x(), q.y(), q.z());
  if (!(std::abs(rotation.norm() - 1) < 0.01)) throw std::runtime_error("its rotation has not the length 1");
  rotation.normalize();
  const Eigen::Vector3d translation(pose.x(), pose.y(), pose.z());
  if (!translation.allFinite()) throw std::runtime_error("its position is not finite");
  return mrpt::poses::CPose3D(mrpt::math::CMatrixDouble33(Eigen::Matrix3d(rotation.toRotationMatrix())),
                              mrpt::math::CMatrixDouble31(translation));
}

/// A node as OctoMap's ScanNode writes it: points, pose, id. (ScanNode itself comments on every cloud it
/// reads.)
GraphScan readNode(std::istream& file, uint64_t bytesLeft)
{
  uint32_t size = 0;
  file.read(reinterpret_cast<char*>(&size), sizeof(size));
  if (!file || size > bytesLeft / kPointBytes) throw std::runtime_error("the file ends within it");
  std::vector<octomap::point3d> points(size);
  for (octomap::point3d& point : points) point.readBinary(file);
  octomap::pose6d pose;
  pose.readBinary(file);
  uint32_t id = 0;
  file.read(reinterpret_cast<char*>(&id), sizeof(id));
  if (!file) throw std::runtime_error("the file ends within it");

  GraphScan scan;
  scan.sensorPose_map = poseOf(pose);
  scan.points_map.reserve(points.size());
  for (const octomap::point3d& point : points)
  {
    Eigen::Vector3d moved;
    scan.sensorPose_map.composePoint(point.x(), point.y(), point.z(), moved.x(), moved.y(), moved.z());
    scan.points_map.push_back(moved);
  }
  return scan;
}
}  // namespace

GraphFile::GraphFile(const std::string& path) : file_(path, std::ios::binary)
{
  std::error_code error;
  fileSize_ = std::filesystem::file_size(path, error);
  if (!file_ || error) throw std::runtime_error(path + ": cannot be read");
  uint32_t size = 0;
  if (!file_.read(reinterpret_cast<char*>(&size), sizeof(size)))
    throw std::runtime_error(path + ": too short for a scan graph");
  // The file's end may be cut off, but no graph has so many scans that they fill thousands of such files.
  constexpr uint64_t kLeastNodeBytes = 16;
  if (size > 1000 * (fileSize_ / kLeastNodeBytes + 1))
    throw std::runtime_error(path + ": not a scan graph of OctoMap: it would hold " + std::to_string(size) +
                             " scans");
  size_ = size;
}

std::optional<GraphScan> GraphFile::next()
{
  if (damage_ || read_ == size_) return std::nullopt;
  try
  {
    const uint64_t bytesLeft = fileSize_ - static_cast<uint64_t>(file_.tellg());
    GraphScan scan = readNode(file_, bytesLeft);
    ++read_;
    return scan;
  }
  catch (const std::runtime_error& error)
  {
    // The graph ends here for us; what it is worth so far is the caller's to decide.
    damage_ = "scan " + std::to_string(read_ + 1) + " of " + std::to_string(size_) + ": " + error.what();
    return std::nullopt;
  }
}

}  // namespace lamap::tools
