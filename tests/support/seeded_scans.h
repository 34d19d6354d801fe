#pragma once

#include <lamap_core/scan/scan.h>
#include <Eigen/Core>

#include <cmath>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

namespace lamap::test
{
/** Random numbers that depend on the seed alone, not on the C++ library's distributions. */
class Random
{
 public:
  explicit Random(uint64_t seed) : engine_(seed) {}

  /// In [low, high).
  double uniform(double low, double high)
  {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  /// In [low, high].
  int integer(int low, int high)
  {
    const auto count = static_cast<uint64_t>(int64_t{high} - low) + 1;
    return static_cast<int>(low + static_cast<int64_t>(engine_() % count));
  }
  bool chance(double prob) { return uniform(0, 1) < prob; }
  uint64_t bits() { return engine_(); }
  Eigen::Vector3d inCube(double halfEdge)
  {
    const double x = uniform(-halfEdge, halfEdge), y = uniform(-halfEdge, halfEdge);
    return {x, y, uniform(-halfEdge, halfEdge)};
  }
  template <typename T>
  const T& pick(const std::vector<T>& options)
  {
    return options[static_cast<size_t>(integer(0, static_cast<int>(options.size()) - 1))];
  }
  template <typename T>
  void shuffle(std::vector<T>& items)
  {
    for (size_t i = items.size(); i > 1; --i) std::swap(items[i - 1], items[engine_() % i]);
  }

 private:
  std::mt19937_64 engine_;
};

/// What a random scan looks like. Lengths in metres.
struct ScanRecipe
{
  double halfEdge_m = 0.6;       ///< of the cube around the centre in which origins and ends lie
  double clusterRadius_m = 0.1;  ///< returns come in clusters, so that several share a cell
  int rays = 16;                 ///< of a fan
  int fans = 2;                  ///< at most
  bool noReturns = true;         ///< some rays have no return
  bool unusable = true;          ///< some rays are NaN, infinite or of length zero
  bool statedRanges = true;      ///< some fans state a nearest and farthest range
  Eigen::Vector3d centre_map = Eigen::Vector3d::Zero();
};

/// A fan by hand: the points where its rays returned [m], then directions of rays without a return.
RayFan fanOf(const Eigen::Vector3d& centre, const std::vector<Eigen::Vector3d>& returns,
             const std::vector<Eigen::Vector3d>& noReturns = {}, double statedMin_m = 0,
             double statedMax_m = 0);

/// A scan in the map's frame.
Scan scanWith(std::vector<RayFan> fans);

/// The ends of the rays that mean this, in their order.
std::vector<Eigen::Vector3d> endsOf(const RayFan& fan, RayEnd meaning = RayEnd::Return);

/// A direction of length 1.
inline Eigen::Vector3d towards(double azimuth_deg, double elevation_deg = 0)
{
  const double azimuth = azimuth_deg * M_PI / 180;
  const double elevation = elevation_deg * M_PI / 180;
  return {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
          std::sin(elevation)};
}

Scan randomScan(Random& random, const ScanRecipe& recipe);

/// The scan with every coordinate rounded to a multiple of 2^-bits m, so that moving it is exact.
Scan quantized(const Scan& scan, int bits);

/// The scan moved as a whole.
Scan moved(const Scan& scan, const Eigen::Vector3d& by_m);

}  // namespace lamap::test
