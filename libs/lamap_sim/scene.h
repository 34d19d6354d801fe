#pragma once

#include <lamap_sim/shapes.h>

#include <vector>

namespace lamap::sim
{
/** Solids that may overlap; space in none of them is open.
 *
 * Immutable: may be shared between threads. Queries visit only nearby shapes (a tree of bounding boxes).
 */
class Scene
{
 public:
  Scene() = default;
  explicit Scene(std::vector<Shape> shapes);

  [[nodiscard]] const std::vector<Shape>& shapes() const { return shapes_; }

  /// The first surface within a range along a ray that starts in open space.
  /// @param direction_map  of length 1
  [[nodiscard]] std::optional<SurfaceHit> firstHit(const Eigen::Vector3d& origin_map,
                                                   const Eigen::Vector3d& direction_map,
                                                   double rangeMax_m) const;

  /** Where a line crosses the surface of the union of all solids, sorted: distances [m] from its origin, in
   * [0, length]. */
  [[nodiscard]] std::vector<double> crossings(const Eigen::Vector3d& origin_map,
                                              const Eigen::Vector3d& direction_map, double length_m) const;

  [[nodiscard]] bool solidAt(const Eigen::Vector3d& point_map) const;

  /** How a cell lies relative to the union of all solids. Outside and Inside are never wrong. A cell that
   * only several solids together fill is recognized if each of its parts, after halving it `splits` times
   * along each axis, lies in one of them. */
  [[nodiscard]] Relation relationOf(const Eigen::AlignedBox3d& cell_map, int splits = 3) const;

 private:
  /// The bounding box of shapes first .. last-1 of order_; its children are the next node and `second`.
  struct Node
  {
    Eigen::AlignedBox3d bounds;
    size_t first = 0;
    size_t last = 0;
    size_t second = 0;  ///< 0: a leaf
  };

  size_t addNode(size_t first, size_t last);
  /// Calls visit(shape) for all shapes whose enclosing boxes satisfy near(box), until visit returns false.
  template <class Near, class Visit>
  void visitNear(const Near& near, const Visit& visit) const;

  std::vector<Shape> shapes_;
  std::vector<Eigen::AlignedBox3d> bounds_;  ///< of shapes_
  std::vector<size_t> order_;                ///< of the bounded shapes, by leaf
  std::vector<size_t> unbounded_;
  std::vector<Node> nodes_;
};

}  // namespace lamap::sim
