#pragma once

#include <pybind11/pybind11.h>

#include <stdexcept>
#include <string>

namespace lamap::python
{
/// What is wrong with a file, whose name the message has.
class FileError : public std::runtime_error
{
 public:
  FileError(const std::string& message, std::string path)
      : std::runtime_error(message), path_(std::move(path))
  {
  }
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

/** Calls work(), in which every failure is one of a file.
 * @throws FileError with the message of a std::runtime_error; bad arguments stay what they are */
template <typename Work>
auto withFile(const std::string& path, const Work& work);

/// Adds the classes FileError and MissingFileError, and makes the exceptions of C++ those of Python, with the
/// same words: bad arguments ValueError, FileError its own, too little memory MemoryError, else RuntimeError.
void addErrors(pybind11::module_& module);

/// @throws FileError for what is being thrown; call it in a catch block
[[noreturn]] void rethrowAsFileError(const std::string& path);

template <typename Work>
auto withFile(const std::string& path, const Work& work)
{
  try
  {
    return work();
  }
  catch (...)
  {
    rethrowAsFileError(path);
  }
}

}  // namespace lamap::python
