#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>

namespace lamap
{
/// Index of a finest cell. Cell i covers [i·r, (i+1)·r) along each axis; its centre is at (i + 1/2)·r.
struct CellIndex
{
  int32_t x = 0;
  int32_t y = 0;
  int32_t z = 0;

  friend bool operator==(const CellIndex& a, const CellIndex& b)
  {
    return a.x == b.x && a.y == b.y && a.z == b.z;
  }
  friend bool operator!=(const CellIndex& a, const CellIndex& b) { return !(a == b); }
};

/// Thesis eq. (4.9).
enum class CellState : uint8_t
{
  Unknown = 0,
  Free = 1,
  Occupied = 2
};

/// What a map says of one finest cell that has evidence.
struct CellEstimate
{
  double prob = 0.5;               ///< P(occupied), in [0, 1]
  std::optional<double> variance;  ///< of the estimate of prob, where the learner gives one
  CellState state = CellState::Unknown;
  /// The learner's own quantities, in the order of its evidence names (BGK: alpha, beta with the prior
  /// included).
  std::array<double, 2> evidence{};
};

/// No cell of a map has an index beyond ±this: what evidence reaches from the last cells that points are
/// found in, with room for neighbours.
constexpr int32_t kLastCell = 2'145'000'000;

/// The cell along an axis that holds a coordinate [cells], held to what cells can have; 0 for NaN.
[[nodiscard]] int32_t heldCell(double coordinate);

/// Centre of a cell [m].
[[nodiscard]] Eigen::Vector3d cellCentre(const CellIndex& cell, double resolution_m);

/// The cell that holds a point [m]; nothing where the point is not finite or beyond the range of the index.
[[nodiscard]] std::optional<CellIndex> cellAt(const Eigen::Vector3d& point_m, double resolution_m);

}  // namespace lamap
