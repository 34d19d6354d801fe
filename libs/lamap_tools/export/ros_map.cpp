#include <lamap_tools/export/flat_cells.h>
#include <lamap_tools/files/file_output.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <string>

namespace lamap::tools
{
namespace
{
// map_server's own grey levels. With the thresholds below, (255 − grey) / 255 reads back as each state.
constexpr uint8_t kOccupied = 0;
constexpr uint8_t kFree = 254;
constexpr uint8_t kUnknown = 205;

uint8_t greyOf(CellState state)
{
  return state == CellState::Occupied ? kOccupied : state == CellState::Free ? kFree : kUnknown;
}
}  // namespace

void writeRosMap(const CellMap& map, const std::string& yamlPath, const ExportOptions& options)
{
  const FlatCells flat = flatCellsOf(map, yamlPath, options);
  std::string grey(flat.cells.size(), '\0');
  std::transform(flat.cells.begin(), flat.cells.end(), grey.begin(),
                 [](const FlatCell& cell) { return static_cast<char>(greyOf(cell.state)); });
  const auto pgmPath = std::filesystem::path(yamlPath).replace_extension(".pgm");
  const std::string comment = options.z_m ? "slice at z = " + shortest(*options.z_m) + " m" : "projection";

  FileOutput pgm(pgmPath.string());
  pgm.append("P5\n# " + comment + ", " + shortest(map.resolution()) + " m/pixel\n" +
             std::to_string(flat.width) + " " + std::to_string(flat.height()) + "\n255\n");
  for (size_t row = flat.height(); row-- > 0;)  // the top row is the greatest y
    pgm.append({&grey[row * flat.width], flat.width});

  FileOutput yaml(yamlPath);
  // A name in single quotes is taken literally by YAML; a quote in it is doubled.
  std::string image = pgmPath.filename().string();
  for (size_t at = 0; (at = image.find('\'', at)) != std::string::npos; at += 2) image.insert(at, 1, '\'');
  yaml.append("image: '" + image + "'\nmode: trinary\nresolution: " + shortest(map.resolution()) +
              "\norigin: [" + shortest(flat.extent.first.x * map.resolution()) + ", " +
              shortest(flat.extent.first.y * map.resolution()) +
              ", 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n");
  FileOutput::commitAll({&pgm, &yaml});
}

}  // namespace lamap::tools
