#pragma once

#include <lamap_core/overlapping/map.h>
#include <lamap_mrpt/files/byte_stream.h>

namespace lamap
{
/// Appends what an overlapping Hilbert map holds, without its options: equal content gives equal bytes.
void writeOverlappingMap(const OverlappingHilbertMap& map, ByteWriter& out);

/** Reads it into an empty map of the same structure.
 * @param version of the format: models of version 1 keep no hits
 * @throws std::runtime_error naming the place and what cannot be; the bytes are not trusted. */
void readOverlappingMap(OverlappingHilbertMap& map, ByteReader& in, uint8_t version);

}  // namespace lamap
