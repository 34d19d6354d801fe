#pragma once

#include <lamap_tools/cells/cell_map.h>
#include <lamap_tools/cells/truth.h>

#include <memory>
#include <utility>
#include <vector>

namespace lamap::tools
{
/// A cell, and whether it is occupied.
using LabelledCell = std::pair<CellIndex, bool>;

/// A map that is sure of each of these cells, given in any order, each once.
[[nodiscard]] std::unique_ptr<CellMap> cellsOf(std::vector<LabelledCell> cells, double resolution_m);

/// A truth as such a map; nothing where it has one cell only.
[[nodiscard]] std::unique_ptr<CellMap> cellsOf(const Truth& truth);

}  // namespace lamap::tools
