#include <lamap_core/options/nearest_name.h>
#include <lamap_tools/files/text_fields.h>
#include <lamap_tools/files/usage_error.h>
#include <lamap_tools/inputs/scan_choice.h>
#include <lamap_tools/inputs/scan_source.h>
#include <lamap_tools/report/counted.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <stdexcept>

namespace lamap::tools
{
using Time = mrpt::Clock::time_point;

namespace
{
int64_t microsecondsSince1970(Time time)
{
  using namespace std::chrono;
  const Time epoch = mrpt::Clock::fromDouble(0);
  return round<microseconds>(time - epoch).count();
}

/// A span of time [us since 1970], both ends included.
struct Span
{
  int64_t first_us;
  int64_t last_us;
};

/// A time is what is printed of it: `lamap info` prints milliseconds.
Span spanAround(int64_t time_us)
{
  constexpr int64_t kHalfAMillisecond_us = 500;
  return {time_us - kHalfAMillisecond_us, time_us + kHalfAMillisecond_us};
}

/// Of a date: the moment if it has a time of day, else the whole day; nothing if the text is not a date.
std::optional<Span> dateIn(std::string_view text)
{
  if (!text.empty() && text.back() == 'Z') text.remove_suffix(1);
  const auto parts = fieldsBetween(text, "T ");
  const auto days = fieldsBetween(parts[0], "-");
  if (parts.size() > 2 || days.size() != 3) return std::nullopt;
  const auto year = numberIn<int>(days[0]);
  const auto month = numberIn<int>(days[1]);
  const auto day = numberIn<int>(days[2]);
  if (!year || !month || !day || *year < 1900 || *year > 9999 || *month < 1 || *month > 12 || *day < 1 ||
      *day > 31)
    return std::nullopt;
  int hour = 0;
  int minute = 0;
  double second = 0;
  if (parts.size() == 2)
  {
    const auto clock = fieldsBetween(parts[1], ":");
    if (clock.size() < 2 || clock.size() > 3) return std::nullopt;
    hour = numberIn<int>(clock[0]).value_or(-1);
    minute = numberIn<int>(clock[1]).value_or(-1);
    if (clock.size() == 3) second = numberIn<double>(clock[2]).value_or(-1);
    if (hour < 0 || hour > 23 || minute < 0 || minute > 59 || !(second >= 0 && second < 61))
      return std::nullopt;
  }
  std::tm date{};
  date.tm_year = *year - 1900;
  date.tm_mon = *month - 1;
  date.tm_mday = *day;
  date.tm_hour = hour;
  date.tm_min = minute;
  const std::time_t seconds = timegm(&date);
  if (date.tm_mday != *day) return std::nullopt;  // no 31st in this month
  const int64_t begin_us = static_cast<int64_t>(seconds) * 1'000'000;
  constexpr int64_t kDay_us = int64_t{24} * 3600 * 1'000'000;
  if (parts.size() == 1) return Span{begin_us, begin_us + kDay_us - 1};
  return spanAround(begin_us + std::llround(second * 1e6));
}

/// "A: 3, B: 2".
std::string countsText(const std::map<std::string, uint64_t>& countOf)
{
  std::vector<std::string> counts;
  for (const auto& [name, count] : countOf) counts.push_back(name + ": " + std::to_string(count));
  return joined(counts);
}
}  // namespace

std::string sensorNameOf(const mrpt::obs::CObservation& observation)
{
  return observation.sensorLabel.empty() ? shortClassName(observation) : observation.sensorLabel;
}

void LogContents::include(const mrpt::obs::CObservation& observation)
{
  sensors.insert(sensorNameOf(observation));
  if (observation.timestamp == INVALID_TIMESTAMP) return;
  firstTime = firstTime ? std::min(*firstTime, observation.timestamp) : observation.timestamp;
}

LogTime::LogTime(const std::string& flag, const std::string& text) : text_(text)
{
  if (const auto date = dateIn(trimmed(text)))
  {
    isAbsolute_ = true;
    first_us_ = date->first_us;
    last_us_ = date->last_us;
    return;
  }
  constexpr double kFirstAbsolute_s = 1e8;
  constexpr double kLast_s = 1e11;  // the year 5138; later ones would overflow MRPT's clock
  const auto seconds = numberIn<long double>(trimmed(text));
  if (!seconds || !(*seconds >= 0 && *seconds <= kLast_s))
    throw UsageError(flag + " " + text +
                     ": must be seconds >= 0 from the log's first time stamp, seconds since 1970, or a date "
                     "like 2006-01-21T10:05:07");
  isAbsolute_ = *seconds >= kFirstAbsolute_s;
  const Span span = spanAround(std::llround(*seconds * 1e6L));
  first_us_ = span.first_us;
  last_us_ = span.last_us;
}

int LogTime::compare(Time time, Time firstTime) const
{
  const int64_t start_us = isAbsolute_ ? 0 : microsecondsSince1970(firstTime);
  const int64_t time_us = microsecondsSince1970(time) - start_us;
  return time_us < first_us_ ? -1 : (time_us > last_us_ ? 1 : 0);
}

bool LogTime::isLaterThan(const LogTime& other) const
{
  return isAbsolute_ == other.isAbsolute_ && first_us_ > other.last_us_;
}

std::string ScanChoice::text() const
{
  std::vector<std::string> flags;
  if (!sensors.empty()) flags.push_back("--sensors " + joined(sensors, ","));
  if (from) flags.push_back("--from " + from->text());
  if (to) flags.push_back("--to " + to->text());
  if (every != 1) flags.push_back("--every " + std::to_string(every));
  return joined(flags, " ");
}

ScanChooser::ScanChooser(ScanChoice choice) : choice_(std::move(choice))
{
  if (choice_.every < 1) throw UsageError("--every 0: must be a whole number >= 1");
  if (choice_.from && choice_.to && choice_.from->isLaterThan(*choice_.to))
    throw UsageError("--from " + choice_.from->text() + " is later than --to " + choice_.to->text());
}

void ScanChooser::requireSensors(const std::vector<LogContents>& logs, const std::string& names) const
{
  std::set<std::string> present;
  for (const LogContents& log : logs) present.insert(log.sensors.begin(), log.sensors.end());
  const std::vector<std::string> all(present.begin(), present.end());
  for (const std::string& sensor : choice_.sensors)
    if (present.count(sensor) == 0)
      throw std::runtime_error("--sensors: there is no '" + sensor + "' in " + names + "; " +
                               suggestionFor(sensor, all, "'", "'"));
}

bool ScanChooser::takes(const mrpt::obs::CObservation& observation, const LogContents& log)
{
  const Time time = observation.timestamp;
  return takes(sensorNameOf(observation), time == INVALID_TIMESTAMP ? std::nullopt : std::optional(time),
               log);
}

bool ScanChooser::takes(const std::string& sensor, std::optional<Time> time, const LogContents& log)
{
  ++asked_;
  const auto& names = choice_.sensors;
  if (!names.empty() && std::find(names.begin(), names.end(), sensor) == names.end()) return false;
  if (needsTime() && !time)
  {
    ++untimedOf_[sensor];
    return false;
  }
  if (!isInTime(time, log)) return false;
  if (countOf_[sensor]++ % choice_.every != 0) return false;
  ++taken_;
  return true;
}

bool ScanChooser::isInTime(std::optional<Time> time, const LogContents& log) const
{
  if (!needsTime()) return true;
  const Time first = log.firstTime.value_or(*time);
  return !(choice_.from && choice_.from->compare(*time, first) < 0) &&
         !(choice_.to && choice_.to->compare(*time, first) > 0);
}

std::string ScanChooser::untimedText() const
{
  uint64_t untimed = 0;
  for (const auto& entry : untimedOf_) untimed += entry.second;
  if (untimed == 0) return "";
  return "; --from and --to leave out " + std::to_string(untimed) + " without a time stamp (" +
         countsText(untimedOf_) + ")";
}

void ScanChooser::requireTaken(const std::string& names) const
{
  if (asked_ == 0 || taken_ > 0) return;
  throw std::runtime_error(choice_.text() + ": selects none of " + counted(asked_, "observation") + " of " +
                           names + untimedText() + "; `lamap info` shows its sensors and their times");
}

std::string ScanChooser::summary() const
{
  return std::to_string(taken_) + " of " + counted(asked_, "observation") + " chosen by " + choice_.text() +
         untimedText();
}

}  // namespace lamap::tools
