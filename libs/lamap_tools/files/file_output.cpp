#include <lamap_tools/files/file_output.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <stdexcept>

namespace lamap::tools
{
namespace
{
using NumberText = std::array<char, 32>;  // the longest shortest form of a double has 24 characters

std::string_view format(double number, NumberText& text)
{
  const auto result = std::to_chars(text.data(), text.data() + text.size(), number);
  return {text.data(), static_cast<size_t>(result.ptr - text.data())};
}
}  // namespace

FileOutput::FileOutput(const std::string& path) : file_(path)
{
  stream_ = std::fopen(file_.temporaryPath().c_str(), "wb");
  if (stream_ == nullptr) fail();
}

FileOutput::~FileOutput()
{
  if (stream_ != nullptr) std::fclose(stream_);
}

void FileOutput::append(std::string_view bytes)
{
  if (std::fwrite(bytes.data(), 1, bytes.size(), stream_) != bytes.size()) fail();
}

void FileOutput::append(double number)
{
  NumberText text;
  append(format(number, text));
}

void FileOutput::commit()
{
  commitAll({this});
}

void FileOutput::commitAll(const std::vector<FileOutput*>& files)
{
  std::vector<AtomicFile*> whole;
  for (FileOutput* file : files)
  {
    file->close();
    whole.push_back(&file->file_);
  }
  AtomicFile::commitAll(whole);
}

void FileOutput::close()
{
  std::FILE* stream = stream_;
  stream_ = nullptr;
  if (std::fclose(stream) != 0) fail();
}

void FileOutput::fail() const
{
  throw std::runtime_error(file_.path() + ": cannot be written: " + std::strerror(errno));
}

std::string shortest(double number)
{
  NumberText text;
  return std::string(format(number, text));
}

}  // namespace lamap::tools
