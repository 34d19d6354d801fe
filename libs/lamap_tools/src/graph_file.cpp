#include <lamap_tools/graph_file.h>
#include <octomap/ScanGraph.h>

#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>
#include <stdexcept>

namespace lamap::tools
{
namespace
{
// What OctoMap writes a node: number of points, points (3 floats), pose (3 floats, 4 doubles), id.
constexpr uint64_t kPointBytes = 12;
constexpr uint64_t kNodeBytesWithoutPoints = 4 + 12 + 32 + 4;

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

GraphScan scanOf(const octomap::ScanNode& node)
{
  GraphScan scan;
  scan.sensorPose_map = poseOf(node.pose);
  scan.points_map.reserve(node.scan->size());
  for (const octomap::point3d& point : *node.scan)
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
  if (size > 1000 * (fileSize_ / kNodeBytesWithoutPoints + 1))
    throw std::runtime_error(path + ": not a scan graph of OctoMap: it would hold " + std::to_string(size) +
                             " scans");
  size_ = size;
}

std::optional<GraphScan> GraphFile::next()
{
  if (damage_ || read_ == size_) return std::nullopt;
  try
  {
    // Looked at first: OctoMap reserves the memory for as many points as the file states.
    const auto begin = file_.tellg();
    const uint64_t bytesLeft = fileSize_ - static_cast<uint64_t>(begin);
    uint32_t points = 0;
    file_.read(reinterpret_cast<char*>(&points), sizeof(points));
    if (!file_ || bytesLeft < kNodeBytesWithoutPoints + points * kPointBytes)
      throw std::runtime_error("the file ends within it");
    file_.seekg(begin);

    octomap::ScanNode node;
    if (!node.readBinary(file_)) throw std::runtime_error("the file ends within it");
    GraphScan scan = scanOf(node);
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
