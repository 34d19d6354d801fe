#include <lamap_core/grid/evidence_block.h>

#include <lamap_core/options/legal_range.h>

#include <algorithm>
#include <stdexcept>
#include <string>

namespace lamap
{
namespace
{
constexpr uint64_t kNarrowMax = 0xFFFFFFFFu;

bool bitAt(const uint64_t* words, uint32_t offset)
{
  return words[offset >> 6] >> (offset & 63) & 1;
}

/// Are all bits of [first, first + count) set? The run is an aligned octant.
bool allSet(const uint64_t* words, uint32_t first, uint32_t count)
{
  if (count < 64)
  {
    const uint64_t run = ((uint64_t{1} << count) - 1) << (first & 63);
    return (words[first >> 6] & run) == run;
  }
  return std::all_of(words + (first >> 6), words + ((first + count) >> 6),
                     [](uint64_t word) { return ~word == 0; });
}

void clearBits(std::vector<uint64_t>& words, uint32_t first, uint32_t count)
{
  if (count < 64)
  {
    words[first >> 6] &= ~(((uint64_t{1} << count) - 1) << (first & 63));
    return;
  }
  std::fill(words.begin() + (first >> 6), words.begin() + ((first + count) >> 6), uint64_t{0});
}

/// An octant that is held once, with its evidence.
struct HeldOctant
{
  uint32_t begin;
  uint32_t count;
  CellSums sums;
};

/// The largest octants that may be held once, by their first cell: from the finest level up, an octant may be
/// if all its children are (or are observed cells) and the merger agrees.
std::vector<HeldOctant> heldOctants(const BlockShape& shape, const DenseBlock& dense,
                                    const OctantMerger& merger)
{
  const auto cells = static_cast<uint32_t>(shape.cellCount());
  const auto branching = static_cast<uint32_t>(shape.branching());
  std::vector<HeldOctant> finer;
  std::vector<HeldOctant> held;
  for (uint32_t count = branching; count <= cells; count *= branching)
  {
    const bool finest = count == branching;
    held.clear();
    auto next = finer.begin();
    for (uint32_t begin = 0; begin < cells; begin += count)
    {
      const auto children = next;
      while (next != finer.end() && next->begin < begin + count) ++next;
      const bool mayBe =
          finest ? allSet(dense.observed.data(), begin, count)
                 : static_cast<uint32_t>(next - children) == branching &&
                       std::all_of(children, next,
                                   [&](const HeldOctant& child) { return child.count == count / branching; });
      CellSums sums;
      if (mayBe && merger(dense, begin, count, sums))
        held.push_back({begin, count, sums});
      else
        held.insert(held.end(), children, next);
    }
    const bool grew = finest ? !held.empty() : held.size() != finer.size();
    finer.swap(held);
    if (!grew) break;
  }
  return finer;
}

/// Calls visit(sums) for each leaf in order. @param starts mask of the leaves' first cells
template <typename Visit>
void forEachLeaf(const DenseBlock& dense, const uint64_t* starts, size_t maskWords,
                 const std::vector<HeldOctant>& held, Visit&& visit)
{
  auto nextHeld = held.begin();
  for (size_t word = 0; word < maskWords; ++word)
  {
    const CellSums* const sums = dense.sums.data() + word * 64;
    if (~starts[word] == 0)
    {
      for (size_t i = 0; i < 64; ++i) visit(sums[i]);
      continue;
    }
    for (uint64_t rest = starts[word]; rest != 0; rest &= rest - 1)
    {
      const auto bit = static_cast<uint32_t>(__builtin_ctzll(rest));
      const bool isHeld = nextHeld != held.end() && nextHeld->begin == word * 64 + bit;
      visit(isHeld ? (nextHeld++)->sums : sums[bit]);
    }
  }
}

/// Of the cells whose Morton numbers differ in the lowest six bits, a word of a mask: those in each layer
/// along an axis.
template <int kAxes>
constexpr std::array<std::array<uint64_t, 64>, kAxes> wordLayers()
{
  std::array<std::array<uint64_t, 64>, kAxes> cells{};
  for (uint32_t offset = 0; offset < 64; ++offset)
    for (uint32_t axis = 0; axis < kAxes; ++axis)
    {
      uint32_t layer = 0;
      for (uint32_t bit = 0; bit * kAxes + axis < 6; ++bit)
        layer |= (offset >> (bit * kAxes + axis) & 1u) << bit;
      cells[axis][layer] |= uint64_t{1} << offset;
    }
  return cells;
}

/// The layers of the set bits of a mask.
template <int kAxes>
BlockLayers layersOf(const BlockShape& shape, const uint64_t* mask)
{
  constexpr auto kWordLayers = wordLayers<kAxes>();
  constexpr uint32_t kWordEdge = kAxes == 3 ? 4 : 8;
  BlockLayers layers{};
  for (size_t word = 0; word < shape.maskWords(); ++word)
  {
    if (mask[word] == 0) continue;
    const CellIndex first = shape.localOf(static_cast<uint32_t>(word * 64));
    const std::array<int32_t, 3> firsts{first.x, first.y, first.z};
    for (size_t axis = 0; axis < kAxes; ++axis)
      for (uint32_t layer = 0; layer < kWordEdge; ++layer)
        if ((mask[word] & kWordLayers[axis][layer]) != 0)
          layers[axis] |= 1u << (static_cast<uint32_t>(firsts[axis]) + layer);
  }
  if (kAxes == 2 && layers[0] != 0) layers[2] = 1;
  return layers;
}

constexpr uint32_t spread(uint32_t coordinate, int axes)
{
  uint32_t spreadBits = 0;
  for (int bit = 0; bit < 5; ++bit) spreadBits |= (coordinate >> bit & 1u) << (bit * axes);
  return spreadBits;
}

/// Local coordinates of a Morton number: x | y << 8 | z << 16.
constexpr uint32_t local(uint32_t offset, uint32_t axes)
{
  uint32_t packed = 0;
  for (uint32_t bit = 0; bit < 6; ++bit) packed |= (offset >> bit & 1u) << (bit % axes * 8 + bit / axes);
  return packed;
}

}  // namespace

#define LAMAP_SPREAD_ROW(a, n)                                                                            \
  spread(a, n), spread(a + 1, n), spread(a + 2, n), spread(a + 3, n), spread(a + 4, n), spread(a + 5, n), \
      spread(a + 6, n), spread(a + 7, n)
const uint32_t BlockShape::kSpread2[32] = {LAMAP_SPREAD_ROW(0, 2), LAMAP_SPREAD_ROW(8, 2),
                                           LAMAP_SPREAD_ROW(16, 2), LAMAP_SPREAD_ROW(24, 2)};
const uint32_t BlockShape::kSpread3[32] = {LAMAP_SPREAD_ROW(0, 3), LAMAP_SPREAD_ROW(8, 3),
                                           LAMAP_SPREAD_ROW(16, 3), LAMAP_SPREAD_ROW(24, 3)};
#undef LAMAP_SPREAD_ROW

#define LAMAP_LOCAL_ROW(a, n)                                                                       \
  local(a, n), local(a + 1, n), local(a + 2, n), local(a + 3, n), local(a + 4, n), local(a + 5, n), \
      local(a + 6, n), local(a + 7, n)
#define LAMAP_LOCALS(n)                                                                         \
  LAMAP_LOCAL_ROW(0, n), LAMAP_LOCAL_ROW(8, n), LAMAP_LOCAL_ROW(16, n), LAMAP_LOCAL_ROW(24, n), \
      LAMAP_LOCAL_ROW(32, n), LAMAP_LOCAL_ROW(40, n), LAMAP_LOCAL_ROW(48, n), LAMAP_LOCAL_ROW(56, n)
const uint32_t BlockShape::kLocal2[64] = {LAMAP_LOCALS(2)};
const uint32_t BlockShape::kLocal3[64] = {LAMAP_LOCALS(3)};
#undef LAMAP_LOCALS
#undef LAMAP_LOCAL_ROW

bool DenseBlock::any() const
{
  return std::any_of(observed.begin(), observed.end(), [](uint64_t word) { return word != 0; });
}

void DenseBlock::clear()
{
  std::fill(observed.begin(), observed.end(), uint64_t{0});
}

BlockShape::BlockShape(int log2Edge, bool planar) : log2Edge_(log2Edge), planar_(planar)
{
  requireLegal(log2Edge >= 1 && log2Edge <= 5, "log2Edge", log2Edge, "a whole number from 1 to 5");
}

void EvidenceBlock::setMasks(const BlockShape& shape, const uint64_t* observed, const uint64_t* leafStarts)
{
  const size_t maskWords = shape.maskWords();
  const size_t ranks = rankWords(shape);
  std::vector<uint64_t> masks(ranks + (leafStarts != nullptr ? 2 : 1) * maskWords);
  std::copy_n(observed, maskWords, masks.begin() + static_cast<std::ptrdiff_t>(ranks));
  if (leafStarts != nullptr)
    std::copy_n(leafStarts, maskWords, masks.begin() + static_cast<std::ptrdiff_t>(ranks + maskWords));
  const uint64_t* const starts = leafStarts != nullptr ? leafStarts : observed;
  uint64_t before = 0;
  for (size_t word = 0; word < maskWords; ++word)
  {
    masks[word >> 2] |= before << (word & 3) * 16;
    before += countBits(starts[word]);
  }
  masks_.swap(masks);
  pruned_ = leafStarts != nullptr;
}

uint32_t EvidenceBlock::leafCells(const BlockShape& shape, uint32_t begin) const
{
  const uint64_t* observed = observedMask(shape);
  const uint64_t* first = leafMask(shape);
  const auto cells = static_cast<uint32_t>(shape.cellCount());
  const auto branching = static_cast<uint32_t>(shape.branching());
  uint32_t count = 1;
  while (count * branching <= cells && begin % (count * branching) == 0 && bitAt(observed, begin + count) &&
         !bitAt(first, begin + count))
    count *= branching;
  return count;
}

void EvidenceBlock::unpack(const BlockShape& shape, DenseBlock& dense) const
{
  if (empty())
  {
    dense.clear();
    return;
  }
  std::copy_n(observedMask(shape), shape.maskWords(), dense.observed.begin());
  visitLeaves(shape, [&](uint32_t first, uint32_t count, const CellSums& sums)
              { std::fill_n(dense.sums.begin() + first, count, sums); });
}

bool EvidenceBlock::isPlainFor(const EvidenceBlock& other) const
{
  return !wide_ && !pruned_ && !other.wide_ && !other.pruned_ && uint64_t{most_} + other.most_ <= kNarrowMax;
}

void EvidenceBlock::addPlain(const BlockShape& shape, const EvidenceBlock& other)
{
  const size_t maskWords = shape.maskWords();
  const uint64_t* const own = observedMask(shape);
  const uint64_t* const theirs = other.observedMask(shape);
  const uint64_t* term = other.leaves_.data();
  most_ += other.most_;
  if (std::equal(own, own + maskWords, theirs))
  {
    for (size_t i = 0; i < leaves_.size(); ++i) leaves_[i] += term[i];
    return;
  }
  std::vector<uint64_t> both(maskWords);
  for (size_t word = 0; word < maskWords; ++word) both[word] = own[word] | theirs[word];
  std::vector<uint64_t> sum(countBits(both.data(), maskWords));
  const uint64_t* value = leaves_.data();
  uint64_t* next = sum.data();
  for (size_t word = 0; word < maskWords; ++word)
  {
    if (own[word] == theirs[word])
    {
      const size_t cells = countBits(own[word]);
      for (size_t i = 0; i < cells; ++i) next[i] = value[i] + term[i];
      next += cells;
      value += cells;
      term += cells;
      continue;
    }
    for (uint64_t rest = both[word]; rest != 0; rest &= rest - 1)
    {
      const uint64_t cell = rest & (~rest + 1);
      uint64_t counts = 0;
      if ((own[word] & cell) != 0) counts += *value++;
      if ((theirs[word] & cell) != 0) counts += *term++;
      *next++ = counts;
    }
  }
  setMasks(shape, both.data(), nullptr);
  leaves_.swap(sum);
}

bool EvidenceBlock::hasEqualOctant(const BlockShape& shape) const
{
  const auto branching = static_cast<uint32_t>(shape.branching());
  const uint64_t octantBits = (uint64_t{1} << branching) - 1;
  const uint64_t* observed = observedMask(shape);
  const uint64_t* value = leaves_.data();
  const auto cells = static_cast<uint32_t>(shape.cellCount());
  for (uint32_t begin = 0; begin < cells; begin += branching)
  {
    const uint64_t octant = observed[begin >> 6] >> (begin & 63) & octantBits;
    if (octant == octantBits &&
        std::all_of(value + 1, value + branching, [&](uint64_t v) { return v == *value; }))
      return true;
    value += countBits(octant);
  }
  return false;
}

void EvidenceBlock::pack(const BlockShape& shape, const DenseBlock& dense, const OctantMerger& merger)
{
  const std::vector<HeldOctant> held = merger ? heldOctants(shape, dense, merger) : std::vector<HeldOctant>{};
  const size_t maskWords = shape.maskWords();

  // Each observed cell starts a leaf but those inside an octant that is held once.
  std::vector<uint64_t> starts;
  if (!held.empty()) starts = dense.observed;
  for (const HeldOctant& octant : held)
  {
    clearBits(starts, octant.begin, octant.count);
    starts[octant.begin >> 6] |= uint64_t{1} << (octant.begin & 63);
  }
  const uint64_t* const first = held.empty() ? dense.observed.data() : starts.data();
  const size_t count = countBits(first, maskWords);
  if (count == 0)
  {
    *this = {};
    return;
  }
  std::vector<uint64_t> leaves(count);
  uint64_t* next = leaves.data();
  uint64_t bits = 0;
  const auto packNarrow = [&](const CellSums& sums)
  {
    bits |= sums.first | sums.second;
    *next++ = sums.first | sums.second << 32;
  };
  forEachLeaf(dense, first, maskWords, held, packNarrow);
  const bool wide = bits > kNarrowMax;
  if (wide)
  {
    leaves.resize(2 * count);
    next = leaves.data();
    const auto packWide = [&](const CellSums& sums)
    {
      *next++ = sums.first;
      *next++ = sums.second;
    };
    forEachLeaf(dense, first, maskWords, held, packWide);
  }
  setMasks(shape, dense.observed.data(), held.empty() ? nullptr : starts.data());
  leaves_.swap(leaves);
  most_ = static_cast<uint32_t>(std::min(bits, kNarrowMax));
  wide_ = wide;
}

EvidenceBlock EvidenceBlock::ofNarrowCells(const BlockShape& shape, const uint64_t* cells)
{
  const size_t maskWords = shape.maskWords();
  const size_t cellCount = shape.cellCount();
  std::vector<uint64_t> observed(maskWords);
  size_t count = 0;
  uint64_t bits = 0;
  for (size_t word = 0; word < maskWords; ++word)
  {
    const uint64_t* const some = cells + word * 64;
    const size_t cellsOfWord = std::min<size_t>(64, cellCount - word * 64);
    uint64_t mask = 0;
    for (size_t i = 0; i < cellsOfWord; ++i)
    {
      mask |= uint64_t{some[i] != 0} << i;
      bits |= some[i];
    }
    observed[word] = mask;
    count += countBits(mask);
  }
  EvidenceBlock block;
  if (count == 0) return block;
  block.leaves_.resize(count);
  uint64_t* next = block.leaves_.data();
  for (size_t word = 0; word < maskWords; ++word)
    for (uint64_t rest = observed[word]; rest != 0; rest &= rest - 1)
      *next++ = cells[word * 64 + static_cast<size_t>(__builtin_ctzll(rest))];
  block.setMasks(shape, observed.data(), nullptr);
  block.most_ = static_cast<uint32_t>(bits | bits >> 32);
  return block;
}

size_t EvidenceBlock::leafCount(const BlockShape& shape) const
{
  return empty() ? 0 : countBits(leafMask(shape), shape.maskWords());
}

size_t EvidenceBlock::observedCount(const BlockShape& shape) const
{
  return empty() ? 0 : countBits(observedMask(shape), shape.maskWords());
}

BlockLayers EvidenceBlock::layers(const BlockShape& shape) const
{
  if (empty()) return {};
  return shape.planar() ? layersOf<2>(shape, observedMask(shape)) : layersOf<3>(shape, observedMask(shape));
}

std::vector<uint64_t> EvidenceBlock::words(const BlockShape& shape) const
{
  if (empty()) return {};
  std::vector<uint64_t> words(masks_.begin() + static_cast<std::ptrdiff_t>(rankWords(shape)), masks_.end());
  words.insert(words.end(), leaves_.begin(), leaves_.end());
  return words;
}

EvidenceBlock EvidenceBlock::fromWords(const BlockShape& shape, SumKind kind, bool wide, bool pruned,
                                       const std::vector<uint64_t>& words)
{
  const auto refuse = [](const char* what)
  { throw std::runtime_error(std::string("a block of the map is corrupt: ") + what); };

  EvidenceBlock block;
  const size_t maskWords = shape.maskWords();
  const size_t beforeLeaves = (pruned ? 2 : 1) * maskWords;
  if (words.size() < beforeLeaves) refuse("its masks are cut short");
  block.setMasks(shape, words.data(), pruned ? words.data() + maskWords : nullptr);
  block.wide_ = wide;
  const auto cells = static_cast<uint32_t>(shape.cellCount());
  if (cells < 64 && (block.observedMask(shape)[0] >> cells || block.leafMask(shape)[0] >> cells))
    refuse("a mask names cells beyond the block");
  for (size_t word = 0; word < shape.maskWords(); ++word)
  {
    if (block.leafMask(shape)[word] & ~block.observedMask(shape)[word])
      refuse("a leaf begins at an unobserved cell");
  }
  const size_t leafCount = block.leafCount(shape);
  if (leafCount == 0) refuse("it holds no cell");
  if (words.size() != beforeLeaves + (wide ? 2 : 1) * leafCount)
    refuse("the number of its leaves does not fit its masks");
  block.leaves_.assign(words.begin() + static_cast<std::ptrdiff_t>(beforeLeaves), words.end());

  uint64_t largest = 0;
  bool empty = false;
  bool octants = true;
  uint32_t endOfLast = 0;
  size_t covered = 0;
  block.visitLeaves(shape,
                    [&](uint32_t first, uint32_t count, const CellSums& sums)
                    {
                      largest = std::max({largest, sums.first, sums.second});
                      empty = empty || !sums.any();
                      octants =
                          octants && first >= endOfLast && allSet(block.observedMask(shape), first, count);
                      endOfLast = first + count;
                      covered += count;
                    });
  // Leaves that do not overlap, hold observed cells only, and as many as there are: exactly these.
  if (!octants || covered != block.observedCount(shape)) refuse("its leaves are not its observed cells");
  if (empty) refuse("an observed cell has no evidence");
  if (wide != (largest > kNarrowMax)) refuse("the width of its counts does not fit their size");
  if (largest > mostCode(kind)) refuse("a sum of a cell is larger than any map holds");
  if (pruned && leafCount == block.observedCount(shape)) refuse("it is said to be pruned and is not");
  block.most_ = static_cast<uint32_t>(std::min(largest, kNarrowMax));
  return block;
}

}  // namespace lamap
