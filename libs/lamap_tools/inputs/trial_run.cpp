#include <fcntl.h>
#include <lamap_tools/inputs/trial_run.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <memory>
#include <new>
#include <stdexcept>
#include <thread>

namespace lamap::tools
{
namespace
{
using Counter = std::atomic<uint64_t>;
static_assert(Counter::is_always_lock_free, "shared between processes");

/// A counter that this process and its children see.
class SharedCounter
{
 public:
  SharedCounter()
  {
    void* memory = mmap(nullptr, sizeof(Counter), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED)
      throw std::runtime_error(std::string("no shared memory: ") + std::strerror(errno));
    counter_ = new (memory) Counter(0);
  }
  ~SharedCounter() { munmap(counter_, sizeof(Counter)); }
  SharedCounter(const SharedCounter&) = delete;
  SharedCounter& operator=(const SharedCounter&) = delete;

  Counter& operator*() const { return *counter_; }

 private:
  Counter* counter_;
};

struct FileCloser
{
  void operator()(std::FILE* file) const { std::fclose(file); }
};
/// Has no name; this process and its children share it.
using SharedFile = std::unique_ptr<std::FILE, FileCloser>;

bool write(const std::vector<uint8_t>& bytes, const SharedFile& file)
{
  return std::fwrite(bytes.data(), 1, bytes.size(), file.get()) == bytes.size() &&
         std::fflush(file.get()) == 0;
}

std::vector<uint8_t> contentOf(const SharedFile& file)
{
  std::fseek(file.get(), 0, SEEK_END);
  std::vector<uint8_t> bytes(static_cast<size_t>(std::ftell(file.get())));
  std::rewind(file.get());
  if (std::fread(bytes.data(), 1, bytes.size(), file.get()) != bytes.size())
    throw std::runtime_error("what a trial has found cannot be read");
  return bytes;
}

using Attempt = std::function<std::vector<uint8_t>(const std::function<void()>&)>;

[[noreturn]] void runInChild(const Attempt& attempt, Counter& counter, const SharedFile& found)
{
  // What it says would only confuse, and a core of it is of no use.
  const int nowhere = open("/dev/null", O_WRONLY);
  if (nowhere >= 0)
  {
    dup2(nowhere, STDOUT_FILENO);
    dup2(nowhere, STDERR_FILENO);
  }
  const rlimit none{0, 0};
  setrlimit(RLIMIT_CORE, &none);
  try
  {
    _exit(write(attempt([&counter] { ++counter; }), found) ? 0 : 1);
  }
  catch (...)
  {
    _exit(1);
  }
}

std::string failureText(int status)
{
  if (WIFSIGNALED(status)) return std::string("reading it ends in: ") + strsignal(WTERMSIG(status));
  return "it cannot be read";
}
}  // namespace

TrialRun tryInChild(const Attempt& attempt, const std::function<bool()>& shouldStop)
{
  using Clock = std::chrono::steady_clock;
  const SharedCounter counter;
  const SharedFile found(std::tmpfile());
  if (!found) throw std::runtime_error(std::string("no temporary file: ") + std::strerror(errno));
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error(std::string("no new process: ") + std::strerror(errno));
  if (child == 0) runInChild(attempt, *counter, found);

  TrialRun run;
  int status = 0;
  auto pause = std::chrono::microseconds(50);
  auto lastStep = Clock::now();
  while (waitpid(child, &status, WNOHANG) == 0)
  {
    std::this_thread::sleep_for(pause);
    pause = std::min<std::chrono::microseconds>(2 * pause, std::chrono::milliseconds(20));
    if (const uint64_t steps = *counter; steps != run.steps)
    {
      run.steps = steps;
      lastStep = Clock::now();
    }
    run.stopped = shouldStop();
    const bool hangs = Clock::now() - lastStep > std::chrono::minutes(1);
    if (!run.stopped && !hangs) continue;
    kill(child, SIGKILL);
    waitpid(child, &status, 0);
    if (hangs) run.failure = "reading it comes to no end";
    break;
  }
  run.steps = *counter;
  const bool succeeded = WIFEXITED(status) && WEXITSTATUS(status) == 0;
  if (!run.failure && !run.stopped && !succeeded) run.failure = failureText(status);
  if (succeeded) run.found = contentOf(found);
  return run;
}

}  // namespace lamap::tools
