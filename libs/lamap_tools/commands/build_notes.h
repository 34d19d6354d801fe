#pragma once

#include <lamap_tools/inputs/scan_source.h>
#include <mrpt/maps/CMetricMap.h>

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
[[nodiscard]] std::string phantomShellNote(const std::string& sensor, double range_m);

/** What the user should know about how a log goes with a map, each at most once.
 *
 * Looks at the first scans of each sensor and at a twentieth of the others: rays take time to read. The map
 * must outlive it. */
class BuildNotes
{
 public:
  explicit BuildNotes(const mrpt::maps::CMetricMap& map) : map_(map) {}

  /// To be shown every item.
  void look(const ScanItem& item);

  /// What there is to say, once all has been shown.
  [[nodiscard]] std::vector<std::string> notes(const std::vector<std::unique_ptr<ScanSource>>& sources) const;

 private:
  /// What was seen of a sensor.
  struct Sensor
  {
    size_t scans = 0;
    size_t lookedAt = 0;  ///< of them, those with returns
    size_t phantomShells = 0;
    double shell_m = 0;    ///< range of the last one
    double longest_m = 0;  ///< range of a return
    double height_m = 0;   ///< the largest one of a scan without its outliers
    size_t crowded = 0;    ///< scans that more than half of are in fewer than ten cells
  };

  void lookClosely(const ScanItem& item, Sensor& sensor) const;
  [[nodiscard]] std::optional<std::string> planarNote() const;
  [[nodiscard]] std::optional<std::string> coarseNote() const;
  [[nodiscard]] std::optional<std::string> shellNote() const;

  const mrpt::maps::CMetricMap& map_;
  std::map<std::string, Sensor> sensors_;
  std::optional<Eigen::Vector3d> firstPosition_map_;
  double farthestFromFirst_m_ = 0;
};

}  // namespace lamap::tools
