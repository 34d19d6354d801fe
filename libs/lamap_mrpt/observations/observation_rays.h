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

/** An observation as rays, in the frame of its sensor.
 *
 * The pose of the scan is robotPose ⊕ sensor pose, composed in double; every end point is the sensor's own.
 * Nothing is left out for its range: end points may lie beyond the maximum range or be NaN; whoever selects
 * rays decides, and counts. What each class states:
 *
 * - CObservation2DRangeScan. Ray i of n points at −aperture/2 + i·aperture/(n−1), mirrored unless rightToLeft
 * (a single ray points forward), and the sensor pitches by deltaPitch over the scan. A ray did not return
 * where its range is at least maxRange, valid or not, or where it is invalid with range 0. An invalid ray
 * with any other range (MRPT's exclusion areas and angles mark them: the robot's own body, a range below the
 * sensor's least) was measured and rejected: it is dropped, whereas MRPT's grid maps call it free.
 * - CObservation3DRangeScan. The range image through the depth camera's own model, distortion included; the
 * points where there is no image or no calibration. A pixel 0 or a point (0,0,0) is dropped, not free: a
 * depth camera without a match has seen nothing. No rays without return.
 * - CObservationPointCloud. All points, NaN too; sensorPose is applied (MRPT's own insertion forgets it). No
 * range is stated.
 * - CObservationVelodyneScan. The generated points; where there are none, they are made from the packets, of
 *   all ranges from minRange to maxRange, by MRPT's rules. The sensor is taken as standing still during the
 * scan. MRPT tells nothing of missing returns.
 * - CObservationRotatingScan. rangeImage, column c of n at azimuth start + c·span/(n−1); 0 is a ray without
 * return. A Velodyne's rows have the elevations of its standard calibration, and the columns as MRPT's
 * fromVelodyne() fills them: only the first n/rows, clockwise; there a column without any return was not
 * measured.
 * - CObservationRange. One fan per measurement, all in the frame of the first one's sensor. Its ray is the
 * axis of the cone that its beam states. No echo (range ≤ 0 or ≥ maxSensorDistance) is a ray without return.
 *
 * Externally stored data is loaded, and unloaded again if it was not in memory before; the observation is as
 * it was afterwards. For that the observation must not be used by another thread meanwhile.
 *
 * @param robotPose pose of the robot in the map frame [m, rad].
 * @return nothing for a class that supportsObservation() refuses.
 * @throws std::runtime_error naming the class, the sensor label and the reason, if external data cannot be
 * loaded or the content contradicts itself (coordinates of different count, a depth image without
 * calibration).
 */
[[nodiscard]] std::optional<Scan> raysOf(const mrpt::obs::CObservation& observation,
                                         const mrpt::poses::CPose3D& robotPose);

}  // namespace lamap
