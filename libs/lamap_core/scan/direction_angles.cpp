#include <lamap_core/scan/direction_angles.h>

namespace lamap
{
Eigen::Array4f anglesOf(const Eigen::Array4f& y, const Eigen::Array4f& x)
{
  using Four = Eigen::Array4f;
  constexpr auto kPi = 3.141592653589793F;
  const Four ax = x.abs();
  const Four ay = y.abs();
  const Four larger = ax.max(ay).max(1e-30f);
  const Four z = ax.min(ay) / larger;
  const Four s = z * z;
  Four sum = Four::Constant(-0.01172120f);
  for (const float term : {0.05265332f, -0.11643287f, 0.19354346f, -0.33262347f, 0.99997726f})
  {
    const Four product = sum * s;
    sum = product + term;
  }
  Four angle = sum * z;
  for (int i = 0; i < 4; ++i)
  {
    if (ay[i] > ax[i]) angle[i] = 0.5f * kPi - angle[i];
    if (x[i] < 0) angle[i] = kPi - angle[i];
    if (y[i] < 0) angle[i] = -angle[i];
  }
  return angle;
}

}  // namespace lamap
