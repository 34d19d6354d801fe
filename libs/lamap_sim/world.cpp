#include <lamap_sim/random.h>
#include <lamap_sim/world.h>

#include <lamap_sim/world_builder.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace lamap::sim
{
// The order in which arguments are evaluated is unspecified: at most one argument of a call may draw from the
// generator, and several draws must be in braces.
namespace
{
using Eigen::Vector2d;
using Eigen::Vector3d;

World structured(uint64_t seed)
{
  WorldBuilder builder(seed, {10, 7, 2});
  Random& random = builder.random();
  builder.addFloor();
  builder.addWallsAround();

  const double wall = random.uniform(4.2, 5.0);
  const double door = random.uniform(2.4, 3.4);
  const double doorWidth = random.uniform(1.2, 1.5);
  const double thickness = random.uniform(0.21, 0.29);
  builder.addBlock({wall, -0.5, -0.5}, {wall + thickness, door, 2});
  builder.addBlock({wall, door + doorWidth, -0.5}, {wall + thickness, 7.5, 2});
  const double niche = random.uniform(3.2, 3.9);
  builder.addBlock({random.uniform(8.0, 8.4), niche, -0.5}, {10.5, niche + thickness, 2});

  const double middle = door + doorWidth / 2;
  builder.setPath({{1.6, 1.6},
                   {2.6, 4.6},
                   {wall - 0.7, middle},
                   {wall + thickness + 0.7, middle},
                   {6.9, 5.4},
                   {7.1, 1.7},
                   {8.6, 1.5}});
  for (int i = random.integer(6, 8); i > 0; --i)
  {
    const Vector2d half{random.uniform(0.15, 0.5), random.uniform(0.15, 0.5)};
    const double height = random.uniform(0.3, 1.6);
    if (const auto place = builder.freePlace({0.2, 0.2}, {9.8, 6.8}, half.norm(), 0.35))
      builder.addBlock({place->x() - half.x(), place->y() - half.y(), -0.5},
                       {place->x() + half.x(), place->y() + half.y(), height});
  }
  return builder.take("structured");
}

World unstructured(uint64_t seed)
{
  WorldBuilder builder(seed, {10, 7, 2});
  Random& random = builder.random();
  builder.addFloor();
  builder.addWallsAround();
  builder.setPath({{1.3, 1.2}, {3.5, 2.2}, {5.2, 4.9}, {8.4, 5.5}, {8.7, 1.5}});
  for (int i = random.integer(16, 20); i > 0; --i)
  {
    const double trunk = random.uniform(0.08, 0.2);
    const double crown = random.uniform(0.3, 0.6);
    const double crownZ = random.uniform(1.3, 1.7);
    const double crownHalfHeight = random.uniform(0.25, 0.45);
    const auto place = builder.freePlace({0, 0}, {10, 7}, crown, 0.15);
    if (!place) continue;
    builder.addCylinder(*place, trunk, -0.5, crownZ);
    builder.addEllipsoid({place->x(), place->y(), crownZ},
                         {crown, crown * random.uniform(0.8, 1.0), crownHalfHeight});
  }
  for (int i = random.integer(8, 12); i > 0; --i)
  {
    const Vector3d radii{random.uniform(0.15, 0.45), random.uniform(0.15, 0.45), random.uniform(0.2, 0.7)};
    if (const auto place = builder.freePlace({0, 0}, {10, 7}, radii.head<2>().maxCoeff(), 0.25))
      builder.addEllipsoid({place->x(), place->y(), 0}, radii);
  }
  return builder.take("unstructured");
}

/// A wall with a door, along x at y .. y + thickness.
void addWallWithDoor(WorldBuilder& builder, double xLow, double xHigh, double y, double doorX,
                     double ceiling_m)
{
  constexpr double kThickness_m = 0.26;
  constexpr double kDoorHalfWidth_m = 0.5;
  constexpr double kDoorHeight_m = 2.12;
  const double high = ceiling_m + 0.5;
  builder.addBlock({xLow, y, -0.5}, {doorX - kDoorHalfWidth_m, y + kThickness_m, high});
  builder.addBlock({doorX + kDoorHalfWidth_m, y, -0.5}, {xHigh, y + kThickness_m, high});
  builder.addBlock({xLow, y, kDoorHeight_m}, {xHigh, y + kThickness_m, high});
}

/// Furniture for the office between two corners, walls excluded.
void furnish(WorldBuilder& builder, const Vector2d& low, const Vector2d& high)
{
  Random& random = builder.random();
  constexpr double kClear_m = 0.42;
  for (int i = random.integer(1, 2); i > 0; --i)  // desks
  {
    const Vector2d half{random.uniform(0.6, 0.8), random.uniform(0.35, 0.45)};
    const auto place = builder.freePlace(low + half, high - half, half.norm(), kClear_m);
    if (!place) continue;
    const Vector3d centre(place->x(), place->y(), 0);
    builder.addBlock(centre + Vector3d(-half.x(), -half.y(), 0.6),
                     centre + Vector3d(half.x(), half.y(), 0.76));
    builder.addBlock(centre + Vector3d(-half.x(), -half.y(), -0.5),
                     centre + Vector3d(-half.x() + 0.3, half.y(), 0.65));
  }
  const double shelf = random.uniform(0.4, 0.9);  // against the wall
  const double shelfX = random.uniform(low.x() + shelf, high.x() - shelf);
  const bool atLow = random.chance(0.5);
  const double shelfY = atLow ? low.y() + 0.2 : high.y() - 0.2;
  if (builder.isClear({shelfX, shelfY}, shelf + 0.1, kClear_m))
    builder.addBlock({shelfX - shelf, atLow ? low.y() - 0.1 : high.y() - 0.38, -0.5},
                     {shelfX + shelf, atLow ? low.y() + 0.38 : high.y() + 0.1, random.uniform(1.2, 2.2)});
  for (int i = random.integer(1, 3); i > 0; --i)
  {
    const Vector2d half{random.uniform(0.2, 0.26), random.uniform(0.2, 0.26)};
    const double height = random.uniform(0.4, 0.9);
    if (const auto place = builder.freePlace(low, high, half.norm(), kClear_m))
      builder.addTurnedBlock(*place, half, -0.5, height, random.uniform(0, 1.5));
  }
  const double bin = random.uniform(0.12, 0.2);
  const double height = random.uniform(0.4, 1.6);
  if (const auto place = builder.freePlace(low, high, bin, kClear_m))
    builder.addCylinder(*place, bin, -0.5, height);
}

struct Office
{
  Vector2d low;
  Vector2d high;
};

World corridor(uint64_t seed)
{
  constexpr double kCeiling_m = 3.3;
  constexpr double kLowWall = 7.65;  // the corridor lies between y = 7.91 and y = 10.1
  constexpr double kHighWall = 10.1;
  constexpr double kMiddle = 9.0;
  WorldBuilder builder(seed, {44, 18, kCeiling_m});
  Random& random = builder.random();
  builder.encloseAll();

  std::vector<Vector2d> path{{0.9, kMiddle}};
  std::vector<Office> offices;
  constexpr int kOffices = 7;
  std::array<double, 2> xLow{0, 0};
  for (int i = 1; i <= kOffices; ++i)
  {
    for (const size_t side : {size_t{0}, size_t{1}})
    {
      const bool last = i == kOffices;
      const double x = last ? 44 : i * 44.0 / kOffices + random.uniform(-0.7, 0.7);
      const double start = xLow[side];
      const double doorX = random.uniform(start + 1.4, x - 1.4);
      addWallWithDoor(builder, start - 0.5, x + 0.5, side == 0 ? kLowWall : kHighWall, doorX, kCeiling_m);
      const double y0 = side == 0 ? -0.5 : kHighWall;
      const double y1 = side == 0 ? kLowWall + 0.26 : 18.5;
      if (!last) builder.addBlock({x, y0, -0.5}, {x + 0.22, y1, kCeiling_m + 0.5});
      offices.push_back(side == 0 ? Office{{start + 0.22, 0}, {x, kLowWall}}
                                  : Office{{start + 0.22, kHighWall + 0.26}, {x, 18}});
      const double inside = side == 0 ? 5.6 : 12.4;
      const double deep = side == 0 ? 3.0 : 15.0;
      const Vector2d turn((start + x) / 2, deep);
      path.insert(path.end(), {{doorX, kMiddle}, {doorX, inside}, turn, {doorX, inside}, {doorX, kMiddle}});
      xLow[side] = x;
    }
  }
  path.emplace_back(43.1, kMiddle);
  builder.setPath(path);
  for (const Office& office : offices) furnish(builder, office.low, office.high);
  for (int i = 0; i < 6; ++i)  // lockers along the corridor
  {
    const bool low = random.chance(0.5);
    const double half = random.uniform(0.3, 0.7);
    const double x = random.uniform(1.5, 42.5);
    const double depth = random.uniform(0.25, 0.4);
    if (!builder.isClear({x, low ? 7.9 : 10.1}, half, 0.5)) continue;
    builder.addBlock({x - half, low ? 7.8 : 10.1 - depth, -0.5},
                     {x + half, low ? 7.91 + depth : 10.2, random.uniform(1.0, 2.0)});
  }
  return builder.take("corridor");
}

World pier(uint64_t seed)
{
  WorldBuilder builder(seed, {24, 14, 5});
  Random& random = builder.random();
  builder.addBlock({-2, 12.6, -1}, {26, 17, 6});  // the sea wall
  const double along = random.uniform(-0.02, 0.02);
  const double across = random.uniform(0.02, 0.06);
  builder.addSlope({along, -across, 1}, {12, 7, random.uniform(0.5, 0.8)});
  builder.setPath({{2.0, 6.0}, {9.0, 6.6}, {15.0, 5.8}, {22.0, 6.3}});
  for (int i = 0; i < 6; ++i)
    for (const double y : {2.4, 9.6})
    {
      const double radius = random.uniform(0.22, 0.38);
      builder.addCylinder({3.0 + 3.6 * i + random.uniform(-0.25, 0.25), y + random.uniform(-0.25, 0.25)},
                          radius, -1, 5.5);
    }
  for (int i = random.integer(4, 7); i > 0; --i)
  {
    const Vector3d radii{random.uniform(0.3, 0.9), random.uniform(0.3, 0.9), random.uniform(0.3, 0.8)};
    builder.addEllipsoid({random.uniform(1, 23), random.uniform(1, 12), random.uniform(0.4, 0.8)}, radii);
  }
  World world = builder.take("pier");
  world.sensorZ_map = world.interior_map.min().z() + random.uniform(2.8, 3.1);
  return world;
}

World station(uint64_t seed)
{
  World world = structured(seed);
  world.name = "station";
  world.path_map.resize(1);
  world.heading_rad = 0.75;  // towards the middle of the room
  return world;
}

World flatland(uint64_t seed)
{
  WorldBuilder builder(seed, {12, 9, 2});
  Random& random = builder.random();
  builder.addWallsAround();
  const double thickness = random.uniform(0.21, 0.29);
  const double first = random.uniform(3.6, 4.2);
  builder.addBlock({first, -0.5, -0.5}, {first + thickness, random.uniform(4.6, 5.2), 2.5});
  const double second = random.uniform(7.6, 8.2);
  builder.addBlock({second, random.uniform(3.6, 4.2), -0.5}, {second + thickness, 9.5, 2.5});
  builder.setPath({{1.5, 1.5}, {2.0, 6.6}, {5.8, 6.8}, {6.0, 2.2}, {10.2, 2.0}, {10.2, 7.2}});
  for (int i = random.integer(5, 8); i > 0; --i)
  {
    const double size = random.uniform(0.2, 0.6);
    const auto place = builder.freePlace({0.2, 0.2}, {11.8, 8.8}, size, 0.4);
    if (!place) continue;
    if (random.chance(0.5))
      builder.addCylinder(*place, size, -0.5, 2.5);
    else
      builder.addTurnedBlock(*place, {0.8 * size, 0.55 * size}, -0.5, 2.5, random.uniform(0, 1.5));
  }
  World world = builder.take("flatland");
  world.flat = true;
  world.sensorZ_map = 0;
  return world;
}

/// Two posts with a lintel, along x or y.
void addDoorFrame(WorldBuilder& builder, const Vector2d& middle, bool alongX)
{
  Random& random = builder.random();
  const double halfPost = random.uniform(0.025, 0.05);
  const double half = random.uniform(0.4, 0.5);  // from the middle of the frame to that of a post
  const double height = random.uniform(1.7, 1.95);
  const Vector2d along = alongX ? Vector2d::UnitX() : Vector2d::UnitY();
  const Vector2d reach = Vector2d::Constant(halfPost);
  for (const double side : {-half, half})
  {
    const Vector2d post = middle + side * along;
    builder.addBlock({post.x() - halfPost, post.y() - halfPost, -0.5},
                     {post.x() + halfPost, post.y() + halfPost, height});
  }
  const Vector2d low = middle - half * along - reach;
  const Vector2d high = middle + half * along + reach;
  builder.addBlock({low.x(), low.y(), height - 2 * halfPost}, {high.x(), high.y(), height});
}

/// A plate on four legs.
void addTable(WorldBuilder& builder, const Vector2d& middle, const Vector2d& half)
{
  Random& random = builder.random();
  const double height = random.uniform(0.65, 0.8);
  const double thickness = random.uniform(0.02, 0.04);
  const double halfLeg = random.uniform(0.02, 0.035);
  builder.addBlock({middle.x() - half.x(), middle.y() - half.y(), height - thickness},
                   {middle.x() + half.x(), middle.y() + half.y(), height});
  for (const double x : {-half.x() + halfLeg, half.x() - halfLeg})
    for (const double y : {-half.y() + halfLeg, half.y() - halfLeg})
      builder.addBlock({middle.x() + x - halfLeg, middle.y() + y - halfLeg, -0.5},
                       {middle.x() + x + halfLeg, middle.y() + y + halfLeg, height - thickness});
}

World poles(uint64_t seed)
{
  WorldBuilder builder(seed, {10, 7, 2});
  Random& random = builder.random();
  builder.addFloor();
  builder.addWallsAround();
  builder.setPath({{1.3, 1.2}, {3.5, 2.2}, {5.2, 4.9}, {8.4, 5.5}, {8.7, 1.5}});
  constexpr double kClear_m = 0.25;
  for (int i = random.integer(2, 3); i > 0; --i)
  {
    const bool alongX = random.chance(0.5);
    if (const auto place = builder.freePlace({0.8, 0.8}, {9.2, 6.2}, 0.6, kClear_m))
      addDoorFrame(builder, *place, alongX);
  }
  for (int i = random.integer(3, 4); i > 0; --i)
  {
    const Vector2d half{random.uniform(0.4, 0.7), random.uniform(0.3, 0.4)};
    if (const auto place = builder.freePlace({0.9, 0.9}, {9.1, 6.1}, half.norm(), kClear_m))
      addTable(builder, *place, half);
  }
  for (int i = random.integer(18, 24); i > 0; --i)
  {
    const double radius = random.uniform(0.025, 0.05);
    const double height = random.uniform(1.0, 1.95);
    if (const auto place = builder.freePlace({0.2, 0.2}, {9.8, 6.8}, radius, kClear_m))
      builder.addCylinder(*place, radius, -0.5, height);
  }
  return builder.take("poles");
}

using Maker = World (*)(uint64_t);
const std::vector<std::pair<std::string, Maker>>& makers()
{
  static const std::vector<std::pair<std::string, Maker>> all{
      {"structured", structured}, {"unstructured", unstructured}, {"corridor", corridor}, {"pier", pier},
      {"station", station},       {"flatland", flatland},         {"poles", poles}};
  return all;
}
}  // namespace

const std::vector<std::string>& worldNames()
{
  static const std::vector<std::string> names = []
  {
    std::vector<std::string> all;
    for (const auto& [name, maker] : makers()) all.push_back(name);
    return all;
  }();
  return names;
}

World makeWorld(const std::string& name, uint64_t seed)
{
  for (const auto& [known, maker] : makers())
    if (known == name) return maker(seed);
  throw std::invalid_argument("world = " + name + ": no world of this name");
}

}  // namespace lamap::sim
