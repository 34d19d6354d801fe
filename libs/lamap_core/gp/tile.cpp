#include <lamap_core/gp/tile.h>

#include <lamap_core/math/wide_floats.h>

#include <cmath>
#include <cstring>

// Compiles the body for registers of two numbers, and of four for processors that have them.
#ifdef LAMAP_FOR_AVX2
#define LAMAP_FOR_EACH_PROCESSOR(name, parameters, arguments) \
  LAMAP_FOR_AVX2 static void name##Wide parameters            \
  {                                                           \
    name##Body<Four> arguments;                               \
  }                                                           \
  void name parameters                                        \
  {                                                           \
    if (hasAvx2()) return name##Wide arguments;               \
    name##Body<Two> arguments;                                \
  }
#else
#define LAMAP_FOR_EACH_PROCESSOR(name, parameters, arguments) \
  void name parameters                                        \
  {                                                           \
    name##Body<Two> arguments;                                \
  }
#endif

namespace lamap
{
namespace
{
using Two = double __attribute__((vector_size(16), aligned(8), may_alias));
using Four = double __attribute__((vector_size(32), aligned(8), may_alias));

/// A tile in registers' worth of numbers. @tparam V Two or Four
template <typename V>
struct Parts
{
  static constexpr int kLanes = sizeof(V) / sizeof(double);
  static constexpr int kCount = 8 / kLanes;
};

template <typename V>
LAMAP_INLINED const V* partsOf(const GpTile& tile)
{
  return reinterpret_cast<const V*>(tile.data());
}
template <typename V>
LAMAP_INLINED V* partsOf(GpTile& tile)
{
  return reinterpret_cast<V*>(tile.data());
}

template <typename V>
LAMAP_INLINED void squaredDistancesBody(const double* x, const double* y, const double* z, size_t count,
                                        const GpPlaces& to, GpTile* rows, GpTile& nearest)
{
  for (int part = 0; part < Parts<V>::kCount; ++part)
  {
    const V cx = partsOf<V>(to.x)[part];
    const V cy = partsOf<V>(to.y)[part];
    const V cz = partsOf<V>(to.z)[part];
    V least = V{} + 1e300;
    for (size_t i = 0; i < count; ++i)
    {
      const V dx = cx - x[i];
      const V dy = cy - y[i];
      const V dz = cz - z[i];
      const V squared = dx * dx + dy * dy + dz * dz;
      least = squared < least ? squared : least;
      partsOf<V>(rows[i])[part] = squared;
    }
    partsOf<V>(nearest)[part] = least;
  }
}

template <typename V>
LAMAP_INLINED void lookUpBody(const double* table, size_t count, GpTile* rows)
{
  for (size_t i = 0; i < count; ++i)
  {
    for (double& entry : rows[i]) entry = table[static_cast<int32_t>(entry)];
  }
}

/// Replaces t ≥ 0 by portableExp(−t), to the last bit.
template <typename V>
LAMAP_INLINED void replaceByExpOfMinus(V& t)
{
  constexpr double kRounder = 0x1.8p52;
  constexpr double kFarthest = 708.0;
  const V bounded = t > kFarthest ? V{} - kFarthest : -t;
  const V shifted = bounded * 0x1.71547652b82fep+0 + kRounder;
  const V n = shifted - kRounder;
  const V r = (bounded - n * 0x1.62e42feep-1) - n * 0x1.a39ef35793c76p-33;
  V sum = V{} + 1.0 / 6227020800.0;
  for (const double term :
       {1.0 / 479001600.0, 1.0 / 39916800.0, 1.0 / 3628800.0, 1.0 / 362880.0, 1.0 / 40320.0, 1.0 / 5040.0,
        1.0 / 720.0, 1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0, 1.0})
    sum = sum * r + term;
  decltype(t < t) bits;
  std::memcpy(&bits, &shifted, sizeof(V));
  bits = (bits + 1023) << 52;
  V power;
  std::memcpy(&power, &bits, sizeof(V));
  t = t > kFarthest ? V{} : sum * power;
}

template <typename V>
LAMAP_INLINED void matern32Body(double factor, double scale, size_t count, GpTile* rows)
{
  double* numbers = rows->data();
  for (size_t i = 0; i < 8 * count; ++i) numbers[i] = factor * std::sqrt(numbers[i]);
  for (size_t i = 0; i < count; ++i)
  {
    for (int part = 0; part < Parts<V>::kCount; ++part)
    {
      V& entry = partsOf<V>(rows[i])[part];
      const V t = entry;
      V power = t;
      replaceByExpOfMinus<V>(power);
      entry = scale * ((1.0 + t) * power);
    }
  }
}

/// The rows first to first + kRows − 1, together, because they share the loaded values.
template <typename V, int kRows>
LAMAP_INLINED void solveRows(const double* factor, const double* inverse, size_t first, GpTile* rows)
{
  constexpr int kParts = Parts<V>::kCount;
  const double* l[kRows];
  V sums[kRows][kParts];
  for (int r = 0; r < kRows; ++r)
  {
    const size_t i = first + static_cast<size_t>(r);
    l[r] = factor + i * (i + 1) / 2;
    for (int part = 0; part < kParts; ++part) sums[r][part] = partsOf<V>(rows[i])[part];
  }
  for (size_t j = 0; j < first; ++j)
  {
    for (int part = 0; part < kParts; ++part)
    {
      const V solved = partsOf<V>(rows[j])[part];
      for (int r = 0; r < kRows; ++r) sums[r][part] -= l[r][j] * solved;
    }
  }
  for (int r = 0; r < kRows; ++r)
  {
    const size_t i = first + static_cast<size_t>(r);
    for (int part = 0; part < kParts; ++part)
    {
      for (int q = 0; q < r; ++q) sums[r][part] -= l[r][first + static_cast<size_t>(q)] * sums[q][part];
      sums[r][part] *= inverse[i];
      partsOf<V>(rows[i])[part] = sums[r][part];
    }
  }
}

template <typename V>
LAMAP_INLINED void solveForwardBody(const double* factor, const double* inverse, size_t count, GpTile* rows)
{
  constexpr int kRows = Parts<V>::kLanes;
  size_t i = 0;
  for (; i + kRows <= count; i += kRows) solveRows<V, kRows>(factor, inverse, i, rows);
  for (; i < count; ++i) solveRows<V, 1>(factor, inverse, i, rows);
}

template <typename V>
LAMAP_INLINED void subtractProductsBody(size_t count, const GpTile* rows, GpTile* square)
{
  constexpr int kParts = Parts<V>::kCount;
  constexpr size_t kRows = Parts<V>::kLanes;
  for (size_t first = 0; first < 8; first += kRows)
  {
    V sums[kRows][kParts];
    for (size_t r = 0; r < kRows; ++r)
      for (int part = 0; part < kParts; ++part) sums[r][part] = partsOf<V>(square[first + r])[part];
    for (size_t i = 0; i < count; ++i)
    {
      for (int part = 0; part < kParts; ++part)
      {
        const V column = partsOf<V>(rows[i])[part];
        for (size_t r = 0; r < kRows; ++r) sums[r][part] -= rows[i][first + r] * column;
      }
    }
    for (size_t r = 0; r < kRows; ++r)
      for (int part = 0; part < kParts; ++part) partsOf<V>(square[first + r])[part] = sums[r][part];
  }
}

template <typename V>
LAMAP_INLINED void sumRowsBody(const double* weights, size_t count, const GpTile* rows, GpTile& mean,
                               GpTile& squares)
{
  for (int part = 0; part < Parts<V>::kCount; ++part)
  {
    V sum{};
    V squared{};
    for (size_t i = 0; i < count; ++i)
    {
      const V v = partsOf<V>(rows[i])[part];
      sum += v * weights[i];
      squared += v * v;
    }
    partsOf<V>(mean)[part] = sum;
    partsOf<V>(squares)[part] = squared;
  }
}
}  // namespace

LAMAP_FOR_EACH_PROCESSOR(squaredDistances,
                         (const double* x, const double* y, const double* z, size_t count, const GpPlaces& to,
                          GpTile* rows, GpTile& nearest),
                         (x, y, z, count, to, rows, nearest))
LAMAP_FOR_EACH_PROCESSOR(lookUp, (const double* table, size_t count, GpTile* rows), (table, count, rows))
LAMAP_FOR_EACH_PROCESSOR(matern32, (double factor, double scale, size_t count, GpTile* rows),
                         (factor, scale, count, rows))
LAMAP_FOR_EACH_PROCESSOR(solveForward,
                         (const double* factor, const double* inverse, size_t count, GpTile* rows),
                         (factor, inverse, count, rows))
LAMAP_FOR_EACH_PROCESSOR(subtractProducts, (size_t count, const GpTile* rows, GpTile* square),
                         (count, rows, square))
LAMAP_FOR_EACH_PROCESSOR(sumRows,
                         (const double* weights, size_t count, const GpTile* rows, GpTile& mean,
                          GpTile& squares),
                         (weights, count, rows, mean, squares))

}  // namespace lamap
