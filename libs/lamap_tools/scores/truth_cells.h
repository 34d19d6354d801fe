#pragma once

#include <lamap_tools/cells/cell_map.h>
#include <lamap_tools/scores/truth.h>

#include <memory>

namespace lamap::tools
{
/// A truth as a map that is sure of each of its cells; nothing where it has one cell only.
[[nodiscard]] std::unique_ptr<CellMap> cellsOf(const Truth& truth);

}  // namespace lamap::tools
