#pragma once

#include <lamap_core/overlapping/model.h>

#include <functional>
#include <memory>
#include <vector>

namespace lamap
{
/// A model and its pose. Models never change, so copies of a map share them.
struct PlacedModel
{
  ModelPose pose;
  std::shared_ptr<const HilbertModel> model;
};

/** Finds the models whose box may contain a point: a k-d tree over the centres of their boxes.
 *
 * Immutable: may be shared between threads. */
class HilbertModelIndex
{
 public:
  /// @param layer of the cells of a planar map
  HilbertModelIndex(const std::vector<PlacedModel>& models, const ModelShape& shape, int32_t layer);
  ~HilbertModelIndex();

  /** Calls visit(number of a model) for all models whose box contains the point, and for others near it, in
   * unspecified order. Allocates nothing. */
  void forEachNear(const Eigen::Vector3d& point_map, const std::function<void(size_t)>& visit) const;

  /// Whether one of the hits that a model keeps lies in a cell of the map.
  [[nodiscard]] bool isHit(size_t model, const CellIndex& cell) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace lamap
