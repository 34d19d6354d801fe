#include <lamap_core/bgk/evidence_table.h>

#include <algorithm>
#include <cstring>

namespace lamap
{
namespace
{
constexpr int kEdge = kScanBlockEdge;
using Bytes = uint8_t __attribute__((vector_size(8)));
using Words = uint16_t __attribute__((vector_size(16)));

uint32_t rowOf(uint64_t layer, int y)
{
  return static_cast<uint32_t>(layer >> (y * kEdge) & 0xFF);
}

Words asWords(uint64_t bytes)
{
  Bytes counts;
  std::memcpy(&counts, &bytes, sizeof(counts));
  return __builtin_convertvector(counts, Words);
}

}  // namespace

/** Marked cells of one layer, and of the rows around, a cell of eight in each byte of a word: by row, from −1
 * on. */
struct EvidenceTable::LayerCounts
{
  bool any = false;
  std::array<uint64_t, kEdge + 2> own{};     ///< whether the cell is marked
  std::array<uint64_t, kEdge + 2> beside{};  ///< of the two cells beside it in x
  std::array<uint64_t, kEdge + 2> across{};  ///< of the two beside it in y; not set in the first and last row
  std::array<uint64_t, kEdge + 2> corners{};  ///< of the four beside it in x and y

  void count(const MaskNeighbourhood& neighbourhood, int z);
};

void EvidenceTable::LayerCounts::count(const MaskNeighbourhood& neighbourhood, int z)
{
  const int dz = z < 0 ? -1 : z >= kEdge;
  const auto layer = static_cast<size_t>(z & (kEdge - 1));
  std::array<std::array<uint64_t, 3>, 3> layers{};  // of the nine masks around, by dy and dx
  uint64_t marked = 0;
  for (int dy = -1; dy <= 1; ++dy)
  {
    const CellMask* const* const masks = neighbourhood.rowOf(dy, dz);
    for (size_t i = 0; i < 3; ++i)
      if (masks[i] != nullptr) marked |= layers[static_cast<size_t>(dy + 1)][i] = (*masks[i])[layer];
  }
  any = marked != 0;
  if (!any) return;
  for (int y = -1; y <= kEdge; ++y)
  {
    const auto& [left, middle, right] = layers[static_cast<size_t>(y < 0 ? 0 : y < kEdge ? 1 : 2)];
    const int row = y & (kEdge - 1);
    const uint32_t bits = rowOf(middle, row);
    const auto i = static_cast<size_t>(y + 1);
    own[i] = bytesOfBits(bits);
    beside[i] = bytesOfBits((bits << 1 & 0xFF) | rowOf(left, row) >> (kEdge - 1)) +
                bytesOfBits(bits >> 1 | (rowOf(right, row) << (kEdge - 1) & 0xFF));
  }
  for (size_t i = 1; i <= kEdge; ++i)
  {
    across[i] = own[i - 1] + own[i + 1];
    corners[i] = beside[i - 1] + beside[i + 1];
  }
}

bool EvidenceTable::isTabulable(const CellStencil& stencil)
{
  return stencil.reach() == 1 && stencil.scale().evidence(stencil.fullSum()) < uint64_t{1} << 31;
}

EvidenceTable::EvidenceTable(const CellStencil& stencil, bool planar) : planar_(planar)
{
  const size_t distances = stencil.weights().size();
  size_t size = 1;
  for (size_t i = 0; i < distances; ++i)
  {
    strides_[i] = static_cast<uint16_t>(size);
    size *= stencil.classSizes()[i] + 1;
  }
  table_.resize(size);
  for (size_t place = 0; place < size; ++place)
  {
    int64_t sum = 0;
    size_t rest = place;
    for (size_t i = 0; i < distances; ++i)
    {
      const size_t counts = stencil.classSizes()[i] + 1;
      sum += static_cast<int64_t>(rest % counts) * stencil.weights()[i];
      rest /= counts;
    }
    table_[place] = static_cast<uint32_t>(stencil.scale().evidence(sum));
  }
}

void EvidenceTable::lookUpLayer(const LayerCounts& below, const LayerCounts& here, const LayerCounts& above,
                                uint32_t* evidence) const
{
  for (size_t y = 1; y <= kEdge; ++y, evidence += kEdge)
  {
    const uint64_t at1 = here.beside[y] + here.across[y] + below.own[y] + above.own[y];
    const uint64_t at2 =
        here.corners[y] + below.beside[y] + below.across[y] + above.beside[y] + above.across[y];
    const uint64_t at3 = below.corners[y] + above.corners[y];
    const Words place = asWords(here.own[y]) * strides_[0] + asWords(at1) * strides_[1] +
                        asWords(at2) * strides_[2] + asWords(at3) * strides_[3];
    for (int x = 0; x < kEdge; ++x) evidence[x] = table_[place[x]];
  }
}

Layers EvidenceTable::look(const MaskNeighbourhood& neighbourhood, BlockEvidence& evidence) const
{
  std::array<LayerCounts, kEdge + 2> layers;
  for (int z = -1; z <= kEdge; ++z) layers[static_cast<size_t>(z + 1)].count(neighbourhood, z);
  static const LayerCounts kNone;
  Layers reached;
  for (int z = 0; z < kEdge; ++z)
  {
    const auto i = static_cast<size_t>(z);
    const LayerCounts& below = planar_ ? kNone : layers[i];
    const LayerCounts& here = layers[i + 1];
    const LayerCounts& above = planar_ ? kNone : layers[i + 2];
    if (!below.any && !here.any && !above.any) continue;
    reached.include({z, z + 1});
    lookUpLayer(below, here, above, &evidence[i * kEdge * kEdge]);
  }
  return reached;
}

}  // namespace lamap
