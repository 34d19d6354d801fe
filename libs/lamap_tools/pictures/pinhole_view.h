#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace lamap::tools
{
/** Pose of a perspective camera, in the frame of the scene; the same pinhole model as MRPT's CCamera.
 */
struct PinholeView
{
  Eigen::Vector3d lookAt = Eigen::Vector3d::Zero();
  double distance = 1;
  double azimuth_rad = 0;
  double elevation_rad = 0;
  double verticalFov_rad = 0.5;
  double width = 1;  ///< of the picture [pixels]
  double height = 1;

  struct Pixel
  {
    double x = 0;
    double y = 0;
    double depth = 0;  ///< along the view direction
  };
  /// Empty for a point behind the camera.
  [[nodiscard]] std::optional<Pixel> project(const Eigen::Vector3d& point) const;

  /// Towards the camera, to its right and up.
  [[nodiscard]] Eigen::Vector3d backward() const;
  [[nodiscard]] Eigen::Vector3d right() const;
  [[nodiscard]] Eigen::Vector3d up() const;

  /// Changes lookAt and the distance, but not the direction, so that the points fill the picture up to a
  /// margin [pixels].
  void fit(const std::vector<Eigen::Vector3d>& points, double margin);
};

}  // namespace lamap::tools
