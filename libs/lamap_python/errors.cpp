#include <lamap_mrpt/compat/mrpt_compat.h>
#include <lamap_python/errors.h>
#include <lamap_tools/files/usage_error.h>
#include <pybind11/eval.h>
#include <unistd.h>

#include <cerrno>
#include <exception>
#include <new>

namespace py = pybind11;

namespace lamap::python
{
void rethrowAsFileError(const std::string& path)
{
  try
  {
    throw;
  }
  catch (const py::error_already_set&)
  {
    throw;
  }
  catch (const tools::UsageError&)
  {
    throw;
  }
  catch (const std::runtime_error& error)
  {
    throw FileError(compat::messageOf(error), path);
  }
}

namespace
{
/// Messages may have names of files in them, which need not be UTF-8.
py::object textOf(const std::string& text)
{
  return py::reinterpret_steal<py::object>(PyUnicode_DecodeFSDefault(text.c_str()));
}

void setOsError(const FileError& error)
{
  const bool isMissing = access(error.path().c_str(), F_OK) != 0 && errno == ENOENT;
  const py::object type = py::module_::import("lamap").attr(isMissing ? "MissingFileError" : "FileError");
  PyErr_SetObject(type.ptr(), type(textOf(error.what()), textOf(error.path())).ptr());
}

void setError(PyObject* type, const std::exception& error)
{
  PyErr_SetObject(type, textOf(compat::messageOf(error)).ptr());
}
}  // namespace

void addErrors(py::module_& module)
{
  // An OSError whose text is the message alone, which names the file already.
  py::exec(R"(
class FileError(OSError):
    """A file cannot be read or written; `filename` is its name."""

    def __init__(self, message, filename=None):
        super().__init__(message)
        self.filename = filename

    def __str__(self):
        return self.args[0]


class MissingFileError(FileError, FileNotFoundError):
    """There is no such file or folder."""
)",
           module.attr("__dict__"));
  py::register_local_exception_translator(
      [](std::exception_ptr thrown)
      {
        try
        {
          if (thrown) std::rethrow_exception(thrown);
        }
        catch (const py::error_already_set&)
        {
          throw;
        }
        catch (const py::builtin_exception&)
        {
          throw;
        }
        catch (const FileError& error)
        {
          setOsError(error);
        }
        catch (const tools::UsageError& error)
        {
          setError(PyExc_ValueError, error);
        }
        catch (const std::invalid_argument& error)
        {
          setError(PyExc_ValueError, error);
        }
        catch (const std::length_error& error)
        {
          setError(PyExc_ValueError, error);
        }
        catch (const std::out_of_range& error)
        {
          setError(PyExc_IndexError, error);
        }
        catch (const std::bad_alloc&)
        {
          PyErr_NoMemory();
        }
        catch (const std::exception& error)
        {
          setError(PyExc_RuntimeError, error);
        }
      });
}

}  // namespace lamap::python
