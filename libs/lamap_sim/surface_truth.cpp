#include <lamap_sim/dot.h>
#include <lamap_sim/label_grid.h>
#include <lamap_sim/surface_truth.h>

#include <algorithm>
#include <cmath>
#include <tuple>

namespace lamap::sim
{
namespace
{
using Eigen::AlignedBox3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Index3 = LabelGrid::Index3;

/// Ends of rays are this inexact at most.
constexpr double kRounding_m = 1e-9;
/// Points along each edge of a cell.
constexpr int kPointsAlongEdge = 3;

/// A sensor's place and orientation in one shot.
struct View
{
  Vector3d position_map;
  Matrix3d mapFromSensor;
};

std::vector<View> viewsOf(const SensorModel& sensor, const std::vector<Pose>& shots)
{
  std::vector<View> views;
  for (size_t i = 0; i < shots.size(); ++i)
  {
    View view{shots[i].position_map, rotationOf(shots[i])};
    if (sensor.kind == SensorKind::Sonar)
    {
      const HeadTurn head = headTurn(sensor, static_cast<int>(i));
      Pose turn;
      turn.yaw_rad = head.yaw_rad;
      turn.pitch_rad = head.pitch_rad;
      const Matrix3d mountFromHead = rotationOf(turn);
      for (int column = 0; column < 3; ++column)
        view.mapFromSensor.col(column) = turned(rotationOf(shots[i]), mountFromHead.col(column));
    }
    const auto isSame = [&](const View& other)
    { return other.position_map == view.position_map && other.mapFromSensor == view.mapFromSensor; };
    if (std::none_of(views.begin(), views.end(), isSame)) views.push_back(view);
  }
  return views;
}

/// The lines of sight of a sensor from all its shots. Used by one thread at a time.
class Sight
{
 public:
  Sight(const World& world, const SensorModel& sensor, const std::vector<Pose>& shots)
      : scene_(world.scene), sensor_(sensor), field_(sensor), views_(viewsOf(sensor, shots))
  {
  }

  /// Calls visit(end, normal) for the end of each of the sensor's own beams.
  template <class Visit>
  bool forEachBeamEnd(const Visit& visit, const std::function<bool()>& shouldStop) const
  {
    for (const View& view : views_)
    {
      if (shouldStop && shouldStop()) return false;
      for (const Vector3d& beam : sensor_.beams)
      {
        const Vector3d direction = turned(view.mapFromSensor, beam);
        if (const auto hit = scene_.firstHit(view.position_map, direction, sensor_.rangeMax_m))
          visit(Vector3d(view.position_map + hit->range_m * direction), hit->normal_map);
      }
    }
    return true;
  }

  /// Whether the centre of an open cell can be seen.
  [[nodiscard]] bool reachesCentreOf(const AlignedBox3d& cell)
  {
    return anyView(
        [&](const View& view)
        {
          const auto point = inReachOf(view, cell, (cell.min() + cell.max()) / 2);
          if (!point) return false;
          const auto [direction, distance] = *point;
          return distance <= sensor_.rangeMax_m && !scene_.firstHit(view.position_map, direction, distance);
        });
  }

  /// Whether a line of sight to a point of a cell ends in the cell.
  [[nodiscard]] bool endsIn(const AlignedBox3d& cell)
  {
    const double diagonal_m = std::sqrt(dot(cell.sizes(), cell.sizes()));
    const AlignedBox3d enlarged(cell.min() - Vector3d::Constant(kRounding_m),
                                cell.max() + Vector3d::Constant(kRounding_m));
    const auto endsThere = [&](const View& view, const Vector3d& target)
    {
      const auto point = inReachOf(view, cell, target);
      if (!point) return false;
      const auto [direction, distance] = *point;
      const auto hit =
          scene_.firstHit(view.position_map, direction, std::min(sensor_.rangeMax_m, distance + diagonal_m));
      return hit && enlarged.contains(view.position_map + hit->range_m * direction);
    };
    return anyView(
        [&](const View& view)
        {
          for (int x = 0; x < kPointsAlongEdge; ++x)
            for (int y = 0; y < kPointsAlongEdge; ++y)
              for (int z = 0; z < kPointsAlongEdge; ++z)
              {
                const Vector3d share = (Vector3d(x, y, z).array() + 0.5).matrix() / kPointsAlongEdge;
                if (endsThere(view, cell.min() + share.cwiseProduct(cell.sizes()))) return true;
              }
          return false;
        });
  }

 private:
  struct Ray
  {
    Vector3d direction_map;
    double distance_m = 0;
  };

