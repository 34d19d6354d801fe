#include <lamap_sim/scene.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace lamap::sim
{
namespace
{
using Eigen::AlignedBox3d;
using Eigen::Vector3d;

/// Whether a ray may meet a box within a range. Boxes are slightly enlarged, so that rounding can only add
/// meetings, never miss one.
bool mayMeet(const AlignedBox3d& box, const Vector3d& origin, const Vector3d& direction, double rangeMax_m)
{
  double enter = 0;
  double leave = rangeMax_m;
  for (int axis = 0; axis < 3; ++axis)
  {
    if (direction[axis] == 0)
    {
      if (origin[axis] < box.min()[axis] || origin[axis] > box.max()[axis]) return false;
      continue;
    }
    const double a = (box.min()[axis] - origin[axis]) / direction[axis];
    const double b = (box.max()[axis] - origin[axis]) / direction[axis];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return enter <= leave;
}

AlignedBox3d octantOf(const AlignedBox3d& cell, int octant)
{
  const Vector3d middle = (cell.min() + cell.max()) / 2;
  AlignedBox3d part = cell;
  for (int axis = 0; axis < 3; ++axis)
    ((octant >> axis & 1) != 0 ? part.min() : part.max())[axis] = middle[axis];
  return part;
}

/// Whether the shapes together fill a cell, as far as halving it can show.
bool fill(const AlignedBox3d& cell, const std::vector<const Shape*>& shapes, int splits)
{
  std::vector<const Shape*> near;
  for (const Shape* shape : shapes)
  {
    const Relation relation = relationOf(cell, *shape);
    if (relation == Relation::Inside) return true;
    if (relation == Relation::Mixed) near.push_back(shape);
  }
  if (near.size() < 2 || splits == 0) return false;
  for (int octant = 0; octant < 8; ++octant)
    if (!fill(octantOf(cell, octant), near, splits - 1)) return false;
  return true;
}
}  // namespace

Scene::Scene(std::vector<Shape> shapes) : shapes_(std::move(shapes))
{
  constexpr double kSlack_m = 1e-6;
  for (size_t i = 0; i < shapes_.size(); ++i)
  {
    AlignedBox3d bounds = boundsOf(shapes_[i]);
    const bool bounded = bounds.sizes().array().isFinite().all();
    (bounded ? order_ : unbounded_).push_back(i);
    bounds.min().array() -= kSlack_m;
    bounds.max().array() += kSlack_m;
    bounds_.push_back(bounds);
  }
  if (!order_.empty()) addNode(0, order_.size());
}

size_t Scene::addNode(size_t first, size_t last)
{
  const size_t index = nodes_.size();
  nodes_.push_back({AlignedBox3d(), first, last, 0});
  AlignedBox3d bounds;
  for (size_t i = first; i < last; ++i) bounds.extend(bounds_[order_[i]]);
  nodes_[index].bounds = bounds;
  constexpr size_t kLeafSize = 2;
  if (last - first <= kLeafSize) return index;

  int axis = 0;
  bounds.sizes().maxCoeff(&axis);
  const auto middleOf = [&](size_t shape) { return bounds_[shape].min()[axis] + bounds_[shape].max()[axis]; };
  std::stable_sort(order_.begin() + static_cast<long>(first), order_.begin() + static_cast<long>(last),
                   [&](size_t a, size_t b) { return middleOf(a) < middleOf(b); });
  const size_t middle = (first + last) / 2;
  addNode(first, middle);
  const size_t second = addNode(middle, last);
  nodes_[index].second = second;
  return index;
}

template <class Near, class Visit>
void Scene::visitNear(const Near& near, const Visit& visit) const
{
  for (const size_t shape : unbounded_)
    if (!visit(shapes_[shape])) return;
  if (nodes_.empty()) return;
  constexpr size_t kDeepest = 64;
  std::array<size_t, kDeepest> waiting{};
  size_t count = 0;
  waiting[count++] = 0;
  while (count > 0)
  {
    const size_t index = waiting[--count];
    const Node& node = nodes_[index];
    if (!near(node.bounds)) continue;
    if (node.second != 0)
    {
      waiting[count++] = node.second;
      waiting[count++] = index + 1;
      continue;
    }
    for (size_t i = node.first; i < node.last; ++i)
      if (near(bounds_[order_[i]]) && !visit(shapes_[order_[i]])) return;
  }
}

std::optional<SurfaceHit> Scene::firstHit(const Vector3d& origin_map, const Vector3d& direction_map,
                                          double rangeMax_m) const
{
  std::optional<SurfaceHit> nearest;
  double range = rangeMax_m;
  visitNear([&](const AlignedBox3d& box) { return mayMeet(box, origin_map, direction_map, range); },
            [&](const Shape& shape)
            {
              const auto hit = sim::firstHit(shape, origin_map, direction_map);
              if (hit && hit->range_m <= range)
              {
                nearest = hit;
                range = hit->range_m;
              }
              return true;
            });
  return nearest;
}

std::vector<double> Scene::crossings(const Vector3d& origin_map, const Vector3d& direction_map,
                                     double length_m) const
{
  std::vector<std::pair<double, double>> parts;
  visitNear([&](const AlignedBox3d& box) { return mayMeet(box, origin_map, direction_map, length_m); },
            [&](const Shape& shape)
            {
              if (const auto part = partInside(shape, origin_map, direction_map)) parts.push_back(*part);
              return true;
            });
  std::sort(parts.begin(), parts.end());
  constexpr double kTouching_m = 1e-9;  // solids that share a face, up to rounding
  std::vector<double> ends;
  for (size_t i = 0; i < parts.size();)
  {
    const double enter = parts[i].first;
    double leave = parts[i].second;
    for (++i; i < parts.size() && parts[i].first <= leave + kTouching_m; ++i)
      leave = std::max(leave, parts[i].second);
    for (const double end : {enter, leave})
      if (end >= 0 && end <= length_m) ends.push_back(end);
  }
  return ends;
}

bool Scene::solidAt(const Vector3d& point_map) const
{
  bool solid = false;
  visitNear([&](const AlignedBox3d& box) { return box.contains(point_map); },
            [&](const Shape& shape)
            {
              solid = contains(shape, point_map);
              return !solid;
            });
  return solid;
}

Relation Scene::relationOf(const AlignedBox3d& cell_map, int splits) const
{
  std::vector<const Shape*> near;
  bool inside = false;
  visitNear([&](const AlignedBox3d& box) { return box.intersects(cell_map); },
            [&](const Shape& shape)
            {
              const Relation relation = sim::relationOf(cell_map, shape);
              inside = relation == Relation::Inside;
              if (relation == Relation::Mixed) near.push_back(&shape);
              return !inside;
            });
  if (inside) return Relation::Inside;
  if (near.empty()) return Relation::Outside;
  return fill(cell_map, near, splits) ? Relation::Inside : Relation::Mixed;
}

}  // namespace lamap::sim
