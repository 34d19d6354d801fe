#pragma once

#include <lamap_tools/pictures/render_map.h>

namespace lamap::tools
{
/// View::Perspective of drawMap, from checked options.
[[nodiscard]] mrpt::img::CImage drawPerspective(const CellMap& map, const RenderOptions& options);

}  // namespace lamap::tools
