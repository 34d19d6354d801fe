# Run by ctest, see CMakeLists.txt here. Every step that fails ends the test with the step's output.

function(run)
  execute_process(COMMAND ${ARGV} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  list(JOIN ARGV " " command)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${command}\nended with ${result}:\n${output}")
  endif()
  message(STATUS "${command}")
  set(output "${output}" PARENT_SCOPE)
endfunction()

file(REMOVE_RECURSE ${WORK_DIR})
run(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${WORK_DIR}/installed)
file(RENAME ${WORK_DIR}/installed ${WORK_DIR}/moved)
set(prefix ${WORK_DIR}/moved)
set(share ${prefix}/${DATA_DIR}/mrpt-lamap)
set(library ${prefix}/${LIB_DIR}/libmrpt-lamap.so)

# The tool starts from where it is now, and finds the library that was installed with it.
set(ENV{LD_LIBRARY_PATH} "")
run(${prefix}/${BIN_DIR}/lamap --version)
run(${prefix}/${BIN_DIR}/lamap run -- env)
file(REAL_PATH ${library} real_library)
string(FIND "${output}" "LD_PRELOAD=${real_library}" found)
if(found EQUAL -1)
  message(FATAL_ERROR "The installed lamap does not load ${real_library} into other programs:\n${output}")
endif()

# MRPT never unregisters a class, so the library must never be unloaded.
run(${READELF} --dynamic --wide ${library})
if(NOT output MATCHES "NODELETE")
  message(FATAL_ERROR "libmrpt-lamap.so is not linked with -z nodelete:\n${output}")
endif()

# The library shows what its public headers declare, not what it is made of.
run(${NM} --dynamic --demangle --defined-only ${library})
string(REGEX MATCHALL "\n[^\n]* lamap::[^\n]*" symbols "\n${output}")
list(LENGTH symbols count)
message(STATUS "${count} symbols of namespace lamap are shown")
if(count GREATER 600 OR NOT output MATCHES "vtable for lamap::CBGKMap\n" OR output MATCHES "lamap::loadMapFile")
  message(FATAL_ERROR "libmrpt-lamap.so shows ${count} symbols of namespace lamap, or the wrong ones:\n${output}")
endif()

# The Python module works from where it is now, and its stubs are beside it.
if(PYTHON)
  file(GLOB module ${prefix}/${PYTHON_DIR}/lamap.*.so)
  if(NOT module OR NOT EXISTS ${prefix}/${PYTHON_DIR}/lamap.pyi)
    message(FATAL_ERROR "No Python module, or no stubs, were installed to ${prefix}/${PYTHON_DIR}")
  endif()
  file(MAKE_DIRECTORY ${WORK_DIR}/python)
  run(${CMAKE_COMMAND} -E chdir ${WORK_DIR}/python ${CMAKE_COMMAND} -E env PYTHONPATH=${prefix}/${PYTHON_DIR}
    ${PYTHON} -B ${share}/examples/python/first_map.py)
  foreach(map bgkMap gpMap hilbertMap overlappingHilbertMap)
    run(${prefix}/${BIN_DIR}/lamap info ${WORK_DIR}/python/${map}.lamap.gz)
  endforeach()
endif()

file(GLOB ini_files ${share}/ini/*/*.ini)
if(NOT ini_files)
  message(FATAL_ERROR "No .ini file was installed to ${share}/ini")
endif()

# Other projects: the installed examples, whatever the type of build; nothing but the package is given to them.
foreach(build_type "" Debug Release)
  set(examples ${WORK_DIR}/examples${build_type})
  run(${CMAKE_COMMAND} -G ${GENERATOR} -S ${share}/examples -B ${examples}
    -D CMAKE_CXX_COMPILER=${CXX_COMPILER} -D CMAKE_BUILD_TYPE=${build_type} -D CMAKE_PREFIX_PATH=${prefix})
  run(${CMAKE_COMMAND} --build ${examples})
  foreach(example core_maps mrpt_maps)
    run(${CMAKE_COMMAND} -E chdir ${examples} ./${example})
    message(STATUS "${output}")
  endforeach()
endforeach()
foreach(map bgkMap gpMap hilbertMap overlappingHilbertMap)
  run(${prefix}/${BIN_DIR}/lamap info ${WORK_DIR}/examplesRelease/${map}.lamap.gz)
endforeach()

# Every installed header compiles alone.
run(${CMAKE_COMMAND} -G ${GENERATOR} -S ${HEADERS_DIR} -B ${WORK_DIR}/headers
  -D CMAKE_CXX_COMPILER=${CXX_COMPILER} -D CMAKE_PREFIX_PATH=${prefix} -D HEADERS_BELOW=${prefix}/include)
run(${CMAKE_COMMAND} --build ${WORK_DIR}/headers)
