#include <lamap_core/overlapping/model_index.h>

#include <nanoflann.hpp>

#include <algorithm>
#include <tuple>

namespace lamap
{
namespace
{
/// The data set interface that nanoflann expects.
struct Centres
{
  std::vector<Eigen::Vector3d> points;

  [[nodiscard]] size_t kdtree_get_point_count() const { return points.size(); }
  [[nodiscard]] double kdtree_get_pt(size_t index, size_t axis) const
  {
    return points[index][static_cast<int>(axis)];
  }
  template <typename Box>
  bool kdtree_get_bbox(Box& /*box*/) const
  {
    return false;
  }
};

bool isBefore(const CellIndex& a, const CellIndex& b)
{
  return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
}

/// Passes each point found to a visitor, instead of collecting them.
class Visitor
{
 public:
  using DistanceType = double;
  Visitor(double radius_m, const std::function<void(size_t)>& visit)
      : squaredRadius_(radius_m * radius_m), visit_(visit)
  {
  }
  [[nodiscard]] static bool full() { return true; }
  bool addPoint(double squaredDistance, size_t index)
  {
    if (squaredDistance < squaredRadius_) visit_(index);
    return true;
  }
  [[nodiscard]] double worstDist() const { return squaredRadius_; }

 private:
  double squaredRadius_;
  const std::function<void(size_t)>& visit_;
};

}  // namespace

struct HilbertModelIndex::Tree
{
  using KdTree =
      nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Centres>, Centres, 3, size_t>;
  Centres centres;
  double radius_m = 0;
  bool planar = false;
  std::unique_ptr<KdTree> kdTree;
  std::vector<std::vector<CellIndex>> hitCells;  ///< of each model, sorted
};

HilbertModelIndex::HilbertModelIndex(const std::vector<PlacedModel>& models, const ModelShape& shape,
                                     int32_t layer)
    : tree_(std::make_unique<Tree>())
{
  tree_->planar = shape.planar;
  double radius_m = 0;
  for (const auto& [pose, model] : models)
  {
    Eigen::Vector3d centre = 0.5 * (model->boxLow + model->boxHigh);
    Eigen::Vector3d half = 0.5 * (model->boxHigh - model->boxLow);
    if (shape.planar) half.z() = centre.z() = 0;
    radius_m = std::max(radius_m, half.norm());
    centre = pose.isometry(shape.resolution_m) * centre;
    if (shape.planar) centre.z() = 0;
    tree_->centres.points.push_back(centre);
    std::vector<CellIndex>& hits = tree_->hitCells.emplace_back();
    for (const std::optional<CellIndex>& cell : model->hitCells(pose, shape, layer))
      if (cell) hits.push_back(*cell);
    std::sort(hits.begin(), hits.end(), isBefore);
  }
  // Far from the map's origin, rounding may be as large as a millimetre.
  tree_->radius_m = radius_m * (1 + 1e-6) + 1e-3;
  if (!models.empty()) tree_->kdTree = std::make_unique<Tree::KdTree>(3, tree_->centres);
  if (tree_->kdTree) tree_->kdTree->buildIndex();
}

HilbertModelIndex::~HilbertModelIndex() = default;

bool HilbertModelIndex::isHit(size_t model, const CellIndex& cell) const
{
  const std::vector<CellIndex>& hits = tree_->hitCells[model];
  return std::binary_search(hits.begin(), hits.end(), cell, isBefore);
}

void HilbertModelIndex::forEachNear(const Eigen::Vector3d& point_map,
                                    const std::function<void(size_t)>& visit) const
{
  if (!tree_->kdTree) return;
  Eigen::Vector3d point = point_map;
  if (tree_->planar) point.z() = 0;
  Visitor visitor(tree_->radius_m, visit);
  tree_->kdTree->findNeighbors(visitor, point.data(), nanoflann::SearchParams());
}

}  // namespace lamap
