#pragma once

#include <lamap_core/scan/scan.h>

#include <cstddef>
#include <cstdint>
#include <optional>

namespace lamap
{
class OptionTable;

/// Which rays of a scan are used, and how far.
struct RangeOptions
{
  /// [m] returns nearer than this are left out, with their rays; also what the observation states
  double minRange = 0;
  /// [m] hits and free space end here, or at what the observation states if that is less; 0: only there
  double maxRange = 0;
  bool considerInvalidRangesAsFreeSpace = true;  ///< rays without a return are free, see OpenSpace
  uint32_t rayDecimation = 1;  ///< use every Nth ray, counted through the scan in the order of the sensor

  /// These options alone, of a struct that adds its own.
  [[nodiscard]] const RangeOptions& rangeLimits() const { return *this; }

  /// Describes every option, once.
  [[nodiscard]] static const OptionTable& optionTable();
};

/** Longer rays are left out, after they were cut to the maximum range: the work of a ray grows with the
 * number of cells that it crosses. 3.2 km in cells of 0.1 m. */
constexpr double kLongestRay_cells = 32768;

/// What became of the rays of a scan.
struct RayCounts
{
  size_t hits = 0;       ///< used, with their end
  size_t freeOnly = 0;   ///< used as free space only: without return, or cut at the maximum range
  size_t noReturn = 0;   ///< of those, without return
  size_t narrowed = 0;   ///< of the used ones: their beams are too far apart to be given a width
  size_t decimated = 0;  ///< skipped by rayDecimation
  size_t dropped = 0;    ///< nothing is known of them
  size_t notFinite = 0;  ///< NaN or infinite: left out
  size_t tooNear = 0;    ///< nearer than the minimum range, or of length zero: left out
  size_t unbounded =
      0;  ///< without return and without a maximum range to end at, or not wanted as free space: left out
  size_t tooLong = 0;            ///< longer than kLongestRay_cells: left out
  size_t outside = 0;            ///< beyond what cell indices can address: left out
  double noReturnLength_m = 0;   ///< of the used rays without return together
  double noReturnLongest_m = 0;  ///< the longest of them
  double tooLongLongest_m = 0;   ///< the longest of the rays that are too long

  [[nodiscard]] size_t used() const { return hits + freeOnly; }
  [[nodiscard]] size_t leftOut() const { return notFinite + tooNear + unbounded + tooLong + outside; }
  RayCounts& operator+=(const RayCounts& other);
};

/** The usable rays of a scan, cut to their ranges.
 *
 * Each ray is a Return; or a NoReturn or Cut, whose vector [m] ends where its free space does: a vector, for
 * an end point would be rounded far from the map's origin. Each fan states the maximum range that was applied
 * (0: unlimited). Fans and rays keep their order. */
struct SelectedRays
{
  Scan scan;
  RayCounts counts;

  /// Optical centre of the first fan with usable rays [m]; the sensor if there is none.
  [[nodiscard]] Eigen::Vector3d firstCentre_map() const;
};

/** Selects and cuts the rays of a scan.
 *
 * The maximum range is the smaller of the option's and the one that the observation states. A ray longer than
 * that is free up to there and has no hit. A ray without a return is free up to there too, but not beyond the
 * returns that bound it, see OpenSpace.
 * @param resolution_m of the cells that the rays are for; nothing: they may have any length
 * @throws std::invalid_argument naming the first illegal option, its value and the legal range; or if the
 * scan's pose is no rigid motion, or the beam of a fan not legal */
[[nodiscard]] SelectedRays selectRays(const Scan& scan, const RangeOptions& limits,
                                      std::optional<double> resolution_m = std::nullopt);

}  // namespace lamap
