#include <lamap_mrpt/files/payload.h>
#include <mrpt/core/format.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>

namespace lamap
{
namespace
{
// Small enough that a false count costs nothing, and that MRPT's gzip streams, which take 32-bit lengths,
// hold it.
constexpr std::size_t kPayloadChunk = std::size_t{1} << 20;

uint32_t crcOf(const std::vector<uint8_t>& bytes)
{
  uLong crc = crc32(0L, Z_NULL, 0);
  for (std::size_t done = 0; done < bytes.size(); done += kPayloadChunk)
    crc = crc32(crc, bytes.data() + done, static_cast<uInt>(std::min(kPayloadChunk, bytes.size() - done)));
  return static_cast<uint32_t>(crc);
}

// CArchive::ReadBuffer may return fewer bytes than were asked for, and throws only where there are none at
// all.
std::size_t readFully(mrpt::serialization::CArchive& archive, uint8_t* to, std::size_t count)
{
  std::size_t done = 0;
  while (done < count)
  {
    std::size_t got = 0;
    try
    {
      got = archive.ReadBuffer(to + done, count - done);
    }
    catch (const EndOfContent& end)
    {
      return done + end.bytesRead();
    }
    catch (const std::exception&)
    {
      break;  // the end of the stream, as MRPT's archives report it
    }
    if (got == 0) break;
    done += got;
  }
  return done;
}

template <typename T>
T readNumber(mrpt::serialization::CArchive& archive)
{
  uint8_t bytes[sizeof(T)];
  if (readFully(archive, bytes, sizeof(T)) != sizeof(T))
    throw std::runtime_error("the map's content is truncated: it ends before its length and CRC-32");
  T number = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) number = static_cast<T>(number | T{bytes[i]} << (8 * i));
  return number;
}
}  // namespace

uint64_t memoryForContent()
{
  const long pages = sysconf(_SC_PHYS_PAGES);
  const long pageSize = sysconf(_SC_PAGESIZE);
  if (pages <= 0 || pageSize <= 0) return std::numeric_limits<uint64_t>::max();
  return static_cast<uint64_t>(pages) * static_cast<uint64_t>(pageSize) / 2;
}

void writePayload(mrpt::serialization::CArchive& archive, const std::vector<uint8_t>& payload)
{
  archive << static_cast<uint64_t>(payload.size()) << crcOf(payload);
  for (std::size_t done = 0; done < payload.size(); done += kPayloadChunk)
    archive.WriteBuffer(payload.data() + done, std::min(kPayloadChunk, payload.size() - done));
}

std::vector<uint8_t> readPayload(mrpt::serialization::CArchive& archive)
{
  const auto length = readNumber<uint64_t>(archive);
  const auto crcStored = readNumber<uint32_t>(archive);
  if (length > memoryForContent())
    throw std::runtime_error(
        "the map's content claims " + std::to_string(length) + " bytes, more than this machine can hold (" +
        std::to_string(memoryForContent()) + "): it is damaged, or the map is too large here");

  std::vector<uint8_t> payload;
  // Room costs memory only as it is filled; growing would hold the content twice.
  constexpr uint64_t kMostRoom = uint64_t{1} << 30;
  payload.reserve(static_cast<std::size_t>(std::min(length, kMostRoom)));
  while (payload.size() < length)
  {
    const std::size_t before = payload.size();
    const std::size_t wanted = static_cast<std::size_t>(std::min<uint64_t>(kPayloadChunk, length - before));
    // Doubles with what has really come, and ends with no more than the content needs.
    if (payload.capacity() < before + wanted)
      payload.reserve(static_cast<std::size_t>(std::min<uint64_t>(length, 2 * (before + wanted))));
    payload.resize(before + wanted);
    const std::size_t got = readFully(archive, payload.data() + before, wanted);
    if (got != wanted)
      throw std::runtime_error("the map's content is truncated: " + std::to_string(before + got) + " of " +
                               std::to_string(length) + " bytes are there");
  }
  if (const uint32_t crc = crcOf(payload); crc != crcStored)
    throw std::runtime_error(mrpt::format(
        "the map's content is damaged: its CRC-32 is %08x, the file states %08x", crc, crcStored));
  return payload;
}

void refuseVersion(const char* className, uint8_t version, uint8_t newestKnown)
{
  const std::string what = "a " + std::string(className) + " of format version " + std::to_string(version);
  const std::string known = "; this program reads up to version " + std::to_string(newestKnown);
  throw std::runtime_error(what + known +
                           (version > newestKnown ? ": it was written by a newer mrpt-lamap" : ""));
}

}  // namespace lamap
