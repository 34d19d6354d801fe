#include "program.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <thread>

namespace lamap::test
{
namespace
{
namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

/// In the child: never returns.
[[noreturn]] void become(const std::vector<std::string>& command, const fs::path& folder,
                         const fs::path& outputFile, const Program::Environment& environment,
                         const std::string& inputFile)
{
  setpgid(0, 0);
  const int input = open(inputFile.c_str(), O_RDWR | O_NOCTTY);
  const int output = open(outputFile.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  if (input < 0 || output < 0 || chdir(folder.c_str()) != 0) _exit(127);
  dup2(input, STDIN_FILENO);
  dup2(output, STDOUT_FILENO);
  dup2(output, STDERR_FILENO);
  for (const auto& [name, text] : environment) setenv(name.c_str(), text.c_str(), 1);
  std::vector<char*> arguments;
  for (const std::string& argument : command) arguments.push_back(const_cast<char*>(argument.c_str()));
  arguments.push_back(nullptr);
  execvp(arguments.front(), arguments.data());
  _exit(127);
}
}  // namespace

Program::Program(const std::vector<std::string>& command, const fs::path& folder,
                 const Environment& environment, Keys keys)
{
  static int count = 0;
  outputFile_ = folder / ("printed_" + std::to_string(count++) + ".txt");
  std::string inputFile = "/dev/null";
  if (keys == Keys::Terminal)
  {
    terminal_ = posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
    if (terminal_ < 0 || grantpt(terminal_) != 0 || unlockpt(terminal_) != 0)
      throw std::runtime_error(std::string("no terminal: ") + std::strerror(errno));
    inputFile = ptsname(terminal_);
  }
  pid_ = fork();
  if (pid_ < 0) throw std::runtime_error(std::string("fork: ") + std::strerror(errno));
  if (pid_ == 0) become(command, folder, outputFile_, environment, inputFile);
  setpgid(pid_, pid_);
}

Program::~Program()
{
  stop();
  if (terminal_ >= 0) close(terminal_);
}

bool Program::reap()
{
  if (status_) return true;
  int status = 0;
  if (waitpid(pid_, &status, WNOHANG) != pid_) return false;
  status_ = status;
  return true;
}

bool Program::isRunning()
{
  return !reap();
}

Outcome Program::wait(std::chrono::seconds timeout)
{
  if (becomes([this] { return reap(); }, timeout)) return stop();
  Outcome outcome = stop();
  outcome.timedOut = true;
  return outcome;
}

Outcome Program::stop()
{
  if (!reap()) kill(-pid_, SIGTERM);
  if (!becomes([this] { return reap(); }, std::chrono::seconds(5)))
  {
    kill(-pid_, SIGKILL);
    int status = 0;
    waitpid(pid_, &status, 0);
    status_ = status;
  }
  kill(-pid_, SIGKILL);  // and all processes it has started
  Outcome outcome;
  if (WIFEXITED(*status_)) outcome.exitCode = WEXITSTATUS(*status_);
  outcome.output = output();
  return outcome;
}

std::string Program::output() const
{
  return readFile(outputFile_);
}

Outcome run(const std::vector<std::string>& command, const fs::path& folder, std::chrono::seconds timeout,
            const Program::Environment& environment)
{
  return Program(command, folder, environment).wait(timeout);
}

std::vector<std::string> withPlugin(const std::vector<std::string>& command)
{
  std::vector<std::string> whole{lamapTool(), "run", "--"};
  whole.insert(whole.end(), command.begin(), command.end());
  return whole;
}

std::string pluginFile()
{
  return LAMAP_PLUGIN_FILE;
}
std::string lamapTool()
{
  return LAMAP_TOOL;
}
std::string configFile(const std::string& name)
{
  return std::string(LAMAP_SHARE_DIR) + "/ini/" + name;
}

bool isInstalled(const std::string& program)
{
  std::istringstream path(std::getenv("PATH") ? std::getenv("PATH") : "");
  for (std::string folder; std::getline(path, folder, ':');)
    if (access((fs::path(folder) / program).c_str(), X_OK) == 0) return true;
  return false;
}

std::optional<std::string> dataset(const std::string& name)
{
  const fs::path path = fs::path("/usr/share/mrpt/datasets") / name;
  if (!fs::exists(path)) return std::nullopt;
  return path.string();
}

bool becomes(const std::function<bool()>& question, std::chrono::seconds timeout)
{
  const auto end = Clock::now() + timeout;
  while (!question())
  {
    if (Clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  return true;
}

fs::path freshFolder()
{
  const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
  std::string name = std::string(test->test_suite_name()) + "." + test->name();
  std::replace(name.begin(), name.end(), '/', '_');  // in names of parametrized tests
  const fs::path folder = fs::path(LAMAP_WORK_DIR) / name;
  fs::remove_all(folder);
  fs::create_directories(folder);
  return folder;
}

std::string readFile(const fs::path& path)
{
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

void writeFile(const fs::path& path, const std::string& text)
{
  std::ofstream out(path, std::ios::binary);
  out << text;
  if (!out.flush()) throw std::runtime_error(path.string() + " cannot be written");
}

}  // namespace lamap::test
