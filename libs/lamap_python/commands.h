#pragma once

#include <pybind11/pybind11.h>

namespace lamap::python
{
/// Adds what the subcommands of `lamap` do to the module: build and evaluate.
void addCommands(pybind11::module_& module);

}  // namespace lamap::python
