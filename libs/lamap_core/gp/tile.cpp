#include <lamap_core/gp/tile.h>

#include <lamap_core/math/exponential.h>
#include <lamap_core/math/registers.h>

#include <cmath>

namespace lamap
{
namespace
{
/// A tile in registers' worth of numbers. @tparam R Registers
template <typename R>
struct Parts
{
  static constexpr int kLanes = R::kDoubles;
  static constexpr int kCount = 8 / kLanes;
  using V = typename Vector<double, kLanes>::Numbers;

  // Tiles are aligned as doubles are, which is less than vectors expect.
  static LAMAP_INLINED void load(const GpTile& tile, int part, V& to)
  {
    Vector<double, kLanes>::load(tile.data() + part * kLanes, to);
  }
  static LAMAP_INLINED void store(const V& from, int part, GpTile& tile)
  {
    Vector<double, kLanes>::store(from, tile.data() + part * kLanes);
  }
};

template <typename R>
LAMAP_INLINED void squaredDistancesBody(const double* x, const double* y, const double* z, size_t count,
                                        const GpPlaces& to, GpTile* rows, GpTile& nearest)
{
  using V = typename Parts<R>::V;
  for (int part = 0; part < Parts<R>::kCount; ++part)
  {
    V cx;
    Parts<R>::load(to.x, part, cx);
    V cy;
    Parts<R>::load(to.y, part, cy);
    V cz;
    Parts<R>::load(to.z, part, cz);
    V least = V{} + 1e300;
    for (size_t i = 0; i < count; ++i)
    {
      const V dx = cx - x[i];
      const V dy = cy - y[i];
      const V dz = cz - z[i];
      const V squared = dx * dx + dy * dy + dz * dz;
      least = squared < least ? squared : least;
      Parts<R>::store(squared, part, rows[i]);
    }
    Parts<R>::store(least, part, nearest);
  }
}

LAMAP_INLINED void lookUpBody(const double* table, size_t count, GpTile* rows)
{
  for (size_t i = 0; i < count; ++i)
  {
    for (double& entry : rows[i]) entry = table[static_cast<int32_t>(entry)];
  }
}

/// Replaces t ≥ 0 by portableExp(−t), to the last bit.
template <typename R>
LAMAP_INLINED void replaceByExpOfMinus(typename Parts<R>::V& t)
{
  using V = typename Parts<R>::V;
  constexpr double kFarthest = -Exponential<double>::kLowest;
  V power = t > kFarthest ? V{} - kFarthest : -t;
  replaceByExp<double, V>(power);
  t = t > kFarthest ? V{} : power;
}

template <typename R>
LAMAP_INLINED void matern32Body(double factor, double scale, size_t count, GpTile* rows)
{
  using V = typename Parts<R>::V;
  double* numbers = rows->data();
  for (size_t i = 0; i < 8 * count; ++i) numbers[i] = factor * std::sqrt(numbers[i]);
  for (size_t i = 0; i < count; ++i)
  {
    for (int part = 0; part < Parts<R>::kCount; ++part)
    {
      V t;
      Parts<R>::load(rows[i], part, t);
      V power = t;
      replaceByExpOfMinus<R>(power);
      Parts<R>::store(scale * ((1.0 + t) * power), part, rows[i]);
    }
  }
}

/// The rows first to first + kRows − 1, together, because they share the loaded values.
template <typename R, int kRows>
LAMAP_INLINED void solveRows(const double* factor, const double* inverse, size_t first, GpTile* rows)
{
  using V = typename Parts<R>::V;
  constexpr int kParts = Parts<R>::kCount;
  const double* l[kRows];
  V sums[kRows][kParts];
  for (int r = 0; r < kRows; ++r)
  {
    const size_t i = first + static_cast<size_t>(r);
    l[r] = factor + i * (i + 1) / 2;
    for (int part = 0; part < kParts; ++part) Parts<R>::load(rows[i], part, sums[r][part]);
  }
  for (size_t j = 0; j < first; ++j)
  {
    for (int part = 0; part < kParts; ++part)
    {
      V solved;
      Parts<R>::load(rows[j], part, solved);
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
      Parts<R>::store(sums[r][part], part, rows[i]);
    }
  }
}

template <typename R>
LAMAP_INLINED void solveForwardBody(const double* factor, const double* inverse, size_t count, GpTile* rows)
{
  constexpr int kRows = Parts<R>::kLanes;
  size_t i = 0;
  for (; i + kRows <= count; i += kRows) solveRows<R, kRows>(factor, inverse, i, rows);
  for (; i < count; ++i) solveRows<R, 1>(factor, inverse, i, rows);
}

template <typename R>
LAMAP_INLINED void subtractProductsBody(size_t count, const GpTile* rows, GpTile* square)
{
  using V = typename Parts<R>::V;
  constexpr int kParts = Parts<R>::kCount;
  constexpr size_t kRows = Parts<R>::kLanes;
  for (size_t first = 0; first < 8; first += kRows)
  {
    V sums[kRows][kParts];
    for (size_t r = 0; r < kRows; ++r)
      for (int part = 0; part < kParts; ++part) Parts<R>::load(square[first + r], part, sums[r][part]);
    for (size_t i = 0; i < count; ++i)
    {
      for (int part = 0; part < kParts; ++part)
      {
        V column;
        Parts<R>::load(rows[i], part, column);
        for (size_t r = 0; r < kRows; ++r) sums[r][part] -= rows[i][first + r] * column;
      }
    }
    for (size_t r = 0; r < kRows; ++r)
      for (int part = 0; part < kParts; ++part) Parts<R>::store(sums[r][part], part, square[first + r]);
  }
}

template <typename R>
LAMAP_INLINED void sumRowsBody(const double* weights, size_t count, const GpTile* rows, GpTile& mean,
                               GpTile& squares)
{
  using V = typename Parts<R>::V;
  for (int part = 0; part < Parts<R>::kCount; ++part)
  {
    V sum{};
    V squared{};
    for (size_t i = 0; i < count; ++i)
    {
      V v;
      Parts<R>::load(rows[i], part, v);
      sum += v * weights[i];
      squared += v * v;
    }
    Parts<R>::store(sum, part, mean);
    Parts<R>::store(squared, part, squares);
  }
}
}  // namespace

void squaredDistances(const double* x, const double* y, const double* z, size_t count, const GpPlaces& to,
                      GpTile* rows, GpTile& nearest)
{
  withRegisters([&](auto r) LAMAP_INLINED_LAMBDA
                { squaredDistancesBody<decltype(r)>(x, y, z, count, to, rows, nearest); });
}

void lookUp(const double* table, size_t count, GpTile* rows)
{
  withRegisters([&](auto /*r*/) LAMAP_INLINED_LAMBDA { lookUpBody(table, count, rows); });
}

void matern32(double factor, double scale, size_t count, GpTile* rows)
{
  withRegisters([&](auto r) LAMAP_INLINED_LAMBDA { matern32Body<decltype(r)>(factor, scale, count, rows); });
}

void solveForward(const double* factor, const double* inverse, size_t count, GpTile* rows)
{
  withRegisters([&](auto r) LAMAP_INLINED_LAMBDA
                { solveForwardBody<decltype(r)>(factor, inverse, count, rows); });
}

void subtractProducts(size_t count, const GpTile* rows, GpTile* square)
{
  withRegisters([&](auto r) LAMAP_INLINED_LAMBDA { subtractProductsBody<decltype(r)>(count, rows, square); });
}

void sumRows(const double* weights, size_t count, const GpTile* rows, GpTile& mean, GpTile& squares)
{
  withRegisters([&](auto r) LAMAP_INLINED_LAMBDA
                { sumRowsBody<decltype(r)>(weights, count, rows, mean, squares); });
}

}  // namespace lamap
