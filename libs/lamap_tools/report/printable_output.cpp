#include <lamap_tools/report/printable_output.h>

namespace lamap::tools
{
namespace
{
constexpr unsigned char kLead = 0xC2;  // of U+0080 to U+00BF in UTF-8

bool isControl(unsigned char character)
{
  return (character < 0x20 && character != '\n' && character != '\t') || character == 0x7F;
}

/// Of a character after kLead.
bool isControlAfterLead(unsigned char character)
{
  return character >= 0x80 && character < 0xA0;
}
}  // namespace

PrintableOutput::PrintableOutput(std::ostream& stream) : stream_(stream), target_(stream.rdbuf(this)) {}

PrintableOutput::~PrintableOutput()
{
  const auto state = stream_.rdstate();
  (void)sync();
  stream_.rdbuf(target_);
  stream_.setstate(state);
}

std::streambuf::int_type PrintableOutput::overflow(int_type character)
{
  if (traits_type::eq_int_type(character, traits_type::eof())) return traits_type::not_eof(character);
  return put(static_cast<unsigned char>(traits_type::to_char_type(character))) ? character
                                                                               : traits_type::eof();
}

std::streamsize PrintableOutput::xsputn(const char* text, std::streamsize count)
{
  std::streamsize done = 0;
  while (done < count)
  {
    std::streamsize plain = done;
    const auto at = [&](std::streamsize place) { return static_cast<unsigned char>(text[place]); };
    while (!leadWaits_ && plain < count && !isControl(at(plain)) && at(plain) != kLead) ++plain;
    if (plain > done && !write({text + done, static_cast<size_t>(plain - done)})) return done;
    done = plain;
    if (done < count && !put(at(done++))) return done - 1;
  }
  return done;
}

int PrintableOutput::sync()
{
  if (leadWaits_ && !write({reinterpret_cast<const char*>(&kLead), 1})) return -1;
  leadWaits_ = false;
  return target_->pubsync();
}

bool PrintableOutput::put(unsigned char character)
{
  if (leadWaits_)
  {
    leadWaits_ = false;
    if (isControlAfterLead(character)) return escape(character);
    if (!write({reinterpret_cast<const char*>(&kLead), 1})) return false;
  }
  if (character == kLead)
  {
    leadWaits_ = true;
    return true;
  }
  if (isControl(character)) return escape(character);
  return write({reinterpret_cast<const char*>(&character), 1});
}

bool PrintableOutput::write(std::string_view text)
{
  const auto size = static_cast<std::streamsize>(text.size());
  return target_->sputn(text.data(), size) == size;
}

bool PrintableOutput::escape(unsigned char character)
{
  constexpr const char* kDigits = "0123456789abcdef";
  const char escaped[] = {'\\', 'x', kDigits[character >> 4U], kDigits[character & 0xFU]};
  return write({escaped, sizeof(escaped)});
}

}  // namespace lamap::tools
