#pragma once

#include <lamap_core/grid/evidence.h>

#include <cstdint>
#include <string>
#include <vector>

namespace lamap::test
{
/// A block as files hold it.
struct BlockWords
{
  BlockIndex index;
  bool wide = false;
  bool pruned = false;
  std::vector<uint64_t> words;
};

/// All blocks of a grid as files hold them, sorted.
std::vector<BlockWords> wordsOf(const Evidence& grid);

/// Empty where both grids hold the same words, else the first difference.
std::string differenceOf(const Evidence& a, const Evidence& b);

/// Empty where both grids hold the same evidence cell by cell, however their blocks are packed.
std::string evidenceDifferenceOf(const Evidence& a, const Evidence& b);

/// A cell with its evidence, by z, y, x.
struct CellEvidence
{
  CellIndex cell;
  CellSums evidence;
};

/// Every cell that has evidence.
std::vector<CellEvidence> cellsOf(const Evidence& grid);

}  // namespace lamap::test
