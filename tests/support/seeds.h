#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <string>

namespace lamap::test
{
/** Share of the usual cases that properties are tried with: less in sanitized builds, which look for other
 * faults and take ten times as long. LAMAP_SEEDS in the environment replaces it, e.g. 20 for a long search.
 */
inline double shareOfCases()
{
  if (const char* text = std::getenv("LAMAP_SEEDS")) return std::stod(text);
#ifdef LAMAP_SANITIZED
  return 0.2;
#else
  return 1;
#endif
}

/// How many seeds a property is tried with.
inline unsigned seeds(unsigned usual)
{
  return std::max(1U, static_cast<unsigned>(shareOfCases() * usual));
}

/// For sweeps over combinations of options: whether to skip this one; cases are numbered from 1.
inline bool isSkipped(uint64_t number)
{
  const double share = shareOfCases();
  return share < 1 && number % static_cast<uint64_t>(1 / share) != 0;
}

}  // namespace lamap::test
