#include <lamap_mrpt/compat/mrpt_compat.h>

#include <cctype>

namespace lamap::compat
{
namespace
{
/// "file.cpp:123: [function [with T = int]] text" → "text"
std::string withoutPlace(const std::string& message)
{
  const std::size_t bracket = message.find(": [");
  if (bracket == std::string::npos || bracket == 0 ||
      !std::isdigit(static_cast<unsigned char>(message[bracket - 1])))
    return message;
  int depth = 0;
  for (std::size_t i = bracket + 2; i < message.size(); ++i)
  {
    if (message[i] == '[') ++depth;
    if (message[i] == ']' && --depth == 0) return message.substr(i + 1);
  }
  return message;
}

std::string trimmed(const std::string& text)
{
  const char* const blanks = " \t\r\n";
  const std::size_t first = text.find_first_not_of(blanks);
  if (first == std::string::npos) return {};
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}
}  // namespace

std::string messageOf(const std::exception& error)
{
  const auto* decorated = dynamic_cast<const mrpt::ExceptionWithCallBackBase*>(&error);
  std::string text = decorated ? decorated->originalWhat : error.what();

  // MRPT wraps the exception of a nested object as text: the innermost one is the cause.
  const std::string original = "Original exception:";
  if (const std::size_t inner = text.rfind(original); inner != std::string::npos)
    text.erase(0, inner + original.size());
  const std::string label = "Message:";
  if (const std::size_t inner = text.find(label); inner != std::string::npos)
    text.erase(0, inner + label.size());
  text = text.substr(0, text.find("\nLocation:"));
  return trimmed(withoutPlace(text));
}

}  // namespace lamap::compat
