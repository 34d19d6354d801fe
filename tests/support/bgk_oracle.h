#pragma once

#include <lamap_core/bgk/map.h>
#include <lamap_core/bgk/options.h>
#include <lamap_core/scan/ray_selection.h>
#include <lamap_core/scan/scan.h>
#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

/** BGK inference by brute force, written only from the thesis's equations and the options' definitions.
 *
 * Of the library, it uses only the types of options and scans: the contribution of every training point to
 * every cell around it is computed with the kernels' formulas as printed, and summed in long double.
 */
namespace lamap::test
{
/// The kernels as printed, with the C library's functions: thesis eq. (4.10), section 5.1, and Wendland
/// (1995).
double oracleKernel(KernelShape shape, double distance_m, double support_m, double scale);

/// A free line of thesis section 4.4, from P to Q [m].
struct FreeLine
{
  Eigen::Vector3d p_map;
  Eigen::Vector3d q_map;
  bool hasHit = true;  ///< behind its end

  /// Thesis eq. (4.30), (4.31), the parameter divided by |PQ|².
  [[nodiscard]] double distanceTo(const Eigen::Vector3d& point_map) const;
};

using Cell = std::array<int64_t, 3>;

/// A scan's training points [m]. In a planar map all have the height of the layer's middle.
struct TrainingSet
{
  std::vector<Eigen::Vector3d> hits_map;
  std::vector<Eigen::Vector3d> frees_map;
  std::vector<FreeLine> lines;
  std::map<Cell, uint32_t> rawHits;  ///< by cell
  RayCounts counts;
};

TrainingSet trainingSetOf(const Scan& scan, const BgkStructure& structure, const BgkInference& inference);

/// Evidence of a cell by brute force.
struct OracleEvidence
{
  double occupied = 0;
  double free = 0;
  /// Is a training point strictly within the support? `Maybe`: so close to its edge that rounding decides.
  enum class Reach : uint8_t
  {
    No,
    Maybe,
    Yes
  };
  Reach occupiedReach = Reach::No;
  Reach freeReach = Reach::No;
};

/// One scan's evidence in a box of cells that contains everything within the support.
class OracleField
{
 public:
  OracleField(const Scan& scan, const BgkStructure& structure, const BgkInference& inference);

  [[nodiscard]] const RayCounts& counts() const { return training_.counts; }
  [[nodiscard]] const TrainingSet& training() const { return training_; }
  [[nodiscard]] const Cell& first() const { return first_; }
  [[nodiscard]] const Cell& last() const { return last_; }
  [[nodiscard]] OracleEvidence at(const Cell& cell) const;

 private:
  struct Sums
  {
    long double occupied = 0;
    long double free = 0;
    OracleEvidence::Reach occupiedReach = OracleEvidence::Reach::No;
    OracleEvidence::Reach freeReach = OracleEvidence::Reach::No;
  };
  [[nodiscard]] Eigen::Vector3d centreOf(const Cell& cell) const;
  [[nodiscard]] Sums& sumsAt(const Cell& cell);
  void keepUnseenSpace(double freeWeight);
  template <typename Distance>
  void weigh(const Eigen::Vector3d& low_map, const Eigen::Vector3d& high_map, double weight, bool occupied,
             const Distance& distance);

  TrainingSet training_;
  double resolution_;
  bool planar_;
  int64_t layer_ = 0;
  KernelShape kernel_;
  double support_;
  double scale_;
  Cell first_{};
  Cell last_{-1, -1, -1};
  std::vector<Sums> sums_;
};

/// How a map differs from the oracle.
struct Comparison
{
  std::string firstDifference;  ///< empty: the map agrees
  double worstDeviation = 0;    ///< of a count [pseudo-counts], over all scans
  double worstRounding = 0;     ///< the same of counts above one unit, for a single scan
  size_t cells = 0;             ///< with evidence

  [[nodiscard]] bool agrees() const { return firstDifference.empty(); }
};

/** Compares every cell of the map with the sum of the scans' fields: values within 1e-6 per scan, evidence
 * exactly where the oracle has a training point within the support, α and β with the map's prior. */
Comparison compare(const BgkMap& map, const std::vector<OracleField>& scans);

}  // namespace lamap::test
