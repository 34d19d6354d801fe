#pragma once

#include <pybind11/pybind11.h>

#include <string>
#include <vector>

namespace lamap::python
{
/// A path as Python's own functions take it: str, bytes or os.PathLike. @throws TypeError or ValueError
[[nodiscard]] std::string pathOf(const pybind11::handle& path);
/// One path, or several in a sequence.
[[nodiscard]] std::vector<std::string> pathsOf(const pybind11::handle& paths);

}  // namespace lamap::python
