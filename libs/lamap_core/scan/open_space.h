#pragma once

#include <lamap_core/scan/direction_bins.h>
#include <lamap_core/scan/scan.h>

#include <cstdint>
#include <vector>

namespace lamap
{
/** How far the rays of a fan that had no return may be free.
 *
 * A reading without return is a dropout (a dark, wet or specular thing, crosstalk) far more often than open
 * space, and a dropout says nothing beyond the surface that its neighbours saw. So such a ray is free only as
 * far as the nearest of the returns that bound the run of rays without return it lies in: the next ones to
 * either side, above and below, by direction in bins of one degree. Where a sensor's field of view ends (at a
 * gap of more than 30 degrees without any ray) a run ends without a return.
 *
 * The order of the rays does not matter. The same on every processor. Immutable: may be shared between
 * threads. */
class OpenSpace
{
 public:
  /// @param rangeMin_m nearer returns do not count: the robot's own body bounds nothing
  OpenSpace(const RayFan& fan, double rangeMin_m);

  /** The same for any direction, bounded by all rays: how far a place between them may be free.
   * @param ends of the rays, from where they leave; those of no length are left out */
  static OpenSpace between(const std::vector<Eigen::Vector3d>& ends);

  /// Of between(): whether a place, from where the rays leave, is nearer than the rays that bound it.
  [[nodiscard]] bool reaches(const Eigen::Vector3d& place) const;

  /// @param direction of a ray of the fan, not zero; its length does not matter
  /// @return range [m] of the nearest return that bounds it; infinite where none does
  [[nodiscard]] double reach_m(const Eigen::Vector3d& direction) const;

 private:
  struct Seen
  {
    DirectionBin bin;
    float range_m;  ///< infinite: no return
  };

  OpenSpace() = default;
  void fill(const std::vector<Seen>& seen);
  [[nodiscard]] size_t placeOf(const DirectionBin& bin) const;
  [[nodiscard]] std::vector<float> firstReturns(const std::vector<float>& returns_m, int rowStep,
                                                int columnStep) const;
  void findReaches(const std::vector<float>& returns_m);

  int firstRow_ = 0;
  int rows_ = 0;                  ///< 0: nothing bounds the rays of the fan
  std::vector<float> reaches_m_;  ///< by row, then by column
};

}  // namespace lamap
