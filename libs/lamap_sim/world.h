#pragma once

#include <lamap_sim/scene.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace lamap::sim
{
/** A place with exact surfaces, and a path through it for a sensor. */
struct World
{
  std::string name;
  Scene scene;
  /// The space to be mapped; there is no truth beyond it. Its faces are the world's walls, floor and ceiling,
  /// if it has them.
  Eigen::AlignedBox3d interior_map;
  /// Corners of the path, without the height; at least one. The path keeps clear of all solids.
  std::vector<Eigen::Vector2d> path_map;
  /// Heading of a sensor if the path is a single place.
  double heading_rad = 0;
  /// Height of every sensor in the map; empty: relative to the floor, interior_map's lowest z.
  std::optional<double> sensorZ_map;
  /// Upright walls only, seen from inside: a world for planar sensors, with one layer of cells at z = 0.
  bool flat = false;
};

/// All names for makeWorld().
[[nodiscard]] const std::vector<std::string>& worldNames();

/** Makes a world from a seed; the same seed gives the same world, bit by bit.
 *
 *   structured    10 × 7 × 2 m, two rooms with right angles and blocks, open above
 *   unstructured  10 × 7 × 2 m, trunks, crowns and bushes inside walls, open above
 *   corridor      44 × 18 × 3.3 m, a corridor with seven furnished offices on either side
 *   pier          24 × 14 × 5 m of water: piles, a sea wall, a sloping bottom with boulders
 *   station       the structured world, seen from one place
 *   flatland      12 × 9 m, two-dimensional
 *   poles         10 × 7 × 2 m, poles of 5 to 10 cm, tables on thin legs, free-standing door frames, open
 * above
 *
 * @throws std::invalid_argument for any other name */
[[nodiscard]] World makeWorld(const std::string& name, uint64_t seed);

}  // namespace lamap::sim
