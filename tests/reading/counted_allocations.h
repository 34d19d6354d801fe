#pragma once

#include <cstddef>

namespace lamap::test
{
/// How often this thread has called operator new.
size_t allocations();
}  // namespace lamap::test
