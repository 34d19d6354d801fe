#include <gtest/gtest.h>
#include <lamap_mrpt/files/atomic_file.h>
#include <lamap_mrpt/files/byte_stream.h>
#include <lamap_mrpt/files/map_file.h>
#include <lamap_mrpt/files/payload.h>
#include <mrpt/io/CFileGZInputStream.h>
#include <mrpt/io/CFileGZOutputStream.h>
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/opengl/CSetOfObjects.h>
#include <mrpt/poses/CPose3D.h>
#include <mrpt/serialization/CArchive.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <limits>
#include <numeric>
#include <random>
#include <sstream>

namespace lamap::test
{
/// A map that stores its content like this library's maps: in one payload.
class CPayloadMap : public mrpt::maps::CMetricMap
{
  DEFINE_SERIALIZABLE(CPayloadMap, lamap::test)

 public:
  std::vector<uint8_t> content;

  bool isEmpty() const override { return content.empty(); }
  void saveMetricMapRepresentationToFile(const std::string&) const override {}
  void getVisualizationInto(mrpt::opengl::CSetOfObjects&) const override {}
  std::string asString() const override { return "CPayloadMap"; }

 private:
  void internal_clear() override { content.clear(); }
  bool internal_insertObservation(const mrpt::obs::CObservation&,
                                  const std::optional<const mrpt::poses::CPose3D>&) override
  {
    return false;
  }
  double internal_computeObservationLikelihood(const mrpt::obs::CObservation&,
                                               const mrpt::poses::CPose3D&) const override
  {
    return 0;
  }
};

IMPLEMENTS_SERIALIZABLE(CPayloadMap, CMetricMap, lamap::test)

uint8_t CPayloadMap::serializeGetVersion() const
{
  return 3;
}
void CPayloadMap::serializeTo(mrpt::serialization::CArchive& out) const
{
  lamap::writePayload(out, content);
}
void CPayloadMap::serializeFrom(mrpt::serialization::CArchive& in, uint8_t)
{
  content = lamap::readPayload(in);
}
const bool kRegistered = (mrpt::rtti::registerClass(CLASS_ID(CPayloadMap)), true);
}  // namespace lamap::test

namespace
{
namespace fs = std::filesystem;
using lamap::AtomicFile;
using lamap::ByteReader;
using lamap::ByteWriter;
using lamap::loadMapFile;
using lamap::saveMapFile;
using lamap::test::CPayloadMap;

class Folder
{
 public:
  Folder()
  {
    std::string name = (fs::path(::testing::TempDir()) / "lamap_files_XXXXXX").string();
    if (!mkdtemp(name.data())) throw std::runtime_error("no temporary folder");
    path_ = name;
  }
  ~Folder() { fs::remove_all(path_); }
  [[nodiscard]] std::string at(const std::string& name) const { return (path_ / name).string(); }
  [[nodiscard]] std::vector<std::string> names() const
  {
    std::vector<std::string> found;
    for (const auto& entry : fs::directory_iterator(path_)) found.push_back(entry.path().filename().string());
    std::sort(found.begin(), found.end());
    return found;
  }

