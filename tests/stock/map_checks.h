#pragma once

#include <filesystem>
#include <ostream>
#include <string>
#include <vector>

namespace lamap::test
{
/// In the map frame [m].
struct Point
{
  double x = 0, y = 0, z = 0;
};

/// One of this library's maps, as the tests that hold for all of them name it.
struct MapKind
{
  std::string name;       ///< of its ready configurations, icp-slam_NAME.ini, and of the test
  std::string className;  ///< in the registry
};
const std::vector<MapKind>& mapKinds();

/// Path of the ready configuration of a program for a kind of map.
std::string configFile(const std::string& program, const MapKind& kind);

/// What the stock programs put before the extension of a map's file, "lamap__CBGKMap_00".
std::string savedName(const MapKind& kind);

/// The name alone, for the name of a test and for what it prints.
std::ostream& operator<<(std::ostream& out, const MapKind& kind);

/// What a saved map holds.
struct SavedMap
{
  std::string className;
  size_t free = 0;
  size_t unknown = 0;
  std::vector<Point> occupied;  ///< centres
};

/// Loads a map as any program with the plug-in would. @throws std::exception if it is none
SavedMap loadSavedMap(const std::filesystem::path& path);

/// A points map as MRPT saves it: x y z a line.
std::vector<Point> readPoints(const std::filesystem::path& path);

/// Share of the points that have one of the others within a distance in the plane; 0 if there is no point.
double shareNear(const std::vector<Point>& points, const std::vector<Point>& others, double distance_m);

/** Whether a saved map and the points map of the same run show the same walls: so many of the occupied cells
 * have a point within 0.2 m and most of the points a cell. Says what it found otherwise. */
void expectSameWalls(const SavedMap& map, const std::vector<Point>& points, double shareOnWalls = 0.9);

/// The first `entries` of a log.
void cutLog(const std::string& log, size_t entries, const std::filesystem::path& shorter);

/// A log that holds the map of a file as an object, between two readings of odometry.
void writeLogWithMap(const std::filesystem::path& mapFile, const std::filesystem::path& log);

/// `copies` of the first observation of a log, `period_s` apart.
void repeatObservation(const std::string& log, size_t copies, double period_s,
                       const std::filesystem::path& longer);

/// Once for each kind of map, whose name ends the test's.
#define FOR_EACH_KIND_OF_MAP(suite)                                               \
  INSTANTIATE_TEST_SUITE_P(, suite, ::testing::ValuesIn(lamap::test::mapKinds()), \
                           [](const auto& testParam) { return testParam.param.name; })

}  // namespace lamap::test
