#include <fcntl.h>
#include <lamap_mrpt/files/atomic_file.h>
#include <mrpt/core/format.h>
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

/// Creates a new empty file beside the destination, with the permissions of the umask.
std::string createBeside(const fs::path& destination, const std::string& named)
{
  const fs::path folder = destination.parent_path().empty() ? fs::path(".") : destination.parent_path();
  // A file name holds 255 bytes; the end of a longer one is kept, with its extension.
  std::string name = destination.filename().string();
  constexpr std::size_t kLongest = 200;
  if (name.size() > kLongest) name.erase(0, name.size() - kLongest);

  for (int attempt = 0; attempt < 100; ++attempt)
  {
    std::string temporary = (folder / (".partial-" + randomWord() + "-" + name)).string();
    const Descriptor created(temporary, O_WRONLY | O_CREAT | O_EXCL);
    if (created.isOpen()) return temporary;
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
      destination_ = temporary_ = path;
      inPlace_ = true;
      pending_ = false;
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
  temporary_ = createBeside(destination, path);
  // A map that its owner hid or shared stays so. Not ours to change on some file systems: then the umask's
  // holds.
  if (modeBefore && ::chmod(temporary_.c_str(), *modeBefore) != 0 && errno != EPERM)
  {
    const int chmodError = errno;
    ::unlink(temporary_.c_str());
    fail(chmodError);
  }
}

AtomicFile::~AtomicFile()
{
  if (pending_) ::unlink(temporary_.c_str());
}

void AtomicFile::fail(int errorNumber) const
{
  refuse(named_, systemReason(errorNumber));
}

void AtomicFile::write(std::string_view content)
{
  checked_ = false;
  Descriptor file(temporary_, O_WRONLY | (inPlace_ ? 0 : O_TRUNC));
  if (!file.isOpen()) fail(errno);
  if (const int error = writeFully(file.number(), content); error != 0) fail(error);
  if (const int error = file.close(); error != 0) fail(error);
  checked_ = true;
}

void AtomicFile::commit()
{
  if (inPlace_) return;
  if (!pending_) throw std::logic_error("AtomicFile::commit called twice for '" + named_ + "'");
  {
    Descriptor file(temporary_, O_WRONLY);
    if (!file.isOpen()) fail(errno);
    if (const int error = checked_ ? 0 : probeForSpace(file.number()); error != 0) fail(error);
    if (::fsync(file.number()) != 0 && errno != EINVAL) fail(errno);
    if (const int error = file.close(); error != 0) fail(error);
  }
  if (::rename(temporary_.c_str(), destination_.c_str()) != 0) fail(errno);
  pending_ = false;

  // The new name itself. The content is safe already, and not every file system can do this: errors are no
  // loss.
  const fs::path folder = fs::path(destination_).parent_path();
  const Descriptor entry(folder.empty() ? "." : folder.string(), O_RDONLY | O_DIRECTORY);
  if (entry.isOpen()) static_cast<void>(::fsync(entry.number()));
}

void writeFileAtomically(const std::string& path, std::string_view content)
{
  AtomicFile file(path);
  file.write(content);
  file.commit();
}

}  // namespace lamap
