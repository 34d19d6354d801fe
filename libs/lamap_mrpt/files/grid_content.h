#pragma once

#include <lamap_core/grid/evidence.h>
#include <lamap_mrpt/files/byte_stream.h>

#include <cstdint>
#include <optional>

namespace lamap
{
/** Appends the blocks of a grid: equal grids give equal bytes.
 *
 * The number of blocks (uint64); for each, by z, y, x: its index (3 × int32), a byte (1: numbers of 64 bits,
 * 2: pruned) and its packed words. */
void writeGrid(const Evidence& grid, ByteWriter& out);

/** Reads them.
 * @param like the shape and the kind of the sums, whatever it holds
 * @param planarLayer the only layer of cells that is allowed
 * @throws std::runtime_error naming the place and what cannot be; the bytes are not trusted. */
[[nodiscard]] Evidence readGrid(const Evidence& like, std::optional<int32_t> planarLayer, ByteReader& in);

}  // namespace lamap