 private:
  fs::path path_;
};

using Names = std::vector<std::string>;

std::string contentOf(const std::string& path)
{
  std::ifstream file(path, std::ios::binary);
  std::ostringstream content;
  content << file.rdbuf();
  return content.str();
}

void put(const std::string& path, const std::string& content)
{
  std::ofstream file(path, std::ios::binary);
  file << content;
  ASSERT_TRUE(file.good());
}

template <typename Action>
std::string errorOf(const Action& action)
{
  try
  {
    action();
  }
  catch (const std::runtime_error& error)
  {
    return error.what();
  }
  return "no error";
}

#define EXPECT_ERROR(action, part)                                                  \
  do                                                                                \
  {                                                                                 \
    const std::string errorText = errorOf([&] { static_cast<void>(action); });      \
    EXPECT_NE(errorText.find(part), std::string::npos) << "it says: " << errorText; \
  } while (false)

/// Writing files beyond the limit fails with EFBIG: like a full disk, without privileges.
class FileSizeLimit
{
 public:
  explicit FileSizeLimit(rlim_t bytes)
  {
    handler_ = std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &before_);
    rlimit limit = before_;
    limit.rlim_cur = bytes;
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit()
  {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  rlimit before_{};
  void (*handler_)(int);
};

/// A disk of 64 KiB; isMounted() is false if mounting is not allowed.
class TinyDisk
{
 public:
  explicit TinyDisk(std::string folder) : folder_(std::move(folder))
  {
    fs::create_directory(folder_);
    mounted_ = ::mount("lamap", folder_.c_str(), "tmpfs", 0, "size=64k") == 0;
  }
  ~TinyDisk()
  {
    if (mounted_) ::umount(folder_.c_str());
  }
  TinyDisk(const TinyDisk&) = delete;
  TinyDisk& operator=(const TinyDisk&) = delete;
  [[nodiscard]] bool isMounted() const { return mounted_; }

 private:
  std::string folder_;
  bool mounted_ = false;
};

// ---- Byte stream ----

TEST(ByteStream, ReadsWhatWasWritten)
{
  ByteWriter writer;
  writer.number(true);
  writer.number<int8_t>(-3);
  writer.number<uint64_t>(0x1122334455667788u);
  writer.number(-0.0);
  writer.number(1.5f);
  writer.text("Straße");
  writer.text("");
  writer.vector(std::vector<int32_t>{1, -2, 3});
  const double three[3] = {1, 2, 3};
  writer.numbers(three, 3);
  const auto bytes = writer.take();
  EXPECT_TRUE(writer.bytes().empty());

  ByteReader reader(bytes);
  EXPECT_TRUE(reader.number<bool>());
  EXPECT_EQ(reader.number<int8_t>(), -3);
  EXPECT_EQ(reader.number<uint64_t>(), 0x1122334455667788u);
  EXPECT_TRUE(std::signbit(reader.number<double>()));
  EXPECT_EQ(reader.number<float>(), 1.5f);
  EXPECT_EQ(reader.text(), "Straße");
  EXPECT_EQ(reader.text(), "");
  EXPECT_EQ(reader.vector<int32_t>(), (std::vector<int32_t>{1, -2, 3}));
  double read[3];
  reader.numbers(read, 3);
  EXPECT_EQ(read[2], 3);
  EXPECT_NO_THROW(reader.expectEnd());
}

TEST(ByteStream, StoresTheLeastSignificantByteFirst)
{
  ByteWriter writer;
  writer.number<uint32_t>(0x01020304);
  EXPECT_EQ(writer.bytes(), (std::vector<uint8_t>{4, 3, 2, 1}));
}

TEST(ByteStream, RefusesToReadBeyondTheEnd)
{
  ByteWriter writer;
  writer.vector(std::vector<double>{1, 2});
  auto bytes = writer.take();
  for (std::size_t size = 0; size < bytes.size(); ++size)
  {
    SCOPED_TRACE(size);
    ByteReader reader(bytes.data(), size);
    EXPECT_THROW(static_cast<void>(reader.vector<double>()), std::runtime_error);
  }
  bytes.assign(8, 0xff);  // 2^64 − 1 elements: refused before anything is allocated
  ByteReader huge(bytes);
  EXPECT_ERROR(huge.vector<double>(), "18446744073709551615 x 8 bytes are due, 0 are left");
  ByteReader text(bytes);
  EXPECT_ERROR(text.text(), "at byte 4 of 8");
  ByteReader rest(bytes);
  EXPECT_ERROR(rest.expectEnd(), "8 bytes are left over");
  ByteReader yesNo(bytes);
  EXPECT_ERROR(yesNo.number<bool>(), "neither 0 nor 1");
}

// ---- Payload ----

/// Bytes in memory that are read at most `step` at a time, as a socket or a damaged disk would.
class StepArchive : public mrpt::serialization::CArchive
{
 public:
  std::vector<uint8_t> bytes;
  std::size_t position = 0;
  std::size_t step = 7;

