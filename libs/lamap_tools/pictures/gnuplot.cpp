#include <lamap_mrpt/files/atomic_file.h>
#include <lamap_tools/pictures/gnuplot.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <vector>

namespace lamap::tools
{
namespace
{
struct FileCloser
{
  void operator()(std::FILE* file) const { std::fclose(file); }
};
/// An unnamed file for a program's input or output: unlike with pipes, neither side can block.
using NamelessFile = std::unique_ptr<std::FILE, FileCloser>;

NamelessFile makeNamelessFile(const std::string& content = "")
{
  NamelessFile file(std::tmpfile());
  if (!file || std::fwrite(content.data(), 1, content.size(), file.get()) != content.size() ||
      std::fflush(file.get()) != 0)
    throw std::runtime_error(std::string("no temporary file for gnuplot: ") + std::strerror(errno));
  std::rewind(file.get());
  return file;
}

std::string contentOf(const NamelessFile& file)
{
  std::rewind(file.get());
  std::string content;
  for (int c = std::fgetc(file.get()); c != EOF; c = std::fgetc(file.get())) content += static_cast<char>(c);
  return content;
}

struct Outcome
{
  bool started = false;
  bool succeeded = false;
  std::string said;
};

Outcome runGnuplot(std::vector<std::string> arguments, const std::string& script)
{
  arguments.insert(arguments.begin(), "gnuplot");
  std::vector<char*> raw;
  for (std::string& argument : arguments) raw.push_back(argument.data());
  raw.push_back(nullptr);
  const NamelessFile input = makeNamelessFile(script);
  const NamelessFile output = makeNamelessFile();
  posix_spawn_file_actions_t redirections;
  posix_spawn_file_actions_init(&redirections);
  posix_spawn_file_actions_adddup2(&redirections, fileno(input.get()), STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&redirections, fileno(output.get()), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&redirections, fileno(output.get()), STDERR_FILENO);
  pid_t process = 0;
  const int error = posix_spawnp(&process, "gnuplot", &redirections, nullptr, raw.data(), environ);
  posix_spawn_file_actions_destroy(&redirections);
  Outcome outcome;
  if (error != 0) return outcome;
  int status = 0;
  while (waitpid(process, &status, 0) < 0 && errno == EINTR)
  {
  }
  outcome.started = !(WIFEXITED(status) && WEXITSTATUS(status) == 127);
  outcome.succeeded = WIFEXITED(status) && WEXITSTATUS(status) == 0;
  outcome.said = contentOf(output);
  return outcome;
}
}  // namespace

void requireGnuplot(const std::string& forPath)
{
  if (!runGnuplot({"--version"}, "").started)
    throw std::runtime_error(forPath +
                             ": plots are drawn by gnuplot, which is not installed (Debian package "
                             "gnuplot-nox); a .csv needs no gnuplot");
}

void drawWithGnuplot(const std::string& script, const std::string& path, int width_px, int height_px)
{
  AtomicFile file(path);
  const std::string head = "set terminal pngcairo noenhanced size " + std::to_string(width_px) + "," +
                           std::to_string(height_px) + "\nset output " + gnuplotText(file.temporaryPath()) +
                           "\n";
  const Outcome outcome = runGnuplot({"-"}, head + script + "\nset output\n");
  if (!outcome.started) requireGnuplot(path);
  std::error_code noFile;
  const bool drawn = outcome.succeeded && std::filesystem::file_size(file.temporaryPath(), noFile) > 0;
  if (!drawn) throw std::runtime_error(path + ": gnuplot could not draw it: " + outcome.said);
  file.commit();
}

std::string gnuplotText(const std::string& text)
{
  std::string quoted = "'";
  for (const char c : text)
  {
    if (c == '\'') quoted += '\'';
    quoted += c == '\n' ? ' ' : c;
  }
  return quoted + "'";
}

}  // namespace lamap::tools
