#include <gtest/gtest.h>
#include <lamap_core/grid/evidence_block.h>
#include <support/seeded_scans.h>
#include <support/seeds.h>

#include <set>
#include <stdexcept>
#include <string>
#include <vector>

namespace lamap::test
{
namespace
{
std::vector<BlockShape> allShapes()
{
  std::vector<BlockShape> shapes;
  for (const bool planar : {false, true})
    for (int log2Edge = 1; log2Edge <= 5; ++log2Edge) shapes.emplace_back(log2Edge, planar);
  return shapes;
}

std::string nameOf(const BlockShape& shape)
{
  return std::string(shape.planar() ? "planar, " : "3D, ") + std::to_string(shape.edge()) + " cells wide";
}

/// Random evidence; runs of equal cells, so that octants can be held once.
DenseBlock randomBlock(Random& random, const BlockShape& shape, double observedShare, int largestBits)
{
  DenseBlock dense(shape);
  CellSums evidence;
  const auto fresh = [&]
  {
    const int bits = random.integer(1, largestBits);
    evidence = {random.bits() >> (64 - bits), random.bits() >> (64 - bits)};
    if (!evidence.any()) evidence.second = 1;
  };
  fresh();
  for (uint32_t offset = 0; offset < shape.cellCount(); ++offset)
  {
    if (offset % shape.branching() == 0 ? random.chance(0.5) : random.chance(0.05)) fresh();
    if (!random.chance(observedShare)) continue;
    dense.set(offset, evidence);
  }
  return dense;
}

bool holdsEqual(const DenseBlock& block, uint32_t first, uint32_t count, CellSums& merged)
{
  merged = block.at(first);
  for (uint32_t offset = first; offset < first + count; ++offset)
    if (!(block.at(offset) == merged)) return false;
  return true;
}

void expectSameCells(const BlockShape& shape, const DenseBlock& dense, const EvidenceBlock& packed)
{
  DenseBlock unpacked(shape);
  unpacked.set(static_cast<uint32_t>(shape.cellCount() - 1), {1, 1});  // must be overwritten
  packed.unpack(shape, unpacked);
  EXPECT_EQ(unpacked.observed, dense.observed);
  for (uint32_t offset = 0; offset < shape.cellCount(); ++offset)
  {
    ASSERT_TRUE(packed.at(shape, offset) == dense.at(offset)) << "offset " << offset;
    // What an unpacked block says of unobserved cells means nothing.
    if (dense.isObserved(offset))
    {
      ASSERT_TRUE(unpacked.at(offset) == dense.at(offset)) << "offset " << offset;
    }
  }
}

void expectRefused(const BlockShape& shape, bool wide, bool pruned, const std::vector<uint64_t>& words,
                   const std::string& what)
{
  EXPECT_THROW((void)EvidenceBlock::fromWords(shape, SumKind::Counts, wide, pruned, words),
               std::runtime_error)
      << what << " is taken, " << nameOf(shape);
}

TEST(BlockShape, NumbersItsCellsAlongTheMortonCurve)
{
  for (const BlockShape& shape : allShapes())
  {
    SCOPED_TRACE(nameOf(shape));
    EXPECT_EQ(shape.cellCount(),
              shape.planar() ? shape.edge() * shape.edge() : shape.edge() * shape.edge() * shape.edge());
    std::set<uint32_t> seen;
    const int height = shape.planar() ? 1 : shape.edge();
    for (int z = 0; z < height; ++z)
      for (int y = 0; y < shape.edge(); ++y)
        for (int x = 0; x < shape.edge(); ++x)
        {
          // Bit by bit: x lowest, then y, then z.
          uint32_t morton = 0;
          int to = 0;
          for (int bit = 0; bit < shape.log2Edge(); ++bit)
          {
            morton |= static_cast<uint32_t>(x >> bit & 1) << to++;
            morton |= static_cast<uint32_t>(y >> bit & 1) << to++;
            if (!shape.planar()) morton |= static_cast<uint32_t>(z >> bit & 1) << to++;
          }
          const uint32_t offset = shape.offsetOfLocal(static_cast<uint32_t>(x), static_cast<uint32_t>(y),
                                                      static_cast<uint32_t>(z));
          ASSERT_EQ(offset, morton);
          ASSERT_LT(offset, shape.cellCount());
          ASSERT_TRUE(seen.insert(offset).second);
          ASSERT_TRUE(shape.localOf(offset) == (CellIndex{x, y, z}));
          // The same place in any other block, left of the origin too.
          ASSERT_EQ(shape.offsetOf({x - 7 * shape.edge(), y + 3 * shape.edge(), z - shape.edge()}), offset);
        }
    EXPECT_EQ(seen.size(), shape.cellCount());
  }
}

TEST(BlockShape, RefusesEdgesBeyondItsRange)
{
  for (const bool planar : {false, true})
  {
    EXPECT_THROW(BlockShape(0, planar), std::invalid_argument);
    EXPECT_THROW(BlockShape(6, planar), std::invalid_argument);
    EXPECT_THROW(BlockShape(-1, planar), std::invalid_argument);
  }
}

TEST(EvidenceBlock, UnpacksWhatWasPacked)
{
  for (const BlockShape& shape : allShapes())
    for (unsigned seed = 1; seed <= seeds(20); ++seed)
    {
      SCOPED_TRACE(nameOf(shape) + ", seed " + std::to_string(seed));
      Random random(seed);
      const int bits = seed % 3 == 0 ? 63 : 32;
      const DenseBlock dense =
          randomBlock(random, shape, seed % 4 == 0 ? 1.0 : random.uniform(0.1, 1.0), bits);
      uint64_t largest = 0;
      size_t observed = 0;
      for (uint32_t offset = 0; offset < shape.cellCount(); ++offset)
      {
        largest = std::max({largest, dense.at(offset).first, dense.at(offset).second});
        observed += dense.isObserved(offset);
      }
      EvidenceBlock plain, lossless;
      plain.pack(shape, dense, {});
      lossless.pack(shape, dense, holdsEqual);
      expectSameCells(shape, dense, plain);
      expectSameCells(shape, dense, lossless);
      EXPECT_EQ(plain.wide(), largest > 0xFFFFFFFFu);
      EXPECT_EQ(lossless.wide(), largest > 0xFFFFFFFFu);
      EXPECT_FALSE(plain.pruned());
      EXPECT_EQ(plain.leafCount(shape), observed);
      EXPECT_EQ(plain.observedCount(shape), observed);
      EXPECT_EQ(lossless.observedCount(shape), observed);
      EXPECT_EQ(lossless.pruned(), lossless.leafCount(shape) < observed);
      if (observed == 0) continue;

      // Through the words of a file.
      for (const EvidenceBlock& block : {plain, lossless})
      {
        const EvidenceBlock again = EvidenceBlock::fromWords(shape, SumKind::Counts, block.wide(),
                                                             block.pruned(), block.words(shape));
        expectSameCells(shape, dense, again);
        EXPECT_EQ(again.words(shape), block.words(shape));
      }
      // Leaves cover each observed cell once, in order.
      uint32_t next = 0;
      size_t covered = 0;
      lossless.visitLeaves(shape,
                           [&](uint32_t first, uint32_t count, const CellSums& evidence)
                           {
                             EXPECT_GE(first, next);
                             EXPECT_EQ(first % count, 0u);
                             for (uint32_t offset = first; offset < first + count; ++offset)
                             {
                               EXPECT_TRUE(dense.isObserved(offset));
                               EXPECT_TRUE(dense.at(offset) == evidence);
                             }
                             next = first + count;
                             covered += count;
                           });
      EXPECT_EQ(covered, observed);
    }
}

TEST(EvidenceBlock, OfNarrowCellsIsWhatIsPackedOfThem)
{
  Random random(7);
  for (const BlockShape& shape : allShapes())
    for (const double share : {0.0, 0.3, 1.0})
    {
      const DenseBlock dense = randomBlock(random, shape, share, 31);
      std::vector<uint64_t> cells(shape.cellCount());
      for (uint32_t i = 0; i < cells.size(); ++i)
        if (dense.isObserved(i)) cells[i] = dense.at(i).first | dense.at(i).second << 32;
      EvidenceBlock packed;
      packed.pack(shape, dense, {});
      const EvidenceBlock narrow = EvidenceBlock::ofNarrowCells(shape, cells.data());
      EXPECT_EQ(narrow.words(shape), packed.words(shape)) << nameOf(shape);
      EXPECT_FALSE(narrow.wide() || narrow.pruned());
      EXPECT_EQ(narrow.isPlainFor(packed), packed.isPlainFor(packed));
    }
}

TEST(EvidenceBlock, HoldsOctantsOfEveryLevelOnce)
{
  for (const BlockShape& shape : allShapes())
  {
    SCOPED_TRACE(nameOf(shape));
    DenseBlock dense(shape);
    for (uint32_t offset = 0; offset < shape.cellCount(); ++offset)
    {
      dense.set(offset, {5, 7});
    }
    EvidenceBlock block;
    block.pack(shape, dense, holdsEqual);
    EXPECT_EQ(block.leafCount(shape), 1u);
    expectSameCells(shape, dense, block);

    // One cell that disagrees splits its octants and no others: b − 1 siblings a level, and the finest b.
    dense.sums[shape.cellCount() - 1].first = 6;
    block.pack(shape, dense, holdsEqual);
    EXPECT_EQ(block.leafCount(shape), (shape.branching() - 1) * static_cast<size_t>(shape.log2Edge()) + 1);
    expectSameCells(shape, dense, block);
  }
}

TEST(EvidenceBlock, NeverJoinsObservedWithUnobservedCells)
{
  for (const BlockShape& shape : allShapes())
  {
    SCOPED_TRACE(nameOf(shape));
    const auto last = static_cast<uint32_t>(shape.cellCount() - 1);
    DenseBlock dense(shape);
    for (uint32_t offset = 0; offset < last; ++offset)
    {
      dense.set(offset, {0, 3});
    }
    EvidenceBlock block;
    // A merger that would join anything.
    block.pack(shape, dense,
               [](const DenseBlock& cells, uint32_t first, uint32_t, CellSums& merged)
               {
                 merged = cells.at(first);
                 return true;
               });
    EXPECT_EQ(block.observedCount(shape), last);
    EXPECT_FALSE(block.at(shape, last).any());
    expectSameCells(shape, dense, block);
  }
}

TEST(EvidenceBlock, HoldsTheEvidenceTheMergerGives)
{
  const BlockShape shape(2, false);
  DenseBlock dense(shape);
  for (uint32_t offset = 0; offset < 8; ++offset)
  {
    dense.set(offset, {offset, 10 + offset});
  }
  EvidenceBlock block;
  block.pack(shape, dense,
             [](const DenseBlock&, uint32_t, uint32_t, CellSums& merged)
             {
               merged = {100, 200};
               return true;
             });
  EXPECT_EQ(block.leafCount(shape), 1u);
  for (uint32_t offset = 0; offset < 8; ++offset)
    EXPECT_TRUE(block.at(shape, offset) == (CellSums{100, 200}));
  EXPECT_FALSE(block.at(shape, 8).any());
}

TEST(EvidenceBlock, IsWideExactlyWhereACountNeedsIt)
{
  const BlockShape shape(3, false);
  for (const bool first : {false, true})
  {
    DenseBlock dense(shape);
    uint64_t CellSums::*const sum = first ? &CellSums::first : &CellSums::second;
    dense.set(17, {});
    dense.sums[17].*sum = 0xFFFFFFFFu;
    EvidenceBlock block;
    block.pack(shape, dense, {});
    EXPECT_FALSE(block.wide());
    expectSameCells(shape, dense, block);
    ++(dense.sums[17].*sum);
    block.pack(shape, dense, {});
    EXPECT_TRUE(block.wide());
    expectSameCells(shape, dense, block);
  }
}

TEST(EvidenceBlock, RefusesWordsThatWerePackedByNobody)
{
  for (const BlockShape& shape : allShapes())
    for (const bool wide : {false, true})
    {
      SCOPED_TRACE(nameOf(shape) + (wide ? ", wide" : ", narrow"));
      const size_t mask = shape.maskWords();
      DenseBlock dense(shape);
      for (uint32_t offset = 0; offset + 1 < shape.cellCount(); ++offset)
      {
        dense.set(offset, {0, offset < shape.branching() ? 3 : 4 + offset});
      }
      if (wide) dense.sums[1].first = uint64_t{1} << 40;
      EvidenceBlock plain;
      plain.pack(shape, dense, {});
      const std::vector<uint64_t> good = plain.words(shape);
      ASSERT_EQ(plain.wide(), wide);

      // Length.
      for (size_t size = 0; size < good.size(); size += 1 + size / 3)
        expectRefused(shape, wide, false, {good.begin(), good.begin() + static_cast<long>(size)},
                      "a cut block");
      expectRefused(shape, wide, false, {good.begin(), good.end() - 1}, "a block without its last word");
      std::vector<uint64_t> words = good;
      words.push_back(1);
      expectRefused(shape, wide, false, words, "a word too many");
      expectRefused(shape, wide, false, {}, "no word");
      expectRefused(shape, wide, false, std::vector<uint64_t>(mask), "an empty mask");
      expectRefused(shape, wide, true, std::vector<uint64_t>(2 * mask), "two empty masks");

      // Flags.
      expectRefused(shape, !wide, false, good, "the other width");
      expectRefused(shape, wide, true, good, "a leaf mask that is none");

      // A bit more or less in the mask.
      words = good;
      words[0] ^= 2;
      expectRefused(shape, wide, false, words, "an observed cell less");
      words = good;
      words[mask - 1] |= uint64_t{1} << ((shape.cellCount() - 1) & 63);
      expectRefused(shape, wide, false, words, "an observed cell more");
      if (shape.cellCount() < 64)
      {
        words = good;
        words[0] |= uint64_t{1} << shape.cellCount();
        words.insert(words.end(), wide ? 2 : 1, 5);
        expectRefused(shape, wide, false, words, "a cell beyond the block");
      }

      // Evidence.
      words = good;
      for (size_t i = 0; i < (wide ? 2u : 1u); ++i) words[mask + i] = 0;
      expectRefused(shape, wide, false, words, "an observed cell without evidence");
      if (wide)
      {
        words = good;
        words[mask + 2] = uint64_t{1} << 63;
        expectRefused(shape, wide, false, words, "a count beyond 2^63");
        words = good;
        words[mask + 2] = 1;
        expectRefused(shape, wide, false, words, "64 bits for counts that need 32");
      }
    }
}

TEST(EvidenceBlock, RefusesLeavesThatAreNoOctants)
{
  for (const BlockShape& shape : allShapes())
  {
    if (shape.log2Edge() < 2) continue;
    SCOPED_TRACE(nameOf(shape));
    const size_t mask = shape.maskWords();
    const auto b = static_cast<uint32_t>(shape.branching());
    const auto make = [&](const std::vector<uint32_t>& observed, const std::vector<uint32_t>& leaves)
    {
      std::vector<uint64_t> words(2 * mask);
      for (const uint32_t offset : observed) words[offset >> 6] |= uint64_t{1} << (offset & 63);
      for (const uint32_t offset : leaves) words[mask + (offset >> 6)] |= uint64_t{1} << (offset & 63);
      for (size_t i = 0; i < leaves.size(); ++i) words.push_back(7 + i);
      return words;
    };
    const auto range = [](uint32_t from, uint32_t to)
    {
      std::vector<uint32_t> offsets;
      for (uint32_t offset = from; offset < to; ++offset) offsets.push_back(offset);
      return offsets;
    };
    const auto without = [](std::vector<uint32_t> offsets, uint32_t offset)
    {
      offsets.erase(std::find(offsets.begin(), offsets.end(), offset));
      return offsets;
    };

    EXPECT_NO_THROW(
        (void)EvidenceBlock::fromWords(shape, SumKind::Counts, false, true, make(range(0, b), {0})));
    EXPECT_NO_THROW(
        (void)EvidenceBlock::fromWords(shape, SumKind::Counts, false, true, make(range(0, b + 1), {0, b})));
    EXPECT_NO_THROW(
        (void)EvidenceBlock::fromWords(shape, SumKind::Counts, false, true, make(range(0, b * b), {0})));

    expectRefused(shape, false, true, make(range(0, b - 1), {0}), "a part of an octant");
    expectRefused(shape, false, true, make(range(0, 2 * b), {0}), "two octants that are none");
    expectRefused(shape, false, true, make(range(1, b + 1), {1}), "an octant that is not aligned");
    expectRefused(shape, false, true, make(without(range(0, b + 1), 3), {0}),
                  "an octant with a hole and a cell beyond it");
    expectRefused(shape, false, true, make(range(0, b), {1}), "a first cell without a leaf");
    expectRefused(shape, false, true, make(range(0, b + 1), range(0, b + 1)),
                  "pruned where nothing is held once");
    expectRefused(shape, false, true, make(range(0, b), {0, b}), "a leaf at an unobserved cell");
    expectRefused(shape, false, true, make(range(0, 2 * b), {0, b - 1}),
                  "an octant split in the wrong place");
    // As many observed cells as leaves cover, but other ones.
    expectRefused(shape, false, true, make(without(range(0, 2 * b + 1), b - 2), {0, b}),
                  "a hole in a leaf, and a cell in no leaf");
    expectRefused(shape, false, true, make(without(range(0, b * b), b * b - 1), {0, b + 1}),
                  "a leaf within a leaf");
    std::vector<uint32_t> scattered = range(0, b * b);
    scattered.resize(b + 1);
    for (uint32_t i = 0; i + 1 < b; ++i) scattered.push_back(b * b - 1 - 2 * i);
    std::sort(scattered.begin(), scattered.end());
    scattered.erase(std::unique(scattered.begin(), scattered.end()), scattered.end());
    expectRefused(shape, false, true, make(scattered, {0}), "a leaf that covers cells that are not observed");
  }
}

TEST(EvidenceBlock, RefusesSumsThatNoMapHolds)
{
  const BlockShape shape(3, false);
  const auto wordsWith = [&](uint64_t sum)
  {
    std::vector<uint64_t> words(shape.maskWords());
    words[0] = 1;
    words.insert(words.end(), {sum, 5});
    return words;
  };
  for (const SumKind kind : {SumKind::Counts, SumKind::Signed})
  {
    EXPECT_NO_THROW((void)EvidenceBlock::fromWords(shape, kind, true, false, wordsWith(mostCode(kind))));
    EXPECT_THROW((void)EvidenceBlock::fromWords(shape, kind, true, false, wordsWith(mostCode(kind) + 1)),
                 std::runtime_error);
  }
  EXPECT_EQ(SignedSums::decoded(mostCode(SumKind::Signed)), kMostSignedSum);
}
}  // namespace
}  // namespace lamap::test
