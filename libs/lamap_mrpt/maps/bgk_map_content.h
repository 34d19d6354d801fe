#pragma once

#include <lamap_core/bgk/map.h>
#include <lamap_mrpt/files/byte_stream.h>
#include <lamap_mrpt/maps/CBGKMap.h>

namespace lamap
{
/** Appends what a BGK map is made with, its evidence and its prior map: equal maps give equal bytes.
 *
 * The options of creation, as a group; the number of blocks (uint64); for each block, by z, y, x: its index
 * (3 × int32), a byte (1: counts of 64 bits, 2: pruned) and its packed words; then 1 and the prior map
 * likewise, or 0. */
void writeBgkMap(const CBGKMap::TCreationOptions& options, const BgkMap& map, ByteWriter& out);

/** Reads it again.
 * @param options receives the options of creation
 * @throws std::runtime_error naming the place and what cannot be; the bytes are not trusted. */
[[nodiscard]] BgkMap readBgkMap(CBGKMap::TCreationOptions& options, ByteReader& in);

}  // namespace lamap
