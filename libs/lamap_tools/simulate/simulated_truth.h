#pragma once

#include <lamap_sim/truth.h>
#include <lamap_tools/files/file_output.h>

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

namespace lamap::tools
{
/// `x,y,z,label`: one line per cell with its centre [m] and 1 (occupied) or 0 (free), in the order of the
/// cells.
/// @param goOn  called from time to time with the number of cells written; returns false to stop
/// @return false if it was stopped
bool writeTruthCsv(const std::vector<sim::TrueCell>& cells, double resolution_m, FileOutput& file,
                   const std::function<bool(size_t)>& goOn);

/// `x,y,z`: one line per point [m].
void writePointsCsv(const std::vector<Eigen::Vector3d>& points, FileOutput& file);

/// OctoMap's `.bt`. @throws as writeOctomapFile
void writeTruthOctree(const std::vector<sim::TrueCell>& cells, double resolution_m, const std::string& path,
                      FileOutput& file);

}  // namespace lamap::tools
