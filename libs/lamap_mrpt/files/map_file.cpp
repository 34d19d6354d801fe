#include <fcntl.h>
#include <lamap_mrpt/compat/mrpt_compat.h>
#include <lamap_mrpt/files/atomic_file.h>
#include <lamap_mrpt/files/byte_stream.h>
#include <lamap_mrpt/files/environment.h>
#include <lamap_mrpt/files/map_file.h>
#include <lamap_mrpt/files/payload.h>
#include <mrpt/rtti/CObject.h>
#include <mrpt/serialization/CArchive.h>
#include <mrpt/serialization/CSerializable.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <vector>

namespace lamap
{
namespace
{
using mrpt::maps::CMetricMap;
using mrpt::serialization::CArchive;
using mrpt::serialization::CSerializable;

constexpr std::size_t kChunk = std::size_t{1} << 18;
constexpr const char* kLimitAdvice =
    "which is the limit here: 48 MiB and 40 times the size of the file, or half the memory of this machine "
    "if "
    "that is less; the environment variable LAMAP_MAX_CONTENT_MIB raises that";

/// An archive that compresses into a file, and notices every error of writing: MRPT's own gzip stream ignores
/// them.
class GzipWriter : public CArchive
{
 public:
  /// @throws std::runtime_error with the reason.
  explicit GzipWriter(const std::string& path)
  {
    const int descriptor = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
    if (descriptor < 0) throw std::runtime_error(systemReason(errno));
    // Through a descriptor, so that zlib writes neither name nor time into the header.
    // Level 1: evidence is hard to compress, and higher levels take five times as long for 4 to 12 %.
    file_ = gzdopen(descriptor, "wb1");
    if (!file_)
    {
      ::close(descriptor);
      throw std::runtime_error("not enough memory to compress");
    }
    gzbuffer(file_, static_cast<unsigned>(kChunk));
  }
  ~GzipWriter() override
  {
    if (file_) gzclose(file_);
  }
  GzipWriter(const GzipWriter&) = delete;
  GzipWriter& operator=(const GzipWriter&) = delete;

  /// Writes what is left. @throws std::runtime_error with the reason.
  void close()
  {
    errno = 0;
    const int result = gzclose(std::exchange(file_, nullptr));
    if (result != Z_OK) throw std::runtime_error(reasonOf(result));
  }

 protected:
  std::size_t write(const void* bytes, std::size_t count) override
  {
    const auto* next = static_cast<const uint8_t*>(bytes);
    for (std::size_t left = count; left > 0;)
    {
      const auto part = static_cast<unsigned>(std::min(left, kChunk));
      errno = 0;
      if (gzwrite(file_, next, part) != static_cast<int>(part))
      {
        int error = Z_ERRNO;
        gzerror(file_, &error);
        throw std::runtime_error(reasonOf(error));
      }
      next += part;
      left -= part;
    }
    return count;
  }
  std::size_t read(void* /*bytes*/, std::size_t /*count*/) override
  {
    throw std::logic_error("GzipWriter cannot be read");
  }

 private:
  static std::string reasonOf(int zlibError)
  {
    if (errno != 0) return systemReason(errno);
    return zlibError == Z_MEM_ERROR ? "not enough memory to compress" : "the disk did not take all bytes";
  }

  gzFile file_ = nullptr;
};

/** Uncompresses a file that is one gzip member, and nothing else.
 * Every method throws std::runtime_error with what is wrong and what would be right, but without the file's
 * name. */
class GzipFile
{
 public:
  explicit GzipFile(const std::string& path)
  {
    struct stat status
    {
    };
    if (::stat(path.c_str(), &status) != 0) throw std::runtime_error(systemReason(errno));
    if (S_ISDIR(status.st_mode)) throw std::runtime_error("it is a folder; name a map file (.lamap.gz)");
    if (!S_ISREG(status.st_mode))
      throw std::runtime_error("it is not a regular file; name a map file (.lamap.gz)");
    if (status.st_size == 0)
      throw std::runtime_error("it is empty; a map file holds a map compressed by gzip");
    file_.reset(std::fopen(path.c_str(), "rbe"));
    if (!file_) throw std::runtime_error(systemReason(errno));

    fill();
    if (input_[0] != 0x1f || (stream_.avail_in > 1 && input_[1] != 0x8b))
      throw std::runtime_error("it is not compressed by gzip, as map files (.lamap.gz) are");
    if (inflateInit2(&stream_, 16 + MAX_WBITS) != Z_OK)
      throw std::runtime_error("not enough memory to uncompress");
    initialized_ = true;
  }
  ~GzipFile()
  {
    if (initialized_) inflateEnd(&stream_);
  }
  GzipFile(const GzipFile&) = delete;
  GzipFile& operator=(const GzipFile&) = delete;