 protected:
  size_t write(const void* from, size_t count) override
  {
    const auto* first = static_cast<const uint8_t*>(from);
    bytes.insert(bytes.end(), first, first + count);
    return count;
  }
  size_t read(void* to, size_t count) override
  {
    const std::size_t got = std::min({count, step, bytes.size() - position});
    std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(position), got, static_cast<uint8_t*>(to));
    position += got;
    return got;
  }
};

std::vector<uint8_t> someBytes(std::size_t count)
{
  std::mt19937 generator(42);
  std::vector<uint8_t> bytes(count);
  for (auto& byte : bytes) byte = static_cast<uint8_t>(generator());
  return bytes;
}

TEST(Payload, ReadsWhatWasWrittenWhateverTheSizeOfReads)
{
  for (const std::size_t count : {0u, 1u, 1000u, 3000000u})
  {
    SCOPED_TRACE(count);
    StepArchive archive;
    archive.step = count > 100000 ? 4096 : 7;
    const auto payload = someBytes(count);
    lamap::writePayload(archive, payload);
    EXPECT_EQ(archive.bytes.size(), count + 12);
    const std::vector<uint8_t> read = lamap::readPayload(archive);
    EXPECT_EQ(read, payload);
    EXPECT_EQ(read.capacity(), read.size()) << "room for no more than the content";
    EXPECT_EQ(archive.position, archive.bytes.size());
  }
}

TEST(Payload, StatesZlibsCrc)
{
  StepArchive archive;
  lamap::writePayload(archive, {'1', '2', '3', '4', '5', '6', '7', '8', '9'});
  ASSERT_EQ(archive.bytes.size(), 21u);
  const uint32_t check = 0xcbf43926;  // the check value of CRC-32
  for (unsigned i = 0; i < 4; ++i) EXPECT_EQ(archive.bytes[8 + i], static_cast<uint8_t>(check >> (8 * i)));
}

TEST(Payload, NoticesEveryFlippedBitAndEveryCut)
{
  StepArchive whole;
  lamap::writePayload(whole, someBytes(50));
  for (std::size_t bit = 0; bit < whole.bytes.size() * 8; ++bit)
  {
    SCOPED_TRACE(bit);
    StepArchive damaged;
    damaged.bytes = whole.bytes;
    damaged.bytes[bit / 8] ^= static_cast<uint8_t>(1u << (bit % 8));
    EXPECT_THROW(static_cast<void>(lamap::readPayload(damaged)), std::runtime_error);
  }
  for (std::size_t size = 0; size < whole.bytes.size(); ++size)
  {
    StepArchive cut;
    cut.bytes.assign(whole.bytes.begin(), whole.bytes.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_ERROR(lamap::readPayload(cut), "truncated");
  }
}

TEST(Payload, FalseLengthCostsNoMemory)
{
  StepArchive archive;
  archive << std::numeric_limits<uint64_t>::max() << uint32_t{0};
  EXPECT_ERROR(lamap::readPayload(archive), "more than this machine can hold");

  StepArchive plausible;
  plausible << lamap::memoryForContent() / 2 << uint32_t{0} << uint64_t{0};
  rusage before{};
  getrusage(RUSAGE_SELF, &before);
  EXPECT_ERROR(lamap::readPayload(plausible), "truncated: 8 of");
  rusage after{};
  getrusage(RUSAGE_SELF, &after);
#ifdef LAMAP_SANITIZED
  constexpr long kMost = (64 + 128) * 1024;  // AddressSanitizer marks the room of 1 GiB in an eighth of it
#else
  constexpr long kMost = 64 * 1024;
#endif
  EXPECT_LT(after.ru_maxrss - before.ru_maxrss, kMost) << "KiB more than before";
}

// ---- AtomicFile ----

TEST(AtomicFile, AppearsOnlyWhenCommitted)
{
  const Folder folder;
  put(folder.at("map.lamap.gz"), "old");
  {
    AtomicFile file(folder.at("map.lamap.gz"));
    EXPECT_EQ(fs::path(file.temporaryPath()).parent_path(), fs::path(folder.at("x")).parent_path());
    EXPECT_EQ(fs::path(file.temporaryPath()).extension(), ".gz");
    put(file.temporaryPath(), "new");
    EXPECT_EQ(contentOf(folder.at("map.lamap.gz")), "old");
    file.commit();
    EXPECT_EQ(contentOf(folder.at("map.lamap.gz")), "new");
  }
  EXPECT_EQ(folder.names(), Names{"map.lamap.gz"});
}

TEST(AtomicFile, LeavesNothingBehindWithoutCommit)
{
  const Folder folder;
  put(folder.at("old.txt"), "old");
  {
    AtomicFile replaced(folder.at("old.txt"));
    replaced.write("new");
    AtomicFile fresh(folder.at("fresh.txt"));
    fresh.write("new");
    EXPECT_EQ(folder.names().size(), 3u);
  }
  EXPECT_EQ(folder.names(), Names{"old.txt"});
  EXPECT_EQ(contentOf(folder.at("old.txt")), "old");
}

TEST(AtomicFile, TwoWritersOfOnePlaceDoNotMeet)
{
  const Folder folder;
  AtomicFile first(folder.at("map"));
  AtomicFile second(folder.at("map"));
  EXPECT_NE(first.temporaryPath(), second.temporaryPath());
  first.write("first");
  second.write("second");
  second.commit();
  first.commit();
  EXPECT_EQ(contentOf(folder.at("map")), "first");
  EXPECT_EQ(folder.names(), Names{"map"});
}

TEST(AtomicFile, SaysWhyAPlaceCannotBeWritten)
{
  const Folder folder;
  put(folder.at("file"), "x");
  EXPECT_ERROR(AtomicFile(folder.at("none/map")), "folder '" + folder.at("none") + "' does not exist");
  EXPECT_ERROR(AtomicFile(folder.at("file/map")), "'" + folder.at("file") + "' is not a folder");
  EXPECT_ERROR(AtomicFile(folder.at("")), "it is a folder");
  EXPECT_ERROR(AtomicFile(folder.at("none/")), "ends with '/'");
  EXPECT_ERROR(AtomicFile(""), "the name is empty");
  EXPECT_ERROR(AtomicFile(folder.at(std::string(256, 'x'))), "File name too long");
  EXPECT_NO_THROW(AtomicFile(folder.at(std::string(255, 'x'))).commit());
  fs::create_symlink("loop", folder.at("loop"));
  EXPECT_ERROR(AtomicFile(folder.at("loop")), "symbolic links");
}

TEST(AtomicFile, RefusesWhatTheUserMayNotWrite)
{
  const Folder folder;
  if (geteuid() == 0) GTEST_SKIP() << "root may write everything";
  put(folder.at("file"), "x");
  ASSERT_EQ(chmod(folder.at("file").c_str(), 0444), 0);
  EXPECT_ERROR(AtomicFile(folder.at("file")), "Permission denied");
  fs::create_directory(folder.at("closed"));
  ASSERT_EQ(chmod(folder.at("closed").c_str(), 0555), 0);
  EXPECT_ERROR(AtomicFile(folder.at("closed/map")), "Permission denied");
}

mode_t modeOf(const std::string& path)
{
  struct stat status
  {
  };
  EXPECT_EQ(::stat(path.c_str(), &status), 0);
  return status.st_mode & 07777;
}

TEST(AtomicFile, NewFilesFollowTheUmaskAndOldOnesKeepTheirMode)
{
  const Folder folder;
  const mode_t before = umask(027);
  lamap::writeFileAtomically(folder.at("new"), "x");
  umask(before);
  EXPECT_EQ(modeOf(folder.at("new")), 0640u);

  ASSERT_EQ(chmod(folder.at("new").c_str(), 0600), 0);
  lamap::writeFileAtomically(folder.at("new"), "y");
  EXPECT_EQ(modeOf(folder.at("new")), 0600u);
}

TEST(AtomicFile, FollowsSymbolicLinksAndKeepsThem)
{
  const Folder folder;
  fs::create_directory(folder.at("maps"));
  put(folder.at("maps/real"), "old");
  fs::create_symlink("maps/real", folder.at("link"));
  fs::create_symlink("maps/none", folder.at("dangling"));
  lamap::writeFileAtomically(folder.at("link"), "new");
  lamap::writeFileAtomically(folder.at("dangling"), "born");
  EXPECT_TRUE(fs::is_symlink(folder.at("link")));
  EXPECT_TRUE(fs::is_symlink(folder.at("dangling")));
  EXPECT_EQ(contentOf(folder.at("maps/real")), "new");
  EXPECT_EQ(contentOf(folder.at("maps/none")), "born");
}

TEST(AtomicFile, WritesDevicesInPlace)
{
  lamap::writeFileAtomically("/dev/null", "x");
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
  EXPECT_ERROR(lamap::writeFileAtomically("/dev/full", "x"), "'/dev/full': No space left on device");
}

TEST(AtomicFile, SeveralComeToTheirPlacesOrNone)
{
  const Folder folder;
  put(folder.at("replaced"), "old");
  const auto write = [&](const std::string& last)
  {
    AtomicFile fresh(folder.at("fresh"));
    AtomicFile replaced(folder.at("replaced"));
    AtomicFile third(folder.at(last));
    for (AtomicFile* file : {&fresh, &replaced, &third}) file->write("new");
    if (last == "lost") fs::create_directories(folder.at("lost/in the way"));  // no file can be put there
    AtomicFile::commitAll({&fresh, &replaced, &third});
  };
  EXPECT_ERROR(write("lost"), "cannot write '" + folder.at("lost") + "'");
  EXPECT_EQ(contentOf(folder.at("replaced")), "old");
  EXPECT_EQ(folder.names(), (Names{"lost", "replaced"}));
  EXPECT_NO_THROW(write("third"));
  EXPECT_EQ(contentOf(folder.at("replaced")), "new");
  EXPECT_EQ(contentOf(folder.at("fresh")), "new");
  EXPECT_EQ(folder.names(), (Names{"fresh", "lost", "replaced", "third"}));
}

TEST(AtomicFile, NoticesAFailedWriteAndKeepsTheOldFile)
{
  const Folder folder;
  put(folder.at("map"), "old");
  {
    const FileSizeLimit limit(100000);
    EXPECT_ERROR(lamap::writeFileAtomically(folder.at("map"), std::string(200000, 'x')), "File too large");
  }
  EXPECT_EQ(contentOf(folder.at("map")), "old");
  EXPECT_EQ(folder.names(), Names{"map"});
}

TEST(AtomicFile, NoticesAFullDiskThatMrptsStreamsSwallow)
{
  const Folder folder;
  const TinyDisk disk(folder.at("disk"));
  if (!disk.isMounted()) GTEST_SKIP() << "needs the right to mount a tmpfs (root)";
  put(folder.at("disk/scene"), "old");
  const auto content = someBytes(200000);  // does not compress
  const auto write = [&]
  {
    AtomicFile file(folder.at("disk/scene"));
    mrpt::io::CFileGZOutputStream stream(file.temporaryPath());
    stream.Write(content.data(), content.size());
    stream.close();
    file.commit();
  };
  EXPECT_ERROR(write(), "No space left on device");
  EXPECT_EQ(contentOf(folder.at("disk/scene")), "old");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.at("disk")), {}), 1);
  EXPECT_ERROR(lamap::writeFileAtomically(folder.at("disk/scene"), std::string(200000, 'x')),
               "No space left on device");
  EXPECT_NO_THROW(lamap::writeFileAtomically(folder.at("disk/scene"), std::string(50000, 'x')));
}

