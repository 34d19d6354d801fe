#pragma once

#include <lamap_core/overlapping/map.h>
#include <lamap_mrpt/files/byte_stream.h>

namespace lamap
{
/// What an overlapping Hilbert map holds as bytes, the same for the same content; its options apart.
void writeOverlappingMap(const OverlappingHilbertMap& map, ByteWriter& out);

/** Reads it again, into a map of the same structure that is empty.
 * @throws std::runtime_error naming the place and what cannot be; the bytes are not trusted. */
void readOverlappingMap(OverlappingHilbertMap& map, ByteReader& in);

}  // namespace lamap
