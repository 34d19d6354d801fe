#pragma once

#include <lamap_core/scan/echo_detection.h>
#include <lamap_core/scan/scan.h>
#include <mrpt/core/Clock.h>

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace lamap::tools
{
/// In which unit a file of pings gives azimuths.
enum class AngleUnit
{
  Degrees,
  Radians,
  Gradians  ///< 400 in a full turn
};

/// How the pings of a scanning sonar are read.
struct PingRules
{
  /// Opening angles of the beam, edge to edge [deg]: about the vertical axis of the sensor, and across that;
  /// 0: the beam is a line.
  double beamWidth_deg = 0;
  double beamHeight_deg = 0;
  AngleUnit azimuthUnit = AngleUnit::Degrees;
  /// Near the sensor and at the maximum range, see EchoRules; empty: half of the highest intensity in the
  /// file beyond the dead zone.
  std::optional<std::pair<double, double>> threshold;
  double deadZone_m = 0.5;
  double separation_m = 0.5;
  size_t mostEchoes = 3;

  /// @throws UsageError naming the first flag whose value is illegal
  void validate() const;

  friend bool operator==(const PingRules& a, const PingRules& b);
};

struct Ping
{
  mrpt::Clock::time_point time;
  double azimuth_rad = 0;  ///< from the x axis of the sensor to its y axis
  double rangeMax_m = 0;
  std::vector<DetectedEcho> echoes;
};

/** Pings of a scanning sonar, one per line: time [s], azimuth, maximum range [m], and the intensities of bins
 * of equal length up to that range, separated by commas, semicolons or blanks. Empty lines and lines that
 * begin with # are left out; the first line may be a header. */
struct PingFile
{
  std::vector<Ping> pings;  ///< in the file's order
  EchoRules rules;          ///< that the echoes were found by

  /** @throws std::runtime_error naming the file, the line and what would be right there; also if there is no
   * ping */
  [[nodiscard]] static PingFile read(const std::string& path, const PingRules& rules,
                                     const std::function<bool()>& shouldStop);
};

/** A ping as rays in the frame of the sensor: a return for each echo, of which the first is of rank 0, or one
 * ray without a return. */
[[nodiscard]] RayFan fanOf(const Ping& ping, const PingRules& rules);

}  // namespace lamap::tools
