#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string>
#include <vector>

namespace lamap::tools
{
/// One cloud of a PCD file, in the frame that the file means: that is not written in it.
struct PcdCloud
{
  /// The position of VIEWPOINT [m], and how far it may be off because the file rounds it.
  Eigen::Vector3d viewpoint = Eigen::Vector3d::Zero();
  Eigen::Vector3d viewpointError = Eigen::Vector3d::Zero();
  /// The rotation of VIEWPOINT as the file states it: files exist in which its length is not 1 but 0 or 2.
  Eigen::Quaterniond viewpointRotation = Eigen::Quaterniond::Identity();
  /// All points in the file's order [m]; NaN if the file says so.
  std::vector<Eigen::Vector3d> points;
  /// How far a coordinate may be off, divided by its absolute value, because of the type of its field.
  double relativeError = 0;
  bool isWhole = false;  ///< its coordinates are whole numbers by the type of a field: metres, as is assumed?
};

/** Reads a PCD file (versions .5 to .7; ascii, binary or binary_compressed; fields in any order and of any
 * type, of which x, y and z are used). Bytes that follow binary points are ignored, as PCL does.
 * @throws std::runtime_error naming the file and what is wrong: truncated, wrong counts, no x, y or z, not a
 * PCD. */
[[nodiscard]] PcdCloud readPcdFile(const std::string& path);

}  // namespace lamap::tools