  /// The ray to a point of a cell, if the sensor looks there; not cut to its range.
  [[nodiscard]] std::optional<Ray> inReachOf(const View& view, const AlignedBox3d& cell, Vector3d point) const
  {
    if (sensor_.kind == SensorKind::Planar)
    {
      const double z = view.position_map.z();
      if (z < cell.min().z() || z >= cell.max().z()) return std::nullopt;
      point.z() = z;
    }
    const Vector3d way = point - view.position_map;
    const double distance_m = std::sqrt(dot(way, way));
    const double halfCell_m = cell.sizes().sum() / 2;
    if (distance_m == 0 || distance_m > sensor_.rangeMax_m + halfCell_m) return std::nullopt;
    const Vector3d direction = way / distance_m;
    if (!field_.contains(turned(view.mapFromSensor.transpose(), direction))) return std::nullopt;
    return Ray{direction, distance_m};
  }

  /// Asks the view that saw the last cell first, because it often sees the next one too.
  template <class Sees>
  bool anyView(const Sees& sees)
  {
    for (size_t i = 0; i < views_.size(); ++i)
    {
      const size_t view = (last_ + i) % views_.size();
      if (!sees(views_[view])) continue;
      last_ = view;
      return true;
    }
    return false;
  }

  const Scene& scene_;
  const SensorModel& sensor_;
  FieldOfView field_;
  std::vector<View> views_;
  size_t last_ = 0;
};
}  // namespace

std::vector<TrueCell> surfaceTruthOf(const World& world, const SensorModel& sensor,
                                     const std::vector<Pose>& shots, double resolution_m,
                                     const std::function<bool()>& shouldStop)
{
  constexpr int kMargin = 1;
  LabelGrid grid(world, resolution_m, kMargin);
  if (!grid.labelAll(shouldStop)) return {};
  Sight sight(world, sensor, shots);
  std::vector<uint8_t> seen(grid.count(), 0);
  const auto markEnd = [&](const Vector3d& end_map, const Vector3d& normal_map)
  {
    const auto index = cellAt(end_map - kRounding_m * normal_map, resolution_m);
    const auto cell = index ? grid.cellOf(*index) : std::nullopt;
    if (cell && grid.holdsSurface(*cell)) seen[grid.at(*cell)] = 1;
  };
  if (!sight.forEachBeamEnd(markEnd, shouldStop)) return {};

  std::vector<TrueCell> cells;
  int32_t row = -1;
  const bool finished = grid.forEachCell(
      [&](const Index3& cell)
      {
        if (cell[1] != row && shouldStop && shouldStop()) return false;
        row = cell[1];
        const bool surface = grid.holdsSurface(cell);
        if (!surface && grid.labelOf(cell) != CellLabel::Open) return true;
        const AlignedBox3d box = grid.boxOf(cell);
        if (seen[grid.at(cell)] == 1 || (surface ? sight.endsIn(box) : sight.reachesCentreOf(box)))
          cells.push_back({grid.indexOf(cell), surface});
        return true;
      });
  return finished ? cells : std::vector<TrueCell>();
}

std::vector<Vector3d> surfacePointsOf(const World& world, double resolution_m,
                                      const std::function<bool()>& shouldStop)
{
  constexpr int kMargin = 1;
  const LabelGrid grid(world, resolution_m, kMargin);
  const AlignedBox3d box = grid.box();
  const double spacing_m = resolution_m / kPointsAlongEdge;
  std::vector<Vector3d> points;
  const auto countAlong = [&](int axis) { return std::lround(box.sizes()[axis] / spacing_m); };
  for (int axis = 0; axis < (world.flat ? 2 : 3); ++axis)
  {
    const int across = (axis + 1) % 3;
    const int other = (axis + 2) % 3;
    for (long i = 0; i < countAlong(across); ++i)
    {
      if (shouldStop && shouldStop()) return {};
      for (long j = 0; j < countAlong(other); ++j)
      {
        Vector3d origin = box.min();
        origin[across] += (static_cast<double>(i) + 0.5) * spacing_m;
        origin[other] += (static_cast<double>(j) + 0.5) * spacing_m;
        if (world.flat)
        {
          if ((across == 2 ? i : j) > 0) continue;
          origin.z() = 0;
        }
        for (const double range : world.scene.crossings(origin, Vector3d::Unit(axis), box.sizes()[axis]))
          points.emplace_back(origin + range * Vector3d::Unit(axis));
      }
    }
  }
  std::sort(points.begin(), points.end(),
            [](const Vector3d& a, const Vector3d& b)
            { return std::tuple(a.z(), a.y(), a.x()) < std::tuple(b.z(), b.y(), b.x()); });
  return points;
}

}  // namespace lamap::sim
