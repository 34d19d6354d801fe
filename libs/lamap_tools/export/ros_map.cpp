#include <lamap_tools/cells/cell_table.h>
#include <lamap_tools/export/export_map.h>
#include <lamap_tools/files/file_output.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <vector>

namespace lamap::tools
{
namespace
{
// map_server's own grey levels. With the thresholds below, (255 − grey) / 255 reads back as each state.
constexpr uint8_t kOccupied = 0;
constexpr uint8_t kFree = 254;
constexpr uint8_t kUnknown = 205;

/// Cells of a slice or a projection, row by row from the lowest y.
struct Layer
{
  CellExtent extent;
  size_t width = 0;
  std::vector<uint8_t> grey;
};

bool selected(const CellIndex& cell, double resolution_m, const ExportOptions& options)
{
  const double z_m = (cell.z + 0.5) * resolution_m;
  if (options.z_m) return cell.z == std::floor(*options.z_m / resolution_m);
  return (!options.zMin_m || z_m >= *options.zMin_m) && (!options.zMax_m || z_m <= *options.zMax_m);
}

Layer flatten(const CellMap& map, const std::string& path, const ExportOptions& options)
{
  Layer layer;
  const auto extent = cellExtent(map, [&](const CellIndex& cell, const CellEstimate&)
                                 { return selected(cell, map.resolution(), options); });
  if (!extent) throw std::runtime_error(path + ": the map has no cell at the heights asked for");
  layer.extent = *extent;
  const CellIndex& first = layer.extent.first;
  const CellIndex& last = layer.extent.last;
  layer.width = static_cast<size_t>(int64_t{last.x} - first.x + 1);
  const size_t height = static_cast<size_t>(int64_t{last.y} - first.y + 1);
  constexpr size_t kMaxPixels = size_t{1} << 31U;
  if (layer.width > kMaxPixels / height)
    throw std::runtime_error(path + ": the picture would have " + std::to_string(layer.width) + " x " +
                             std::to_string(height) + " pixels, more than 2^31");
  layer.grey.assign(layer.width * height, kUnknown);
  map.visitCells(
      [&](const CellIndex& cell, const CellEstimate& estimate)
      {
        if (!selected(cell, map.resolution(), options)) return;
        uint8_t& grey = layer.grey[static_cast<size_t>(int64_t{cell.y} - first.y) * layer.width +
                                   static_cast<size_t>(int64_t{cell.x} - first.x)];
        if (estimate.state == CellState::Occupied) grey = kOccupied;
        if (estimate.state == CellState::Free && grey != kOccupied) grey = kFree;
      });
  return layer;
}
}  // namespace

void writeRosMap(const CellMap& map, const std::string& yamlPath, const ExportOptions& options)
{
  const Layer layer = flatten(map, yamlPath, options);
  const size_t height = layer.grey.size() / layer.width;
  const auto pgmPath = std::filesystem::path(yamlPath).replace_extension(".pgm");
  const std::string comment = options.z_m ? "slice at z = " + shortest(*options.z_m) + " m" : "projection";

  FileOutput pgm(pgmPath.string());
  pgm.append("P5\n# " + comment + ", " + shortest(map.resolution()) + " m/pixel\n" +
             std::to_string(layer.width) + " " + std::to_string(height) + "\n255\n");
  for (size_t row = height; row-- > 0;)  // the top row is the greatest y
    pgm.append({reinterpret_cast<const char*>(&layer.grey[row * layer.width]), layer.width});

  FileOutput yaml(yamlPath);
  // A name in single quotes is taken literally by YAML; a quote in it is doubled.
  std::string image = pgmPath.filename().string();
  for (size_t at = 0; (at = image.find('\'', at)) != std::string::npos; at += 2) image.insert(at, 1, '\'');
  yaml.append("image: '" + image + "'\nmode: trinary\nresolution: " + shortest(map.resolution()) +
              "\norigin: [" + shortest(layer.extent.first.x * map.resolution()) + ", " +
              shortest(layer.extent.first.y * map.resolution()) +
              ", 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n");
  FileOutput::commitAll({&pgm, &yaml});
}

}  // namespace lamap::tools
