#pragma once

#include <Eigen/Core>
#include <cmath>

namespace lamap
{
/** A place for the pose of a drawn object whose parts lie about another place, and are relative to the pose.
 *
 * MRPT writes the pose of an object as floats, which are half a metre apart in UTM coordinates, and would so
 * move its parts. The coordinates of this place are exact as floats.
 * @return a place within 32 m, or, beyond a million kilometres, as near as floats come */
inline Eigen::Vector3d sceneAnchorNear(const Eigen::Vector3d& place)
{
  constexpr double kFloatIntegers = 1 << 24;
  double step_m = 64;
  while (place.cwiseAbs().maxCoeff() >= step_m * kFloatIntegers) step_m *= 2;
  const auto rounded = [step_m](double x) { return step_m * std::round(x / step_m); };
  return {rounded(place.x()), rounded(place.y()), rounded(place.z())};
}

}  // namespace lamap
