#pragma once

#include <lamap_core/gp/map.h>
#include <support/bgk_oracle.h>

#include <Eigen/Core>
#include <map>
#include <set>
#include <string>
#include <vector>

/** Gaussian process occupancy maps by dense algebra, written only from the thesis's equations and the
 * options' definitions: matrices are inverted by Gaussian elimination in long double, and no factor is
 * shared. */
namespace lamap::test
{
/// Thesis eq. (2.24).
long double oracleMatern(long double distance_m, double lengthScale_m, double signalVariance);

/// Labelled points [m]: 1 occupied, −1 free.
struct OraclePoints
{
  std::vector<Eigen::Vector3d> places_map;
  std::vector<double> labels;

  void add(const Eigen::Vector3d& place_map, double label)
  {
    places_map.push_back(place_map);
    labels.push_back(label);
  }
};

/// A plain GP on all points, thesis eq. (2.22), (2.23).
class OracleGp
{
 public:
  OracleGp(OraclePoints points, double lengthScale_m, double signalVariance, double noiseVariance);

  struct Normal
  {
    long double mean;
    long double variance;
  };
  [[nodiscard]] Normal at(const Eigen::Vector3d& place_map) const;
  /// Distance to the nearest training point [m].
  [[nodiscard]] double distanceTo(const Eigen::Vector3d& place_map) const;

 private:
  using Matrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
  using Vector = Eigen::Matrix<long double, Eigen::Dynamic, 1>;
  OraclePoints points_;
  double lengthScale_;
  double signalVariance_;
  Matrix inverse_;
  Vector labels_;
};

/// Cells in which rays ended, of a scan whose hits are protected: a GP map says at least of them what a GP
/// says that knows three hits at their centre.
std::set<Cell> gpHitCellsOf(const Scan& scan, const GpStructure& structure, const GpInference& inference);

/// A scan's training points for a GP map. In a planar map all have the height of the layer's middle.
OraclePoints gpTrainingSetOf(const Scan& scan, const GpStructure& structure, const GpInference& inference);

/// Sums of one scan in one cell.
struct GpSums
{
  long double precision = 0;  ///< Σ(1/σ² − 1/σ_f²)
  long double weighted = 0;   ///< Σ μ/σ²
  /// Whether a training point is strictly within the support, or so close to its edge that rounding decides.
  bool reached = false;
  bool undecided = false;
};

/// One scan's sums for all cells that may be reached, block by block, for options whose maxPoints is not
/// reached.
std::map<Cell, GpSums> gpSumsOf(const Scan& scan, const GpStructure& structure, const GpInference& inference);

/// Compares every cell of a map of these scans (GpFusion::Bcm): sums within 1e-6 per scan, evidence exactly
/// where the oracle has some. @return empty if the map agrees
std::string differenceFromOracle(const GpMap& map, const std::vector<Scan>& scans,
                                 const GpInference& inference);

}  // namespace lamap::test
