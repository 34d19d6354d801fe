#pragma once

#include <lamap_core/scan/scan.h>
#include <Eigen/Core>

#include <optional>
#include <string>
#include <vector>

namespace lamap::test
{
/// The folder with measured data, from the environment variable LAMAP_DATA; empty if it is not set.
std::optional<std::string> dataFolder();

/** Points of a binary PCD file whose fields are exactly x y z intensity as 32-bit floats.
 * @throws std::runtime_error naming the file. */
std::vector<Eigen::Vector3d> readPcdPoints(const std::string& path);

/// The scans of the folder NAME of la3dm (NAME_1.pcd to NAME_count.pcd), with the origins of the file
/// sim_structured.tum.
std::vector<Scan> readStructuredScans(const std::string& folder, const std::string& name, int count);

}  // namespace lamap::test
