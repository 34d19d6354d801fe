#include <lamap_core/options/legal_range.h>
#include <lamap_sim/dot.h>
#include <lamap_sim/scanner.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

namespace lamap::sim
{
namespace
{
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// One random stream for each kind of noise, besides that of the world.
enum Stream : uint64_t
{
  kRangeStream = 2,
  kAngleStream,
  kPointStream,
  kMissingStream,
  kPoseStream
};

Random streamOf(uint64_t seed, Stream stream, uint64_t number)
{
  return Random(seed, uint64_t{stream} | (number + 1) << 8U);
}

/// Two directions perpendicular to a beam: horizontal, and upwards.
std::pair<Vector3d, Vector3d> across(const Vector3d& beam)
{
  const double level = std::sqrt(beam.x() * beam.x() + beam.y() * beam.y());
  if (level < 1e-9) return {Vector3d::UnitX(), Vector3d::UnitY()};
  const Vector3d left(-beam.y() / level, beam.x() / level, 0);
  const Vector3d up(-beam.z() * left.y(), beam.z() * left.x(), level);
  return {left, up};
}

void requireAtLeastZero(const char* name, double value)
{
  lamap::requireLegal(value >= 0 && std::isfinite(value), name, value, "finite and 0 or more");
}

/// A distance from which part of a ping returns.
struct Reflection
{
  double range_m = 0;
  double strength = 0;
};

/// Mean length of a burst, in beams.
double meanBurst(int longest)
{
  return (longest + 1) / 2.0;
}

/// Which beams of a scan lose their return, one after the other.
class Dropouts
{
 public:
  Dropouts(const NoiseOptions& noise, const Random& random) : noise_(noise), random_(random) {}

  [[nodiscard]] bool next()
  {
    if (noise_.missing == 0) return false;
    if (noise_.longestBurst == 1) return random_.chance(noise_.missing);
    if (left_ > 0)
    {
      --left_;
      return true;
    }
    if (justEnded_)
    {
      justEnded_ = false;
      return false;
    }
    // Between bursts are 1 / start beams on average, so that `missing` is the share of the bursts.
    const double start = noise_.missing / (meanBurst(noise_.longestBurst) * (1 - noise_.missing));
    if (!random_.chance(start)) return false;
    left_ = random_.integer(1, noise_.longestBurst) - 1;
    justEnded_ = true;
    return true;
  }