// ---- Map files ----

mrpt::maps::CSimplePointsMap somePoints()
{
  mrpt::maps::CSimplePointsMap points;
  for (int i = 0; i < 20; ++i) points.insertPoint(static_cast<float>(i), 0.5f, -1.0f);
  return points;
}

CPayloadMap payloadMap(std::size_t count)
{
  CPayloadMap map;
  map.content = someBytes(count);
  return map;
}

/// The archive of an object, uncompressed.
template <typename Object>
std::string archived(const Object& object)
{
  mrpt::io::CMemoryStream stream;
  auto archive = mrpt::serialization::archiveFrom(stream);
  archive << object;
  return {static_cast<const char*>(stream.getRawBufferData()),
          static_cast<std::size_t>(stream.getTotalBytesCount())};
}

void putGzip(const std::string& path, const std::string& content)
{
  mrpt::io::CFileGZOutputStream stream(path);
  stream.Write(content.data(), content.size());
}

TEST(MapFile, LoadsWhatWasSaved)
{
  const Folder folder;
  const auto map = payloadMap(3000000);
  saveMapFile(map, folder.at("map.lamap.gz"));
  const auto loaded = std::dynamic_pointer_cast<CPayloadMap>(loadMapFile(folder.at("map.lamap.gz")));
  ASSERT_TRUE(loaded);
  EXPECT_EQ(loaded->content, map.content);
  EXPECT_EQ(folder.names(), Names{"map.lamap.gz"});
}

