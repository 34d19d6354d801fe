#include <lamap_core/bgk/expected_kernel.h>

#include <lamap_core/math/portable_math.h>

#include <algorithm>
#include <cmath>

namespace lamap
{
namespace
{
/// Height and deviation of a Gaussian, for a kernel of support 1 and scale 1.
struct Gaussian
{
  double height;
  double deviation;
};

/// How a kernel is written as Gaussians.
struct Fit
{
  std::array<Gaussian, 2> narrow;  ///< for widths below kWide supports: their sum
  Gaussian wide;                   ///< for others
};
constexpr double kWide = 0.7;

/// Least squares against the exact expectation, at widths of 1/4 and 1/2, and of 3/4 and 2 supports.
Fit fitOf(KernelShape shape, bool planar)
{
  switch (shape)
  {
    case KernelShape::Sparse:
      return planar ? Fit{{{{1.827312, 0.231489}, {-0.894543, 0.18}}}, {1.102972, 0.249932}}
                    : Fit{{{{2.172389, 0.226165}, {-1.325909, 0.18}}}, {1.20207, 0.24362}};
    case KernelShape::SparseMatern32:
      return planar ? Fit{{{{1.71604, 0.223685}, {-0.765532, 0.18}}}, {1.067623, 0.2391}}
                    : Fit{{{{2.040057, 0.218988}, {-1.151659, 0.18}}}, {1.140521, 0.234445}};
    case KernelShape::WendlandC2:
      break;
  }
  return planar ? Fit{{{{1.300899, 0.254226}, {-0.388166, 0.18}}}, {1.021333, 0.264464}}
                : Fit{{{{1.522629, 0.247807}, {-0.709552, 0.18}}}, {1.089652, 0.259308}};
}

ExpectedKernel::Term termOf(const Gaussian& gaussian, double support, double scale, double width, bool planar,
                            int reach)
{
  const double before = gaussian.deviation * gaussian.deviation * support * support;
  const double after = before + width * width;
  const double shrink = before / after;
  ExpectedKernel::Term term;
  term.factor = scale * gaussian.height * (planar ? shrink : shrink * std::sqrt(shrink));
  term.inverseSquare = 1 / after;
  for (int i = -reach; i <= reach; ++i)
    term.weights.push_back(static_cast<float>(portableExp(-0.5 * i * i * term.inverseSquare)));
  return term;
}

}  // namespace

ExpectedKernel::ExpectedKernel(KernelShape shape, double support, double scale, double width, bool planar)
    : support_(support + 3 * width), reach_(static_cast<int>(std::ceil(support_)) - 1)
{
  const Fit fit = fitOf(shape, planar);
  if (width >= kWide * support)
  {
    terms_.push_back(termOf(fit.wide, support, scale, width, planar, reach_));
    return;
  }
  for (const Gaussian& gaussian : fit.narrow)
    terms_.push_back(termOf(gaussian, support, scale, width, planar, reach_));
}

double ExpectedKernel::atSquaredDistance(double squaredDistance) const
{
  if (squaredDistance >= support_ * support_) return 0;
  double sum = 0;
  for (const Term& term : terms_)
    sum += term.factor * portableExp(-0.5 * squaredDistance * term.inverseSquare);
  return std::max(0.0, sum);
}

}  // namespace lamap
