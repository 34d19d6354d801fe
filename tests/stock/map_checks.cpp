#include "map_checks.h"

#include "program.h"

#include <gtest/gtest.h>
#include <lamap_mrpt/files/map_file.h>
#include <lamap_mrpt/learned_map/CLearnedMap.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CRawlog.h>
#include <mrpt/system/datetime.h>

#include <algorithm>
#include <fstream>
#include <stdexcept>

namespace lamap::test
{
namespace
{
using mrpt::obs::CRawlog;

CRawlog readLog(const std::string& path)
{
  CRawlog log;
  if (!log.loadFromRawLogFile(path)) throw std::runtime_error(path + " cannot be read");
  return log;
}

void saveLog(const CRawlog& log, const std::filesystem::path& path)
{
  if (!log.saveToRawLogFile(path.string())) throw std::runtime_error(path.string() + " cannot be written");
}
}  // namespace

const std::vector<MapKind>& mapKinds()
{
  static const std::vector<MapKind> kinds{{"bgk", "lamap::CBGKMap"},
                                          {"gp", "lamap::CGPMap"},
                                          {"hilbert", "lamap::CHilbertMap"},
                                          {"overlapping", "lamap::COverlappingHilbertMap"}};
  return kinds;
}

std::string configFile(const std::string& program, const MapKind& kind)
{
  return configFile(program + "/" + kind.name + ".ini");
}

std::string savedName(const MapKind& kind)
{
  std::string name = kind.className;
  return name.replace(name.find("::"), 2, "__") + "_00";
}

std::ostream& operator<<(std::ostream& out, const MapKind& kind)
{
  return out << kind.name;
}

SavedMap loadSavedMap(const std::filesystem::path& path)
{
  const auto loaded = loadMapFile(path.string());
  const auto map = std::dynamic_pointer_cast<const CLearnedMap>(loaded);
  if (!map) throw std::runtime_error(path.string() + " is not one of this library's maps");
  SavedMap saved;
  saved.className = loaded->GetRuntimeClass()->className;
  const double r = map->resolution();
  map->visitCells(
      [&](const CellIndex& cell, const CellEstimate& estimate)
      {
        if (estimate.state == CellState::Occupied)
          saved.occupied.push_back({(cell.x + 0.5) * r, (cell.y + 0.5) * r, (cell.z + 0.5) * r});
        else
          ++(estimate.state == CellState::Free ? saved.free : saved.unknown);
      });
  return saved;
}

std::vector<Point> readPoints(const std::filesystem::path& path)
{
  std::vector<Point> points;
  std::ifstream in(path);
  for (Point p; in >> p.x >> p.y >> p.z;) points.push_back(p);
  return points;
}

double shareNear(const std::vector<Point>& points, const std::vector<Point>& others, double distance_m)
{
  if (points.empty()) return 0;
  const double limit = distance_m * distance_m;
  const auto hasNeighbour = [&](const Point& p)
  {
    return std::any_of(others.begin(), others.end(),
                       [&](const Point& q)
                       { return (p.x - q.x) * (p.x - q.x) + (p.y - q.y) * (p.y - q.y) <= limit; });
  };
  return static_cast<double>(std::count_if(points.begin(), points.end(), hasNeighbour)) /
         static_cast<double>(points.size());
}

void expectSameWalls(const SavedMap& map, const std::vector<Point>& points, double shareOnWalls)
{
  ASSERT_GT(points.size(), 100u);
  EXPECT_GT(map.occupied.size(), 100u);
  EXPECT_GT(map.free, map.occupied.size());
  EXPECT_GE(shareNear(map.occupied, points, 0.2), shareOnWalls) << map.occupied.size() << " occupied cells";
  EXPECT_GE(shareNear(points, map.occupied, 0.2), 0.6) << points.size() << " points";
}

void cutLog(const std::string& log, size_t entries, const std::filesystem::path& shorter)
{
  CRawlog whole = readLog(log);
  if (whole.size() > entries) whole.remove(entries, whole.size() - 1);
  saveLog(whole, shorter);
}

void writeLogWithMap(const std::filesystem::path& mapFile, const std::filesystem::path& log)
{
  CRawlog entries;
  const auto insertOdometry = [&](double x)
  {
    auto odometry = std::make_shared<mrpt::obs::CObservationOdometry>();
    odometry->sensorLabel = "ODOMETRY";
    odometry->odometry.x(x);
    odometry->timestamp = mrpt::system::now();
    entries.insert(std::static_pointer_cast<mrpt::serialization::CSerializable>(odometry));
  };
  insertOdometry(0);
  entries.insert(std::static_pointer_cast<mrpt::serialization::CSerializable>(loadMapFile(mapFile.string())));
  insertOdometry(1);
  saveLog(entries, log);
}

void repeatObservation(const std::string& log, size_t copies, double period_s,
                       const std::filesystem::path& longer)
{
  const CRawlog whole = readLog(log);
  const auto observation = whole.getAsObservation(0);
  const auto first = observation->timestamp;
  CRawlog repeated;
  for (size_t i = 0; i < copies; ++i)
  {
    auto copy = std::dynamic_pointer_cast<mrpt::obs::CObservation>(observation->duplicateGetSmartPtr());
    copy->timestamp = mrpt::system::timestampAdd(first, static_cast<double>(i) * period_s);
    repeated.insert(copy);
  }
  saveLog(repeated, longer);
}

}  // namespace lamap::test
