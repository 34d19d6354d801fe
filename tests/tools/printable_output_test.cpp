#include <gtest/gtest.h>
#include <lamap_tools/report/printable_output.h>

#include <sstream>

namespace
{
using lamap::tools::PrintableOutput;

/// As it is shown, written in pieces of so many bytes.
std::string shown(const std::string& text, size_t piece)
{
  std::ostringstream out;
  {
    const PrintableOutput printable(out);
    for (size_t at = 0; at < text.size(); at += piece) out << text.substr(at, piece);
  }
  return out.str();
}

TEST(PrintableOutput, EscapesControlCharactersAndNothingElse)
{
  const std::string plain = "a\tb\n\xC3\xA9 \xC2\xB0 \xE2\x82\xAC \\x1b~";
  for (const size_t piece : {1, 2, 3, 1000})
  {
    SCOPED_TRACE(piece);
    EXPECT_EQ(shown(plain, piece), plain);
    EXPECT_EQ(shown("\x1b[2J\r\x7f\a", piece), "\\x1b[2J\\x0d\\x7f\\x07");
    EXPECT_EQ(shown(std::string("a\0b", 3), piece), "a\\x00b");
    EXPECT_EQ(shown("\xC2\x80\xC2\x9F\xC2\xA0", piece), "\\x80\\x9f\xC2\xA0");
    EXPECT_EQ(shown("\xC2\xC2\x9B\xC2", piece), "\xC2\\x9b\xC2") << "half of a character at the end";
  }
}

TEST(PrintableOutput, LeavesTheStreamAsItWas)
{
  std::ostringstream out;
  {
    const PrintableOutput printable(out);
    out << "\x1b";
    std::ostream(printable.terminal()) << "\x1b";
  }
  out << "\x1b";
  EXPECT_EQ(out.str(), "\\x1b\x1b\x1b");
}

TEST(PrintableOutput, TellsThatTheOutputIsFull)
{
  struct Full : std::streambuf
  {
  };
  Full full;
  std::ostream out(&full);
  const PrintableOutput printable(out);
  EXPECT_FALSE(out << "text" << std::flush);
}
}  // namespace
