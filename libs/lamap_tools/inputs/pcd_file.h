#pragma once

#include <mrpt/poses/CPose3D.h>

#include <Eigen/Core>
#include <string>
#include <vector>

namespace lamap::tools
{
/// One cloud of a PCD file.
struct PcdCloud
{
  /// The header's VIEWPOINT in the map frame [m].
  mrpt::poses::CPose3D viewpoint_map;
  /// All points in the file's order, in the map frame [m]; NaN if the file says so.
  std::vector<Eigen::Vector3d> points_map;
};

/** Reads a PCD file (versions .5 to .7; ascii, binary or binary_compressed; fields in any order and of any
 * type, of which x, y and z are used).
 * @throws std::runtime_error naming the file and what is wrong: truncated, wrong counts, no x, y or z, not a
 * PCD. */
[[nodiscard]] PcdCloud readPcdFile(const std::string& path);

}  // namespace lamap::tools
