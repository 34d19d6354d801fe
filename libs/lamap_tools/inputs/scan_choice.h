#pragma once

#include <mrpt/core/Clock.h>
#include <mrpt/obs/CObservation.h>

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace lamap::tools
{
/// What a sensor is called: its label, or its class where an observation has none.
[[nodiscard]] std::string sensorNameOf(const mrpt::obs::CObservation& observation);

/// Which sensors a log has and when it begins, whatever is chosen from it. Odometry does not count.
struct LogContents
{
  std::set<std::string> sensors;  ///< see sensorNameOf()
  std::optional<mrpt::Clock::time_point> firstTime;

  void include(const mrpt::obs::CObservation& observation);
};

/** A time in a log: seconds from its first time stamp, or absolute.
 *
 * Absolute are a date ("2006-01-21", "2006-01-21T10:05:07.25", UTC) and a number of at least 1e8, the seconds
 * since 1970: no log is three years long. A date without a time of day is the whole day; all others are a
 * moment, to the millisecond. */
class LogTime
{
 public:
  /// @throws UsageError naming the flag if the text is no such time
  LogTime(const std::string& flag, const std::string& text);

  /// Whether the time of an observation is earlier (−1), within (0) or later (1).
  [[nodiscard]] int compare(mrpt::Clock::time_point time, mrpt::Clock::time_point firstTime) const;
  /// Whether this can be told to be later than another one, without a log.
  [[nodiscard]] bool isLaterThan(const LogTime& other) const;
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  std::string text_;
  int64_t first_us_ = 0;  ///< since the log's first time stamp, or since 1970
  int64_t last_us_ = 0;
  bool isAbsolute_ = false;
};

/// Which observations of logs are used; by default all.
struct ScanChoice
{
  std::vector<std::string> sensors;  ///< their names, see sensorNameOf(); empty: all
  uint64_t every = 1;                ///< every Nth observation of each sensor, of those that the rest chooses
  std::optional<LogTime> from;       ///< the first and
  std::optional<LogTime> to;         ///< the last time; with one of them, observations need a time stamp

  [[nodiscard]] bool isAll() const { return sensors.empty() && every == 1 && !from && !to; }
  /// As it was asked for: "--sensors A,B --from 3".
  [[nodiscard]] std::string text() const;
};

/** Chooses observations, of one log after the other. All commands that read logs use this.
 *
 * Of each sensor, the first observation and every Nth after it are taken, counted through all logs. */
class ScanChooser
{
 public:
  /// @throws UsageError if the choice is illegal
  explicit ScanChooser(ScanChoice choice);

  /// @throws std::runtime_error naming a sensor that is in none of the logs, the nearest name, and all there
  /// are
  void requireSensors(const std::vector<LogContents>& logs, const std::string& names) const;

  /// To be asked once for each observation, in their order. @param log  that it belongs to
  [[nodiscard]] bool takes(const mrpt::obs::CObservation& observation, const LogContents& log);
  /// The same for what has no label and perhaps no time stamp.
  [[nodiscard]] bool takes(const std::string& sensor, std::optional<mrpt::Clock::time_point> time,
                           const LogContents& log);

  /// @throws std::runtime_error if there were observations, but none was taken
  void requireTaken(const std::string& names) const;
  /// "3 of 20 observations chosen by --every 7", and which were left out for want of a time stamp.
  [[nodiscard]] std::string summary() const;

 private:
  [[nodiscard]] bool needsTime() const { return choice_.from || choice_.to; }
  /// @param time  is there if it is needed
  [[nodiscard]] bool isInTime(std::optional<mrpt::Clock::time_point> time, const LogContents& log) const;

  /// What is left out for want of a time stamp; empty: nothing.
  [[nodiscard]] std::string untimedText() const;

  ScanChoice choice_;
  std::map<std::string, uint64_t> countOf_;    ///< by sensor, what the rest of the choice takes
  std::map<std::string, uint64_t> untimedOf_;  ///< by sensor, what needs a time stamp and has none
  uint64_t asked_ = 0;
  uint64_t taken_ = 0;
};

}  // namespace lamap::tools
