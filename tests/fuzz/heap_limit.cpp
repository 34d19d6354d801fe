#include "heap_limit.h"

#include <sanitizer/allocator_interface.h>

#include <atomic>
#include <cstdint>

#include "map_use.h"

namespace lamap::fuzz
{
namespace
{
std::atomic<int64_t> inUse{0};
std::atomic<int64_t> most{INT64_MAX};

void allocated(const volatile void* /*place*/, size_t bytes)
{
  const auto size = static_cast<int64_t>(bytes);
  if (inUse.fetch_add(size) + size <= most) return;
  most = INT64_MAX;  // for the report
  breakPromise("reading a file takes no more than 64 MiB and 100 times its size");
}

void freed(const volatile void* place)
{
  if (place != nullptr) inUse -= static_cast<int64_t>(__sanitizer_get_allocated_size(place));
}
}  // namespace

HeapLimit::HeapLimit(size_t bytes)
{
  static const int isInstalled = __sanitizer_install_malloc_and_free_hooks(allocated, freed);
  if (isInstalled == 0) breakPromise("allocations are seen");
  most = inUse + static_cast<int64_t>(bytes);
}

HeapLimit::~HeapLimit()
{
  most = INT64_MAX;
}

}  // namespace lamap::fuzz
