#include <lamap_mrpt/files/atomic_file.h>
#include <lamap_tools/pictures/gnuplot.h>
#include <mrpt/system/os.h>
#include <sys/wait.h>

#include <filesystem>
#include <stdexcept>

namespace lamap::tools
{
namespace
{
/// In single quotes, with the quotes in it written as the reader of the text wants them.
std::string quoted(const std::string& text, const std::string& quoteInText)
{
  std::string all = "'";
  for (const char c : text) all += c == '\'' ? quoteInText : std::string(1, c);
  return all + "'";
}
}  // namespace

void requireGnuplot(const std::string& forPath)
{
  constexpr int kNotFound = 127;  // by the shell
  std::string said;
  const int status = mrpt::system::executeCommand("gnuplot --version 2>&1", &said);
  if (status == -1 || (WIFEXITED(status) && WEXITSTATUS(status) == kNotFound))
    throw std::runtime_error(forPath +
                             ": plots are drawn by gnuplot, which is not installed (Debian package "
                             "gnuplot-nox); a .csv needs no gnuplot");
}

void drawWithGnuplot(const std::string& script, const std::string& path, int width_px, int height_px)
{
  requireGnuplot(path);
  AtomicFile picture(path);
  AtomicFile scriptFile(path + ".gnuplot");
  scriptFile.write("set terminal pngcairo noenhanced size " + std::to_string(width_px) + "," +
                   std::to_string(height_px) + "\nset output " + gnuplotText(picture.temporaryPath()) + "\n" +
                   script + "\nset output\n");
  std::string said;
  const int status =
      mrpt::system::executeCommand("gnuplot " + quoted(scriptFile.temporaryPath(), "'\\''") + " 2>&1", &said);
  std::error_code noFile;
  if (status != 0 || std::filesystem::file_size(picture.temporaryPath(), noFile) == 0)
    throw std::runtime_error(path + ": gnuplot could not draw it: " + said);
  picture.commit();
}

std::string gnuplotText(const std::string& text)
{
  std::string line = text;
  for (char& c : line)
    if (c == '\n') c = ' ';
  return quoted(line, "''");
}

}  // namespace lamap::tools
