#pragma once

#include <lamap_sim/random.h>
#include <lamap_sim/world.h>

#include <optional>
#include <string>
#include <vector>

namespace lamap::sim
{
/** Builds a world. All coordinates are the world's own: its interior extends from zero to `size`. In the map
 * it is shifted by a few centimetres, drawn from the seed, so that its surfaces are not on the faces of
 * cells.
 */
class WorldBuilder
{
 public:
  WorldBuilder(uint64_t seed, const Eigen::Vector3d& size_m);

  [[nodiscard]] Random& random() { return random_; }

  /// Solid below z = 0.
  void addFloor();
  /// Walls around the interior, one metre thick and as high as the interior.
  void addWallsAround();
  /// Solid everywhere outside the interior.
  void encloseAll();
  /// Solid below the plane through a point.
  void addSlope(const Eigen::Vector3d& normal, const Eigen::Vector3d& through);
  void addBlock(const Eigen::Vector3d& low, const Eigen::Vector3d& high);
  /// @param yaw_rad  counter-clockwise
  void addTurnedBlock(const Eigen::Vector2d& centre, const Eigen::Vector2d& halfSize, double zLow,
                      double zHigh, double yaw_rad);
  void addCylinder(const Eigen::Vector2d& axis, double radius, double zLow, double zHigh);
  void addEllipsoid(const Eigen::Vector3d& centre, const Eigen::Vector3d& radii);

  void setPath(std::vector<Eigen::Vector2d> corners) { path_ = std::move(corners); }
  /// Whether a disc is at least a distance away from the path.
  [[nodiscard]] bool isClear(const Eigen::Vector2d& centre, double radius, double distance) const;
  /// A random clear place for a disc's centre; empty if several attempts find none.
  [[nodiscard]] std::optional<Eigen::Vector2d> freePlace(const Eigen::Vector2d& low,
                                                         const Eigen::Vector2d& high, double radius,
                                                         double distance);

  /// The world built so far, shifted into the map.
  [[nodiscard]] World take(const std::string& name);

 private:
  Random random_;
  Eigen::Vector3d size_;
  Eigen::Vector3d offset_;
  std::vector<Shape> shapes_;  ///< in the map's coordinates
  std::vector<Eigen::Vector2d> path_;
};

}  // namespace lamap::sim
