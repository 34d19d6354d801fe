#include <lamap_sim/dot.h>
#include <lamap_sim/shapes.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace lamap::sim
{
namespace
{
using Eigen::AlignedBox3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The part of a ray inside a convex solid.
struct Crossing
{
  double enter = -kInfinity;
  double leave = kInfinity;
  Vector3d normal = Vector3d::Zero();  ///< at the point of entry

  /// Intersects it with the slab |x| ≤ halfWidth; the ray starts at x = `position` and moves at `speed`.
  void cut(double position, double speed, double halfWidth, const Vector3d& axis)
  {
    if (speed == 0)
    {
      if (std::abs(position) > halfWidth) leave = -kInfinity;
      return;
    }
    const double side = speed > 0 ? -halfWidth : halfWidth;
    enterAt((side - position) / speed, speed > 0 ? -axis : axis);
    leave = std::min(leave, (-side - position) / speed);
  }

  /// Intersects it with the quadric a t² + 2 b t + c ≤ 0.
  template <class NormalAt>
  void cutQuadratic(double a, double b, double c, const NormalAt& normalAt)
  {
    if (a == 0)
    {
      if (c > 0) leave = -kInfinity;
      return;
    }
    const double discriminant = b * b - a * c;
    if (discriminant < 0)
    {
      leave = -kInfinity;
      return;
    }
    const double root = std::sqrt(discriminant);
    const double t = (-b - root) / a;
    if (t > enter) enterAt(t, normalAt(t));
    leave = std::min(leave, (-b + root) / a);
  }

  [[nodiscard]] std::optional<SurfaceHit> hit(const Vector3d& direction) const
  {
    if (enter > leave || leave < 0) return std::nullopt;
    if (enter < 0) return SurfaceHit{0, -direction};
    return SurfaceHit{enter, normal};
  }

 private:
  void enterAt(double t, const Vector3d& outward)
  {
    if (!(t > enter)) return;
    enter = t;
    normal = outward;
  }
};

/// A vector in a box's own axes.
Vector3d turnedInto(const Box& box, const Vector3d& v)
{
  return {box.cosine * v.x() + box.sine * v.y(), box.cosine * v.y() - box.sine * v.x(), v.z()};
}

Vector3d cornerOf(const AlignedBox3d& cell, int corner)
{
  return {(corner & 1) != 0 ? cell.max().x() : cell.min().x(),
          (corner & 2) != 0 ? cell.max().y() : cell.min().y(),
          (corner & 4) != 0 ? cell.max().z() : cell.min().z()};
}

/// A convex solid contains a box if it contains its corners.
template <class Solid>
bool containsCorners(const Solid& solid, const AlignedBox3d& cell)
{
  for (int corner = 0; corner < 8; ++corner)
    if (!contains(solid, cornerOf(cell, corner))) return false;
  return true;
}

/// Distance of [low, high] from `position`.
double gap(double low, double high, double position)
{
  return std::max({low - position, position - high, 0.0});
}

bool areApart(const AlignedBox3d& cell, const Box& box)
{
  // Separating axes; those from pairs of edges are vertical or horizontal here, and add no new ones.
  const Vector3d half = (cell.max() - cell.min()) / 2;
  const Vector3d between = (cell.max() + cell.min()) / 2 - box.centre_map;
  const double c = std::abs(box.cosine);
  const double s = std::abs(box.sine);
  const Vector3d& size = box.halfSize_m;
  if (std::abs(between.z()) >= half.z() + size.z()) return true;
  if (std::abs(between.x()) >= half.x() + c * size.x() + s * size.y()) return true;
  if (std::abs(between.y()) >= half.y() + s * size.x() + c * size.y()) return true;
  const Vector3d own = turnedInto(box, between);
  return std::abs(own.x()) >= size.x() + c * half.x() + s * half.y() ||
         std::abs(own.y()) >= size.y() + s * half.x() + c * half.y();
}

bool areApart(const AlignedBox3d& cell, const Cylinder& cylinder)
{
  if (cell.min().z() >= cylinder.zHigh_map || cell.max().z() <= cylinder.zLow_map) return true;
  const double x = gap(cell.min().x(), cell.max().x(), cylinder.axis_map.x());
  const double y = gap(cell.min().y(), cell.max().y(), cylinder.axis_map.y());
  return x * x + y * y >= cylinder.radius_m * cylinder.radius_m;
}

bool areApart(const AlignedBox3d& cell, const Ellipsoid& ellipsoid)
{
  double sum = 0;
  for (int axis = 0; axis < 3; ++axis)
  {
    const double distance =
        gap(cell.min()[axis], cell.max()[axis], ellipsoid.centre_map[axis]) / ellipsoid.radii_m[axis];
    sum += distance * distance;
  }
  return sum >= 1;
}

bool areApart(const AlignedBox3d& cell, const HalfSpace& halfSpace)
{
  double lowest = kInfinity;
  for (int corner = 0; corner < 8; ++corner)
    lowest = std::min(lowest, dot(halfSpace.normal_map, cornerOf(cell, corner)));
  return lowest >= halfSpace.offset_m;
}

bool holds(const Box& box, const Vector3d& point)
{
  const Vector3d own = turnedInto(box, point - box.centre_map);
  return (own.array().abs() <= box.halfSize_m.array()).all();
}

bool holds(const Cylinder& cylinder, const Vector3d& point)
{
  const double x = point.x() - cylinder.axis_map.x();
  const double y = point.y() - cylinder.axis_map.y();
  return point.z() >= cylinder.zLow_map && point.z() <= cylinder.zHigh_map &&
         x * x + y * y <= cylinder.radius_m * cylinder.radius_m;
}

bool holds(const Ellipsoid& ellipsoid, const Vector3d& point)
{
  const Vector3d unit = (point - ellipsoid.centre_map).cwiseQuotient(ellipsoid.radii_m);
  return dot(unit, unit) <= 1;
}

bool holds(const HalfSpace& halfSpace, const Vector3d& point)
{
  return dot(halfSpace.normal_map, point) <= halfSpace.offset_m;
}

Crossing crossingOf(const Box& box, const Vector3d& origin, const Vector3d& direction)
{
  const Vector3d start = turnedInto(box, origin - box.centre_map);
  const Vector3d speed = turnedInto(box, direction);
  Crossing crossing;
  crossing.cut(start.x(), speed.x(), box.halfSize_m.x(), {box.cosine, box.sine, 0});
  crossing.cut(start.y(), speed.y(), box.halfSize_m.y(), {-box.sine, box.cosine, 0});
  crossing.cut(start.z(), speed.z(), box.halfSize_m.z(), Vector3d::UnitZ());
  return crossing;
}

Crossing crossingOf(const Cylinder& cylinder, const Vector3d& origin, const Vector3d& direction)
{
  const double middle = (cylinder.zLow_map + cylinder.zHigh_map) / 2;
  const double x = origin.x() - cylinder.axis_map.x();
  const double y = origin.y() - cylinder.axis_map.y();
  Crossing crossing;
  crossing.cut(origin.z() - middle, direction.z(), (cylinder.zHigh_map - cylinder.zLow_map) / 2,
               Vector3d::UnitZ());
  crossing.cutQuadratic(direction.x() * direction.x() + direction.y() * direction.y(),
                        x * direction.x() + y * direction.y(),
                        x * x + y * y - cylinder.radius_m * cylinder.radius_m,
                        [&](double t)
                        {
                          return Vector3d((x + t * direction.x()) / cylinder.radius_m,
                                          (y + t * direction.y()) / cylinder.radius_m, 0);
                        });
  return crossing;
}

Crossing crossingOf(const Ellipsoid& ellipsoid, const Vector3d& origin, const Vector3d& direction)
{
  const Vector3d start = (origin - ellipsoid.centre_map).cwiseQuotient(ellipsoid.radii_m);
  const Vector3d speed = direction.cwiseQuotient(ellipsoid.radii_m);
  Crossing crossing;
  crossing.cutQuadratic(dot(speed, speed), dot(start, speed), dot(start, start) - 1,
                        [&](double t)
                        {
                          const Vector3d gradient = (start + t * speed).cwiseQuotient(ellipsoid.radii_m);
                          return Vector3d(gradient / std::sqrt(dot(gradient, gradient)));
                        });
  return crossing;
}

Crossing crossingOf(const HalfSpace& halfSpace, const Vector3d& origin, const Vector3d& direction)
{
  const double height = dot(halfSpace.normal_map, origin) - halfSpace.offset_m;
  const double speed = dot(halfSpace.normal_map, direction);
  Crossing crossing;
  crossing.normal = halfSpace.normal_map;
  if (speed < 0)
    crossing.enter = height / -speed;
  else if (speed > 0)
    crossing.leave = -height / speed;
  else if (height > 0)
    crossing.leave = -kInfinity;
  return crossing;
}

AlignedBox3d boundsAround(const Box& box)
{
  const double c = std::abs(box.cosine);
  const double s = std::abs(box.sine);
  const Vector3d& half = box.halfSize_m;
  const Vector3d reach(c * half.x() + s * half.y(), s * half.x() + c * half.y(), half.z());
  return {box.centre_map - reach, box.centre_map + reach};
}

AlignedBox3d boundsAround(const Cylinder& cylinder)
{
  const Vector2d reach = Vector2d::Constant(cylinder.radius_m);
  AlignedBox3d bounds;
  bounds.min() << cylinder.axis_map - reach, cylinder.zLow_map;
  bounds.max() << cylinder.axis_map + reach, cylinder.zHigh_map;
  return bounds;
}

AlignedBox3d boundsAround(const Ellipsoid& ellipsoid)
{
  return {ellipsoid.centre_map - ellipsoid.radii_m, ellipsoid.centre_map + ellipsoid.radii_m};
}

AlignedBox3d boundsAround(const HalfSpace&)
{
  return {Vector3d::Constant(-kInfinity), Vector3d::Constant(kInfinity)};
}
}  // namespace

Box boxBetween(const Vector3d& low_map, const Vector3d& high_map)
{
  Box box;
  box.centre_map = (low_map + high_map) / 2;
  box.halfSize_m = (high_map - low_map) / 2;
  return box;
}

bool contains(const Shape& shape, const Vector3d& point_map)
{
  return std::visit([&](const auto& solid) { return holds(solid, point_map); }, shape);
}

std::optional<SurfaceHit> firstHit(const Shape& shape, const Vector3d& origin_map,
                                   const Vector3d& direction_map)
{
  return std::visit([&](const auto& solid)
                    { return crossingOf(solid, origin_map, direction_map).hit(direction_map); },
                    shape);
}

std::optional<std::pair<double, double>> partInside(const Shape& shape, const Vector3d& origin_map,
                                                    const Vector3d& direction_map)
{
  const Crossing crossing =
      std::visit([&](const auto& solid) { return crossingOf(solid, origin_map, direction_map); }, shape);
  if (crossing.enter > crossing.leave) return std::nullopt;
  return std::pair(crossing.enter, crossing.leave);
}

Relation relationOf(const AlignedBox3d& cell_map, const Shape& shape)
{
  const bool apart = std::visit([&](const auto& solid) { return areApart(cell_map, solid); }, shape);
  if (apart) return Relation::Outside;
  return containsCorners(shape, cell_map) ? Relation::Inside : Relation::Mixed;
}

AlignedBox3d boundsOf(const Shape& shape)
{
  return std::visit([](const auto& solid) { return boundsAround(solid); }, shape);
}

}  // namespace lamap::sim
