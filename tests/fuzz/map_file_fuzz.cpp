// Map files of one class: an input is a version and the content that its length and checksum speak of, which
// are put before it. It must be refused with a message, or give a map that answers, takes scans, and saves to
// a file that loads.
#include <lamap_mrpt/files/payload.h>
#include <lamap_mrpt/maps/CBGKMap.h>
#include <lamap_mrpt/maps/CGPMap.h>
#include <lamap_mrpt/maps/CHilbertMap.h>
#include <lamap_mrpt/maps/COverlappingHilbertMap.h>
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/serialization/CArchive.h>

#include "heap_limit.h"
#include "map_use.h"

namespace
{
using namespace lamap::fuzz;

std::vector<uint8_t> fileOf(const uint8_t* bytes, size_t size)
{
  const std::string name = CLASS_ID(lamap::LAMAP_FUZZED_MAP)->className;
  mrpt::io::CMemoryStream stream;
  auto archive = mrpt::serialization::archiveFrom(stream);
  archive << static_cast<uint8_t>(0x80U | name.size());
  archive.WriteBuffer(name.data(), name.size());
  archive << bytes[0];
  lamap::writePayload(archive, {bytes + 1, bytes + size});
  archive << uint8_t{0x88};  // the end of an object
  const auto* first = static_cast<const uint8_t*>(stream.getRawBufferData());
  return {first, first + stream.getTotalBytesCount()};
}
}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size)
{
  if (size == 0) return 0;
  std::shared_ptr<lamap::CLearnedMap> map;
  {
    const std::vector<uint8_t> file = fileOf(bytes, size);
    const HeapLimit limit(heapForFile(size));
    if (!tryTo([&] { map = mapFrom(file); })) return 0;
  }
  quieten(*map);
  requireSaves(*map);
  ask(*map);
  change(*map);
  ask(*map);
  requireSaves(*map);
  return 0;
}