TEST(MapFile, HoldsMrptsOwnMapsToo)
{
  const Folder folder;
  const auto points = somePoints();
  saveMapFile(points, folder.at("points.gz"));
  const auto loaded =
      std::dynamic_pointer_cast<mrpt::maps::CSimplePointsMap>(loadMapFile(folder.at("points.gz")));
  ASSERT_TRUE(loaded);
  EXPECT_EQ(archived(*loaded), archived(points));

  mrpt::maps::COccupancyGridMap2D grid(-2, 2, -1, 1, 0.1f);
  grid.setCell(3, 4, 0.9f);
  saveMapFile(grid, folder.at("grid.gz"));
  const auto loadedGrid =
      std::dynamic_pointer_cast<mrpt::maps::COccupancyGridMap2D>(loadMapFile(folder.at("grid.gz")));
  ASSERT_TRUE(loadedGrid);
  EXPECT_EQ(loadedGrid->getCell(3, 4), grid.getCell(3, 4));
}

TEST(MapFile, IsReadByMrptAlone)
{
  const Folder folder;
  const auto map = payloadMap(100000);
  saveMapFile(map, folder.at("map.lamap.gz"));
  mrpt::io::CFileGZInputStream stream(folder.at("map.lamap.gz"));
  auto archive = mrpt::serialization::archiveFrom(stream);
  mrpt::serialization::CSerializable::Ptr object;
  archive >> object;
  const auto loaded = std::dynamic_pointer_cast<CPayloadMap>(object);
  ASSERT_TRUE(loaded);
  EXPECT_EQ(loaded->content, map.content);
}

