#include <lamap_core/math/registers.h>
#include <lamap_core/scan/direction_angles.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace lamap
{
namespace
{
constexpr auto kPi = 3.141592653589793F;

/// As many angles as there are lanes. @param y, replaced by the angles
template <int kLanes>
LAMAP_INLINED void replaceByAngles(typename Vector<float, kLanes>::Numbers& y,
                                   const typename Vector<float, kLanes>::Numbers& x)
{
  using Floats = typename Vector<float, kLanes>::Numbers;
  const Floats ax = x < 0.0F ? -x : x;
  const Floats ay = y < 0.0F ? -y : y;
  const auto isSteep = ay > ax;
  const Floats most = isSteep ? ay : ax;
  const Floats larger = most < 1e-30F ? Floats{} + 1e-30F : most;
  const Floats z = (isSteep ? ax : ay) / larger;
  const Floats s = z * z;
  Floats sum = Floats{} - 0.01172120F;
  sum = sum * s + 0.05265332F;
  sum = sum * s - 0.11643287F;
  sum = sum * s + 0.19354346F;
  sum = sum * s - 0.33262347F;
  sum = sum * s + 0.99997726F;
  Floats angle = sum * z;
  angle = isSteep ? 0.5F * kPi - angle : angle;
  angle = x < 0.0F ? kPi - angle : angle;
  y = y < 0.0F ? -angle : angle;
}

template <int kLanes>
LAMAP_INLINED void replaceAllByAngles(float* y, const float* x, size_t count)
{
  typename Vector<float, kLanes>::Numbers someY;
  typename Vector<float, kLanes>::Numbers someX;
  for (size_t i = 0; i < count; i += kLanes)
  {
    std::memcpy(&someY, y + i, sizeof(someY));
    std::memcpy(&someX, x + i, sizeof(someX));
    replaceByAngles<kLanes>(someY, someX);
    std::memcpy(y + i, &someY, sizeof(someY));
  }
}

}  // namespace

Eigen::Array4f anglesOf(const Eigen::Array4f& y, const Eigen::Array4f& x)
{
  Eigen::Array4f angles = y;
  replaceAllByAngles<4>(angles.data(), x.data(), 4);
  return angles;
}

void DirectionBatch::add(const Eigen::Vector3d& direction)
{
  // Divided by the largest part first, so that no square is too small or too large.
  const Eigen::Vector3f scaled = (direction / direction.cwiseAbs().maxCoeff()).cast<float>();
  x[count] = scaled.x();
  y[count] = scaled.y();
  z[count] = scaled.z();
  ++count;
}

void findAngles(DirectionBatch& directions)
{
  constexpr size_t kWidest = 8;
  const size_t count = (directions.count + kWidest - 1) / kWidest * kWidest;
  for (size_t i = directions.count; i < count; ++i) directions.x[i] = directions.y[i] = directions.z[i] = 0;
  DirectionBatch::Numbers across;
  for (size_t i = 0; i < count; ++i)
  {
    const float xx = directions.x[i] * directions.x[i];
    const float yy = directions.y[i] * directions.y[i];
    across[i] = std::sqrt(xx + yy);
  }
  std::copy_n(directions.y.begin(), count, directions.azimuth.begin());
  std::copy_n(directions.z.begin(), count, directions.elevation.begin());
  withRegisters(
      [&](auto registers) LAMAP_INLINED_LAMBDA
      {
        constexpr int kLanes = decltype(registers)::kFloats;
        replaceAllByAngles<kLanes>(directions.azimuth.data(), directions.x.data(), count);
        replaceAllByAngles<kLanes>(directions.elevation.data(), across.data(), count);
      });
}

}  // namespace lamap
