#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace lamap
{
/// The system's message for an error number.
[[nodiscard]] std::string systemReason(int errorNumber);

/** A file that appears at its place only when it is whole.
 *
 * What a killed process left of the same file is removed by the next one: a temporary file is locked as long
 * as somebody writes it.
 *
 * Any writer fills temporaryPath(), a new empty file in the same folder; commit() renames it to its place.
 * Until then a file that stood there stays as it is, and without commit() the temporary file is removed. Two
 * writers of one place never share a temporary file: the last one to commit wins, whole.
 *
 * The temporary name ends with the final name, so that writers that choose a format by the extension do the
 * same. A symbolic link is followed and kept. A new file gets the permissions that the process gives new
 * files (umask); a replaced one keeps its own. A device or a pipe (/dev/stdout) cannot be replaced: the
 * temporary file lies in the system's folder for these, and commit() copies it.
 *
 *   AtomicFile file(path);
 *   writer.save(file.temporaryPath());
 *   file.commit();
 *
 * One object belongs to one thread.
 */
class AtomicFile
{
 public:
  /** @throws std::runtime_error naming the path and the reason: empty, a folder, in a folder that does not
   * exist, not writable. Nothing is left behind then. */
  explicit AtomicFile(const std::string& path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// Where to write. Same folder, same extension.
  [[nodiscard]] const std::string& temporaryPath() const { return temporary_; }
  /// The place as it was named by the caller.
  [[nodiscard]] const std::string& path() const { return named_; }

  /** Replaces the content of temporaryPath() by these bytes; every error of the system is noticed.
   *
   * For content that is in memory; may be called once more with other content.
   * @throws std::runtime_error naming the path and the reason, e.g. "No space left on device". */
  void write(std::string_view content);

  /** Brings the content to the disk and the file to its place.
   *
   * Notices a full disk even where the writer of temporaryPath() swallowed the error, as MRPT's streams do: a
   * disk that has not 16 KiB left afterwards counts as full, unless the content came through write().
   * @throws std::runtime_error naming the path and the reason; the place is as it was before. */
  void commit();

  /** The same for files that belong together: all of them come to their places, or none.
   *
   * Where one fails, those that are in their places already are taken back, and what they replaced stands
   * there again. What was copied to a device or a pipe, which is done first, cannot be taken back.
   * @throws as commit() */
  static void commitAll(const std::vector<AtomicFile*>& files);

 private:
  [[noreturn]] void fail(int errorNumber) const;
  void bringToDisk();
  void moveToPlace(bool mayBeTakenBack);
  void takeBack() noexcept;
  void settle() noexcept;
  void copyToPlace();

  std::string named_;        ///< as the caller wrote it, for messages
  std::string destination_;  ///< symbolic links resolved
  std::string temporary_;
  bool inPlace_ = false;    ///< a device or a pipe: commit() copies what temporary_ holds
  bool pending_ = true;     ///< temporary_ is ours to remove
  bool exchanged_ = false;  ///< temporary_ holds what stood at the place
  bool checked_ = false;    ///< the content came through write(), which noticed every error
  int lock_ = -1;           ///< descriptor that locks the temporary file
};

/// AtomicFile, write and commit in one. @throws as these do.
void writeFileAtomically(const std::string& path, std::string_view content);

}  // namespace lamap
