#include <lamap_mrpt/compat/mrpt_compat.h>
#include <lamap_mrpt/files/byte_stream.h>
#include <lamap_tools/inputs/memory_guard.h>
#include <lamap_tools/inputs/rawlog_file.h>
#include <lamap_tools/inputs/trial_run.h>
#include <mrpt/img/CImage.h>
#include <mrpt/io/CStream.h>
#include <mrpt/obs/CAction.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CObservation.h>
#include <mrpt/obs/CRawlog.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/serialization/CArchive.h>
#include <zlib.h>

#include <algorithm>
#include <filesystem>
#include <new>
#include <stdexcept>

namespace lamap::tools
{
using mrpt::serialization::CSerializable;

/** A file, gzip-compressed or not, for MRPT's archives. MRPT's own stream takes a part for the whole at the
 * end of a file and does not tell a cut or damaged gzip stream from a whole one. */
class RawlogFile::Stream : public mrpt::io::CStream
{
 public:
  explicit Stream(const std::string& path) : file_(gzopen(path.c_str(), "rb")) {}
  ~Stream() override
  {
    if (file_) gzclose(file_);
  }
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;

  [[nodiscard]] bool isOpen() const { return file_ != nullptr; }

  /// Whether the file ends here. @throws std::runtime_error if it ends within a gzip stream.
  bool atEnd()
  {
    const int letter = gzgetc(file_);
    if (letter >= 0)
    {
      gzungetc(letter, file_);
      return false;
    }
    requireSound();
    return true;
  }

  size_t Read(void* buffer, size_t count) override
  {
    auto* bytes = static_cast<char*>(buffer);
    for (size_t done = 0; done < count;)
    {
      constexpr size_t kMostAtOnce = size_t{1} << 30;
      const auto part = static_cast<unsigned>(std::min(count - done, kMostAtOnce));
      const int got = gzread(file_, bytes + done, part);
      if (got <= 0)
      {
        requireSound();
        throw std::runtime_error("the file ends here");
      }
      done += static_cast<size_t>(got);
      position_ += static_cast<uint64_t>(got);
    }
    return count;
  }

  size_t Write(const void*, size_t) override { throw std::logic_error("opened for reading"); }
  uint64_t Seek(int64_t, TSeekOrigin) override { throw std::logic_error("cannot seek"); }
  [[nodiscard]] uint64_t getTotalBytesCount() const override { throw std::logic_error("size not known"); }
  /// Uncompressed bytes read so far.
  [[nodiscard]] uint64_t getPosition() const override { return position_; }

 private:
  void requireSound()
  {
    int code = Z_OK;
    const char* text = gzerror(file_, &code);
    if (code == Z_BUF_ERROR) throw std::runtime_error("the compressed file ends here");
    if (code != Z_OK && code != Z_STREAM_END) throw std::runtime_error(std::string("damaged: ") + text);
  }

