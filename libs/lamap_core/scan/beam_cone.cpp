#include <lamap_core/scan/beam_cone.h>

#include <algorithm>
#include <cmath>

namespace lamap
{
namespace
{
constexpr double kHalfTurn_rad = 3.141592653589793;
constexpr double kMostRays = 4096;

/// 2 sin(angle/2) for angles from 0 to π/2, by its series.
double chordOf(double angle_rad)
{
  const double half = 0.5 * angle_rad;
  double sum = 0;
  for (int n = 17; n >= 3; n -= 2) sum = (1 + sum) * -(half * half) / (n * (n - 1));
  return angle_rad * (1 + sum);
}

double radiusOf(double halfAngle_rad)
{
  return chordOf(halfApertureOf(2 * halfAngle_rad));
}

/// Any direction across one of length 1.
Eigen::Vector3d anyAcross(const Eigen::Vector3d& direction)
{
  Eigen::Index least = 0;
  direction.cwiseAbs().minCoeff(&least);
  return Eigen::Vector3d::Unit(least).cross(direction).normalized();
}

/// Across a direction and an axis; any across the direction where they are parallel.
Eigen::Vector3d acrossBoth(const Eigen::Vector3d& axis, const Eigen::Vector3d& direction)
{
  constexpr double kParallel = 1e-9;
  const Eigen::Vector3d across = axis.cross(direction);
  const double length = across.norm();
  return length > kParallel ? Eigen::Vector3d(across / length) : anyAcross(direction);
}

/// Lattice points on each side of the middle, so that each stands for a strip no wider than the spacing.
int stepsFor(double radius, double spacing)
{
  return std::max(0, static_cast<int>(std::ceil(radius / spacing - 0.5)));
}
}  // namespace

double halfApertureOf(double aperture_rad)
{
  return aperture_rad > 0 && aperture_rad < kHalfTurn_rad ? 0.5 * aperture_rad : 0.0;
}

BeamCone::BeamCone(const Beam& beam, const std::optional<Eigen::Vector3d>& vertical)
    : across_(radiusOf(beam.halfWidth_rad)),
      upwards_(radiusOf(beam.halfHeight_rad)),
      up_(beam.up),
      vertical_(vertical)
{
}

BeamCone::Section BeamCone::sectionOf(const Eigen::Vector3d& direction) const
{
  Section section;
  section.across = acrossBoth(up_, direction);
  section.upwards = direction.cross(section.across);
  section.acrossRadius = across_;
  section.upwardsRadius = upwards_;
  if (!vertical_) return section;
  const Eigen::Vector3d level = acrossBoth(*vertical_, direction);
  constexpr double kNone = 1e-9;
  const double cosine = std::abs(level.dot(section.across));
  const double sine = std::abs(level.dot(section.upwards));
  // How much of the level direction is along each radius of the ellipse.
  const double x = cosine > kNone ? cosine / across_ : 0.0;
  const double y = sine > kNone ? sine / upwards_ : 0.0;
  section.across = level;
  section.acrossRadius = 1 / std::sqrt(x * x + y * y);  // 0 where a radius is
  section.upwardsRadius = 0;
  return section;
}

bool BeamCone::isWide(const Eigen::Vector3d& ray, double spacing) const
{
  const double length = ray.norm();
  if (!any() || !(length > 0)) return false;
  const Section section = sectionOf(ray / length);
  return 2 * std::max(section.acrossRadius, section.upwardsRadius) * length > spacing;
}

double BeamCone::footprint(const Eigen::Vector3d& ray, double spacing) const
{
  const double length = ray.norm();
  const Section section = sectionOf(ray / length);
  const double across = 2 * section.acrossRadius * length / spacing;
  const double upwards = 2 * section.upwardsRadius * length / spacing;
  if (across == 0 || upwards == 0) return std::max(across, upwards);
  return kHalfTurn_rad / 4 * across * upwards;
}

void BeamCone::spreadByAngle(const Eigen::Vector3d& ray, std::vector<Eigen::Vector3d>& rays) const
{
  constexpr double kDegree = kHalfTurn_rad / 180;
  spread(ray, kDegree * ray.norm(), rays);
}

void BeamCone::spread(const Eigen::Vector3d& ray, double spacing, std::vector<Eigen::Vector3d>& rays) const
{
  rays.clear();
  if (!isWide(ray, spacing))
  {
    rays.push_back(ray);
    return;
  }
  const double length = ray.norm();
  const Eigen::Vector3d axis = ray / length;
  const Section section = sectionOf(axis);
  const double crowding = std::max(1.0, footprint(ray, spacing) / kMostRays);
  const bool isLine = section.acrossRadius == 0 || section.upwardsRadius == 0;
  const double step = spacing / length * (isLine ? crowding : std::sqrt(crowding));
  const int columns = stepsFor(section.acrossRadius, step);
  const int rows = stepsFor(section.upwardsRadius, step);
  for (int row = -rows; row <= rows; ++row)
    for (int column = -columns; column <= columns; ++column)
    {
      // As shares of the radii; the outermost points stand half a strip within the edge.
      const double x = column / (columns + 0.5);
      const double y = row / (rows + 0.5);
      if (x * x + y * y > 1) continue;
      const double across = x * section.acrossRadius;
      const double upwards = y * section.upwardsRadius;
      const double squared = across * across + upwards * upwards;
      const double sideways = length * std::sqrt(1 - squared / 4);
      rays.push_back(length * (1 - squared / 2) * axis + sideways * across * section.across +
                     sideways * upwards * section.upwards);
    }
}

}  // namespace lamap
