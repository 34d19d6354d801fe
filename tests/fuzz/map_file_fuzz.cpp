// Changes bytes of map files, keeps their length and checksum right, and uses what still loads.
//
//   map_file_fuzz SECONDS SEED FOLDER FILE.lamap.gz...
//
// A file must be refused with a message, or give a map that answers, takes scans, and saves to a file that
// loads. Inputs are tried in processes of their own; one that crashes, hangs or breaks this is kept in
// FOLDER. Ends with 1 if there is any.
#include <lamap_mrpt/files/byte_stream.h>
#include <lamap_mrpt/files/map_file.h>
#include <lamap_mrpt/files/payload.h>
#include <lamap_mrpt/maps/CBGKMap.h>
#include <lamap_mrpt/maps/CGPMap.h>
#include <lamap_mrpt/maps/CHilbertMap.h>
#include <lamap_mrpt/maps/COverlappingHilbertMap.h>
#include <mrpt/io/CFileGZInputStream.h>
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/opengl/CSetOfObjects.h>
#include <mrpt/serialization/CArchive.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace
{
using namespace lamap;
using Bytes = std::vector<uint8_t>;

/// A map file as it is inflated.
struct Sample
{
  std::string path;
  Bytes header;   ///< of the object, as MRPT's archives have it
  Bytes payload;  ///< what its length and checksum speak of
};

Bytes inflated(const std::string& path)
{
  gzFile file = gzopen(path.c_str(), "rb");
  Bytes bytes;
  uint8_t some[4096];
  for (int count = 0; file != nullptr && (count = gzread(file, some, sizeof(some))) > 0;)
    bytes.insert(bytes.end(), some, some + count);
  if (file != nullptr) gzclose(file);
  return bytes;
}

Sample sampleOf(const std::string& path)
{
  const Bytes bytes = inflated(path);
  const size_t header = bytes.empty() ? 0 : size_t{bytes[0] & 0x7fu} + 2;
  const size_t payload = header + sizeof(uint64_t) + sizeof(uint32_t);
  if (bytes.size() < payload)
  {
    std::fprintf(stderr, "%s: not a map file\n", path.c_str());
    std::exit(2);
  }
  return {path,
          {bytes.begin(), bytes.begin() + static_cast<long>(header)},
          {bytes.begin() + static_cast<long>(payload), bytes.end() - 1}};
}

Bytes fileOf(const Sample& sample, const Bytes& payload)
{
  ByteWriter out;
  out.numbers(sample.header.data(), sample.header.size());
  out.number<uint64_t>(payload.size());
  out.number(
      static_cast<uint32_t>(crc32(crc32(0, nullptr, 0), payload.data(), static_cast<uInt>(payload.size()))));
  out.numbers(payload.data(), payload.size());
  out.number<uint8_t>(0x88);  // the end of an object in MRPT's archives
  return out.take();
}

template <typename Number>
void put(Bytes& bytes, size_t at, Number number)
{
  if (at + sizeof(number) <= bytes.size()) std::memcpy(bytes.data() + at, &number, sizeof(number));
}

Bytes changed(const Bytes& payload, std::mt19937_64& random)
{
  Bytes bytes = payload;
  constexpr double kInf = std::numeric_limits<double>::infinity();
  const std::vector<double> doubles{std::nan(""), kInf,  -kInf, 1e300, -1e300, 1e12,
                                    1e9,          2.1e9, -1,    0,     1e-300};
  const std::vector<int64_t> wholes{INT32_MAX, INT32_MIN, -1, 0, 1, 1 << 20, -(1 << 28), INT64_MAX, 1 << 30};
  const int changes = 1 + static_cast<int>(random() % 3);
  for (int i = 0; i < changes && !bytes.empty(); ++i)
  {
    const size_t at = random() % bytes.size();
    switch (random() % 7)
    {
      case 0:
        bytes[at] = static_cast<uint8_t>(random());
        break;
      case 1:
        bytes[at] ^= static_cast<uint8_t>(1u << random() % 8);
        break;
      case 2:
        put(bytes, at, doubles[random() % doubles.size()]);
        break;
      case 3:
        put(bytes, at, static_cast<float>(doubles[random() % doubles.size()]));
        break;
      case 4:
        put(bytes, at, static_cast<int32_t>(wholes[random() % wholes.size()]));
        break;
      case 5:
        put(bytes, at, wholes[random() % wholes.size()]);
        break;
      default:
        bytes.erase(bytes.begin() + static_cast<long>(at),
                    bytes.begin() + static_cast<long>(std::min(bytes.size(), at + random() % 16)));
    }
  }
  return bytes;
}

Bytes bytesOf(const mrpt::serialization::CSerializable& object)
{
  mrpt::io::CMemoryStream stream;
  auto archive = mrpt::serialization::archiveFrom(stream);
  archive << object;
  const auto* first = static_cast<const uint8_t*>(stream.getRawBufferData());
  return {first, first + stream.getTotalBytesCount()};
}

std::shared_ptr<CLearnedMap> mapFrom(const Bytes& bytes)
{
  mrpt::io::CMemoryStream stream;
  stream.assignMemoryNotOwn(bytes.data(), bytes.size());
  auto archive = mrpt::serialization::archiveFrom(stream);
  return std::dynamic_pointer_cast<CLearnedMap>(archive.ReadObject());
}

/// What may be refused for good reasons: a scan too long for the cells, a sum that would overflow.
template <typename Change>
void tryTo(Change&& change)
{
  try
  {
    change();
  }
  catch (const std::exception&)
  {
  }
}

/// Cells may be many: enough of them are seen.
struct Enough
{
};

void use(CLearnedMap& map)
{
  map.setThreadCount(1);
  map.setMinLoggingLevel(mrpt::system::LVL_ERROR);
  map.logging_enable_console_output = false;
  size_t cells = 0;
  try
  {
    map.visitCells(
        [&](const CellIndex& cell, const CellEstimate& estimate)
        {
          if (!(estimate.prob >= 0 && estimate.prob <= 1)) std::abort();
          (void)map.estimateCell(cell);
          if (++cells > 20000) throw Enough();
        });
  }
  catch (const Enough&)
  {
  }
  (void)map.estimateAt({1, 0.2, 0.3});
  (void)map.estimateAt({1e300, -1e300, 1e12});
  (void)map.estimateCell({INT32_MAX, INT32_MIN, INT32_MAX});
  if (cells > 20000) return;
  mrpt::math::TPoint3D end;
  (void)map.castRay({0.1, 0.2, 0.3}, {1, 0.1, 0}, end, true, 0);
  (void)map.boundingBox();
  const auto objects = mrpt::opengl::CSetOfObjects::Create();
  map.getVisualizationInto(*objects);
  tryTo([&] { map.insertRay(1, 0.2f, 0.1f, 0, 0, 0); });
  tryTo([&] { map.updateVoxel(0.5, 0.5, 0.5, true); });
  if (auto* models = dynamic_cast<COverlappingHilbertMap*>(&map);
      models != nullptr && models->modelCount() > 0)
    tryTo([&]
          { models->setModelPose(0, models->modelPose(0) + mrpt::poses::CPose3D(0.3, 0.1, 0, 0.1, 0, 0)); });
  const auto merge = [&](auto* own)
  {
    if (own == nullptr) return;
    const auto other = *own;
    tryTo([&] { own->merge(other); });
  };
  merge(dynamic_cast<CBGKMap*>(&map));
  merge(dynamic_cast<CGPMap*>(&map));
  merge(dynamic_cast<COverlappingHilbertMap*>(&map));
}

/// @throws std::logic_error where a map that was let in does not save to a file that loads
void tryOne(const Bytes& file)
{
  std::shared_ptr<CLearnedMap> map;
  tryTo([&] { map = mapFrom(file); });
  if (!map) return;
  const auto requireSaves = [&](const char* when)
  {
    const Bytes saved = bytesOf(*map);
    if (bytesOf(*mapFrom(saved)) != saved)
      throw std::logic_error(std::string("saves to other bytes ") + when);
  };
  requireSaves("at once");
  use(*map);
  requireSaves("after it was used");
}

/// What a process is at, for the one that watches it.
struct Progress
{
  uint64_t input;
};

/// Tries inputs until the time is over.
void run(const std::vector<Sample>& samples, uint64_t seed, uint64_t first, double seconds,
         Progress& progress)
{
  const rlimit memory{rlim_t{3} << 30, rlim_t{3} << 30};
  setrlimit(RLIMIT_AS, &memory);
  const auto begin = time(nullptr);
  for (progress.input = first; difftime(time(nullptr), begin) < seconds; ++progress.input)
  {
    constexpr unsigned kMostSeconds = 60;
    alarm(kMostSeconds);
    std::mt19937_64 random(seed * 1000003 + progress.input);
    const Sample& sample = samples[random() % samples.size()];
    tryOne(fileOf(sample, changed(sample.payload, random)));
  }
}

void keep(const std::vector<Sample>& samples, uint64_t seed, uint64_t input, const std::string& path)
{
  std::mt19937_64 random(seed * 1000003 + input);
  const Sample& sample = samples[random() % samples.size()];
  const Bytes file = fileOf(sample, changed(sample.payload, random));
  gzFile out = gzopen(path.c_str(), "wb");
  gzwrite(out, file.data(), static_cast<unsigned>(file.size()));
  gzclose(out);
  std::fprintf(stderr, "%s, made of %s\n", path.c_str(), sample.path.c_str());
}
}  // namespace

