#pragma once

#include <lamap_tools/pictures/render_map.h>

namespace lamap::tools
{
/// View::Top and View::Slice of drawMap, from checked options.
[[nodiscard]] mrpt::img::CImage drawFlat(const CellMap& map, const RenderOptions& options);

}  // namespace lamap::tools
