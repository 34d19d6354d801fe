#pragma once

#include <lamap_sim/truth.h>
#include <lamap_tools/file_output.h>

#include <functional>
#include <string>
#include <vector>

namespace lamap::tools
{
/// `x,y,z,label`: a line for each cell with its centre [m] and 1 (solid) or 0 (free), in the order of the
/// cells.
/// @return false if it was stopped
bool writeTruthCsv(const std::vector<sim::TrueCell>& cells, double resolution_m, FileOutput& file,
                   const std::function<bool()>& shouldStop);

/// OctoMap's `.bt`, put in its place. @throws as writeOctomapFile
void writeTruthOctree(const std::vector<sim::TrueCell>& cells, double resolution_m, const std::string& path);

}  // namespace lamap::tools
