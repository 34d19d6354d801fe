#pragma once

#include <lamap_core/hilbert/map.h>
#include <lamap_mrpt/files/byte_stream.h>

namespace lamap
{
/// What a Hilbert map has learned as bytes, the same for the same content; its options apart.
void writeHilbertState(const HilbertState& state, ByteWriter& out);
/// @throws std::runtime_error saying where the bytes end too early; HilbertMap::restore() judges the content.
[[nodiscard]] HilbertState readHilbertState(ByteReader& in);

}  // namespace lamap