  /// @return bytes read; fewer than asked for at the end only, after the checksum was found right.
  std::size_t read(uint8_t* bytes, std::size_t count)
  {
    std::size_t done = 0;
    while (done < count && !ended_)
    {
      if (stream_.avail_in == 0) fill();
      if (stream_.avail_in == 0) throw std::runtime_error("it is truncated; copy or build it again");
      const auto part = static_cast<uInt>(std::min(count - done, kChunk));
      stream_.next_out = bytes + done;
      stream_.avail_out = part;
      const int result = inflate(&stream_, Z_NO_FLUSH);
      done += part - stream_.avail_out;
      if (result == Z_STREAM_END)
        finish();
      else if (result == Z_MEM_ERROR)
        throw std::runtime_error("not enough memory to uncompress");
      else if (result != Z_OK && result != Z_BUF_ERROR)
        throw std::runtime_error(std::string("it is damaged (gzip: ") +
                                 (stream_.msg ? stream_.msg : "invalid data") + "); copy or build it again");
    }
    return done;
  }

 private:
  struct Closer
  {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };

  void fill()
  {
    errno = 0;
    stream_.next_in = input_.data();
    stream_.avail_in = static_cast<uInt>(std::fread(input_.data(), 1, input_.size(), file_.get()));
    if (std::ferror(file_.get())) throw std::runtime_error(systemReason(errno));
  }

  void finish()
  {
    ended_ = true;
    if (stream_.avail_in == 0) fill();
    if (stream_.avail_in != 0)
      throw std::runtime_error("other bytes follow the map: it is damaged, or several files were joined");
  }

  std::unique_ptr<std::FILE, Closer> file_;
  std::array<uint8_t, kChunk> input_{};
  z_stream stream_{};
  bool initialized_ = false;
  bool ended_ = false;
};

/** The archive that an object is read from: inflated once, as it is read.
 *
 * MRPT's classes and readPayload() may swallow what read() throws, so the file's own damage is kept for
 * whoever asks at the end. */
class GzipReader : public CArchive
{
 public:
  /// @throws std::runtime_error as GzipFile, or if the content is larger than the limit, here and in reading.
  GzipReader(const std::string& path, uint64_t limit_bytes)
      : file_(std::make_unique<GzipFile>(path)), limit_bytes_(limit_bytes)
  {
    inflateMore();
  }

  [[nodiscard]] uint64_t limit_bytes() const { return limit_bytes_; }
  /// The first bytes: all of a small file, more than any object's header of a large one. Before the first
  /// read.
  [[nodiscard]] const std::vector<uint8_t>& beginning() const { return ready_; }

  /// Inflates all that is left, so that nothing of a damaged file is ever read.
  void inflateAll()
  {
    while (inflateMore())
    {
    }
  }

  /// @throws std::runtime_error if the file is damaged, in what was read or in what follows.
  void requireSoundFile()
  {
    do
    {
      if (!damage_.empty()) throw std::runtime_error(damage_);
      ready_.clear();
      taken_ = 0;
    } while (inflateMore());
  }

  [[nodiscard]] bool isAtEnd() { return taken_ == ready_.size() && !inflateMore(); }