TEST(MapFile, SameMapGivesTheSameBytes)
{
  const Folder folder;
  const auto map = payloadMap(100000);
  saveMapFile(map, folder.at("one"));
  saveMapFile(map, folder.at("other"));
  const std::string bytes = contentOf(folder.at("one"));
  EXPECT_EQ(bytes, contentOf(folder.at("other")));
  EXPECT_EQ(bytes.substr(0, 8), std::string("\x1f\x8b\x08\0\0\0\0\0", 8)) << "no name and no time";
  saveMapFile(*loadMapFile(folder.at("one")), folder.at("again"));
  EXPECT_EQ(bytes, contentOf(folder.at("again")));
}

TEST(MapFile, NoticesEveryFlippedBit)
{
  const Folder folder;
  const std::string path = folder.at("map.lamap.gz");
  const auto map = payloadMap(20);
  saveMapFile(map, path);
  const std::string whole = contentOf(path);
  std::size_t harmless = 0;
  for (std::size_t bit = 0; bit < whole.size() * 8; ++bit)
  {
    SCOPED_TRACE(bit);
    std::string damaged = whole;
    damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << (bit % 8)));
    put(path, damaged);
    try
    {
      const auto loaded = std::dynamic_pointer_cast<CPayloadMap>(loadMapFile(path));
      ++harmless;
      ASSERT_TRUE(loaded);
      EXPECT_EQ(loaded->content, map.content);
    }
    catch (const std::runtime_error& error)
    {
      EXPECT_NE(std::string(error.what()).find("'" + path + "'"), std::string::npos) << error.what();
    }
  }
  // In gzip's header, time, compression, system and "is text" (49 bits) do not concern the content; nor does
  // the padding of its last byte (at most 7 bits).
  EXPECT_LE(harmless, 56u);
}

