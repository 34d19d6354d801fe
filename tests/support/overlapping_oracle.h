#pragma once

#include <lamap_core/overlapping/map.h>
#include <support/posed_scans.h>

#include <vector>

namespace lamap::test
{
/** What overlapping maps should say of a point, from the equations alone: eq. 3.1 in log-odds, a sum over all
 * kernels of a model, boxes and fields from the scans' rays; nothing is cut short, sorted or kept in blocks.
 *
 * Of the library it takes the weights of each model (trainers have their own tests) and the training points
 * that its box is drawn around. */
class OverlappingOracle
{
 public:
  OverlappingOracle(const OverlappingStructure& structure, const OverlappingInference& inference)
      : structure_(structure), inference_(inference)
  {
  }

  /// The scans that one model was trained on together.
  void addModel(const HilbertModel& model, const std::vector<Scan>& scans);

  struct Answer
  {
    bool inField = false;
    bool outOfField = false;
    double logodds = 0;
    /// So near to a face of a box, an edge of a field or the end of all kernels that rounding decides.
    bool doubtful = false;
    [[nodiscard]] bool any() const { return inField || outOfField; }
  };
  [[nodiscard]] Answer at(const Eigen::Vector3d& point_map) const;

 private:
  struct Kernel
  {
    Eigen::Vector3d centre;
    double weight;
  };
  struct Sensor
  {
    Eigen::Vector3d origin;
    double rangeMax_m;
    std::vector<Eigen::Vector3d> rays;
  };
  struct Model
  {
    Eigen::Isometry3d pose;
    std::vector<Kernel> kernels;
    double bias;
    Eigen::Vector3d low, high;
    std::vector<Sensor> sensors;
    std::vector<Eigen::Vector3d> hits_map;
  };
  [[nodiscard]] bool isHit(const Model& model, const Eigen::Vector3d& point_map, bool& doubtful) const;
  struct Seen
  {
    bool inField = false;
    bool open = false;
  };
  [[nodiscard]] Seen lookAt(const Model& model, const Eigen::Vector3d& p, bool& doubtful) const;

  OverlappingStructure structure_;
  OverlappingInference inference_;
  std::vector<Model> models_;
};

}  // namespace lamap::test
