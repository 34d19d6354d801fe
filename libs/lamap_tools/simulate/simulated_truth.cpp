#include <lamap_tools/simulate/simulated_truth.h>

#include <lamap_tools/cells/octomap_file.h>
#include <lamap_tools/cells/truth_cells.h>

#include <sstream>

namespace lamap::tools
{
bool writeTruthCsv(const std::vector<sim::TrueCell>& cells, double resolution_m, FileOutput& file,
                   const std::function<bool(size_t)>& goOn)
{
  file.append("x,y,z,label\n");
  size_t count = 0;
  for (const sim::TrueCell& cell : cells)
  {
    constexpr size_t kBetweenQuestions = 1U << 16U;
    if (++count % kBetweenQuestions == 0 && !goOn(count)) return false;
    const Eigen::Vector3d centre = cellCentre(cell.index, resolution_m);
    for (int axis = 0; axis < 3; ++axis)
    {
      file.append(centre[axis]);
      file.append(",");
    }
    file.append(cell.occupied ? "1\n" : "0\n");
  }
  return true;
}

void writePointsCsv(const std::vector<Eigen::Vector3d>& points, FileOutput& file)
{
  file.append("x,y,z\n");
  for (const Eigen::Vector3d& point : points)
    for (int axis = 0; axis < 3; ++axis)
    {
      file.append(point[axis]);
      file.append(axis < 2 ? "," : "\n");
    }
}

void writeTruthOctree(const std::vector<sim::TrueCell>& cells, double resolution_m, const std::string& path,
                      FileOutput& file)
{
  std::vector<LabelledCell> labelled;
  labelled.reserve(cells.size());
  for (const sim::TrueCell& cell : cells) labelled.emplace_back(cell.index, cell.occupied);
  std::ostringstream tree;
  writeOctomap(*cellsOf(std::move(labelled), resolution_m), path, tree);
  file.append(tree.str());
}

}  // namespace lamap::tools
