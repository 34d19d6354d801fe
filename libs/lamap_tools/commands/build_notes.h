#pragma once

#include <lamap_core/scan/ray_selection.h>
#include <lamap_tools/inputs/scan_look.h>
#include <lamap_tools/inputs/scan_source.h>
#include <mrpt/maps/CMetricMap.h>

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace lamap::tools
{
/// Where better poses come from than a log's odometry. @param path  of the log
[[nodiscard]] std::string odometryNote(const std::string& path);
/// What to do about points beyond the useful range. @param range_m  where they all seem to lie
[[nodiscard]] std::string phantomShellNote(const std::string& path, const std::string& sensor,
                                           double range_m);
/// What to do about scans without returns; nothing if there are none.
/// @param isAlone  no other sensor is in the log
[[nodiscard]] std::optional<std::string> emptyScansNote(const std::string& path, const std::string& sensor,
                                                        const EmptyScans& scans, bool isAlone);

/// What became of beams whose opening angle is none; nothing if it is one.
/// @param aperture_rad  as statedApertureOf()
[[nodiscard]] std::optional<std::string> apertureNote(const std::string& path, const std::string& sensor,
                                                      double aperture_rad);

/** What the user should know about how logs go with a map, each at most once, with the log that it is about.
 *
 * Looks at the scans that are worth it (see isWorthALook()): rays take time to read. What became of rays is
 * counted of all scans. The map must outlive it. */
class BuildNotes
{
 public:
  explicit BuildNotes(const mrpt::maps::CMetricMap& map) : map_(map) {}

  /// To be shown every item before it is inserted,
  void look(const ScanItem& item, const ScanSource& source);
  /// and told that it was.
  void inserted();

  /// What there is to say, once all has been shown.
  [[nodiscard]] std::vector<std::string> notes() const;

 private:
  /// What was seen of a sensor.
  struct Sensor
  {
    size_t scans = 0;
    size_t lookedAt = 0;  ///< of them, those with returns
    PhantomShells shells;
    size_t shellsAtLimit = 0;        ///< scans with one at the map's maxRange
    EmptyScans emptyScans;           ///< of those that made free space
    double longest_m = 0;            ///< range of a return
    double height_m = 0;             ///< the largest one of a scan without its outliers
    double illegalAperture_rad = 0;  ///< that it states; 0: none
    size_t crowded = 0;              ///< scans of which more than half lies in fewer than ten cells
  };
  /// What was seen of an input.
  struct Log
  {
    const ScanSource* source;
    std::map<std::string, Sensor> sensors{};
    std::optional<Eigen::Vector3d> firstPosition_map{};
    double farthestFromFirst_m = 0;
  };
  /// A note on a sensor of a log, if there is something to say.
  using NoteOnSensor =
      std::function<std::optional<std::string>(const std::string& name, const Sensor&, const Log&)>;

  Log& logOf(const ScanSource& source);
  void lookClosely(const ScanItem& item, Sensor& sensor) const;
  [[nodiscard]] std::optional<std::string> odometryNotes() const;
  /// The first note that there is, and of which other sensors there are others.
  [[nodiscard]] std::optional<std::string> firstOf(const NoteOnSensor& noteOn) const;
  [[nodiscard]] std::optional<std::string> planarNote(const std::string& name, const Sensor& sensor,
                                                      const Log& log) const;
  [[nodiscard]] std::optional<std::string> coarseNote(const std::string& name, const Sensor& sensor,
                                                      const Log& log) const;
  [[nodiscard]] std::optional<std::string> shellNote(const std::string& name, const Sensor& sensor,
                                                     const Log& log) const;

  const mrpt::maps::CMetricMap& map_;
  std::list<Log> logs_;
  Sensor* lookedAt_ = nullptr;  ///< the sensor of the item that is inserted next
  RayCounts before_;            ///< and the map's rays without it
};

}  // namespace lamap::tools
