#pragma once

#include <string>
#include <vector>

namespace lamap
{
/// Letters to insert, delete, replace or swap with a neighbour to turn one name into the other; case counts
/// nothing.
[[nodiscard]] size_t editDistance(const std::string& a, const std::string& b);

/// Whether a name may well be a mistyped other one: at most a third of its letters differ, and it is not the
/// same.
[[nodiscard]] bool looksLikeMistyped(const std::string& name, const std::string& meant);

/// The candidate with the least edit distance, the first of equals; empty if there is no candidate.
[[nodiscard]] std::string nearestOf(const std::string& name, const std::vector<std::string>& candidates);

}  // namespace lamap
