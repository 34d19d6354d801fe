#pragma once

#include <string>

namespace lamap::tools
{
/// Letters to insert, delete, replace or swap with a neighbour to turn one name into the other; case counts
/// nothing.
[[nodiscard]] size_t editDistance(const std::string& a, const std::string& b);

/// Whether a name may well be a mistyped other one: at most a third of its letters differ, and it is not the
/// same.
[[nodiscard]] bool looksLikeMistyped(const std::string& name, const std::string& meant);

}  // namespace lamap::tools
