#pragma once

#include <lamap_mrpt/files/atomic_file.h>

#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

namespace lamap::tools
{
/** A file written piece by piece and renamed to its place when whole. Numbers are appended in their shortest
 * form that reads back as the same double (never locale dependent). One object belongs to one thread. */
class FileOutput
{
 public:
  /// @throws std::runtime_error naming the path if no file can be made there.
  explicit FileOutput(const std::string& path);
  ~FileOutput();
  FileOutput(const FileOutput&) = delete;
  FileOutput& operator=(const FileOutput&) = delete;

  /// @throws std::runtime_error naming the path and the reason (a full disk, say).
  void append(std::string_view bytes);
  void append(double number);

  /// The bytes of a plain number as they lie in memory (little endian on the machines this is built for).
  template <class Number>
  void appendBytes(const Number& number)
  {
    append(std::string_view(reinterpret_cast<const char*>(&number), sizeof(Number)));
  }

  /// Puts the file in its place. @throws as append.
  void commit();
  /// Files that belong together: all of them, or none, as AtomicFile::commitAll(). @throws as append.
  static void commitAll(const std::vector<FileOutput*>& files);

 private:
  [[noreturn]] void fail() const;
  void close();

  AtomicFile file_;
  std::FILE* stream_ = nullptr;
};

/// A double in its shortest form that reads back as the same number; "nan", "inf", "-inf" where it is none.
[[nodiscard]] std::string shortest(double number);

}  // namespace lamap::tools
