#pragma once

#include <mrpt/obs/CObservation.h>

#include <cstdint>
#include <optional>

namespace lamap
{
/// 128 bits that differ if the rays of two observations may differ.
struct ObservationFingerprint
{
  uint64_t high = 0;
  uint64_t low = 0;

  friend bool operator==(const ObservationFingerprint& a, const ObservationFingerprint& b)
  {
    return a.high == b.high && a.low == b.low;
  }
};

/** Identifies an observation by everything that determines its rays: a particle filter passes the same one
 * thousands of times in a row, and neither its address nor its time stamp distinguishes it from the next one.
 *
 * Reads the whole observation, at the speed of memory. External data that is not loaded counts by its file
 * name.
 * @return empty for a class that raysOf() does not read, or whose rays are as quick to compute. */
[[nodiscard]] std::optional<ObservationFingerprint> fingerprintOf(const mrpt::obs::CObservation& observation);

}  // namespace lamap
