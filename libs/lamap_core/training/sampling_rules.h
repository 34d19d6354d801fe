#pragma once

#include <cmath>
#include <cstdint>

namespace lamap
{
/// Where a ray says "free".
enum class FreeSpace
{
  Samples,  ///< points every freeResolution along the ray (thesis 4.2)
  Line,     ///< the nearest point of the ray's segment, each ray once per cell (thesis 4.4, eq. 4.30–4.31)
  None      ///< nowhere
};

/// Where the samples of a ray are counted from.
enum class SamplesFrom
{
  Sensor,  ///< the first one stands at the optical centre (thesis 4.2)
  End      ///< the first one stands freeMargin before the hit, or at the end of a ray without one
};

/// What the training points of a scan are.
enum class TrainingPoints
{
  Cells,     ///< each hit cell and each free cell of the scan once, at its centre
  Centroids  ///< the hits' mean position in each voxel of hitDownsampling, and the free points where they are
};

/// What is taken into account of how wide beams are.
enum class BeamWidth
{
  None,         ///< nothing: a ray is a line, and a point as narrow as a cell
  Observation,  ///< what the observation states of its beams: their cones, and how well ranges are known
  Spacing       ///< that, and the distance to the neighbouring beams, between which nothing was seen
};

/// How wide beams are, and what wide ones say, as options.
struct BeamOptions
{
  BeamWidth beamWidth = BeamWidth::None;
  double echoWeight = 3;  ///< most that the echo of a wide beam weighs, in hits, > 0
  double noEchoWeight =
      1;  ///< of free points of wide beams without a return, as a share of others', in [0, 1]
};

/// How the rays of a scan become training points, whoever learns from them. Lengths in metres.
struct SamplingRules : public BeamOptions
{
  FreeSpace freeSpace = FreeSpace::Samples;
  SamplesFrom samplesFrom = SamplesFrom::Sensor;
  TrainingPoints points = TrainingPoints::Cells;
  double freeResolution = 0.1;  ///< distance between free points on a ray, > 0
  double freeMargin = 0.1;      ///< no free point nearer to its ray's hit
  double sensorMargin = 0;      ///< no free sample nearer to the sensor
  double freeDownsampling = 0;  ///< `Centroids`: voxel edge in which free points are averaged; 0: none
  double hitDownsampling = 0;   ///< `Centroids`: voxel edge in which hits are averaged; 0: none
  uint32_t protectHits = 0;     ///< a cell with this many raw hits takes no free point; 0: none is protected
  /// `Cells`: no free cell between the returns of a surface seen at a glancing angle, see GlancingSurfaces
  bool keepGlancingSurfaces = false;
  double hitWeight = 1;            ///< weight of a hit [-], > 0
  double freeWeight = 1;           ///< weight of a free point [-]; 0: no free points
  bool usePoseCovariance = false;  ///< points are as uncertain as the scan's pose, where it has a covariance
  double widthUnit = 0.2;          ///< what differences of widths the learner can tell, see kWidthLevels; > 0
};

/// A length that is a whole number of cells but for the rounding of the division is that number: cells at
/// exactly the support shall not depend on how 0.3 / 0.1 rounds.
[[nodiscard]] inline double lengthInCells(double length_m, double resolution_m)
{
  const double cells = length_m / resolution_m;
  const double whole = std::round(cells);
  return whole > 0 && std::abs(cells - whole) < 1e-9 ? whole : cells;
}

}  // namespace lamap
