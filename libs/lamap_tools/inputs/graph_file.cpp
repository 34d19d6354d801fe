#include <lamap_tools/inputs/graph_file.h>
#include <lamap_tools/inputs/pose_track.h>
#include <lamap_tools/report/counted.h>
#include <octomap/octomap_types.h>

#include <Eigen/Geometry>
#include <filesystem>
#include <istream>
#include <stdexcept>

namespace lamap::tools
{
namespace
{
constexpr uint64_t kPointBytes = 12;

Eigen::Isometry3d isometryFrom(const octomap::pose6d& pose)
{
  const auto& q = pose.rot();
  Eigen::Quaterniond rotation(q.u(), q.x(), q.y(), q.z());
  if (!isUnit(rotation)) throw std::runtime_error("its rotation has not the length 1");
  rotation.normalize();
  const Eigen::Vector3d translation(pose.x(), pose.y(), pose.z());
  if (!translation.allFinite()) throw std::runtime_error("its position is not finite");
  Eigen::Isometry3d isometry(rotation);
  isometry.translation() = translation;
  return isometry;
}

/// A node as OctoMap's ScanNode writes it: points, pose, id. (ScanNode itself comments on every cloud it
/// reads.)
Scan readNode(std::istream& file, uint64_t bytesLeft)
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

  Scan scan;
  scan.sensorPose_map = isometryFrom(pose);
  RayFan& fan = scan.fans.emplace_back();
  fan.rays.reserve(points.size());
  for (const octomap::point3d& point : points) fan.addReturn({point.x(), point.y(), point.z()});
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
    throw std::runtime_error(path + ": not a scan graph of OctoMap: it would hold " + counted(size, "scan"));
  size_ = size;
}

std::optional<Scan> GraphFile::next()
{
  if (damage_ || read_ == size_) return std::nullopt;
  try
  {
    const uint64_t bytesLeft = fileSize_ - static_cast<uint64_t>(file_.tellg());
    Scan scan = readNode(file_, bytesLeft);
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
