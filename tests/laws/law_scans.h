#pragma once

#include <mrpt/obs/CObservation.h>
#include <mrpt/poses/CPose3D.h>
#include <support/seeded_scans.h>

#include <memory>
#include <vector>

// Observations that the laws are tried with.
namespace lamap::test
{
/// An observation, and where it was taken.
struct TakenScan
{
  std::shared_ptr<mrpt::obs::CObservation> observation;
  mrpt::poses::CPose3D robotPose_map;
};

/// Clusters of points up to about 1 m from a sensor that stands anywhere, turned any way.
TakenScan randomCloud(Random& random, int points = 40);
/// A scan of a planar laser that stands anywhere, turned any way. Some of its rays have no return.
TakenScan randomLaserScan(Random& random, int rays = 40);
/// Clouds and laser scans.
std::vector<TakenScan> randomScans(Random& random, int count, int rays = 40);

/// A cloud whose points and pose are multiples of 2^-20 m, not turned: it can be moved without rounding.
TakenScan roundCloud(Random& random);
/// The scan, with its robot moved.
TakenScan moved(const TakenScan& scan, double x_m, double y_m, double z_m);

/// A cloud with points among the others that are NaN, infinite, or where the sensor is. @param added  how
/// many
TakenScan spoilt(Random& random, const TakenScan& cloud, size_t& added);

}  // namespace lamap::test
