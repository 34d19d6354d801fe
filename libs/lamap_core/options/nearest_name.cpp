#include <lamap_core/options/nearest_name.h>

#include <algorithm>
#include <cctype>
#include <limits>

namespace lamap
{
namespace
{
char lower(char letter)
{
  return static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
}
}  // namespace

size_t editDistance(const std::string& a, const std::string& b)
{
  // Optimal string alignment: three rows of the dynamic programme, the oldest for swaps.
  std::vector<size_t> beforeLast(b.size() + 1);
  std::vector<size_t> last(b.size() + 1);
  std::vector<size_t> row(b.size() + 1);
  for (size_t j = 0; j <= b.size(); ++j) last[j] = j;
  for (size_t i = 1; i <= a.size(); ++i)
  {
    row[0] = i;
    for (size_t j = 1; j <= b.size(); ++j)
    {
      const bool same = lower(a[i - 1]) == lower(b[j - 1]);
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (same ? 0 : 1)});
      const bool swapped =
          i > 1 && j > 1 && lower(a[i - 1]) == lower(b[j - 2]) && lower(a[i - 2]) == lower(b[j - 1]);
      if (swapped) row[j] = std::min(row[j], beforeLast[j - 2] + 1);
    }
    beforeLast.swap(last);
    last.swap(row);
  }
  return last[b.size()];
}

bool looksLikeMistyped(const std::string& name, const std::string& meant)
{
  const size_t distance = editDistance(name, meant);
  return distance > 0 && 3 * distance <= std::max(name.size(), meant.size());
}

std::string nearestOf(const std::string& name, const std::vector<std::string>& candidates)
{
  std::string nearest;
  size_t least = std::numeric_limits<size_t>::max();
  for (const std::string& candidate : candidates)
  {
    const size_t distance = editDistance(name, candidate);
    if (distance >= least) continue;
    least = distance;
    nearest = candidate;
  }
  return nearest;
}

std::optional<std::string> meantBy(const std::string& name, const std::vector<std::string>& candidates)
{
  constexpr size_t kFewestLetters = 3;
  const std::string nearest = nearestOf(name, candidates);
  if (!nearest.empty() && (editDistance(name, nearest) == 0 || looksLikeMistyped(name, nearest)))
    return nearest;
  for (const std::string& candidate : candidates)
    if (name.size() >= kFewestLetters && editDistance(name, candidate.substr(0, name.size())) == 0)
      return candidate;
  return std::nullopt;
}

std::string suggestionFor(const std::string& name, const std::vector<std::string>& candidates,
                          const std::string& open, const std::string& close)
{
  if (const auto meant = meantBy(name, candidates)) return "did you mean " + open + *meant + close + "?";
  if (candidates.empty()) return "there are none";
  std::string text = "there are: ";
  for (size_t i = 0; i < candidates.size(); ++i) text += (i == 0 ? "" : ", ") + open + candidates[i] + close;
  return text;
}

}  // namespace lamap
