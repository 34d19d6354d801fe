#pragma once

#include <lamap_core/scan/scan.h>
#include <mrpt/obs/CObservation.h>
#include <mrpt/poses/CPose3D.h>

#include <optional>

namespace lamap
{
/** Whether raysOf() can read this observation.
 *
 * True for CObservation2DRangeScan, CObservation3DRangeScan, CObservationPointCloud,
 * CObservationVelodyneScan, CObservationRange, and for a CObservationRotatingScan whose rows have known
 * elevations: a single row, a Velodyne VLP-16 or HDL-32E, or one that carries its points. Loads nothing and
 * never throws.
 */
[[nodiscard]] bool supportsObservation(const mrpt::obs::CObservation& observation);

/** The opening angle of an observation's beams as it states it, edge to edge [rad]; 0 where its class has
 * none. raysOf() takes one that is not above 0° and below 180° for 0. */
[[nodiscard]] double statedApertureOf(const mrpt::obs::CObservation& observation);

/** An observation as rays, in the frame of its sensor.
 *
 * The pose of the scan is robotPose ⊕ sensor pose, composed in double; end points are as the sensor measured
 * them. No ray is left out because of its range: end points may be beyond the maximum range or NaN, because
 * selectRays() selects and counts.
 *
 * What the numbers mean (REP 117): at least the maximum range that the observation states, or +Inf: no return
 * within that range. −Inf, or less than the stated minimum: nearer than can be measured. NaN or negative:
 * dropped, nothing is known. 0 is most classes' code for no return. For each class:
 *
 * - CObservation2DRangeScan. Ray i of n is at −aperture/2 + i·aperture/(n−1), mirrored unless rightToLeft; a
 *   single ray points forward. The sensor pitches by deltaPitch during the scan. An invalid ray has no
 *   return if its range is at least maxRange, or 0; a valid 0 is dropped. Any other invalid ray was measured
 *   and rejected (MRPT's exclusion areas and angles mark the robot's own body, or a range below the sensor's
 *   minimum): it is dropped, whereas MRPT's grid maps take it for free.
 * - CObservation3DRangeScan. The range image through the depth camera's own model, with distortion; the
 * points if there is no image, no calibration, or not one reading in the image. A pixel 0 or a point (0,0,0)
 * is dropped, not free, because a depth camera that finds no match has seen nothing. There are no rays
 * without a return.
 * - CObservationPointCloud. All points, including NaN. sensorPose is applied (MRPT's own insertion ignores
 *   it). No range is stated.
 * - CObservationVelodyneScan. The generated points; if there are none, points are generated from the packets
 *   by MRPT's rules, for all ranges from minRange to maxRange, as if the sensor stood still during the scan.
 *   MRPT does not report missing returns.
 * - CObservationRotatingScan. rangeImage, with column c of n at azimuth start + c·span/(n−1); 0 is a ray
 *   without a return. The rows of a Velodyne have the elevations of its standard calibration. Its columns are
 *   those that MRPT's fromVelodyne() fills, only the first n/rows, clockwise; among these, a column without
 * any return was not measured.
 * - CObservationRange. One fan for each measurement, all in the frame of the first one's sensor. Its ray is
 * the axis of the cone that its beam states.
 *
 * The beam of a fan has the aperture that a CObservation2DRangeScan or CObservationRange states; one that is
 * not above 0° and below 180° is none. An observation whose label ends in "/echo2", "/echo3", … holds later
 * echoes of pulses whose first echo is another observation: its rays have that rank.
 *
 * Externally stored data is loaded, and unloaded again if it was not in memory before. No other thread may
 * use the observation meanwhile.
 *
 * @param robotPose pose of the robot in the map frame [m, rad].
 * @return nothing for a class that supportsObservation() refuses.
 * @throws std::runtime_error naming the class, the sensor label and the reason, if external data cannot be
 * loaded or the content contradicts itself (different numbers of coordinates, a depth image without
 * calibration).
 */
[[nodiscard]] std::optional<Scan> raysOf(const mrpt::obs::CObservation& observation,
                                         const mrpt::poses::CPose3D& robotPose);

}  // namespace lamap