int main(int argc, char** argv)
{
  if (argc < 5)
  {
    std::fprintf(stderr, "usage: map_file_fuzz SECONDS SEED FOLDER FILE.lamap.gz...\n");
    return 2;
  }
  const double seconds = std::atof(argv[1]);
  const auto seed = static_cast<uint64_t>(std::atoll(argv[2]));
  std::vector<Sample> samples;
  for (int i = 4; i < argc; ++i) samples.push_back(sampleOf(argv[i]));
  auto* progress = static_cast<Progress*>(
      mmap(nullptr, sizeof(Progress), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0));
  const auto begin = time(nullptr);
  int failures = 0;
  uint64_t next = 0;
  while (difftime(time(nullptr), begin) < seconds)
  {
    const pid_t child = fork();
    if (child == 0)
    {
      try
      {
        run(samples, seed, next, seconds - difftime(time(nullptr), begin), *progress);
      }
      catch (const std::bad_alloc&)
      {
        _exit(0);  // more than the limit: refused
      }
      catch (const std::exception& error)
      {
        std::fprintf(stderr, "input %llu: %s\n", static_cast<unsigned long long>(progress->input),
                     error.what());
        _exit(1);
      }
      _exit(0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    next = progress->input + 1;
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) continue;
    ++failures;
    if (WIFSIGNALED(status))
      std::fprintf(stderr, "input %llu: %s\n", static_cast<unsigned long long>(progress->input),
                   strsignal(WTERMSIG(status)));
    keep(samples, seed, progress->input,
         std::string(argv[3]) + "/" + std::to_string(seed) + "-" + std::to_string(progress->input) +
             ".lamap.gz");
  }
  std::printf("%llu inputs, %d failures\n", static_cast<unsigned long long>(next), failures);
  return failures > 0 ? 1 : 0;
}
