#include <lamap_sim/world_builder.h>

#include <algorithm>
#include <cmath>

namespace lamap::sim
{
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace
{
constexpr uint64_t kWorldStream = 1;

double distanceToSegment(const Vector2d& point, const Vector2d& a, const Vector2d& b)
{
  const Vector2d along = b - a;
  const Vector2d from = point - a;
  const double squared = along.x() * along.x() + along.y() * along.y();
  const double share =
      squared > 0 ? std::clamp((from.x() * along.x() + from.y() * along.y()) / squared, 0.0, 1.0) : 0;
  const double x = from.x() - share * along.x();
  const double y = from.y() - share * along.y();
  return std::sqrt(x * x + y * y);
}

Vector3d drawOffset(Random& random)
{
  const double x = random.uniform(0.02, 0.08);
  const double y = random.uniform(0.02, 0.08);
  return {x, y, random.uniform(0.02, 0.08)};
}
}  // namespace

WorldBuilder::WorldBuilder(uint64_t seed, const Vector3d& size_m)
    : random_(seed, kWorldStream), size_(size_m), offset_(drawOffset(random_))
{
}

void WorldBuilder::addFloor()
{
  shapes_.emplace_back(HalfSpace{Vector3d::UnitZ(), offset_.z()});
}

void WorldBuilder::addWallsAround()
{
  constexpr double kThickness_m = 1;
  const Vector3d& end = size_;
  addBlock({-kThickness_m, -kThickness_m, -1}, {0, end.y() + kThickness_m, end.z()});
  addBlock({end.x(), -kThickness_m, -1}, {end.x() + kThickness_m, end.y() + kThickness_m, end.z()});
  addBlock({-kThickness_m, -kThickness_m, -1}, {end.x() + kThickness_m, 0, end.z()});
  addBlock({-kThickness_m, end.y(), -1}, {end.x() + kThickness_m, end.y() + kThickness_m, end.z()});
}

void WorldBuilder::encloseAll()
{
  for (int axis = 0; axis < 3; ++axis)
  {
    const Vector3d normal = Vector3d::Unit(axis);
    shapes_.emplace_back(HalfSpace{normal, offset_[axis]});
    shapes_.emplace_back(HalfSpace{-normal, -(offset_[axis] + size_[axis])});
  }
}

void WorldBuilder::addSlope(const Vector3d& normal, const Vector3d& through)
{
  const double length =
      std::sqrt(normal.x() * normal.x() + normal.y() * normal.y() + normal.z() * normal.z());
  const Vector3d unit = normal / length;
  const Vector3d point = through + offset_;
  shapes_.emplace_back(HalfSpace{unit, unit.x() * point.x() + unit.y() * point.y() + unit.z() * point.z()});
}

void WorldBuilder::addBlock(const Vector3d& low, const Vector3d& high)
{
  shapes_.emplace_back(boxBetween(low + offset_, high + offset_));
}

void WorldBuilder::addTurnedBlock(const Vector2d& centre, const Vector2d& halfSize, double zLow, double zHigh,
                                  double yaw_rad)
{
  Box box = boxBetween(offset_ + Vector3d(centre.x() - halfSize.x(), centre.y() - halfSize.y(), zLow),
                       offset_ + Vector3d(centre.x() + halfSize.x(), centre.y() + halfSize.y(), zHigh));
  const SineCosine turn = sineCosine(yaw_rad);
  box.cosine = turn.cosine;
  box.sine = turn.sine;
  shapes_.emplace_back(box);
}

void WorldBuilder::addCylinder(const Vector2d& axis, double radius, double zLow, double zHigh)
{
  shapes_.emplace_back(Cylinder{axis + offset_.head<2>(), radius, zLow + offset_.z(), zHigh + offset_.z()});
}

void WorldBuilder::addEllipsoid(const Vector3d& centre, const Vector3d& radii)
{
  shapes_.emplace_back(Ellipsoid{centre + offset_, radii});
}

bool WorldBuilder::isClear(const Vector2d& centre, double radius, double distance) const
{
  for (size_t i = 0; i < path_.size(); ++i)
    if (distanceToSegment(centre, path_[i], path_[std::min(i + 1, path_.size() - 1)]) < radius + distance)
      return false;
  return true;
}

std::optional<Vector2d> WorldBuilder::freePlace(const Vector2d& low, const Vector2d& high, double radius,
                                                double distance)
{
  constexpr int kAttempts = 40;
  for (int i = 0; i < kAttempts; ++i)
  {
    const double x = random_.uniform(low.x(), high.x());
    const Vector2d place(x, random_.uniform(low.y(), high.y()));
    if (isClear(place, radius, distance)) return place;
  }
  return std::nullopt;
}

World WorldBuilder::take(const std::string& name)
{
  World world;
  world.name = name;
  world.scene = Scene(std::move(shapes_));
  world.interior_map = Eigen::AlignedBox3d(offset_, offset_ + size_);
  for (const Vector2d& corner : path_) world.path_map.emplace_back(corner + offset_.head<2>());
  return world;
}

}  // namespace lamap::sim
