#pragma once

#include <lamap_core/grid/cell.h>
#include <lamap_mrpt/files/byte_stream.h>

#include <Eigen/Core>
#include <vector>

// Building blocks of the content of map files.
namespace lamap
{
constexpr size_t kIndexBytes = 3 * sizeof(int32_t);
constexpr size_t kPlaceBytes = 3 * sizeof(double);

/// @tparam Index CellIndex or BlockIndex
template <typename Index>
void writeIndex(const Index& index, ByteWriter& out)
{
  for (const int32_t i : {index.x, index.y, index.z}) out.number(i);
}
template <typename Index>
[[nodiscard]] Index readIndex(ByteReader& in)
{
  Index index;
  for (int32_t* i : {&index.x, &index.y, &index.z}) *i = in.number<int32_t>();
  return index;
}

/// Entries of a matrix of fixed size, column by column.
template <typename Matrix>
void writeMatrix(const Matrix& matrix, ByteWriter& out)
{
  out.numbers(matrix.data(), static_cast<size_t>(matrix.size()));
}
template <typename Matrix>
[[nodiscard]] Matrix readMatrix(ByteReader& in)
{
  Matrix matrix;
  in.numbers(matrix.data(), static_cast<size_t>(matrix.size()));
  return matrix;
}

/// A count (uint64), then that many elements.
template <typename Element, typename Write>
void writeAll(const std::vector<Element>& all, ByteWriter& out, Write&& write)
{
  out.number<uint64_t>(all.size());
  for (const Element& element : all) write(element);
}
/// @param leastBytes of an element: room is made for no more than the remaining bytes can hold
template <typename Element, typename Read>
void readAll(std::vector<Element>& all, size_t leastBytes, ByteReader& in, Read&& read)
{
  const auto count = in.number<uint64_t>();
  in.requireElements(count, leastBytes);
  all.reserve(count);
  for (uint64_t i = 0; i < count; ++i) all.push_back(read());
}

}  // namespace lamap
