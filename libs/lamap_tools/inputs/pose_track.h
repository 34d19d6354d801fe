#pragma once

#include <mrpt/core/Clock.h>
#include <mrpt/poses/CPose3D.h>
#include <mrpt/system/datetime.h>  // INVALID_TIMESTAMP

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

namespace lamap::tools
{
struct TimedPose
{
  mrpt::Clock::time_point time;
  mrpt::poses::CPose3D pose_map;
};

/** Poses of a robot over time [m, map frame].
 *
 * Between two poses the translation is interpolated linearly and the rotation along the shortest turn
 * (slerp). Before the first and after the last there is no pose: nothing is extrapolated. Immutable: may be
 * shared between threads.
 */
class PoseTrack
{
 public:
  /// In any order; of several poses with the same time, the last one counts.
  explicit PoseTrack(std::vector<TimedPose> poses);

  [[nodiscard]] std::optional<mrpt::poses::CPose3D> at(mrpt::Clock::time_point time) const;

  /// Sorted by time, one per time.
  [[nodiscard]] const std::vector<TimedPose>& poses() const { return poses_; }

 private:
  std::vector<TimedPose> poses_;
};

/// Whether a quaternion that was read is a rotation, to the digits that files give.
[[nodiscard]] bool isUnit(const Eigen::Quaterniond& rotation);
/// @param rotation  normalized here
[[nodiscard]] mrpt::poses::CPose3D poseFrom(const Eigen::Quaterniond& rotation,
                                            const Eigen::Vector3d& translation);

/** Reads poses, one per line, in the file's order. The number of columns determines the format:
 *   8  TUM: time tx ty tz qx qy qz qw
 *   7  MRPT's 3D path text: time x y z yaw pitch roll
 *   4  MRPT's 2D path text: time x y phi
 *   12 KITTI: a 3x4 matrix, row by row; such poses have no times (INVALID_TIMESTAMP)
 * with times in seconds (since 1970 if they must match a log), lengths in metres and angles in radians. Empty
 * lines and lines that begin with # or % are skipped.
 * @throws std::runtime_error naming the file, the line and what is wrong with it; also if there is no pose.
 */
[[nodiscard]] std::vector<TimedPose> readPoseFile(const std::string& path);

}  // namespace lamap::tools
