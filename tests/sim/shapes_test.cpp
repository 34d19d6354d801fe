#include <gtest/gtest.h>
#include <lamap_sim/random.h>
#include <lamap_sim/scene.h>

#include <cmath>

namespace lamap::sim
{
namespace
{
using Eigen::AlignedBox3d;
using Eigen::Vector3d;

Vector3d inBox(Random& random, const AlignedBox3d& box)
{
  const double x = random.uniform(box.min().x(), box.max().x());
  const double y = random.uniform(box.min().y(), box.max().y());
  return {x, y, random.uniform(box.min().z(), box.max().z())};
}

AlignedBox3d cube(double halfEdge)
{
  return {Vector3d::Constant(-halfEdge), Vector3d::Constant(halfEdge)};
}

Vector3d randomDirection(Random& random)
{
  for (;;)
  {
    const Vector3d v = inBox(random, cube(1));
    if (v.norm() > 0.1 && v.norm() <= 1) return v.normalized();
  }
}

/// One shape of each kind, of random size, near the origin.
Shape randomShape(Random& random, int kind)
{
  const Vector3d centre = inBox(random, cube(0.5));
  const Vector3d size{random.uniform(0.2, 1), random.uniform(0.2, 1), random.uniform(0.2, 1)};
  switch (kind)
  {
    case 0:
    {
      Box box = boxBetween(centre - size, centre + size);
      const SineCosine turn = sineCosine(random.uniform(-4, 4));
      box.cosine = turn.cosine;
      box.sine = turn.sine;
      return box;
    }
    case 1:
      return boxBetween(centre - size, centre + size);
    case 2:
      return Cylinder{centre.head<2>(), size.x(), centre.z() - size.z(), centre.z() + size.z()};
    case 3:
      return Ellipsoid{centre, size};
    default:
      return HalfSpace{randomDirection(random), random.uniform(-1, 1)};
  }
}
constexpr int kKinds = 5;

/// The first of many small steps along a ray that lies in a solid; empty if none within the range does.
template <class Solid>
std::optional<double> firstStepInside(const Solid& solidAt, const Vector3d& origin, const Vector3d& direction,
                                      double rangeMax_m, double step_m)
{
  for (double range = 0; range <= rangeMax_m; range += step_m)
    if (solidAt(origin + range * direction)) return range;
  return std::nullopt;
}

TEST(Shapes, RaysMeetThemWhereSmallStepsDo)
{
  Random random(11);
  constexpr double kStep = 0.002;
  int hits = 0;
  for (int i = 0; i < 1500; ++i)
  {
    SCOPED_TRACE(i);
    const Shape shape = randomShape(random, i % kKinds);
    const Vector3d origin = inBox(random, cube(2.5));
    const Vector3d direction = (inBox(random, cube(1)) - origin).normalized();
    if (contains(shape, origin)) continue;
    const auto hit = firstHit(shape, origin, direction);
    const auto stepped =
        firstStepInside([&](const Vector3d& p) { return contains(shape, p); }, origin, direction, 6, kStep);
    if (stepped)
    {
      ++hits;
      ASSERT_TRUE(hit);
      EXPECT_LE(hit->range_m, *stepped + 1e-9);
      // Between two earlier steps, the ray may have crossed a corner.
      if (hit->range_m < *stepped - kStep - 1e-9)
      {
        EXPECT_FALSE(contains(shape, origin + (hit->range_m + kStep) * direction));
      }
    }
    if (!hit || hit->range_m > 5) continue;
    const Vector3d place = origin + hit->range_m * direction;
    EXPECT_FALSE(contains(shape, place + 1e-6 * hit->normal_map));
    EXPECT_NEAR(hit->normal_map.norm(), 1, 1e-12);
    EXPECT_LT(hit->normal_map.dot(direction), 1e-12);
    if (hit->normal_map.dot(direction) < -0.05)
    {
      EXPECT_TRUE(contains(shape, place + 1e-6 * direction)) << "kind " << i % kKinds;
    }
  }
  EXPECT_GT(hits, 500);
}

TEST(Shapes, ARayThatStartsInsideHitsAtOnceAndOneThatLooksAwayNever)
{
  const Shape ball = Ellipsoid{Vector3d::Zero(), Vector3d::Ones()};
  EXPECT_EQ(firstHit(ball, Vector3d(0.5, 0, 0), Vector3d::UnitX())->range_m, 0);
  EXPECT_FALSE(firstHit(ball, Vector3d(2, 0, 0), Vector3d::UnitX()));
  EXPECT_EQ(firstHit(ball, Vector3d(-3, 0, 0), Vector3d::UnitX())->range_m, 2);
  const Shape floor = HalfSpace{Vector3d::UnitZ(), 0};
  EXPECT_FALSE(firstHit(floor, Vector3d(0, 0, 1), Vector3d::UnitX()));
  EXPECT_EQ(firstHit(floor, Vector3d(0, 0, 1), -Vector3d::UnitZ())->range_m, 1);
  const Shape block = boxBetween({0, 0, 0}, {1, 1, 1});
  EXPECT_FALSE(firstHit(block, Vector3d(-1, 2, 0.5), Vector3d::UnitX()));
  EXPECT_EQ(firstHit(block, Vector3d(-1, 0.5, 0.5), Vector3d::UnitX())->range_m, 1);
}

/// Whether any, and whether all, of the sample points of a box (its corners and a grid between them) are
/// solid.
template <class Solid>
Relation sampledRelation(const Solid& solidAt, const AlignedBox3d& box)
{
  constexpr int kSteps = 14;
  bool any = false;
  bool all = true;
  for (int i = 0; i <= kSteps; ++i)
    for (int j = 0; j <= kSteps; ++j)
      for (int k = 0; k <= kSteps; ++k)
      {
        const Vector3d share(i, j, k);
        const bool solid = solidAt(box.min() + share.cwiseProduct(box.sizes()) / kSteps);
        any = any || solid;
        all = all && solid;
      }
  return all ? Relation::Inside : any ? Relation::Mixed : Relation::Outside;
}

TEST(Shapes, RelationToACellAgreesWithItsPoints)
{
  Random random(12);
  std::array<int, 3> seen{};
  for (int i = 0; i < 6000; ++i)
  {
    SCOPED_TRACE(i);
    const Shape shape = randomShape(random, i % kKinds);
    const Vector3d low = inBox(random, cube(1.3));
    const AlignedBox3d cell(low, low + Vector3d::Constant(random.uniform(0.05, 0.5)));
    const Relation said = relationOf(cell, shape);
    const Relation sampled = sampledRelation([&](const Vector3d& p) { return contains(shape, p); }, cell);
    ++seen[static_cast<size_t>(said)];
    if (said == sampled) continue;
    // A grid of points may miss the small part of a mixed cell, but never finds one that does not exist.
    ASSERT_EQ(said, Relation::Mixed) << "kind " << i % kKinds << " sampled " << static_cast<int>(sampled);
    const AlignedBox3d smaller(cell.center() - 0.35 * cell.sizes(), cell.center() + 0.35 * cell.sizes());
    EXPECT_EQ(sampledRelation([&](const Vector3d& p) { return contains(shape, p); }, smaller), sampled);
  }
  for (const int count : seen) EXPECT_GT(count, 500);
}

Scene randomScene(Random& random, int count)
{
  std::vector<Shape> shapes;
  for (int i = 0; i < count; ++i)
  {
    const int kind = random.integer(0, kKinds - 2);
    const Vector3d centre = inBox(random, cube(4));
    const Vector3d size{random.uniform(0.2, 1), random.uniform(0.2, 1), random.uniform(0.2, 1)};
    if (kind < 2)
      shapes.emplace_back(boxBetween(centre - size, centre + size));
    else if (kind == 2)
      shapes.emplace_back(Cylinder{centre.head<2>(), size.x(), centre.z() - size.z(), centre.z() + size.z()});
    else
      shapes.emplace_back(Ellipsoid{centre, size});
  }
  shapes.emplace_back(HalfSpace{Vector3d::UnitZ(), -3.5});
  return Scene(std::move(shapes));
}

TEST(Scene, FindsTheFirstOfAllSurfaces)
{
  Random random(13);
  for (int round = 0; round < 10; ++round)
  {
    const Scene scene = randomScene(random, 3 * round);
    for (int i = 0; i < 500; ++i)
    {
      const Vector3d origin = inBox(random, cube(6));
      const Vector3d direction = i % 10 == 0 ? Vector3d(Vector3d::Unit(i / 10 % 3)) : randomDirection(random);
      std::optional<double> nearest;
      for (const Shape& shape : scene.shapes())
        if (const auto hit = firstHit(shape, origin, direction); hit && hit->range_m <= 7)
          nearest = std::min(nearest.value_or(hit->range_m), hit->range_m);
      const auto hit = scene.firstHit(origin, direction, 7);
      ASSERT_EQ(hit.has_value(), nearest.has_value());
      if (hit)
      {
        EXPECT_EQ(hit->range_m, *nearest);
      }
      bool solid = false;
      for (const Shape& shape : scene.shapes()) solid = solid || contains(shape, origin);
      EXPECT_EQ(scene.solidAt(origin), solid);
    }
  }
}

TEST(Scene, RelationToAllSolidsAgreesWithTheCellsPoints)
{
  Random random(14);
  std::array<int, 3> seen{};
  const Scene scene = randomScene(random, 120);
  for (int i = 0; i < 4000; ++i)
  {
    SCOPED_TRACE(i);
    const Vector3d low = inBox(random, cube(4));
    const AlignedBox3d cell(low, low + Vector3d::Constant(0.15));
    const Relation said = scene.relationOf(cell);
    const Relation sampled = sampledRelation([&](const Vector3d& p) { return scene.solidAt(p); }, cell);
    ++seen[static_cast<size_t>(said)];
    if (said != sampled)
    {
      ASSERT_EQ(said, Relation::Mixed);
    }
  }
  for (const int count : seen) EXPECT_GT(count, 300);
}

TEST(Scene, ACellThatTwoBlocksFillTogetherIsSolid)
{
  const Scene scene({boxBetween({0, 0, 0}, {0.5, 1, 1}), boxBetween({0.5, 0, 0}, {1, 1, 1})});
  EXPECT_EQ(scene.relationOf(AlignedBox3d(Vector3d(0.4, 0.4, 0.4), Vector3d(0.6, 0.6, 0.6))),
            Relation::Inside);
  EXPECT_EQ(scene.relationOf(AlignedBox3d(Vector3d(0.4, 0.4, 0.4), Vector3d(0.6, 0.6, 0.6)), 0),
            Relation::Mixed);
  EXPECT_EQ(scene.relationOf(AlignedBox3d(Vector3d(0.4, 0.4, 0.9), Vector3d(0.6, 0.6, 1.1))),
            Relation::Mixed);
  EXPECT_EQ(Scene().relationOf(AlignedBox3d(Vector3d(0, 0, 0), Vector3d(1, 1, 1))), Relation::Outside);
}
}  // namespace
}  // namespace lamap::sim
