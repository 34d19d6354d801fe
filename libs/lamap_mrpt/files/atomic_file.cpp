#include <fcntl.h>
#include <lamap_mrpt/files/atomic_file.h>
#include <mrpt/core/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <optional>
#include <random>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace lamap
{
namespace
{
namespace fs = std::filesystem;

[[noreturn]] void refuse(const std::string& path, const std::string& reason)
{
  throw std::runtime_error("cannot write '" + path + "': " + reason);
}

class Descriptor
{
 public:
  Descriptor(const std::string& path, int flags) : number_(::open(path.c_str(), flags | O_CLOEXEC, 0666)) {}
  ~Descriptor()
  {
    if (number_ >= 0) ::close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  [[nodiscard]] bool isOpen() const { return number_ >= 0; }
  [[nodiscard]] int number() const { return number_; }
  /// Hands it over, to be closed by the caller.
  [[nodiscard]] int release() { return std::exchange(number_, -1); }
  /// @return 0 or the error that only the closing reports.
  [[nodiscard]] int close()
  {
    const int result = ::close(number_);
    number_ = -1;
    return result == 0 || errno == EINTR ? 0 : errno;
  }

 private:
  int number_;
};

/// @return 0 or the error.
int writeFully(int descriptor, std::string_view content)
{
  while (!content.empty())
  {
    const ssize_t written = ::write(descriptor, content.data(), content.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    content.remove_prefix(static_cast<std::size_t>(written));
  }
  return 0;
}

/** The file that a chain of symbolic links ends at; it need not exist.
 * @throws std::runtime_error for a chain that does not end. */
fs::path followLinks(const std::string& named)
{
  fs::path path = named;
  for (int links = 0; links < 40; ++links)
  {
    std::error_code error;
    if (!fs::is_symlink(path, error)) return path;
    const fs::path target = fs::read_symlink(path, error);
    if (error) refuse(named, error.message());
    path = target.is_absolute() ? target : path.parent_path() / target;
  }
  refuse(named, "too many symbolic links");
}

std::string randomWord()
{
  static std::atomic<unsigned> counter{0};
  std::random_device device;
  return mrpt::format("%08x%x", device(), counter++);
}

constexpr std::string_view kPartial = ".partial-";

fs::path folderOf(const fs::path& destination)
{
  return destination.parent_path().empty() ? fs::path(".") : destination.parent_path();
}

/// What ends the names of temporary files for a destination.
std::string endOfName(const fs::path& destination)
{
  // A file name holds 255 bytes; the end of a longer one is kept, with its extension.
  std::string name = destination.filename().string();
  constexpr std::size_t kLongest = 200;
  if (name.size() > kLongest) name.erase(0, name.size() - kLongest);
  return "-" + name;
}

/// Whether a name is one that createBeside() gives.
bool isPartial(const std::string& name, const std::string& end)
{
  if (name.size() <= kPartial.size() + end.size() || name.compare(0, kPartial.size(), kPartial) != 0 ||
      name.compare(name.size() - end.size(), end.size(), end) != 0)
    return false;
  const std::string word = name.substr(kPartial.size(), name.size() - kPartial.size() - end.size());
  return word.find_first_not_of("0123456789abcdef") == std::string::npos;
}

bool lockNow(int descriptor)
{
  return ::flock(descriptor, LOCK_EX | LOCK_NB) == 0;
}

/// Removes temporary files for a destination that nobody writes any more. Errors are no loss.
void removeLeftOvers(const fs::path& destination)
{
  const std::string end = endOfName(destination);
  std::error_code error;
  for (fs::directory_iterator entry(folderOf(destination), error), last; !error && entry != last;
       entry.increment(error))
  {
    if (!isPartial(entry->path().filename().string(), end)) continue;
    const Descriptor left(entry->path().string(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK);
    struct stat status
    {
    };
    if (left.isOpen() && ::fstat(left.number(), &status) == 0 && S_ISREG(status.st_mode) &&
        lockNow(left.number()))
      ::unlink(entry->path().c_str());
  }
}

/// Creates a new empty file beside the destination, with the permissions of the umask.
/// @param lock receives a descriptor that locks it; −1 where the file system has no locks
std::string createBeside(const fs::path& destination, const std::string& named, int& lock)
{
  const fs::path folder = folderOf(destination);
  const std::string end = endOfName(destination);
  for (int attempt = 0; attempt < 100; ++attempt)
  {
    std::string temporary = (folder / (std::string(kPartial) + randomWord() + end)).string();
    Descriptor created(temporary, O_WRONLY | O_CREAT | O_EXCL);
    if (created.isOpen())
    {
      const bool isLocked = lockNow(created.number());
      const bool isTaken = !isLocked && errno == EWOULDBLOCK;
      struct stat status
      {
      };
      // Whoever cleans up may have been quicker.
      if (isTaken || (::fstat(created.number(), &status) == 0 && status.st_nlink == 0)) continue;
      lock = created.release();
      return temporary;
    }
    if (errno != EEXIST) refuse(named, systemReason(errno) + " (in the folder '" + folder.string() + "')");
  }
  refuse(named, "no free name for a temporary file in '" + folder.string() + "'");
}

/** A writer that ignores a full disk leaves a disk that is still full: try to add to the file, then take it
 * back.
 * @return 0 or the error. */
int probeForSpace(int descriptor)
{
  const off_t size = ::lseek(descriptor, 0, SEEK_END);
  if (size < 0) return errno;
  const std::string block(16384, '\1');
  const int error = writeFully(descriptor, block);
  if (::ftruncate(descriptor, size) != 0) return error != 0 ? error : errno;
  return error;
}

}  // namespace

std::string systemReason(int errorNumber)
{
  return std::generic_category().message(errorNumber);
}

AtomicFile::AtomicFile(const std::string& path) : named_(path)
{
  if (path.empty()) refuse(path, "the name is empty");
  if (path.find('\0') != std::string::npos) refuse(path, "the name holds a zero byte");

  std::optional<mode_t> modeBefore;
  struct stat existing
  {
  };
  if (::stat(path.c_str(), &existing) == 0)
  {
    if (S_ISDIR(existing.st_mode)) refuse(path, "it is a folder; name a file");
    if (::access(path.c_str(), W_OK) != 0) refuse(path, systemReason(errno));
    if (!S_ISREG(existing.st_mode))
    {
      destination_ = path;
      inPlace_ = true;
      const fs::path beside = fs::temp_directory_path() / fs::path(path).filename();
      removeLeftOvers(beside);
      temporary_ = createBeside(beside, path, lock_);
      return;
    }
    modeBefore = existing.st_mode & 07777;
  }

  const fs::path destination = followLinks(path);
  if (!destination.has_filename()) refuse(path, "it ends with '/'; name a file");
  const fs::path folder = destination.parent_path();
  std::error_code error;
  const auto kind = fs::status(folder.empty() ? fs::path(".") : folder, error).type();
  if (kind == fs::file_type::not_found)
    refuse(path, "the folder '" + folder.string() + "' does not exist; create it first");
  if (kind != fs::file_type::directory && kind != fs::file_type::none)
    refuse(path, "'" + folder.string() + "' is not a folder");
  if (destination.filename().string().size() > 255) refuse(path, systemReason(ENAMETOOLONG));

  destination_ = destination.string();
  removeLeftOvers(destination);
  temporary_ = createBeside(destination, path, lock_);
  // A map that its owner hid or shared stays so. Not ours to change on some file systems: then the umask's
  // holds.
  if (modeBefore && ::chmod(temporary_.c_str(), *modeBefore) != 0 && errno != EPERM)
  {
    const int chmodError = errno;
    ::unlink(temporary_.c_str());
    ::close(lock_);
    fail(chmodError);
  }
}

AtomicFile::~AtomicFile()
{
  if (pending_) ::unlink(temporary_.c_str());
  if (lock_ >= 0) ::close(lock_);
}

void AtomicFile::fail(int errorNumber) const
{
  refuse(named_, systemReason(errorNumber));
}

void AtomicFile::write(std::string_view content)
{
  checked_ = false;
  Descriptor file(temporary_, O_WRONLY | O_TRUNC);
  if (!file.isOpen()) fail(errno);
  if (const int error = writeFully(file.number(), content); error != 0) fail(error);
  if (const int error = file.close(); error != 0) fail(error);
  checked_ = true;
}

void AtomicFile::commit()
{
  commitAll({this});
}

void AtomicFile::commitAll(const std::vector<AtomicFile*>& files)
{
  for (AtomicFile* file : files) file->bringToDisk();
  for (AtomicFile* file : files)
    if (file->inPlace_) file->copyToPlace();
  std::vector<AtomicFile*> moved;
  moved.reserve(files.size());
  try
  {
    for (AtomicFile* file : files)
    {
      if (file->inPlace_) continue;
      file->moveToPlace(files.size() > 1);
      moved.push_back(file);
    }
  }
  catch (...)
  {
    for (AtomicFile* file : moved) file->takeBack();
    throw;
  }
  for (AtomicFile* file : moved) file->settle();
}

void AtomicFile::bringToDisk()
{
  if (!pending_) throw std::logic_error("AtomicFile::commit called twice for '" + named_ + "'");
  Descriptor file(temporary_, O_WRONLY);
  if (!file.isOpen()) fail(errno);
  if (const int error = checked_ ? 0 : probeForSpace(file.number()); error != 0) fail(error);
  if (::fsync(file.number()) != 0 && errno != EINVAL) fail(errno);
  if (const int error = file.close(); error != 0) fail(error);
}

/// @param mayBeTakenBack  keeps what stood there, where the file system can
void AtomicFile::moveToPlace(bool mayBeTakenBack)
{
  struct stat standing
  {
  };
  const bool stands =
      mayBeTakenBack && ::lstat(destination_.c_str(), &standing) == 0 && S_ISREG(standing.st_mode);
  exchanged_ = stands && ::renameat2(AT_FDCWD, temporary_.c_str(), AT_FDCWD, destination_.c_str(),
                                     RENAME_EXCHANGE) == 0;
  if (!exchanged_ && ::rename(temporary_.c_str(), destination_.c_str()) != 0) fail(errno);
  pending_ = false;
}

void AtomicFile::takeBack() noexcept
{
  const unsigned how = exchanged_ ? RENAME_EXCHANGE : 0;
  pending_ = ::renameat2(AT_FDCWD, destination_.c_str(), AT_FDCWD, temporary_.c_str(), how) == 0;
}

void AtomicFile::settle() noexcept
{
  if (exchanged_) ::unlink(temporary_.c_str());
  // The new name itself. The content is safe already, and not every file system can do this: errors are no
  // loss.
  const std::string folder = fs::path(destination_).parent_path().string();
  const Descriptor entry(folder.empty() ? "." : folder, O_RDONLY | O_DIRECTORY);
  if (entry.isOpen()) static_cast<void>(::fsync(entry.number()));
}

/// To a device or a pipe.
void AtomicFile::copyToPlace()
{
  const Descriptor from(temporary_, O_RDONLY);
  Descriptor to(destination_, O_WRONLY);
  if (!from.isOpen() || !to.isOpen()) fail(errno);
  std::string some(std::size_t{1} << 16, '\0');
  while (true)
  {
    const ssize_t count = ::read(from.number(), some.data(), some.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail(errno);
    if (count == 0) break;
    if (const int error =
            writeFully(to.number(), std::string_view(some).substr(0, static_cast<std::size_t>(count)));
        error != 0)
      fail(error);
  }
  if (const int error = to.close(); error != 0) fail(error);
}

void writeFileAtomically(const std::string& path, std::string_view content)
{
  AtomicFile file(path);
  file.write(content);
  file.commit();
}

}  // namespace lamap
