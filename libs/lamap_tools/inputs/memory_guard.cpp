#include <lamap_tools/inputs/memory_guard.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

namespace lamap::tools
{
namespace
{
/// Address space of this process [bytes]; 0 if unknown.
size_t addressSpaceInUse()
{
  std::ifstream file("/proc/self/statm");
  size_t pages = 0;
  file >> pages;
  return pages * static_cast<size_t>(sysconf(_SC_PAGESIZE));
}
}  // namespace

MemoryGuard::MemoryGuard(size_t bytes)
{
  const size_t inUse = addressSpaceInUse();
  if (inUse == 0 || getrlimit(RLIMIT_AS, &before_) != 0) return;
  rlimit limit = before_;
  limit.rlim_cur = std::min<rlim_t>(before_.rlim_cur, inUse + bytes);
  active_ = setrlimit(RLIMIT_AS, &limit) == 0;
}

MemoryGuard::~MemoryGuard()
{
  if (active_) setrlimit(RLIMIT_AS, &before_);
}

}  // namespace lamap::tools
