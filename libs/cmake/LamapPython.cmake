# The Python module, if it is wanted and can be built. A sanitized library cannot be loaded into a plain interpreter.

set(LAMAP_BUILDS_PYTHON OFF)
if(LAMAP_PYTHON AND LAMAP_SANITIZE)
  message(STATUS "Python module: not built with LAMAP_SANITIZE")
elseif(LAMAP_PYTHON)
  # The system's own interpreter, for which its packages of pybind11 and NumPy are, and not another one that stands
  # first in PATH.
  if(NOT Python_EXECUTABLE AND EXISTS /usr/bin/python3)
    set(Python_EXECUTABLE /usr/bin/python3 CACHE FILEPATH "The interpreter that the module is for")
  endif()
  find_package(Python 3.9 COMPONENTS Interpreter Development.Module)
  if(Python_FOUND)
    find_package(pybind11 2.10 CONFIG)
  endif()
  if(Python_FOUND AND pybind11_FOUND)
    set(LAMAP_BUILDS_PYTHON ON)
    message(STATUS "Python module: for ${Python_EXECUTABLE} ${Python_VERSION}, in ${PROJECT_BINARY_DIR}/python")
    add_subdirectory(libs/lamap_python)
  else()
    message(STATUS "Python module: not built; it needs Python 3.9 and pybind11 2.10, in Debian the packages python3-dev "
      "and pybind11-dev")
  endif()
endif()
