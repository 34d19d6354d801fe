#pragma once

#include <ostream>
#include <streambuf>
#include <string_view>

namespace lamap::tools
{
/** Makes what is written to a stream safe to show on a terminal, for as long as it lives.
 *
 * Names of files, labels of sensors and keys come from elsewhere and may hold control characters, which a
 * terminal would obey. They are shown as escapes: "\x1b" for ESC, "\x9b" for U+009B. Line breaks and tabs
 * pass, as does all other UTF-8. Belongs to one thread. */
class PrintableOutput : private std::streambuf
{
 public:
  /// @param stream must outlive this.
  explicit PrintableOutput(std::ostream& stream);
  ~PrintableOutput() override;
  PrintableOutput(const PrintableOutput&) = delete;
  PrintableOutput& operator=(const PrintableOutput&) = delete;

  /// Where the stream really writes, for who draws on a terminal.
  [[nodiscard]] std::streambuf* terminal() const { return target_; }

 private:
  int_type overflow(int_type character) override;
  std::streamsize xsputn(const char* text, std::streamsize count) override;
  int sync() override;
  bool put(unsigned char character);
  bool write(std::string_view text);
  bool escape(unsigned char character);

  std::ostream& stream_;
  std::streambuf* target_;
  bool leadWaits_ = false;  ///< the first byte of what may be one of U+0080 to U+009F
};

}  // namespace lamap::tools
