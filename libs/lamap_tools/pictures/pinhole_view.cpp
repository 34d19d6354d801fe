#include <lamap_tools/pictures/pinhole_view.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace lamap::tools
{
Eigen::Vector3d PinholeView::backward() const
{
  return {std::cos(azimuth_rad) * std::cos(elevation_rad), std::sin(azimuth_rad) * std::cos(elevation_rad),
          std::sin(elevation_rad)};
}

Eigen::Vector3d PinholeView::right() const
{
  return {-std::sin(azimuth_rad), std::cos(azimuth_rad), 0};
}

Eigen::Vector3d PinholeView::up() const
{
  return backward().cross(right());
}

std::optional<PinholeView::Pixel> PinholeView::project(const Eigen::Vector3d& point) const
{
  const Eigen::Vector3d fromCamera = point - (lookAt + distance * backward());
  const double depth = -fromCamera.dot(backward());
  if (!(depth > 1e-6 * distance)) return std::nullopt;
  const double focal = height / 2 / std::tan(verticalFov_rad / 2);
  return Pixel{width / 2 + focal * fromCamera.dot(right()) / depth,
               height / 2 - focal * fromCamera.dot(up()) / depth, depth};
}

void PinholeView::fit(const std::vector<Eigen::Vector3d>& points, double margin)
{
  // The frustum's four side planes, less the margin. A plane that touches the points gives one equation for
  // the camera's position; the left and right, and the top and bottom planes meet at the nearest position
  // that sees all points.
  const double focal = height / 2 / std::tan(verticalFov_rad / 2);
  const double slopeX = std::max(1.0, width / 2 - margin) / focal;
  const double slopeY = std::max(1.0, height / 2 - margin) / focal;
  const double infinity = std::numeric_limits<double>::infinity();
  double mostRight = -infinity, mostLeft = -infinity, mostUp = -infinity, mostDown = -infinity;
  double nearest = -infinity;
  for (const Eigen::Vector3d& point : points)
  {
    const double x = point.dot(right());
    const double y = point.dot(up());
    const double back = point.dot(backward());
    mostRight = std::max(mostRight, x + slopeX * back);
    mostLeft = std::max(mostLeft, -x + slopeX * back);
    mostUp = std::max(mostUp, y + slopeY * back);
    mostDown = std::max(mostDown, -y + slopeY * back);
    nearest = std::max(nearest, back);
  }
  const double cameraX = (mostRight - mostLeft) / 2;
  const double cameraY = (mostUp - mostDown) / 2;
  const double cameraBack = std::max((mostRight + mostLeft) / 2 / slopeX, (mostUp + mostDown) / 2 / slopeY);
  // Looks at the middle of the depth range, for the clipping planes.
  double farthest = infinity;
  for (const Eigen::Vector3d& point : points) farthest = std::min(farthest, point.dot(backward()));
  const double middle = (nearest + farthest) / 2;
  lookAt = cameraX * right() + cameraY * up() + middle * backward();
  distance = cameraBack - middle;
}

}  // namespace lamap::tools
