#include <lamap_python/commands.h>
#include <lamap_python/errors.h>
#include <lamap_python/map_object.h>
#include <lamap_python/released_gil.h>

namespace py = pybind11;

namespace
{
/// A named tuple that can be pickled.
void addTuple(py::module_& module, const char* name, const char* fields, const char* doc)
{
  const py::object type =
      py::module_::import("collections").attr("namedtuple")(name, fields, py::arg("module") = "lamap");
  type.attr("__doc__") = doc;
  module.attr(name) = type;
}

void addStates(py::module_& module)
{
  py::dict states;
  states["UNOBSERVED"] = -1;
  states["UNKNOWN"] = static_cast<int>(lamap::CellState::Unknown);
  states["FREE"] = static_cast<int>(lamap::CellState::Free);
  states["OCCUPIED"] = static_cast<int>(lamap::CellState::Occupied);
  const py::object type =
      py::module_::import("enum").attr("IntEnum")("State", states, py::arg("module") = "lamap");
  type.attr("__doc__") =
      "What a map says of a place: it has observed nothing there, or is undecided, or takes it for free or "
      "occupied.";
  module.attr("State") = type;
}
}  // namespace

PYBIND11_MODULE(lamap, module)
{
  module.doc() =
      "Learning-aided 3D occupancy maps: BGK, Gaussian process and Hilbert maps of mrpt-lamap.\n\n"
      "Lengths are in metres, angles in radians, points in the frame of the map unless stated otherwise. Bad "
      "arguments "
      "raise ValueError or TypeError, files FileError, an OSError.";
  module.attr("__version__") = LAMAP_VERSION;
  py::options options;
  options.disable_function_signatures();  // the docstrings have their own, which inspect.signature() reads
  lamap::python::addErrors(module);
  addStates(module);
  addTuple(module, "Estimates", "prob variance state", "What LearnedMap.query() returns.");
  addTuple(module, "Cells", "centre size prob variance state evidence", "What LearnedMap.cells() returns.");
  addTuple(module, "Rays", "hit end", "What LearnedMap.cast_rays() returns.");
  lamap::python::addMaps(module);
  lamap::python::addCommands(module);
  lamap::python::watchEndOfInterpreter();
}
