#include <support/pcd_points.h>

#include <array>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace lamap::test
{
std::optional<std::string> dataFolder()
{
  const char* folder = std::getenv("LAMAP_DATA");
  if (folder == nullptr || *folder == '\0') return std::nullopt;
  return std::string(folder);
}

std::vector<Eigen::Vector3d> readPcdPoints(const std::string& path)
{
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error("cannot open " + path);
  size_t count = 0;
  for (std::string line; std::getline(file, line);)
  {
    std::istringstream words(line);
    std::string key, rest;
    words >> key;
    if (key == "POINTS") words >> count;
    if (key == "FIELDS" && line != "FIELDS x y z intensity")
      throw std::runtime_error(path + ": other fields: " + line);
    if (key != "DATA") continue;
    words >> rest;
    if (rest != "binary") throw std::runtime_error(path + ": not binary");
    break;
  }
  std::vector<Eigen::Vector3d> points;
  for (size_t i = 0; i < count; ++i)
  {
    std::array<float, 4> xyzi{};
    file.read(reinterpret_cast<char*>(xyzi.data()), sizeof(xyzi));
    if (!file) throw std::runtime_error(path + ": cut short");
    points.emplace_back(xyzi[0], xyzi[1], xyzi[2]);
  }
  if (points.empty()) throw std::runtime_error(path + ": no points");
  return points;
}

std::vector<Scan> readStructuredScans(const std::string& folder, const std::string& name, int count)
{
  std::ifstream poses(folder + "/la3dm/sim_structured.tum");
  std::vector<Eigen::Vector3d> origins;
  double stamp = 0, x = 0, y = 0, z = 0;
  for (std::string line; std::getline(poses, line);)
    if (std::istringstream(line) >> stamp >> x >> y >> z) origins.emplace_back(x, y, z);
  if (origins.empty()) throw std::runtime_error("no poses in " + folder + "/la3dm/sim_structured.tum");

  std::vector<Scan> scans;
  for (int i = 1; i <= count; ++i)
  {
    RayFan fan;
    // The long-term scans are all taken from the place of the first.
    fan.centre = name == "sim_structured" ? origins.at(static_cast<size_t>(i - 1)) : origins.front();
    for (const Eigen::Vector3d& point :
         readPcdPoints(folder + "/la3dm/" + name + "/" + name + "_" + std::to_string(i) + ".pcd"))
      fan.addReturn(point);
    scans.emplace_back().fans.push_back(std::move(fan));
  }
  return scans;
}

}  // namespace lamap::test
