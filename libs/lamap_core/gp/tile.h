#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace lamap
{
// The loops in which a GP map spends its time, for eight cells at a time. On x86-64 they are compiled with
// and without AVX2 and chosen at run time: the same operations in the same order, so the same bits.

/// One number for each of eight cells.
using GpTile = std::array<double, 8>;

/// Positions of eight cells, or of training points.
struct GpPlaces
{
  GpTile x, y, z;
};

/** rows[i][c] = |point i − cell c|², for training points in three arrays.
 * @param nearest receives the minimum for each c */
void squaredDistances(const double* x, const double* y, const double* z, size_t count, const GpPlaces& to,
                      GpTile* rows, GpTile& nearest);

/// Replaces squared distances, which are whole numbers, by their entries in a table.
void lookUp(const double* table, size_t count, GpTile* rows);

/// Replaces squared distances d² by scale·(1 + t)·e^−t, t = factor·d.
void matern32(double factor, double scale, size_t count, GpTile* rows);

/** Forward substitution: replaces rows by L⁻¹·rows.
 * @param factor L by rows, packed: i + 1 numbers in row i; @param inverse 1/L_ii */
void solveForward(const double* factor, const double* inverse, size_t count, GpTile* rows);

/// square[r][c] −= Σ rows[i][r]·rows[i][c], for eight rows of `square`.
void subtractProducts(size_t count, const GpTile* rows, GpTile* square);

/// mean[c] = Σ rows[i][c]·weights[i], squares[c] = Σ rows[i][c]².
void sumRows(const double* weights, size_t count, const GpTile* rows, GpTile& mean, GpTile& squares);

}  // namespace lamap