 protected:
  std::size_t write(const void* /*bytes*/, std::size_t /*count*/) override
  {
    throw std::logic_error("GzipReader cannot be written");
  }
  std::size_t read(void* bytes, std::size_t count) override
  {
    auto* to = static_cast<uint8_t*>(bytes);
    for (std::size_t left = count; left > 0;)
    {
      // MRPT takes a short read for a whole one.
      if (isAtEnd()) throw EndOfContent(count - left);
      const std::size_t part = std::min(left, ready_.size() - taken_);
      std::copy_n(ready_.begin() + static_cast<std::ptrdiff_t>(taken_), part, to);
      to += part;
      taken_ += part;
      left -= part;
    }
    return count;
  }

 private:
  /// Makes room by dropping what was taken. @return whether there was more
  bool inflateMore()
  {
    if (taken_ == ready_.size())
    {
      ready_.clear();
      taken_ = 0;
    }
    const std::size_t before = ready_.size();
    ready_.resize(before + kChunk);
    std::size_t got = 0;
    try
    {
      got = file_->read(ready_.data() + before, kChunk);
      inflated_ += got;
      if (inflated_ > limit_bytes_)
        throw std::runtime_error("it uncompresses to more than " + std::to_string(limit_bytes_) + " bytes, " +
                                 kLimitAdvice);
    }
    catch (const std::runtime_error& error)
    {
      ready_.resize(before);
      damage_ = error.what();
      throw;
    }
    ready_.resize(before + got);
    return got > 0;
  }

