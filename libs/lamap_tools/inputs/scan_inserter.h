#pragma once

#include <lamap_tools/inputs/scan_source.h>
#include <mrpt/maps/CMetricMap.h>

#include <map>
#include <ostream>
#include <string>
#include <utility>

namespace lamap::tools
{
/// What became of the scans.
struct InsertionTally
{
  std::map<std::string, size_t> used;  ///< by kind: the observation's class, "PCD file", …
  /// By kind and reason.
  std::map<std::pair<std::string, std::string>, size_t> leftOut;

  [[nodiscard]] size_t usedCount() const;
};

/// Why scans were not used: "  left out: COUNT KIND: REASON" per line. @param who  is named before it
void printLeftOut(const InsertionTally& tally, std::ostream& out, const std::string& who = "");

/// The same for an error, each line after a line break.
[[nodiscard]] std::string reasonsOf(const InsertionTally& tally);

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
  explicit ScanInserter(mrpt::maps::CMetricMap& map) : map_(map) {}

  /// One scan that cannot be inserted is counted with its reason; the others go on. @throws std::bad_alloc
  void insert(const ScanItem& item);

  [[nodiscard]] const InsertionTally& tally() const { return tally_; }

 private:
  void insert(const ObservedScan& scan);
  void insert(const PointScan& scan);
  void insert(const LeftOutScan& scan);
  /// @return why the map took nothing; empty if it did
  [[nodiscard]] std::string tryInserting(const ObservedScan& scan);
  [[nodiscard]] std::string tryInserting(const PointScan& scan);
  [[nodiscard]] bool insertPoints(const Scan& scan);
  void count(const std::string& kind, const std::string& reason);

  mrpt::maps::CMetricMap& map_;
  InsertionTally tally_;
};

}  // namespace lamap::tools
