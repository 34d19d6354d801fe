#pragma once

#include <lamap_core/hilbert/map.h>
#include <lamap_mrpt/files/byte_stream.h>

namespace lamap
{
/// Appends what a Hilbert map has learned, without its options: equal content gives equal bytes.
void writeHilbertState(const HilbertState& state, ByteWriter& out);
/** @param version of the format: maps of version 1 know no seen cells, those of version 2 no passes
 * @throws std::runtime_error saying where the bytes end too early; HilbertMap::restore() judges the content.
 */
[[nodiscard]] HilbertState readHilbertState(ByteReader& in, uint8_t version);

}  // namespace lamap
