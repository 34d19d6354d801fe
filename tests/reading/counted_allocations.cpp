#include "counted_allocations.h"

#include <cstdlib>
#include <new>

namespace
{
thread_local size_t count = 0;

void* counted(size_t size, size_t alignment)
{
  ++count;
  const size_t whole = (size + alignment - 1) / alignment * alignment;
  void* const memory = std::aligned_alloc(alignment, whole > 0 ? whole : alignment);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}
}  // namespace

// The others of the standard library call these.
void* operator new(size_t size)
{
  return counted(size, alignof(std::max_align_t));
}
void* operator new(size_t size, std::align_val_t alignment)
{
  return counted(size, static_cast<size_t>(alignment));
}
void operator delete(void* memory) noexcept
{
  std::free(memory);
}
void operator delete(void* memory, size_t) noexcept
{
  std::free(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept
{
  std::free(memory);
}
void operator delete(void* memory, size_t, std::align_val_t) noexcept
{
  std::free(memory);
}

size_t lamap::test::allocations()
{
  return count;
}
