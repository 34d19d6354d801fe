#include <lamap_core/options/legal_range.h>
#include <lamap_core/scan/beam_cone.h>
#include <lamap_tools/files/file_input.h>
#include <lamap_tools/files/text_fields.h>
#include <lamap_tools/files/usage_error.h>
#include <lamap_tools/inputs/ping_file.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <tuple>

namespace lamap::tools
{
namespace
{
constexpr double kPi = 3.141592653589793;
constexpr size_t kColumnsBeforeBins = 3;

double inRadians(double angle, AngleUnit unit)
{
  switch (unit)
  {
    case AngleUnit::Degrees:
      return angle * (kPi / 180);
    case AngleUnit::Gradians:
      return angle * (kPi / 200);
    case AngleUnit::Radians:
      break;
  }
  return angle;
}

/// One line of a file.
struct Profile
{
  double time_s = 0;
  double azimuth = 0;
  double rangeMax_m = 0;
  std::vector<double> intensities;
};

double numberAt(const std::vector<std::string_view>& fields, size_t column, const char* what)
{
  const auto number = numberIn<double>(fields[column]);
  if (number && std::isfinite(*number)) return *number;
  throw std::runtime_error("column " + std::to_string(column + 1) + ", \"" + std::string(fields[column]) +
                           "\": must be " + what);
}

std::vector<std::string_view> columnsOf(std::string_view line)
{
  const bool hasSeparators = line.find_first_of(",;") != std::string_view::npos;
  std::vector<std::string_view> fields = fieldsBetween(line, hasSeparators ? ",;" : " \t");
  if (!hasSeparators)
    fields.erase(std::remove(fields.begin(), fields.end(), std::string_view()), fields.end());
  else if (fields.back().empty())
    fields.pop_back();  // a separator at the end of the line
  return fields;
}

Profile profileIn(const std::vector<std::string_view>& fields)
{
  if (fields.size() <= kColumnsBeforeBins)
    throw std::runtime_error("has " + std::to_string(fields.size()) +
                             " columns; expected time [s], azimuth, maximum range [m] and at least one "
                             "intensity");
  Profile profile;
  profile.time_s = numberAt(fields, 0, "a time in seconds");
  profile.azimuth = numberAt(fields, 1, "an azimuth");
  profile.rangeMax_m = numberAt(fields, 2, "a maximum range in metres, above 0");
  constexpr double kLatestTime_s = 1e11;  // the year 5138; later ones would overflow MRPT's clock
  if (!(profile.time_s >= 0 && profile.time_s <= kLatestTime_s))
    throw std::runtime_error("column 1, \"" + std::string(fields[0]) +
                             "\": must be a time in seconds since 1970, of at least 0");
  if (!(profile.rangeMax_m > 0))
    throw std::runtime_error("column 3, \"" + std::string(fields[2]) +
                             "\": must be a maximum range in metres, above 0");
  profile.intensities.reserve(fields.size() - kColumnsBeforeBins);
  for (size_t column = kColumnsBeforeBins; column < fields.size(); ++column)
    profile.intensities.push_back(numberAt(fields, column, "an intensity"));
  return profile;
}

/// The first one tells whether the table holds pings at all.
Profile firstProfileIn(const std::vector<std::string_view>& fields)
{
  try
  {
    return profileIn(fields);
  }
  catch (const std::runtime_error& error)
  {
    throw std::runtime_error(std::string(error.what()) +
                             ". As a log, a .csv holds the pings of a scanning sonar, one a line: time [s], "
                             "azimuth, maximum range [m], intensities");
  }
}

/// Whether a line names the columns of pings: of other tables, e.g. of points, each line would look like one.
bool isHeader(const std::vector<std::string_view>& fields)
{
  if (fields.empty()) return false;
  std::string name(fields.front());
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char letter) { return static_cast<char>(std::tolower(letter)); });
  return name == "t" || name.find("time") != std::string::npos || name.find("stamp") != std::string::npos;
}

/// A line that was cut short has fewer bins than another one to the same range.
void requireSameBins(const Profile& profile, const Profile& before)
{
  if (profile.rangeMax_m == before.rangeMax_m && profile.intensities.size() != before.intensities.size())
    throw std::runtime_error("intensities: " + std::to_string(profile.intensities.size()) +
                             "; of the ping before, to the same range: " +
                             std::to_string(before.intensities.size()) + "; one of the two lines is damaged");
}

