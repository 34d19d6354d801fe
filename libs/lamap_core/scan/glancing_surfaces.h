#pragma once

#include <lamap_core/scan/direction_bins.h>
#include <lamap_core/scan/scan.h>

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace lamap
{
/** Surfaces that a fan of rays sees at a glancing angle, between its returns: the floor between the rings of
 * a lidar, the far part of a wall along which a laser looks. Rays on their way to the next return pass
 * through the cells that hold such a surface, and are no evidence against it.
 *
 * A piece of surface joins two neighbouring returns, the nearest ones of bins of one degree with no other ray
 * between them and at most kMostApart bins apart in azimuth or in elevation, if the farther one's ray meets
 * it at an angle between kLeastSine and kMostSine and it goes on straight, to the next return before or
 * behind it: else what is between them may be the gap between two things.
 *
 * The order of the rays does not matter. The same on every processor. Keeps its working memory. */
class GlancingSurfaces
{
 public:
  static constexpr int kMostApart = 3;
  static constexpr double kLeastSine = 0.05;
  static constexpr double kMostSine = 0.5;
  static constexpr double kStraightCosine = 0.9;

  /// Ends of rays, in the frame of the fan.
  struct Piece
  {
    Eigen::Vector3d begin;
    Eigen::Vector3d end;
  };
  /// @return valid until the next call
  const std::vector<Piece>& of(const RayFan& fan);

 private:
  /// The nearest return of a bin.
  struct Nearest
  {
    float squaredRange = 0;  ///< [m²] 0: no ray in this bin; infinite: none that returned
    uint32_t ray = 0;
  };

  void sortIntoBins(const RayFan& fan);
  void joinAlong(const RayFan& fan, size_t firstBin, size_t step, int count, int overlap);
  void joinRun(const Eigen::Vector3d& centre);

  std::vector<DirectionBin> bins_;  ///< of the rays
  int firstRow_ = 0;
  int rows_ = 0;
  std::vector<Nearest> nearest_;  ///< by row, then by column
  /// One of a run of neighbouring returns.
  struct Met
  {
    Eigen::Vector3d end;  ///< from the fan's centre
    bool isCounted;       ///< a piece may begin here
  };
  std::vector<Met> run_;
  std::vector<Piece> pieces_;
};

}  // namespace lamap
