#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "support/temporary_folder.h"

// The program `lamap` as a user starts it.
namespace lamap::test
{
struct Outcome
{
  int exitCode = -1;
  int signal = 0;
  std::string out;
  std::string err;
};

/// A process of the program, with its output in files of a folder, which must outlive it.
class Program
{
 public:
  Program(const TemporaryFolder& folder, std::vector<std::string> arguments) : folder_(folder)
  {
    arguments.insert(arguments.begin(), LAMAP_PROGRAM);
    std::vector<char*> raw;
    for (std::string& argument : arguments) raw.push_back(argument.data());
    raw.push_back(nullptr);
    process_ = fork();
    if (process_ != 0) return;
    redirect(folder / "stdout", STDOUT_FILENO);
    redirect(folder / "stderr", STDERR_FILENO);
    execv(LAMAP_PROGRAM, raw.data());
    _exit(99);
  }

  [[nodiscard]] pid_t process() const { return process_; }

  [[nodiscard]] Outcome wait() const
  {
    int status = 0;
    waitpid(process_, &status, 0);
    Outcome outcome;
    if (WIFEXITED(status)) outcome.exitCode = WEXITSTATUS(status);
    if (WIFSIGNALED(status)) outcome.signal = WTERMSIG(status);
    outcome.out = fileContent(folder_ / "stdout");
    outcome.err = fileContent(folder_ / "stderr");
    return outcome;
  }

 private:
  static void redirect(const std::string& path, int descriptor)
  {
    const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    dup2(file, descriptor);
  }

  const TemporaryFolder& folder_;
  pid_t process_ = 0;
};

/// Tests that start the program from a shell, in a folder of their own.
class CommandLine : public testing::Test
{
 protected:
  /// A $ stands for the folder of the test. @return exit code
  int run(const std::string& arguments)
  {
    const int code = start(arguments, "$/stdout");
    out_ = fileContent(folder_ / "stdout");
    return code;
  }
  /// The same, and what the loader of the system says of libraries. @return those that it loaded
  std::string librariesOf(const std::string& arguments)
  {
    setenv("LD_DEBUG", "files", 1);
    (void)run(arguments);
    unsetenv("LD_DEBUG");
    return err_;
  }
  /// The same, with a standard output that takes nothing.
  int runIntoFullDisk(const std::string& arguments) { return start(arguments, "/dev/full"); }

  [[nodiscard]] bool exists(const std::string& name) const { return std::filesystem::exists(folder_ / name); }

  TemporaryFolder folder_;
  std::string out_;
  std::string err_;

 private:
  int start(const std::string& arguments, const std::string& output)
  {
    std::string command =
        std::string(LAMAP_PROGRAM) + " " + arguments + " > " + output + " 2> $/stderr < /dev/null";
    for (size_t at = 0; (at = command.find('$', at)) != std::string::npos;)
      command.replace(at, 1, folder_.path());
    const int status = std::system(command.c_str());
    err_ = fileContent(folder_ / "stderr");
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
};

}  // namespace lamap::test
