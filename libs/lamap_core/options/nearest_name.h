#pragma once

#include <optional>
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

/// The candidate that may well be meant by a name: the one that it looks mistyped for, or else the first one
/// that begins with it, if it has three letters or more. Case counts nothing.
[[nodiscard]] std::optional<std::string> meantBy(const std::string& name,
                                                 const std::vector<std::string>& candidates);

/// "did you mean X?" where a candidate may well be meant, else "there are: A, B, C".
/// @param open, close put around X, and around each of A, B, C
[[nodiscard]] std::string suggestionFor(const std::string& name, const std::vector<std::string>& candidates,
                                        const std::string& open = "", const std::string& close = "");

}  // namespace lamap
