#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <utility>
#include <variant>

namespace lamap::sim
{
/// A box, rotated about the vertical by the angle with the given cosine and sine.
struct Box
{
  Eigen::Vector3d centre_map = Eigen::Vector3d::Zero();
  Eigen::Vector3d halfSize_m = Eigen::Vector3d::Ones();  ///< along its own axes, > 0
  double cosine = 1;
  double sine = 0;
};

/// An upright cylinder with flat ends.
struct Cylinder
{
  Eigen::Vector2d axis_map = Eigen::Vector2d::Zero();
  double radius_m = 1;
  double zLow_map = 0;
  double zHigh_map = 1;
};

/// An ellipsoid with its axes along those of the map.
struct Ellipsoid
{
  Eigen::Vector3d centre_map = Eigen::Vector3d::Zero();
  Eigen::Vector3d radii_m = Eigen::Vector3d::Ones();
};

/// All points with normal · p ≤ offset: a floor, a ceiling, an infinite wall.
struct HalfSpace
{
  Eigen::Vector3d normal_map = Eigen::Vector3d::UnitZ();  ///< of length 1, pointing out of the solid
  double offset_m = 0;
};

/// A convex solid, including its surface.
using Shape = std::variant<Box, Cylinder, Ellipsoid, HalfSpace>;

/// Where a ray meets a surface.
struct SurfaceHit
{
  double range_m = 0;
  Eigen::Vector3d normal_map = Eigen::Vector3d::Zero();  ///< of length 1, pointing out of the solid
};

/// How a box of space lies relative to a solid. Touching its surface from outside counts as outside.
enum class Relation
{
  Outside,  ///< no point of its interior is solid
  Mixed,
  Inside  ///< all of it is solid
};

/// The box between two corners.
[[nodiscard]] Box boxBetween(const Eigen::Vector3d& low_map, const Eigen::Vector3d& high_map);

[[nodiscard]] bool contains(const Shape& shape, const Eigen::Vector3d& point_map);

/** Where a ray enters a shape, exact up to rounding; empty if it misses. A ray that starts inside hits at
 * range 0, with the normal against its direction.
 * @param direction_map  of length 1 */
[[nodiscard]] std::optional<SurfaceHit> firstHit(const Shape& shape, const Eigen::Vector3d& origin_map,
                                                 const Eigen::Vector3d& direction_map);

/// The part of a line inside a shape: from where it enters to where it leaves [m], either of which may be
/// infinite; empty if it misses.
/// @param direction_map  of length 1
[[nodiscard]] std::optional<std::pair<double, double>> partInside(const Shape& shape,
                                                                  const Eigen::Vector3d& origin_map,
                                                                  const Eigen::Vector3d& direction_map);

/// Exact up to rounding.
[[nodiscard]] Relation relationOf(const Eigen::AlignedBox3d& cell_map, const Shape& shape);

/// The axis-aligned bounding box of a shape; infinite for a half-space.
[[nodiscard]] Eigen::AlignedBox3d boundsOf(const Shape& shape);

}  // namespace lamap::sim
