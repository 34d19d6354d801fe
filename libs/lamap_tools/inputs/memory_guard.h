#pragma once

#include <sys/resource.h>

#include <cstddef>

namespace lamap::tools
{
/** Limits how many more bytes the process can allocate during its lifetime: an allocation beyond the limit
 * throws std::bad_alloc.
 *
 * A damaged file may state that billions of elements follow; MRPT reserves them before it reads. The limit
 * applies to the whole process, so nothing else should allocate at the same time. Has no effect if the system
 * does not report how much memory is in use.
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
