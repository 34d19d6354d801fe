#include <lamap_python/released_gil.h>
#include <pthread.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <thread>

namespace py = pybind11;

namespace lamap::python
{
namespace
{
std::atomic<bool> isEnding{false};
std::atomic<int> waiting{0};   ///< threads that take the GIL
std::thread::id endingThread;  ///< the one that may still take it then

/// While it exists, the interpreter does not end.
class Waiting
{
 public:
  Waiting()
  {
    ++waiting;
    if (!isEnding || std::this_thread::get_id() == endingThread) return;
    --waiting;
    while (true) pause();
  }
  ~Waiting() { --waiting; }
  Waiting(const Waiting&) = delete;
  Waiting& operator=(const Waiting&) = delete;
};

py::gil_scoped_acquire takenGil()
{
  const Waiting waits;
  return {};
}
}  // namespace

ReleasedGil::~ReleasedGil()
{
  const Waiting waits;
  PyEval_RestoreThread(state_);
}

HeldGil::HeldGil() : held_(takenGil()) {}

void watchEndOfInterpreter()
{
  // A child that is forked has only the thread that forked it, which holds the GIL.
  pthread_atfork(nullptr, nullptr, [] { waiting = 0; });
  // Python calls this before it unwinds threads, and when all but daemon threads are gone.
  py::module_::import("atexit").attr("register")(py::cpp_function(
      []
      {
        endingThread = std::this_thread::get_id();
        isEnding = true;
        const py::gil_scoped_release released;
        while (waiting > 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }));
}

}  // namespace lamap::python
