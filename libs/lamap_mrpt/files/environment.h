#pragma once

#include <cstdint>
#include <optional>

namespace lamap
{
/** A limit that the user set in the environment: a number of at least 1; "2e9" is one.
 * @return the whole part of it, or the largest number if it is larger; nothing if the variable is not set
 * @throws std::runtime_error naming the variable and its text if that is no such number */
[[nodiscard]] std::optional<uint64_t> limitFromEnvironment(const char* name);

}  // namespace lamap
