#pragma once

#include <pybind11/pybind11.h>

namespace lamap::python
{
/** Lets other threads of Python run.
 *
 * While the interpreter ends, Python unwinds the stack of a daemon thread that waits for the GIL, which C++
 * answers with an abort. So, from the moment that the interpreter begins to end, other threads than the main
 * one sleep instead until the process is gone. */
class ReleasedGil
{
 public:
  ReleasedGil() : state_(PyEval_SaveThread()) {}
  ~ReleasedGil();
  ReleasedGil(const ReleasedGil&) = delete;
  ReleasedGil& operator=(const ReleasedGil&) = delete;

 private:
  PyThreadState* state_;
};

/// Takes the GIL for a while, from a thread that has released it.
class HeldGil
{
 public:
  HeldGil();
  HeldGil(const HeldGil&) = delete;
  HeldGil& operator=(const HeldGil&) = delete;

 private:
  pybind11::gil_scoped_acquire held_;
};

/// To be called once, when the module is imported.
void watchEndOfInterpreter();

}  // namespace lamap::python
