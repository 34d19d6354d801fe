#pragma once

#include <lamap_core/scan/scan.h>

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace lamap
{
/** The cone of a beam, as rays that are spread evenly over it.
 *
 * The cone is elliptic: halfWidth about the axis `up` of the beam, halfHeight across that. Rays stand for
 * equal solid angles: they lie on a lattice in Lambert's azimuthal equal-area projection, in which a
 * direction at the angle θ from the axis is 2 sin(θ/2) from the centre. In a planar map only the section of
 * the cone with the plane through its axis and the horizontal counts.
 *
 * An angle that is not above 0° and below 180° (edge to edge) is no width. The same on every processor.
 * Immutable: may be shared between threads. */
class BeamCone
{
 public:
  /// No width: each beam is a single ray.
  BeamCone() = default;
  /// @param vertical of a planar map, in the frame of the beam; nothing: the map has three dimensions
  BeamCone(const Beam& beam, const std::optional<Eigen::Vector3d>& vertical);

  [[nodiscard]] bool any() const { return across_ > 0 || upwards_ > 0; }
  /// @param ray of the beam, along its axis; @param spacing in the unit of the ray
  /// @return whether the cone is wider than the spacing at the end of the ray
  [[nodiscard]] bool isWide(const Eigen::Vector3d& ray, double spacing) const;

  /** Rays of the same length, the axis among them.
   * @param spacing between their ends, in the unit of the ray, > 0; larger where there would be more than
   * some thousand rays
   * @param rays takes them; if the cone is not wide, only the axis */
  void spread(const Eigen::Vector3d& ray, double spacing, std::vector<Eigen::Vector3d>& rays) const;

  /// The same with their directions about a degree apart.
  void spreadByAngle(const Eigen::Vector3d& ray, std::vector<Eigen::Vector3d>& rays) const;

  /// @return how many squares (planar: stretches) of the spacing the end of the cone covers
  [[nodiscard]] double footprint(const Eigen::Vector3d& ray, double spacing) const;

 private:
  /// Directions across a ray, and the radii of the cone along them, as in the projection.
  struct Section
  {
    Eigen::Vector3d across = Eigen::Vector3d::Zero();
    Eigen::Vector3d upwards = Eigen::Vector3d::Zero();
    double acrossRadius = 0;
    double upwardsRadius = 0;
  };
  [[nodiscard]] Section sectionOf(const Eigen::Vector3d& direction) const;

  double across_ = 0;  ///< radii of the cone in the projection
  double upwards_ = 0;
  Eigen::Vector3d up_ = Eigen::Vector3d::UnitZ();
  std::optional<Eigen::Vector3d> vertical_;
};

/// Half of an opening angle as a sensor states it [rad]: 0 where it is none, because it is not above 0° and
/// below 180°.
[[nodiscard]] double halfApertureOf(double aperture_rad);

}  // namespace lamap
