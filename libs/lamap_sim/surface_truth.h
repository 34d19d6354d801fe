#pragma once

#include <lamap_sim/sensor.h>
#include <lamap_sim/trajectory.h>
#include <lamap_sim/truth.h>
#include <lamap_sim/world.h>

#include <Eigen/Core>
#include <functional>
#include <vector>

namespace lamap::sim
{
/** The cells of a world whose surfaces or open space a sensor can see from some poses, sorted by z, y, x.
 *
 * A cell holds a surface if one of a solid passes through it, however small the solid's share; a surface
 * exactly on the face of two cells belongs to the solid one.
 * - Occupied: holds a surface, and a line of sight ends in it. Traced are the sensor's own beams and, because
 *   those miss cells far away, lines to 3 × 3 × 3 points of each cell, a third of a cell apart, within the
 *   sensor's field of view and range.
 * - Free: lies in the world's interior, holds neither solid nor surface, and its centre can be seen.
 * - All other cells are left out: what no line of sight reaches, and cells with a surface of which only the
 *   open part can be seen.
 * A planar sensor sees only the layer of cells in which it is. Noise has no influence.
 *
 * @param shots       true poses of the sensor: one per scan, of a sonar one per ping (see headTurn())
 * @param shouldStop  called from time to time; once it returns true, the result is empty
 * @throws std::invalid_argument for an illegal resolution, and if there would be more than 10⁹ cells */
[[nodiscard]] std::vector<TrueCell> surfaceTruthOf(const World& world, const SensorModel& sensor,
                                                   const std::vector<Pose>& shots, double resolution_m,
                                                   const std::function<bool()>& shouldStop = nullptr);

/** Points on all surfaces of a world, seen or not, in its interior and up to one cell beyond it: where lines
 * along each axis (of a flat world, in the plane at z = 0), three per edge of a cell with one through its
 * centre, cross a surface.
 *
 * The surface is never farther from the nearest point than a third of a cell, but where it is curved more
 * sharply than a cell; straight ahead of the centre of a cell there is no error.
 * @param shouldStop, @throws as above */
[[nodiscard]] std::vector<Eigen::Vector3d> surfacePointsOf(const World& world, double resolution_m,
                                                           const std::function<bool()>& shouldStop = nullptr);

}  // namespace lamap::sim