  gzFile file_;
  uint64_t position_ = 0;
};

namespace
{
bool belongsInRawlog(const CSerializable& object)
{
  const auto* type = object.GetRuntimeClass();
  return type->derivedFrom(CLASS_ID(mrpt::obs::CObservation)) ||
         type->derivedFrom(CLASS_ID(mrpt::obs::CAction)) ||
         type->derivedFrom(CLASS_ID(mrpt::obs::CSensoryFrame)) ||
         type->derivedFrom(CLASS_ID(mrpt::obs::CActionCollection)) ||
         type->derivedFrom(CLASS_ID(mrpt::obs::CRawlog));
}
}  // namespace

RawlogFile::Trial RawlogFile::tryReading(const std::string& path, const Surveyor& surveyor,
                                         const std::function<bool()>& shouldStop)
{
  Trial trial;
  const auto attempt = [&](const std::function<void()>& step)
  {
    ByteWriter found;
    try
    {
      RawlogFile file(path, trial.limit);
      if (file.first_) step();
      file.onEntry_ = step;
      found.text("");
      const std::vector<uint8_t> survey = surveyor(file);
      found.numbers(survey.data(), survey.size());
    }
    catch (const std::runtime_error& refusal)
    {
      found.text(refusal.what());
    }
    return found.take();
  };
  for (;;)
  {
    const TrialRun run = tryInChild(attempt, shouldStop);
    trial.stopped = run.stopped;
    if (run.stopped) return trial;
    if (!run.failure)
    {
      ByteReader found(run.found);
      if (const std::string refusal = found.text(); !refusal.empty()) throw std::runtime_error(refusal);
      trial.survey.assign(run.found.end() - static_cast<std::ptrdiff_t>(found.remaining()), run.found.end());
      return trial;
    }
    // Once more up to the entry that did harm; every time fewer, so that it comes to an end.
    const uint64_t sound = trial.limit ? std::min(run.steps, trial.limit->objects - 1) : run.steps;
    trial.limit = Limit{sound, "entry " + std::to_string(sound + 1) + " is damaged: " + *run.failure};
  }
}

RawlogFile::RawlogFile(const std::string& path, std::optional<Limit> limit)
    : path_(path), limit_(std::move(limit))
{
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  if (error) throw std::runtime_error(path + ": " + error.message());
  // A compressed entry may be many times larger in memory, and a small file may hold one with a large buffer;
  // but an entry of gigabytes takes a file of nearly that size.
  memoryLimit_ = std::min((size_t{256} << 20) + 64 * size, (size_t{2} << 30) + 8 * size);
  stream_ = std::make_unique<Stream>(path);
  if (!stream_->isOpen()) throw std::runtime_error(path + ": cannot be opened");
  mrpt::img::CImage::setImagesPathBase(mrpt::obs::CRawlog::detectImagesDirectory(path));

  first_ = readObject();
  if (damage_) throw std::runtime_error(path + ": not one entry of a rawlog can be read: " + *damage_);
  if (first_ && !belongsInRawlog(*first_))
    throw std::runtime_error(path + ": not a rawlog: it begins with a " +
                             first_->GetRuntimeClass()->className);
}

RawlogFile::~RawlogFile() = default;

CSerializable::Ptr RawlogFile::next()
{
  if (auto* whole = dynamic_cast<mrpt::obs::CRawlog*>(whole_.get()))
  {
    if (nextInWhole_ < whole->size()) return whole->getAsGeneric(nextInWhole_++);
    whole_.reset();
  }
  CSerializable::Ptr object = first_ ? std::move(first_) : readObject();
  first_.reset();
  if (!object || !dynamic_cast<mrpt::obs::CRawlog*>(object.get())) return object;
  whole_ = object;
  nextInWhole_ = 0;
  return next();
}

CSerializable::Ptr RawlogFile::readObject()
{
  if (damage_) return {};
  if (limit_ && entries_ == limit_->objects)
  {
    damage_ = limit_->damage;
    return {};
  }
  const uint64_t begin = stream_->getPosition();
  const auto damaged = [&](const std::string& what)
  {
    // The log ends here for us; what it is worth so far is the caller's to decide.
    damage_ = "entry " + std::to_string(entries_ + 1) + ", which begins at byte " + std::to_string(begin) +
              " (uncompressed): " + what;
    return CSerializable::Ptr();
  };
  try
  {
    if (stream_->atEnd()) return {};
    const MemoryGuard guard(memoryLimit_);
    auto archive = mrpt::serialization::archiveFrom(*stream_);
    CSerializable::Ptr object = archive.ReadObject();
    if (!object) throw std::runtime_error("an empty object");
    ++entries_;
    if (onEntry_) onEntry_();
    return object;
  }
  catch (const std::bad_alloc&)
  {
    return damaged("it asks for more memory than any entry of this log can need");
  }
  catch (const std::exception& error)
  {
    return damaged(compat::messageOf(error));
  }
}

}  // namespace lamap::tools
