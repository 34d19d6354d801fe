#pragma once

#include <sys/resource.h>

#include <cstddef>

namespace lamap::tools
{
/** While it lives the process cannot take more than so many bytes beyond what it has: an allocation that
 * would throws std::bad_alloc.
 *
 * A damaged file may state that billions of elements follow; MRPT reserves them before it reads. The limit is
 * the whole process's, so nothing else should allocate meanwhile. Does nothing where the system does not say
 * how much memory is in use.
 */
class MemoryGuard
{
 public:
  explicit MemoryGuard(size_t bytes);
  ~MemoryGuard();
  MemoryGuard(const MemoryGuard&) = delete;
  MemoryGuard& operator=(const MemoryGuard&) = delete;

 private:
  rlimit before_{};
  bool active_ = false;
};

}  // namespace lamap::tools
