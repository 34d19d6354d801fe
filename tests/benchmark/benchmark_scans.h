#pragma once

#include <mrpt/obs/CObservation.h>
#include <mrpt/poses/CPose3D.h>

#include <Eigen/Core>
#include <string>
#include <vector>

namespace lamap::test
{
/// An observation and the robot's pose when it was taken.
struct PosedObservation
{
  mrpt::obs::CObservation::Ptr observation;
  mrpt::poses::CPose3D robotPose;
};

/// A cell whose truth is known.
struct TrueCell
{
  Eigen::Vector3d centre_map;
  bool occupied = false;
};

/// Scans for insertion into several maps.
struct ScanSeries
{
  std::string name;
  double rangeMax_m = 0;
  bool planar = false;  ///< of a sensor that sees a plane
  std::vector<PosedObservation> scans;
  /// Cells of 0.1 m: free ones are wholly in open space, occupied ones contain a surface. Cells deeper in
  /// walls are not listed.
  std::vector<TrueCell> truth;
};

/// 12 scans of 3,500 points in a 120° sector, 8 m: a small room with a wall and boxes.
ScanSeries sectorLaserSeries();
/// 10 scans of 89,000 points all around, 30 m: a corridor of 44 × 18 × 3.3 m with rooms.
ScanSeries panTiltSeries();
/// 60 planar scans of 361 beams, 30 m, in the same corridor.
ScanSeries planarLaserSeries();

}  // namespace lamap::test