 private:
  const NoiseOptions& noise_;
  Random random_;
  int left_ = 0;            ///< beams of a burst to come
  bool justEnded_ = false;  ///< the next beam that is not in the burst is the first after it
};

std::vector<Echo> echoesOf(std::vector<Reflection> reflections, size_t beams, int ranks)
{
  std::sort(reflections.begin(), reflections.end(),
            [](const Reflection& a, const Reflection& b) { return a.range_m < b.range_m; });
  constexpr double kApart_m = 0.3;
  std::vector<Echo> echoes;
  for (size_t begin = 0; begin < reflections.size() && static_cast<int>(echoes.size()) < ranks;)
  {
    size_t end = begin;
    double strength = 0;
    do strength += reflections[end++].strength;
    while (end < reflections.size() && reflections[end].range_m - reflections[end - 1].range_m < kApart_m);
    const double share = strength / static_cast<double>(beams);
    echoes.push_back({reflections[begin].range_m, std::clamp(static_cast<int>(255 * share), 1, 255), false});
    begin = end;
  }
  return echoes;
}
}  // namespace

void NoiseOptions::requireLegal() const
{
  requireAtLeastZero("range noise [m]", range_m);
  requireAtLeastZero("angle noise [rad]", angle_rad);
  requireAtLeastZero("point noise [m]", point_m);
  requireAtLeastZero("position noise [m]", position_m);
  requireAtLeastZero("turn noise [rad]", turn_rad);
  lamap::requireLegal(missing >= 0 && missing <= 1, "missing", missing, "between 0 and 1");
  constexpr int kLongest = 1000000;
  lamap::requireLegal(longestBurst >= 1 && longestBurst <= kLongest, "longest burst", longestBurst,
                      "between 1 and 1000000 beams");
  const double most = longestBurst == 1 ? 1 : meanBurst(longestBurst) / (meanBurst(longestBurst) + 1);
  if (missing > most)
    throw std::invalid_argument("missing = " + shortText(missing) + ": with bursts of up to " +
                                std::to_string(longestBurst) + " beams, at most " + shortText(most) +
                                " can be lost");
}

Scanner::Scanner(const World& world, const SensorModel& sensor, const NoiseOptions& noise, uint64_t seed)
    : world_(world), sensor_(sensor), noise_(noise), seed_(seed)
{
  noise_.requireLegal();
  requireLegal(sensor.rangeMax_m > 0 && std::isfinite(sensor.rangeMax_m), "maximum range [m]",
               sensor.rangeMax_m, "finite and above 0");
  if (noise_.longestBurst > 1 && sensor_.kind == SensorKind::Sonar)
    throw std::invalid_argument("longest burst: a " + sensor_.name + " has one beam; echoes get lost singly");
  if (noise_.point_m > 0 && sensor_.kind != SensorKind::Cloud)
    throw std::invalid_argument("point noise: a " + sensor_.name +
                                " reads ranges, not points; give it range noise");
}

void Scanner::requireOpen(const Vector3d& position_map) const
{
  const bool beyond = !world_.flat && !world_.interior_map.contains(position_map);
  if (!beyond && !world_.scene.solidAt(position_map)) return;
  const Vector3d& low = world_.interior_map.min();
  const Vector3d& high = world_.interior_map.max();
  std::ostringstream why;
  why << "a sensor cannot stand at (" << position_map.x() << ", " << position_map.y() << ", "
      << position_map.z() << "): that is "
      << (beyond ? "outside the world " : "inside a wall or another solid of the world ") << world_.name
      << ", which extends over x " << low.x() << " .. " << high.x() << ", y " << low.y() << " .. " << high.y()
      << ", z " << low.z() << " .. " << high.z();
  throw std::invalid_argument(why.str());
}

Vector3d Scanner::trueDirection(const Vector3d& beam, const Matrix3d& rotation, Random& random) const
{
  if (noise_.angle_rad == 0) return turned(rotation, beam);
  const auto [left, up] = across(beam);
  Vector3d direction = beam + (noise_.angle_rad * random.normal()) * left;
  const double upwards = noise_.angle_rad * random.normal();
  if (sensor_.kind != SensorKind::Planar) direction += upwards * up;
  return turned(rotation, direction / std::sqrt(dot(direction, direction)));
}

std::vector<BeamReading> Scanner::scan(const Pose& pose, uint64_t number) const
{
  Random rangeRandom = streamOf(seed_, kRangeStream, number);
  Random angleRandom = streamOf(seed_, kAngleStream, number);
  Random pointRandom = streamOf(seed_, kPointStream, number);
  Dropouts dropouts(noise_, streamOf(seed_, kMissingStream, number));
  const Matrix3d rotation = rotationOf(pose);
  constexpr double kNearest_m = 0.01;
  std::vector<BeamReading> readings;
  readings.reserve(sensor_.beams.size());
  for (const Vector3d& beam : sensor_.beams)
  {
    const auto hit = world_.scene.firstHit(pose.position_map, trueDirection(beam, rotation, angleRandom),
                                           sensor_.rangeMax_m);
    // Drawn for every beam, so that a beam's number does not depend on the others.
    const double rangeError = noise_.range_m > 0 ? noise_.range_m * rangeRandom.normal() : 0;
    Vector3d pointError = Vector3d::Zero();
    if (noise_.point_m > 0) pointError = noise_.point_m * pointRandom.normal3();
    const bool lost = dropouts.next();

    BeamReading reading;
    const double range = hit ? std::max(kNearest_m, hit->range_m + rangeError) : 0;
    const bool returned = hit && range < sensor_.rangeMax_m;
    if (returned && lost) reading.lost_m = range;
    if (returned && !lost)
    {
      reading.range_m = range;
      reading.point_sensor = range * beam + pointError;
    }
    else
      reading.point_sensor = 1.5 * sensor_.rangeMax_m * beam;
    readings.push_back(reading);
  }
  return readings;
}

std::vector<Echo> Scanner::ping(const Pose& pose, const HeadTurn& head, uint64_t number) const
{
  Random angleRandom = streamOf(seed_, kAngleStream, number);
  Pose turnedHead;
  turnedHead.yaw_rad = head.yaw_rad;
  turnedHead.pitch_rad = head.pitch_rad;
  const Matrix3d mapFromMount = rotationOf(pose);
  const Matrix3d mountFromHead = rotationOf(turnedHead);
  // The error applies to the whole beam, not to its individual rays.
  Vector3d astray = Vector3d::Zero();
  if (noise_.angle_rad > 0) astray = noise_.angle_rad * angleRandom.normal3();
  std::vector<Reflection> reflections;
  for (const Vector3d& ray : sensor_.beams)
  {
    Vector3d direction = ray + Vector3d(0, astray.y(), astray.z());
    direction /= std::sqrt(dot(direction, direction));
    direction = turned(mapFromMount, turned(mountFromHead, direction));
    const auto hit = world_.scene.firstHit(pose.position_map, direction, sensor_.rangeMax_m);
    if (hit) reflections.push_back({hit->range_m, std::abs(dot(hit->normal_map, direction))});
  }

  Random rangeRandom = streamOf(seed_, kRangeStream, number);
  Random missingRandom = streamOf(seed_, kMissingStream, number);
  constexpr double kNearest_m = 0.01;
  std::vector<Echo> heard;
  for (Echo echo : echoesOf(std::move(reflections), sensor_.beams.size(), sensor_.echoRanks))
  {
    if (noise_.range_m > 0)
      echo.range_m = std::max(kNearest_m, echo.range_m + noise_.range_m * rangeRandom.normal());
    echo.lost = noise_.missing > 0 && missingRandom.chance(noise_.missing);
    if (echo.range_m < sensor_.rangeMax_m) heard.push_back(echo);
  }
  std::sort(heard.begin(), heard.end(), [](const Echo& a, const Echo& b) { return a.range_m < b.range_m; });
  return heard;
}

Pose Scanner::reportedPose(const Pose& pose, uint64_t number) const
{
  Random random = streamOf(seed_, kPoseStream, number);
  const Vector3d moved = random.normal3();
  const Vector3d turns = random.normal3();
  const bool planar = sensor_.kind == SensorKind::Planar;
  Pose reported = pose;
  reported.position_map += noise_.position_m * Vector3d(moved.x(), moved.y(), planar ? 0 : moved.z());
  reported.yaw_rad += noise_.turn_rad * turns.z();
  if (!planar)
  {
    reported.pitch_rad += noise_.turn_rad * turns.y();
    reported.roll_rad += noise_.turn_rad * turns.x();
  }
  return reported;
}

}  // namespace lamap::sim
