#pragma once

#include <mrpt/obs/CObservation.h>

#include <cstdint>
#include <optional>

namespace lamap
{
/// 128 bits that differ where the rays of two observations may differ.
struct ObservationFingerprint
{
  uint64_t high = 0;
  uint64_t low = 0;

  friend bool operator==(const ObservationFingerprint& a, const ObservationFingerprint& b)
  {
    return a.high == b.high && a.low == b.low;
  }
};

/** Recognizes an observation by all that its rays follow from: a particle filter asks for the same one
 * thousands of times in a row, and neither its address nor its time stamp tells it from the next one.
 *
 * Reads all of it, at the speed of the memory. Data that is stored outside and not loaded counts by its
 * file's name.
 * @return nothing for a class that raysOf() does not read, or whose rays are as quick to make. */
[[nodiscard]] std::optional<ObservationFingerprint> fingerprintOf(const mrpt::obs::CObservation& observation);

}  // namespace lamap
