#pragma once

#include <lamap_tools/inputs/scan_source.h>
#include <lamap_tools/report/json.h>
#include <mrpt/maps/CMetricMap.h>

#include <map>
#include <ostream>
#include <string>
#include <utility>

namespace lamap::tools
{
/// Scans that were not used for the same reason.
struct LeftOutScans
{
  size_t count = 0;
  ScanPlace first;
};

/// What became of the scans.
struct InsertionTally
{
  std::map<std::string, size_t> used;  ///< by kind: the observation's class, "PCD file", …
  /// By kind and reason.
  std::map<std::pair<std::string, std::string>, LeftOutScans> leftOut;
  size_t failed = 0;  ///< of those left out, how many could not be read or learned

  [[nodiscard]] size_t usedCount() const;
  void leaveOut(const std::string& kind, const std::string& reason, const ScanPlace& place);
};

/// Why scans were not used: "  left out: COUNT KIND: REASON (the first: WHICH)" per line. @param who  is
/// named before it
void printLeftOut(const InsertionTally& tally, std::ostream& out, const std::string& who = "");

/// The same for an error, each after the separator: lines of their own.
[[nodiscard]] std::string reasonsOf(const InsertionTally& tally, const std::string& separator = "\n  ");

/// The same as a list of {"kind", "reason", "count", "first": {"input", "number", "time" (s since 1970, or
/// null)}}.
[[nodiscard]] Json leftOutJson(const InsertionTally& tally);

/** Inserts scans into any map and counts them. The map must outlive it.
 *
 * This library's maps take observations and points as they are. MRPT's own maps get points as a
 * CObservationPointCloud in a form in which all of them apply every pose: MRPT 2.5's point maps ignore the
 * robot's pose of one, and its octrees the sensor's pose; a CObservationVelodyneScan after its points were
 * generated; and, in octrees, single beams as the points of their echoes.
 */
class ScanInserter
{
 public:
  /// @param strict stops at the first scan that cannot be read or learned
  explicit ScanInserter(mrpt::maps::CMetricMap& map, bool strict = false) : map_(map), strict_(strict) {}

  /** One scan that cannot be inserted, whatever its source, is counted with its reason; the others go on.
   * @throws std::runtime_error with kind and reason if it is strict */
  void insert(const ScanItem& item);

  [[nodiscard]] const InsertionTally& tally() const { return tally_; }

 private:
  /// @return why the map took nothing; empty if it did
  [[nodiscard]] std::string tryInserting(const ObservedScan& scan);
  [[nodiscard]] std::string tryInserting(const PointScan& scan);
  [[nodiscard]] std::string tryInserting(const LeftOutScan& scan) { return scan.reason; }
  [[nodiscard]] bool insertPoints(const Scan& scan);
  mrpt::maps::CMetricMap& map_;
  bool strict_;
  InsertionTally tally_;
};

}  // namespace lamap::tools