TEST(MapFile, NoticesEveryCut)
{
  const Folder folder;
  const std::string path = folder.at("map.lamap.gz");
  saveMapFile(payloadMap(100), path);
  const std::string whole = contentOf(path);
  for (std::size_t size = 0; size < whole.size(); ++size)
  {
    SCOPED_TRACE(size);
    put(path, whole.substr(0, size));
    EXPECT_ERROR(loadMapFile(path), size == 0 ? "it is empty" : "it is truncated");
  }
}

TEST(MapFile, SaysWhatIsWrongWithAFileThatIsNoMap)
{
  const Folder folder;
  EXPECT_ERROR(loadMapFile(folder.at("none.lamap.gz")), "none.lamap.gz': No such file or directory");
  EXPECT_ERROR(loadMapFile(folder.at("")), "it is a folder");
  EXPECT_ERROR(loadMapFile("/dev/null"), "not a regular file");

  put(folder.at("text"), "# OctoMap");
  EXPECT_ERROR(loadMapFile(folder.at("text")), "not compressed by gzip");
  put(folder.at("archive"), archived(somePoints()));
  EXPECT_ERROR(loadMapFile(folder.at("archive")), "not compressed by gzip");

  putGzip(folder.at("text.gz"), "x,y,z,prob\n");
  EXPECT_ERROR(loadMapFile(folder.at("text.gz")), "does not hold an object of MRPT");
  putGzip(folder.at("nothing.gz"), "");
  EXPECT_ERROR(loadMapFile(folder.at("nothing.gz")), "does not hold an object of MRPT");
  putGzip(folder.at("pose.gz"), archived(mrpt::poses::CPose3D(1, 2, 3, 0, 0, 0)));
  EXPECT_ERROR(loadMapFile(folder.at("pose.gz")), "'mrpt::poses::CPose3D', which is not a map");

  std::string foreign = archived(payloadMap(10));
  foreign.replace(foreign.find("CPayloadMap"), 11, "CForeignMap");
  putGzip(folder.at("foreign.gz"), foreign);
  EXPECT_ERROR(loadMapFile(folder.at("foreign.gz")),
               "'lamap::test::CForeignMap', which this program does not know");

  std::string newer = archived(payloadMap(10));
  newer[newer.find("CPayloadMap") + 11] = 4;
  putGzip(folder.at("newer.gz"), newer);
  EXPECT_ERROR(loadMapFile(folder.at("newer.gz")), "version 4 of lamap::test::CPayloadMap");
  EXPECT_ERROR(loadMapFile(folder.at("newer.gz")), "versions up to 3");
}

TEST(MapFile, RefusesWhatFollowsTheMap)
{
  const Folder folder;
  saveMapFile(payloadMap(10), folder.at("map"));
  const std::string one = contentOf(folder.at("map"));
  put(folder.at("joined"), one + one);
  EXPECT_ERROR(loadMapFile(folder.at("joined")), "other bytes follow the map");
  const std::string archive = archived(payloadMap(10));
  putGzip(folder.at("two"), archive + archive);
  EXPECT_ERROR(loadMapFile(folder.at("two")), "other content follows the map");
}

