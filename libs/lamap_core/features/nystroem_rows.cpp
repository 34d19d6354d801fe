#include <lamap_core/features/nystroem_rows.h>
#include <lamap_core/math/wide_floats.h>

#include <algorithm>

namespace lamap
{
/// What the loops read.
struct NystroemRows::Tables
{
  size_t components;
  size_t stride;
  float exponent;
  std::array<const float*, 3> inducing;
  const Line* inverse;
};

namespace
{
constexpr size_t kLine = 16;  ///< numbers in a line; all numbers of lanes divide it

template <int kLanes, typename Tables>
LAMAP_INLINED void kernels(const Tables& tables, const std::array<float, 3>& point, float* out)
{
  using W = Wide<kLanes>;
  for (size_t k = 0; k < tables.stride; k += kLanes)
  {
    typename W::Floats squares{};
    for (size_t axis = 0; axis < 3; ++axis)
    {
      typename W::Floats place;
      W::load(tables.inducing[axis] + k, place);
      const typename W::Floats d = point[axis] - place;
      squares += d * d;
    }
    typename W::Floats kernel = tables.exponent * squares;
    W::exp(kernel);
    W::store(kernel, out + k);
  }
}

/// Two vectors of components of kAtOnce points stay in registers while the inducing points go by.
template <int kLanes, typename Tables>
LAMAP_INLINED void features(const Tables& tables, const float* kernels, float* out)
{
  using W = Wide<kLanes>;
  using Floats = typename W::Floats;
  constexpr size_t kPoints = NystroemRows::kAtOnce;
  const auto* block = tables.inverse;
  for (size_t line = 0; line < tables.stride; line += kLine)
  {
    const size_t end = std::min(tables.components, line + kLine);
    for (size_t j = 0; j < kLine; j += 2 * kLanes)
    {
      Floats low[kPoints];
      Floats high[kPoints];
      for (size_t p = 0; p < kPoints; ++p) low[p] = high[p] = Floats{};
      for (size_t k = 0; k < end; ++k)
      {
        Floats first;
        Floats second;
        W::load(block[k].rows.data() + j, first);
        W::load(block[k].rows.data() + j + kLanes, second);
        for (size_t p = 0; p < kPoints; ++p)
        {
          const float kernel = kernels[p * tables.stride + k];
          low[p] += first * kernel;
          high[p] += second * kernel;
        }
      }
      for (size_t p = 0; p < kPoints; ++p)
      {
        W::store(low[p], out + p * tables.stride + line + j);
        W::store(high[p], out + p * tables.stride + line + j + kLanes);
      }
    }
    block += end;
  }
}

}  // namespace

NystroemRows::NystroemRows(const std::array<std::vector<float>, 3>& inducing,
                           const std::vector<double>& inverse, double gamma)
    : components_(inducing[0].size()),
      stride_((components_ + kLine - 1) / kLine * kLine),
      exponent_(static_cast<float>(-gamma)),
      inducing_(inducing)
{
  for (std::vector<float>& ofAxis : inducing_) ofAxis.resize(stride_, 0.0f);
  for (size_t line = 0; line < stride_; line += kLine)
    for (size_t k = 0; k < std::min(components_, line + kLine); ++k)
    {
      Line& column = inverse_.emplace_back();
      for (size_t j = std::max(line, k); j < std::min(components_, line + kLine); ++j)
        column.rows[j - line] = static_cast<float>(inverse[j * components_ + k]);
    }
}

NystroemRows::Tables NystroemRows::tables() const
{
  return {components_,
          stride_,
          exponent_,
          {inducing_[0].data(), inducing_[1].data(), inducing_[2].data()},
          inverse_.data()};
}

void NystroemRows::kernelsOf(const std::array<float, 3>& point, float* out, bool wide) const
{
  withRegisters([&](auto r) LAMAP_INLINED_LAMBDA { kernels<decltype(r)::kFloats>(tables(), point, out); },
                wide);
}

void NystroemRows::featuresOf(const float* kernels, float* out, bool wide) const
{
  withRegisters([&](auto r) LAMAP_INLINED_LAMBDA { features<decltype(r)::kFloats>(tables(), kernels, out); },
                wide);
}

}  // namespace lamap
