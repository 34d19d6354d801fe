#pragma once

// Single numbers of BgkReading, for sources of the library that ask for many: they are part of what calls
// them.

#include <lamap_core/bgk/reading.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace lamap
{
/// The evidence of a cell with its prior.
struct PseudoCounts
{
  PseudoCounts(const CellSums& sums, const std::array<double, 2>& prior, double maxEvidence)
      : hits(inCounts(sums.first)), free(inCounts(sums.second))
  {
    const double factor = evidenceFactor(hits + free, maxEvidence);
    alpha = prior[0] + factor * hits;
    beta = prior[1] + factor * free;
  }

  double hits;
  double free;
  double alpha;
  double beta;

 private:
  /// Sums are below 2^63: signed numbers are quicker to convert.
  static double inCounts(uint64_t sum)
  {
    return static_cast<double>(static_cast<int64_t>(sum)) * kEvidenceUnit;
  }
};

/// P(occupied) of BgkReading::read(), to the last bit.
[[nodiscard]] inline double probOf(const BgkReading& reading, const CellIndex& cell, const CellSums& sums)
{
  const BgkStructure& structure = reading.structure();
  const bool isMapped = reading.hasPriorMap();
  const std::array<double, 2> prior =
      isMapped ? reading.priorOf(cell) : std::array<double, 2>{structure.priorAlpha, structure.priorBeta};
  const PseudoCounts counts(sums, prior, structure.maxEvidence);
  return counts.alpha / (counts.alpha + counts.beta);  // Eq. (4.1)
}

/// probOf() of many cells without a prior map, in a form that compilers turn into instructions for several at
/// once. @param sums first | second << 32, as blocks hold them
inline void probsOf(const BgkReading& reading, const uint64_t* sums, size_t count, double* probs)
{
  const BgkStructure& structure = reading.structure();
  // The number in the lower bits of 2^52, which no conversion of unsigned numbers has to find.
  constexpr uint64_t kTwoTo52Bits = 0x4330000000000000u;
  constexpr double kTwoTo52 = 4503599627370496.0;
  const auto countOf = [](uint64_t sum)
  {
    const uint64_t bits = sum | kTwoTo52Bits;
    double number = 0;
    std::memcpy(&number, &bits, sizeof(number));
    return (number - kTwoTo52) * kEvidenceUnit;
  };
  const double alpha = structure.priorAlpha;
  const double beta = structure.priorBeta;
  const double most = structure.maxEvidence;
  if (most > 0)
  {
    for (size_t i = 0; i < count; ++i)
    {
      const double hits = countOf(sums[i] & 0xFFFFFFFFu);
      const double free = countOf(sums[i] >> 32);
      const double factor = hits + free > most ? most / (hits + free) : 1.0;
      const double all = alpha + factor * hits;
      probs[i] = all / (all + (beta + factor * free));
    }
    return;
  }
  for (size_t i = 0; i < count; ++i)
  {
    const double all = alpha + countOf(sums[i] & 0xFFFFFFFFu);
    probs[i] = all / (all + (beta + countOf(sums[i] >> 32)));
  }
}

/// Its state. @param prob of the cell
[[nodiscard]] inline CellState stateOf(const BgkReading& reading, const CellIndex& cell, const CellSums& sums,
                                       double prob, const StateThresholds& thresholds)
{
  return thresholds.variance > 0 ? reading.read(cell, sums, thresholds).state : stateOf(prob, thresholds);
}

}  // namespace lamap
