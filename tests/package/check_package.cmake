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

# The tool starts from where it stands now, and knows the library beside it.
set(ENV{LD_LIBRARY_PATH} "")
run(${prefix}/${BIN_DIR}/lamap --version)
run(ldd ${prefix}/${BIN_DIR}/lamap)
if(NOT output MATCHES "libmrpt-lamap[^\n]* => ${prefix}/")
  message(FATAL_ERROR "The installed lamap does not load the library installed beside it:\n${output}")
endif()

# MRPT never unregisters a class, so the library must never be unloaded.
run(${READELF} --dynamic --wide ${prefix}/${LIB_DIR}/libmrpt-lamap.so)
if(NOT output MATCHES "NODELETE")
  message(FATAL_ERROR "libmrpt-lamap.so is not linked with -z nodelete:\n${output}")
endif()

file(GLOB ini_files RELATIVE ${prefix}/${DATA_DIR}/mrpt-lamap ${prefix}/${DATA_DIR}/mrpt-lamap/ini/*/*.ini)
if(NOT ini_files)
  message(FATAL_ERROR "No .ini file was installed to ${prefix}/${DATA_DIR}/mrpt-lamap")
endif()

# Another project: every installed header in one program, which makes a map, fills it, saves it and reads it back.
file(GLOB_RECURSE headers RELATIVE ${prefix}/include
  ${prefix}/include/lamap_core/*.h ${prefix}/include/lamap_mrpt/*.h)
set(all_headers "")
foreach(header ${headers})
  string(APPEND all_headers "#include <${header}>\n")
endforeach()
file(WRITE ${WORK_DIR}/generated/all_installed_headers.h "${all_headers}")

run(${CMAKE_COMMAND} -G ${GENERATOR} -S ${CONSUMER_DIR} -B ${WORK_DIR}/build
  -D CMAKE_CXX_COMPILER=${CXX_COMPILER} -D CMAKE_BUILD_TYPE=${BUILD_TYPE}
  -D CMAKE_PREFIX_PATH=${prefix} -D GENERATED_DIR=${WORK_DIR}/generated)
run(${CMAKE_COMMAND} --build ${WORK_DIR}/build)
run(${WORK_DIR}/build/consumer ${WORK_DIR}/consumer.lamap.gz)
message(STATUS "${output}")
run(${prefix}/${BIN_DIR}/lamap info ${WORK_DIR}/consumer.lamap.gz)
