#pragma once

#include <cstddef>

namespace lamap::fuzz
{
/** While it lives, the heap may grow by so many bytes; more ends the program, where the allocation is. One at
 * a time. */
class HeapLimit
{
 public:
  explicit HeapLimit(size_t bytes);
  ~HeapLimit();
  HeapLimit(const HeapLimit&) = delete;
  HeapLimit& operator=(const HeapLimit&) = delete;
};

/// What reading a file of this size may take: 64 MiB and 100 times its size.
constexpr size_t heapForFile(size_t bytes)
{
  return (size_t{64} << 20) + 100 * bytes;
}

}  // namespace lamap::fuzz
