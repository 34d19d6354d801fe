#pragma once

#include <mrpt/serialization/CArchive.h>

#include <cstdint>
#include <stdexcept>
#include <vector>

namespace lamap
{
/** Writes bytes so that a reader notices every loss: their count (uint64), their CRC-32 (zlib's, uint32), the
 * bytes.
 *
 * MRPT's archives have no checksum of their own: a flipped bit would be read as another map. Errors of the
 * archive pass through.
 */
void writePayload(mrpt::serialization::CArchive& archive, const std::vector<uint8_t>& payload);

/// Thrown by an archive that ends within what was asked for, and has handed over what there was.
class EndOfContent : public std::runtime_error
{
 public:
  explicit EndOfContent(std::size_t bytesRead)
      : std::runtime_error("the content ends too early"), bytesRead_(bytesRead)
  {
  }
  [[nodiscard]] std::size_t bytesRead() const { return bytesRead_; }

 private:
  std::size_t bytesRead_;
};

/** Reads what writePayload wrote.
 *
 * Memory grows only with bytes that are really there, whatever count a damaged archive claims, and never
 * beyond the machine's memory.
 * @throws std::runtime_error if the archive ends too early, the CRC-32 differs, or the count is beyond
 *         memoryForContent().
 */
[[nodiscard]] std::vector<uint8_t> readPayload(mrpt::serialization::CArchive& archive);

/** The largest content of a map file that this machine can make a map of [bytes]: half its physical memory,
 * since the map takes about as much again. The largest number where the system does not tell. */
[[nodiscard]] uint64_t memoryForContent();

/// Throws std::runtime_error for a format version that is not read here: "format version 3; this program
/// reads up to version 1 …".
[[noreturn]] void refuseVersion(const char* className, uint8_t version, uint8_t newestKnown);

}  // namespace lamap
