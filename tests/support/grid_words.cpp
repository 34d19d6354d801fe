#include <support/grid_words.h>

#include <algorithm>
#include <sstream>
#include <tuple>

namespace lamap::test
{
std::vector<BlockWords> wordsOf(const Evidence& grid)
{
  std::vector<BlockWords> blocks;
  for (const BlockIndex& index : grid.sortedBlocks())
  {
    const EvidenceBlock& block = *grid.find(index);
    blocks.push_back({index, block.wide(), block.pruned(), block.words(grid.shape())});
  }
  return blocks;
}

std::string differenceOf(const Evidence& a, const Evidence& b)
{
  const std::vector<BlockWords> left = wordsOf(a), right = wordsOf(b);
  if (left.size() != right.size())
    return std::to_string(left.size()) + " blocks against " + std::to_string(right.size());
  for (size_t i = 0; i < left.size(); ++i)
  {
    const BlockWords &l = left[i], &r = right[i];
    std::ostringstream where;
    where << "block (" << l.index.x << ", " << l.index.y << ", " << l.index.z << "): ";
    if (!(l.index == r.index)) return where.str() + "has another index in the other grid";
    if (l.wide != r.wide) return where.str() + "is wide in one only";
    if (l.pruned != r.pruned) return where.str() + "is pruned in one only";
    if (l.words != r.words) return where.str() + "has other words";
  }
  return {};
}

std::vector<CellEvidence> cellsOf(const Evidence& grid)
{
  std::vector<CellEvidence> cells;
  for (const BlockIndex& index : grid.sortedBlocks())
  {
    const CellIndex first = grid.firstCellOf(index);
    for (uint32_t offset = 0; offset < grid.shape().cellCount(); ++offset)
    {
      const CellIndex local = grid.shape().localOf(offset);
      const CellIndex cell{first.x + local.x, first.y + local.y, first.z + local.z};
      const CellSums evidence = grid.at(cell);
      if (evidence.any()) cells.push_back({cell, evidence});
    }
  }
  std::sort(cells.begin(), cells.end(),
            [](const CellEvidence& a, const CellEvidence& b)
            { return std::tie(a.cell.z, a.cell.y, a.cell.x) < std::tie(b.cell.z, b.cell.y, b.cell.x); });
  return cells;
}

std::string evidenceDifferenceOf(const Evidence& a, const Evidence& b)
{
  const std::vector<CellEvidence> left = cellsOf(a), right = cellsOf(b);
  for (size_t i = 0; i < std::min(left.size(), right.size()); ++i)
  {
    const CellEvidence &l = left[i], &r = right[i];
    if (l.cell == r.cell && l.evidence == r.evidence) continue;
    std::ostringstream text;
    text << "cell (" << l.cell.x << ", " << l.cell.y << ", " << l.cell.z << ") holds " << l.evidence.first
         << ", " << l.evidence.second << "; the other grid's cell (" << r.cell.x << ", " << r.cell.y << ", "
         << r.cell.z << ") holds " << r.evidence.first << ", " << r.evidence.second;
    return text.str();
  }
  if (left.size() != right.size())
    return std::to_string(left.size()) + " cells against " + std::to_string(right.size());
  return {};
}

}  // namespace lamap::test
