#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <vector>

namespace lamap
{
/// What the end of a ray means.
enum class RayEnd : uint8_t
{
  Return,    ///< the ray met a surface there
  NoReturn,  ///< it met nothing within the sensor's range
  Cut,       ///< it met something farther than maxRange, and is used up to there (see selectRays())
  Dropped,   ///< nothing is known: the reading was rejected, or there was none
  TooNear    ///< it met a surface nearer than the sensor can measure
};

/// One ray of a fan, in the sensor's frame.
struct Ray
{
  /// Return: the point [m] where it ended; may be NaN or infinite, whoever selects rays counts and skips
  /// those. All others: a vector from the fan's centre along the ray. Cut: it ends at maxRange [m]. Else its
  /// length does not matter; zero if the direction is not known.
  Eigen::Vector3d end = Eigen::Vector3d::Zero();
  RayEnd meaning = RayEnd::Return;
  uint8_t echo = 0;  ///< rank among the returns of one pulse; 0 is the first or the only one

  friend bool operator==(const Ray& a, const Ray& b)
  {
    return a.end == b.end && a.meaning == b.meaning && a.echo == b.echo;
  }
};

/// What a single ray stands for: a cone around it, and how well its length is known. All zero for a laser.
struct Beam
{
  double halfWidth_rad = 0;                       ///< half of the opening angle about `up`
  double halfHeight_rad = 0;                      ///< half of the opening angle across that
  double rangeStd_m = 0;                          ///< standard deviation of a range
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();  ///< in the sensor's frame

  friend bool operator==(const Beam& a, const Beam& b)
  {
    return a.halfWidth_rad == b.halfWidth_rad && a.halfHeight_rad == b.halfHeight_rad &&
           a.rangeStd_m == b.rangeStd_m && a.up == b.up;
  }
};

/// Whether a beam's angles and its deviation are finite and not negative, and its axis is one.
[[nodiscard]] bool isLegalBeam(const Beam& beam);

/// All rays of one observation that leave the same optical centre, in the order in which the sensor gives
/// them.
struct RayFan
{
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< [m] in the sensor's frame
  std::vector<Ray> rays;
  Beam beam;
  /// Nearest and farthest range [m] that the observation states; 0: it states none.
  double statedRangeMin_m = 0;
  double statedRangeMax_m = 0;

  /// From the centre along a ray of the fan, as far as its end; of any length if that does not matter.
  [[nodiscard]] Eigen::Vector3d directionOf(const Ray& ray) const
  {
    return ray.meaning == RayEnd::Return ? Eigen::Vector3d(ray.end - centre) : ray.end;
  }

  void addReturn(const Eigen::Vector3d& point) { rays.push_back({point, RayEnd::Return, 0}); }
  void add(RayEnd meaning, const Eigen::Vector3d& direction) { rays.push_back({direction, meaning, 0}); }

  friend bool operator==(const RayFan& a, const RayFan& b)
  {
    return a.centre == b.centre && a.rays == b.rays && a.beam == b.beam &&
           a.statedRangeMin_m == b.statedRangeMin_m && a.statedRangeMax_m == b.statedRangeMax_m;
  }
};

/** One observation as rays, in the sensor's frame.
 *
 * A source whose points are given in the map's frame has the identity as its pose, and the viewpoint as the
 * centre of its fan: then nothing is turned and nothing rounded. Several fans where rays leave from different
 * places. */
struct Scan
{
  // Not aligned: the layout must not depend on the flags of whoever includes this.
  using Pose = Eigen::Transform<double, 3, Eigen::Isometry, Eigen::DontAlign>;
  using PoseCovariance = Eigen::Matrix<double, 6, 6, Eigen::DontAlign>;

  Pose sensorPose_map = Pose::Identity();
  /// How sure the pose is, for Gaussian errors; nothing: it counts as certain. Translation [m], then rotation
  /// vector [rad], both along the axes of the map, the rotation about the sensor.
  std::optional<PoseCovariance> poseCovariance;
  std::vector<RayFan> fans;

  /// @throws std::invalid_argument where the pose is finite but no rigid motion: it would stretch or mirror
  /// the scan
  void requireRigidPose() const;

  /// @param point [m] in the sensor's frame
  [[nodiscard]] Eigen::Vector3d inMap(const Eigen::Vector3d& point) const;
  /// @param vector in the axes of the sensor. @return it in those of the map
  [[nodiscard]] Eigen::Vector3d turnedToMap(const Eigen::Vector3d& vector) const;
};

/// Whether a matrix turns vectors, and neither stretches nor mirrors them: to 1e-6 in each of its products.
[[nodiscard]] bool isRotation(const Eigen::Matrix3d& matrix);

}  // namespace lamap
