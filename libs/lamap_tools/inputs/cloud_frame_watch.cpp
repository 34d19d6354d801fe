#include <lamap_tools/inputs/cloud_frame_watch.h>
#include <mrpt/core/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace lamap::tools
{
namespace
{
using Points = std::vector<Eigen::Vector3d>;
using Pose = Eigen::Transform<double, 3, Eigen::Isometry, Eigen::DontAlign>;

constexpr double kStands_m = 0.1;
constexpr double kStands_rad = 0.1;

struct Motion
{
  double moved_m;
  double turned_rad;

  [[nodiscard]] bool stands() const { return moved_m < kStands_m && turned_rad < kStands_rad; }
};

Motion motionBetween(const Pose& from, const Pose& to)
{
  const Eigen::Matrix3d turn = from.linear().transpose() * to.linear();
  return {(to.translation() - from.translation()).norm(), std::abs(Eigen::AngleAxisd(turn).angle())};
}

/// Bins of equal angles around a sensor.
template <size_t kColumns>
class AngleBins
{
 public:
  static constexpr size_t kCount = kColumns * kColumns / 2;

  static size_t of(const Eigen::Vector3d& ray)
  {
    // Sensors like round angles: the bins begin beside them, so that rounding does not move points to others.
    constexpr double kBeside_rad = 0.1234;
    constexpr double kBin_rad = 2 * M_PI / kColumns;
    const double azimuth = std::atan2(ray.y(), ray.x()) + M_PI + kBeside_rad;
    const double elevation = std::atan2(ray.z(), ray.head<2>().norm()) + M_PI / 2 + kBeside_rad;
    const auto column = static_cast<size_t>(azimuth / kBin_rad) % kColumns;
    const auto row = std::min(static_cast<size_t>(elevation / kBin_rad), kColumns / 2 - 1);
    return kColumns * row + column;
  }
};
using WideBins = AngleBins<24>;     // of 15 degrees
using NarrowBins = AngleBins<120>;  // of 3 degrees

/// Share of a cloud's rays in each direction.
using Directions = std::array<double, WideBins::kCount>;

struct View
{
  Directions directions{};
  double meanRange_m = 0;
};

View viewOf(const Points& rays)
{
  View view;
  for (const Eigen::Vector3d& ray : rays)
  {
    view.directions[WideBins::of(ray)] += 1 / static_cast<double>(rays.size());
    view.meanRange_m += ray.norm() / static_cast<double>(rays.size());
  }
  return view;
}

/// 0: the same; 1: nothing in common.
double difference(const Directions& a, const Directions& b)
{
  double common = 0;
  for (size_t i = 0; i < a.size(); ++i) common += std::min(a[i], b[i]);
  return 1 - common;
}

/// Mean difference of each view to the one that is most like it.
double differenceToTheMostAlike(const std::vector<View>& views)
{
  double sum = 0;
  for (const View& view : views)
  {
    double least = 1;
    for (const View& other : views)
      if (&other != &view) least = std::min(least, difference(view.directions, other.directions));
    sum += least;
  }
  return sum / static_cast<double>(views.size());
}

double meanRangeOf(const std::vector<View>& views)
{
  double sum_m = 0;
  for (const View& view : views) sum_m += view.meanRange_m;
  return sum_m / static_cast<double>(views.size());
}

/// Nearest and farthest ray of a scan in each direction.
class DepthRanges
{
 public:
  explicit DepthRanges(const Points& rays)
      : nearest_m_(NarrowBins::kCount, std::numeric_limits<double>::infinity()),
        farthest_m_(NarrowBins::kCount, -std::numeric_limits<double>::infinity())
  {
    for (const Eigen::Vector3d& ray : rays)
    {
      const size_t bin = NarrowBins::of(ray);
      nearest_m_[bin] = std::min(nearest_m_[bin], ray.norm());
      farthest_m_[bin] = std::max(farthest_m_[bin], ray.norm());
    }
  }

  enum class Finding
  {
    NotSeen,
    SeenThrough,
    Seen
  };
  /// What the scan says of a point, from where its rays leave.
  [[nodiscard]] Finding at(const Eigen::Vector3d& ray) const
  {
    const size_t bin = NarrowBins::of(ray);
    const double range_m = ray.norm();
    const double margin_m = std::max(0.3, 0.05 * range_m);
    if (range_m > farthest_m_[bin] + margin_m) return Finding::NotSeen;
    return range_m < nearest_m_[bin] - margin_m ? Finding::SeenThrough : Finding::Seen;
  }

 private:
  std::vector<double> nearest_m_;
  std::vector<double> farthest_m_;
};

/// How well scans agree on what is where.
struct Agreement
{
  size_t seen = 0;
  size_t seenThrough = 0;

  [[nodiscard]] double share() const
  {
    return static_cast<double>(seen) / static_cast<double>(std::max<size_t>(seen + seenThrough, 1));
  }
  [[nodiscard]] bool isWellFounded() const
  {
    constexpr size_t kFewest = 200;
    return seen + seenThrough >= kFewest;
  }
};

/// Points of one scan, in the map and from the sensor.
struct PlacedScan
{
  Eigen::Vector3d origin_map;
  Points points_map;
  Points rays;  ///< in the axes of the map
};

Agreement agreementOf(const std::vector<PlacedScan>& scans)
{
  constexpr size_t kTriedPoints = 256;
  Agreement agreement;
  for (const PlacedScan& seer : scans)
  {
    const DepthRanges depths(seer.rays);
    for (const PlacedScan& other : scans)
    {
      if (&other == &seer) continue;
      const size_t step = other.points_map.size() / kTriedPoints + 1;
      for (size_t i = 0; i < other.points_map.size(); i += step)
      {
        const auto finding = depths.at(other.points_map[i] - seer.origin_map);
        agreement.seen += finding == DepthRanges::Finding::Seen ? 1 : 0;
        agreement.seenThrough += finding == DepthRanges::Finding::SeenThrough ? 1 : 0;
      }
    }
  }
  return agreement;
}

/// What clouds look like if they are in one of the frames.
struct Look
{
  double difference;  ///< of the directions of their rays
  double range_m;
  Agreement agreement;
};

template <class Samples>
Look lookIn(CloudFrame frame, const Samples& samples)
{
  std::vector<View> views;
  std::vector<PlacedScan> scans;
  for (const auto& sample : samples)
  {
    PlacedScan scan{sample.pose_map * sample.sensorOrigin, {}, {}};
    Points rays;
    for (const Eigen::Vector3d& point : sample.points)
    {
      const Eigen::Vector3d point_map = frame == CloudFrame::Map ? point : sample.pose_map * point;
      const Eigen::Vector3d ray = point_map - scan.origin_map;
      if (ray.isZero(1e-3)) continue;  // no return
      scan.points_map.push_back(point_map);
      scan.rays.push_back(ray);
      rays.push_back(sample.pose_map.linear().transpose() * ray);
    }
    views.push_back(viewOf(rays));
    scans.push_back(std::move(scan));
  }
  return {differenceToTheMostAlike(views), meanRangeOf(views), agreementOf(scans)};
}

/// Whether clouds look as if they were in the other frame.
bool isOther(const Look& taken, const Look& other)
{
  const bool areFounded = taken.agreement.isWellFounded() && other.agreement.isWellFounded();
  const double gain = areFounded ? other.agreement.share() - taken.agreement.share() : 0;
  constexpr double kFarther = 2;
  // Seen from far away, all lies in the same direction.
  if (other.range_m > kFarther * taken.range_m) return false;
  constexpr double kChance = 0.1;  // how far the directions of any two scans may differ
  constexpr double kClearly = 1.5;
  constexpr double kDecidedly = 3;
  const auto isFactorAbove = [&](double factor)
  { return taken.difference >= std::max(kChance, factor * other.difference); };
  // In a corridor, scans agree wherever along it they are put.
  const bool directionsDecide = other.difference < kChance && isFactorAbove(kDecidedly);
  constexpr double kContradicts = -0.1;
  constexpr double kSaysSoAlone = 0.3;
  return directionsDecide || (isFactorAbove(kClearly) && gain > kContradicts) ||
         (gain >= kSaysSoAlone && other.difference <= taken.difference);
}
}  // namespace

void CloudFrameWatch::add(const Eigen::Isometry3d& pose_map, const Eigen::Vector3d& sensorOrigin,
                          const std::vector<Eigen::Vector3d>& points)
{
  constexpr size_t kMostPoints = 4096;
  Sample sample{Pose(pose_map), sensorOrigin, {}};
  const size_t step = points.size() / kMostPoints + 1;
  for (size_t i = 0; i < points.size(); i += step)
    if (points[i].allFinite()) sample.points.push_back(points[i]);
  if (sample.points.empty()) return;
  ++clouds_;
  if (!first_map_) first_map_ = sample.pose_map;
  const Motion motion = motionBetween(*first_map_, sample.pose_map);
  moved_m_ = std::max(moved_m_, motion.moved_m);
  turned_rad_ = std::max(turned_rad_, motion.turned_rad);
  if (samples_.empty() || !motionBetween(samples_.back().pose_map, sample.pose_map).stands()) keep(sample);
}

void CloudFrameWatch::keep(const Sample& sample)
{
  constexpr size_t kMostSamples = 24;
  if (offered_++ % stride_ != 0) return;
  samples_.push_back(sample);
  if (samples_.size() <= kMostSamples) return;
  size_t kept = 0;
  for (size_t i = 0; i < samples_.size(); i += 2) samples_[kept++] = samples_[i];
  samples_.resize(kept);
  stride_ *= 2;
}

std::optional<std::string> CloudFrameWatch::suspicion() const
{
  if (samples_.size() < 2) return std::nullopt;
  const CloudFrame other = taken_ == CloudFrame::Map ? CloudFrame::Sensor : CloudFrame::Map;
  if (!isOther(lookIn(taken_, samples_), lookIn(other, samples_))) return std::nullopt;
  const std::string motion =
      mrpt::format("the poses move by %.1f m and turn by %.0f degrees", moved_m_, turned_rad_ * 180 / M_PI);
  if (taken_ == CloudFrame::Map)
    return mrpt::format(
        "all %zu clouds lie about their own origin while %s, but their points were taken to "
        "be in the map's frame: if they are in the sensor's frame, give --cloud-frame sensor",
        clouds_, motion.c_str());
  return mrpt::format(
      "the %zu clouds fit together as they are while %s, but their points were taken to be "
      "in the sensor's frame: if they are in the map's frame, leave out --cloud-frame sensor",
      clouds_, motion.c_str());
}

}  // namespace lamap::tools
