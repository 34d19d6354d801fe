#include <lamap_python/paths.h>

namespace py = pybind11;

namespace lamap::python
{
std::string pathOf(const py::handle& path)
{
  PyObject* bytes = nullptr;
  if (PyUnicode_FSConverter(path.ptr(), &bytes) == 0) throw py::error_already_set();
  return py::reinterpret_steal<py::bytes>(bytes);
}

std::vector<std::string> pathsOf(const py::handle& paths)
{
  if (!py::isinstance<py::list>(paths) && !py::isinstance<py::tuple>(paths)) return {pathOf(paths)};
  std::vector<std::string> all;
  for (const py::handle path : paths) all.push_back(pathOf(path));
  return all;
}

}  // namespace lamap::python