TEST(MapFile, NamesDamageOfTheContentBehindARightGzip)
{
  const Folder folder;
  std::string archive = archived(payloadMap(1000));
  archive[500] = static_cast<char>(archive[500] ^ 1);
  putGzip(folder.at("flipped.gz"), archive);
  const std::string text = errorOf([&] { static_cast<void>(loadMapFile(folder.at("flipped.gz"))); });
  EXPECT_NE(text.find("flipped.gz': the map's content is damaged: its CRC-32 is"), std::string::npos) << text;
  EXPECT_EQ(text.find('\n'), std::string::npos) << "MRPT's call stack is left out: " << text;

  putGzip(folder.at("short.gz"), archived(payloadMap(1000)).substr(0, 500));
  EXPECT_ERROR(loadMapFile(folder.at("short.gz")), "the map's content is truncated");
  // One of MRPT's own classes, truncated: whatever MRPT reports, it is an error that names the file.
  putGzip(folder.at("points.gz"), archived(somePoints()).substr(0, 60));
  EXPECT_ERROR(loadMapFile(folder.at("points.gz")), "points.gz'");
}

TEST(MapFile, ContentThatUncompressesToMuchCostsNoMemory)
{
  const Folder folder;
  {
    mrpt::io::CFileGZOutputStream stream(folder.at("bomb.gz"));
    const std::string zeros(1 << 20, '\0');
    for (int i = 0; i < 256; ++i) stream.Write(zeros.data(), zeros.size());
  }
  rusage before{};
  getrusage(RUSAGE_SELF, &before);
  EXPECT_ERROR(loadMapFile(folder.at("bomb.gz"), uint64_t{1} << 30), "does not hold an object of MRPT");
  rusage after{};
  getrusage(RUSAGE_SELF, &after);
  EXPECT_LT(after.ru_maxrss - before.ru_maxrss, 64 * 1024) << "KiB more than before";
}

TEST(MapFile, ContentBeyondTheLimitIsRefused)
{
  const Folder folder;
  saveMapFile(payloadMap(1000), folder.at("map"));
  const std::size_t size = archived(payloadMap(1000)).size();
  EXPECT_NO_THROW(static_cast<void>(loadMapFile(folder.at("map"), size)));
  EXPECT_ERROR(loadMapFile(folder.at("map"), size - 1),
               "uncompresses to more than " + std::to_string(size - 1));
}

TEST(MapFile, FailedSaveKeepsTheOldMap)
{
  const Folder folder;
  const std::string path = folder.at("map.lamap.gz");
  saveMapFile(payloadMap(10), path);
  const std::string before = contentOf(path);
  {
    const FileSizeLimit limit(100000);
    EXPECT_ERROR(saveMapFile(payloadMap(2000000), path), "'" + path + "': File too large");
  }
  EXPECT_EQ(contentOf(path), before);
  EXPECT_EQ(folder.names(), Names{"map.lamap.gz"});
  EXPECT_ERROR(saveMapFile(payloadMap(10), folder.at("none/map.lamap.gz")), "does not exist");
  EXPECT_ERROR(saveMapFile(payloadMap(10), "/dev/full"), "'/dev/full': No space left on device");
}

TEST(MapFile, FullDiskIsNamedAndKeepsTheOldMap)
{
  const Folder folder;
  const TinyDisk disk(folder.at("disk"));
  if (!disk.isMounted()) GTEST_SKIP() << "needs the right to mount a tmpfs (root)";
  const std::string path = folder.at("disk/map.lamap.gz");
  saveMapFile(payloadMap(100), path);
  const std::string before = contentOf(path);
  for (const std::size_t count : {62000u, 65000u, 200000u, 2000000u})
  {
    SCOPED_TRACE(count);
    EXPECT_ERROR(saveMapFile(payloadMap(count), path), "'" + path + "': No space left on device");
    EXPECT_EQ(contentOf(path), before);
    EXPECT_EQ(std::distance(fs::directory_iterator(folder.at("disk")), {}), 1);
  }
}

}  // namespace