  std::unique_ptr<GzipFile> file_;
  uint64_t limit_bytes_;
  uint64_t inflated_ = 0;
  std::vector<uint8_t> ready_;  ///< inflated, of which `taken_` bytes are read
  std::size_t taken_ = 0;
  std::string damage_;
};

/// How an object begins in MRPT's archives: the length of its class's name with the top bit set, the name,
/// the version.
struct ObjectHeader
{
  std::string className;
  uint8_t version = 0;
  size_t bytes = 0;  ///< its length
};

std::optional<ObjectHeader> headerOf(const std::vector<uint8_t>& bytes)
{
  if (bytes.empty() || (bytes[0] & 0x80) == 0) return std::nullopt;
  const std::size_t length = bytes[0] & 0x7f;
  if (length == 0 || bytes.size() < length + 2) return std::nullopt;
  ObjectHeader header;
  header.className.assign(bytes.begin() + 1, bytes.begin() + 1 + static_cast<std::ptrdiff_t>(length));
  header.version = bytes[length + 1];
  header.bytes = length + 2;
  const bool isName = std::all_of(header.className.begin(), header.className.end(),
                                  [](unsigned char c) { return c > ' ' && c < 0x7f; });
  return isName ? std::optional(header) : std::nullopt;
}

/// The version that this program writes of a class; nothing where an empty object cannot be written.
std::optional<uint8_t> versionWritten(const mrpt::rtti::TRuntimeClassId& classId)
{
  try
  {
    const auto object = std::dynamic_pointer_cast<CSerializable>(
        std::shared_ptr<mrpt::rtti::CObject>(classId.createObject()));
    if (!object) return std::nullopt;
    std::vector<uint8_t> bytes;
    mrpt::serialization::ObjectToOctetVector(object.get(), bytes);
    const auto header = headerOf(bytes);
    return header ? std::optional(header->version) : std::nullopt;
  }
  catch (const std::exception&)
  {
    return std::nullopt;
  }
}

/// @throws std::runtime_error unless the beginning is that of a map which this program can read.
ObjectHeader headerOfReadableMap(const std::vector<uint8_t>& beginning)
{
  const auto header = headerOf(beginning);
  if (!header) throw std::runtime_error("it does not hold an object of MRPT; a map file holds one map");
  const auto* classId = mrpt::rtti::findRegisteredClass(header->className);
  if (!classId)
    throw std::runtime_error("it holds an object of class '" + header->className +
                             "', which this program does not know; load the library that has it");
  if (!classId->derivedFrom(CLASS_ID(CMetricMap)))
    throw std::runtime_error("it holds an object of class '" + header->className + "', which is not a map");
  if (const auto known = versionWritten(*classId); known && header->version > *known)
    throw std::runtime_error("it holds version " + std::to_string(header->version) + " of " +
                             header->className + ", and this program reads versions up to " +
                             std::to_string(*known) + "; read it with a newer release");
  return *header;
}

/// A file is not looked at any further.
struct ClaimsTooMuch : public std::runtime_error
{
  using std::runtime_error::runtime_error;
};

/// @throws ClaimsTooMuch if a payload says of itself that it is larger than the limit
void requireClaimWithinLimit(const GzipReader& archive, const ObjectHeader& header)
{
  const std::vector<uint8_t>& beginning = archive.beginning();
  if (beginning.size() < header.bytes + sizeof(uint64_t)) return;
  ByteReader claim(beginning.data() + header.bytes, sizeof(uint64_t));
  if (const auto bytes = claim.number<uint64_t>(); bytes > archive.limit_bytes())
    throw ClaimsTooMuch("it is damaged, or its map is too large: its content claims " +
                        std::to_string(bytes) + " bytes, more than " + std::to_string(archive.limit_bytes()) +
                        ", " + kLimitAdvice);
}

MapFile readMap(GzipReader& archive)
{
  const ObjectHeader header = headerOfReadableMap(archive.beginning());
  // This library's maps check their content themselves (readPayload) before they parse it. Others trust what
  // they read: they are given only what gzip's checksum has found right.
  if (header.className.rfind("lamap::", 0) == 0)
    requireClaimWithinLimit(archive, header);
  else
    archive.inflateAll();
  MapFile content{std::dynamic_pointer_cast<CMetricMap>(archive.ReadObject()), header.version};
  if (!content.map) throw std::runtime_error("it does not hold a map");
  if (!archive.isAtEnd()) throw std::runtime_error("other content follows the map");
  return content;
}

MapFile readMap(const std::string& path, std::optional<uint64_t> limit_bytes)
{
  std::error_code none;
  GzipReader archive(path,
                     limit_bytes ? *limit_bytes : mostContentOf(std::filesystem::file_size(path, none)));
  try
  {
    return readMap(archive);
  }
  catch (const std::bad_alloc&)
  {
    throw;
  }
  catch (const ClaimsTooMuch&)
  {
    throw;
  }
  catch (const std::exception&)
  {
    // A damaged file explains whatever its content was found to be.
    archive.requireSoundFile();
    throw;
  }
}

}  // namespace

void writeCompressed(const CSerializable& object, const std::string& path)
{
  GzipWriter archive(path);
  archive << object;
  archive.close();
}

uint64_t mostContentOf(uint64_t fileBytes)
{
  constexpr uint64_t kMiB = uint64_t{1} << 20;
  // Maps of all kinds have been seen to shrink to an eighth.
  constexpr uint64_t kAlways = 48 * kMiB;
  constexpr uint64_t kTimes = 40;
  const uint64_t memory = memoryForContent();
  if (const auto mebibytes = limitFromEnvironment("LAMAP_MAX_CONTENT_MIB"))
    return std::min(memory / kMiB, *mebibytes) * kMiB;
  return std::min(memory, kAlways + std::min(fileBytes, memory) * kTimes);
}

void saveMapFile(const CMetricMap& map, const std::string& path)
{
  AtomicFile file(path);
  try
  {
    writeCompressed(map, file.temporaryPath());
  }
  catch (const std::exception& error)
  {
    throw std::runtime_error("cannot write '" + path + "': " + compat::messageOf(error));
  }
  file.commit();
}

MapFile readMapFile(const std::string& path, std::optional<uint64_t> limit_bytes)
{
  try
  {
    return readMap(path, limit_bytes);
  }
  catch (const std::bad_alloc&)
  {
    throw std::runtime_error("cannot read the map file '" + path + "': not enough memory");
  }
  catch (const std::exception& error)
  {
    throw std::runtime_error("cannot read the map file '" + path + "': " + compat::messageOf(error));
  }
}

CMetricMap::Ptr loadMapFile(const std::string& path, std::optional<uint64_t> limit_bytes)
{
  return readMapFile(path, limit_bytes).map;
}

}  // namespace lamap