/// Calls visit(profile) for each line of a file.
template <typename Visit>
void forEachProfile(const std::string& path, const std::function<bool()>& shouldStop, Visit&& visit)
{
  std::ifstream file = openedFile(path, "a file of pings");
  bool isFirst = true;
  std::optional<Profile> before;
  forEachLine(file, path,
              [&](std::string_view line, size_t)
              {
                if (shouldStop()) return;
                const auto fields = columnsOf(line);
                const bool mayBeHeader = std::exchange(isFirst, false);
                if (mayBeHeader && isHeader(fields)) return;
                Profile profile = before ? profileIn(fields) : firstProfileIn(fields);
                if (before) requireSameBins(profile, *before);
                visit(profile);
                before = std::move(profile);
              });
}

/// The highest intensity in a file, beyond the dead zone.
double highestIntensity(const std::string& path, double deadZone_m, const std::function<bool()>& shouldStop)
{
  double highest = 0;
  forEachProfile(path, shouldStop,
                 [&](const Profile& profile)
                 {
                   const auto bins = static_cast<double>(profile.intensities.size());
                   const double first = std::ceil(deadZone_m / profile.rangeMax_m * bins - 0.5);
                   for (auto i = static_cast<size_t>(std::clamp(first, 0.0, bins));
                        i < profile.intensities.size(); ++i)
                     highest = std::max(highest, profile.intensities[i]);
                 });
  return highest;
}

void requireAngle(const char* flag, double angle_deg)
{
  if (!(angle_deg >= 0 && angle_deg < 180))
    throw UsageError(std::string(flag) + " " + shortText(angle_deg) +
                     ": an opening angle must be at least 0 and less than 180 degrees");
}
}  // namespace

void PingRules::validate() const
{
  requireAngle("--ping-beam", beamWidth_deg);
  requireAngle("--ping-beam", beamHeight_deg);
  const auto requireLength = [](const char* flag, double length_m)
  {
    if (!(length_m >= 0 && std::isfinite(length_m)))
      throw UsageError(std::string(flag) + " " + shortText(length_m) + ": must be a length of at least 0 m");
  };
  requireLength("--ping-dead-zone", deadZone_m);
  requireLength("--ping-separation", separation_m);
  if (mostEchoes < 1) throw UsageError("--ping-echoes 0: must be at least 1");
  if (threshold && !(std::isfinite(threshold->first) && std::isfinite(threshold->second)))
    throw UsageError("--ping-threshold: must be finite");
}

bool operator==(const PingRules& a, const PingRules& b)
{
  const auto all = [](const PingRules& rules)
  {
    return std::tie(rules.beamWidth_deg, rules.beamHeight_deg, rules.azimuthUnit, rules.threshold,
                    rules.deadZone_m, rules.separation_m, rules.mostEchoes);
  };
  return all(a) == all(b);
}

PingFile PingFile::read(const std::string& path, const PingRules& rules,
                        const std::function<bool()>& shouldStop)
{
  PingFile file;
  file.rules.deadZone_m = rules.deadZone_m;
  file.rules.separation_m = rules.separation_m;
  file.rules.mostEchoes = rules.mostEchoes;
  const double half = rules.threshold ? 0.0 : 0.5 * highestIntensity(path, rules.deadZone_m, shouldStop);
  file.rules.nearThreshold = rules.threshold ? rules.threshold->first : half;
  file.rules.farThreshold = rules.threshold ? rules.threshold->second : half;
  file.rules.validate();
  forEachProfile(path, shouldStop,
                 [&](const Profile& profile)
                 {
                   file.pings.push_back({mrpt::Clock::fromDouble(profile.time_s),
                                         inRadians(profile.azimuth, rules.azimuthUnit), profile.rangeMax_m,
                                         findEchoes(profile.intensities, profile.rangeMax_m, file.rules)});
                 });
  if (file.pings.empty() && !shouldStop()) throw std::runtime_error(path + ": holds no ping");
  if (!rules.threshold && half == 0 && !shouldStop())
    throw std::runtime_error(path +
                             ": no intensity beyond the dead zone is above 0, so that none tells what an " +
                             "echo is; give --ping-threshold, or a smaller --ping-dead-zone");
  return file;
}

RayFan fanOf(const Ping& ping, const PingRules& rules)
{
  RayFan fan;
  fan.beam.halfWidth_rad = halfApertureOf(rules.beamWidth_deg * (kPi / 180));
  fan.beam.halfHeight_rad = halfApertureOf(rules.beamHeight_deg * (kPi / 180));
  fan.statedRangeMax_m = ping.rangeMax_m;
  const Eigen::Vector3d direction(std::cos(ping.azimuth_rad), std::sin(ping.azimuth_rad), 0);
  if (ping.echoes.empty()) fan.add(RayEnd::NoReturn, direction);
  for (size_t rank = 0; rank < ping.echoes.size(); ++rank)
    fan.rays.push_back({ping.echoes[rank].range_m * direction, RayEnd::Return,
                        static_cast<uint8_t>(std::min<size_t>(rank, UINT8_MAX))});
  return fan;
}

}  // namespace lamap::tools
