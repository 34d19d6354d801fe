#pragma once

#include <lamap_core/scan/scan.h>

#include <vector>

namespace lamap
{
/** How far the neighbouring beams of a fan's rays are from them, found by the directions of the rays alone:
 * it does not matter in which order a cloud holds its points, or how a log was thinned.
 *
 * Directions are sorted into bins of half a degree. From each bin with rays the nearest others are looked for
 * to the left and right, and above and below, each in a quarter of all directions, up to 30°. The nearer one
 * of each pair counts, so that a beam beside an opening is no farther from its neighbours; of the two pairs
 * the farther one, because between the rings of a lidar the space is not seen however dense the rings are.
 * Several rays in a bin share it.
 * @param fan of rays with finite directions
 * @return the angle [rad] for each ray of the fan; 0 for a ray that is alone */
[[nodiscard]] std::vector<float> beamSpacing(const RayFan& fan);

}  // namespace lamap
