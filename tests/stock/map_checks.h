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

/// One of this library's kinds of maps, for tests that run for all of them.
struct MapKind
{
  std::string name;       ///< in its ready-made configurations, icp-slam_NAME.ini, and in names of tests
  std::string className;  ///< in the registry
};
const std::vector<MapKind>& mapKinds();

/// Path of a program's ready-made configuration for a kind of map.
std::string configFile(const std::string& program, const MapKind& kind);

/// What the stock programs put before the extension of a map's file, "lamap__CBGKMap_00".
std::string savedName(const MapKind& kind);

/// Prints only the name, for test names and output.
std::ostream& operator<<(std::ostream& out, const MapKind& kind);

/// The contents of a saved map.
struct SavedMap
{
  std::string className;
  size_t free = 0;
  size_t unknown = 0;
  std::vector<Point> occupied;  ///< centres
};

/// Loads a map like any program with the plug-in. @throws std::exception if the file is not a map
SavedMap loadSavedMap(const std::filesystem::path& path);

/// A points map as MRPT saves it: x y z per line.
std::vector<Point> readPoints(const std::filesystem::path& path);

/// Share of the points that have one of the others within a distance in the plane; 0 if there are no points.
double shareNear(const std::vector<Point>& points, const std::vector<Point>& others, double distance_m);

/** Expects that a saved map and the points map of the same run show the same walls: at least this share of
 * the occupied cells has a point within 0.2 m, and most of the points have a cell. */
void expectSameWalls(const SavedMap& map, const std::vector<Point>& points, double shareOnWalls = 0.9);

/// The first `entries` of a log.
void cutLog(const std::string& log, size_t entries, const std::filesystem::path& shorter);

/// A log that contains the map of a file as an object, between two odometry readings.
void writeLogWithMap(const std::filesystem::path& mapFile, const std::filesystem::path& log);

/// `copies` of the first observation of a log, `period_s` apart.
void repeatObservation(const std::string& log, size_t copies, double period_s,
                       const std::filesystem::path& longer);

/// Instantiates a suite for each kind of map, whose name is appended to the test's.
#define FOR_EACH_KIND_OF_MAP(suite)                                               \
  INSTANTIATE_TEST_SUITE_P(, suite, ::testing::ValuesIn(lamap::test::mapKinds()), \
                           [](const auto& testParam) { return testParam.param.name; })

}  // namespace lamap::test
