#include <lamap_mrpt/files/grid_content.h>
#include <lamap_mrpt/maps/bgk_map_content.h>

#include <optional>
#include <stdexcept>

namespace lamap
{
namespace
{
/// A prior map may have a prior map; a file in which this does not end is not one of ours.
constexpr int kMaxPriorDepth = 16;

BgkMap readAtDepth(CBGKMap::TCreationOptions& options, ByteReader& in, int depth)
{
  if (depth > kMaxPriorDepth) in.fail("prior maps are nested too deep");
  options = {};
  options.read(in);
  try
  {
    options.validate();
    BgkMap map(options);
    readGrid(map.grid(), map.structure().planar ? std::optional(map.planarLayer()) : std::nullopt, in);
    if (in.number<bool>())
    {
      CBGKMap::TCreationOptions priorOptions;
      map.setPriorMap(std::make_shared<const BgkMap>(readAtDepth(priorOptions, in, depth + 1)));
    }
    return map;
  }
  catch (const std::invalid_argument& error)
  {
    in.fail(error.what());
  }
}
}  // namespace

void writeBgkMap(const CBGKMap::TCreationOptions& options, const BgkMap& map, ByteWriter& out)
{
  options.write(out);
  writeGrid(map.grid(), out);
  out.number(map.priorMap() != nullptr);
  if (!map.priorMap()) return;
  CBGKMap::TCreationOptions priorOptions;
  static_cast<BgkStructure&>(priorOptions) = map.priorMap()->structure();
  writeBgkMap(priorOptions, *map.priorMap(), out);
}

BgkMap readBgkMap(CBGKMap::TCreationOptions& options, ByteReader& in)
{
  return readAtDepth(options, in, 0);
}

}  // namespace lamap
