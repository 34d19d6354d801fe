# The one place that sets the language level, warnings, sanitizers and floating-point rules of our own targets.

function(lamap_configure_target target)
  target_compile_features(${target} PUBLIC cxx_std_17)
  set_target_properties(${target} PROPERTIES CXX_EXTENSIONS OFF POSITION_INDEPENDENT_CODE ON)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wshadow -Wconversion -Wno-sign-conversion)
  # The same input gives the same map, byte for byte, on every processor: no fused multiply-add, which only some
  # processors have.
  target_compile_options(${target} PRIVATE -ffp-contract=off)
  if(LAMAP_WARNINGS_AS_ERRORS)
    target_compile_options(${target} PRIVATE -Werror)
  endif()
  if(LAMAP_SANITIZE)
    # In instrumented code, GCC's warnings of uninitialized variables are false; other builds keep the warning.
    target_compile_options(${target} PRIVATE -fsanitize=${LAMAP_SANITIZE} -fno-omit-frame-pointer
      $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
    if(CMAKE_CXX_COMPILER_ID STREQUAL "Clang" AND NOT LAMAP_SANITIZE MATCHES "thread")
      target_compile_options(${target} PRIVATE
        -fsanitize-ignorelist=${PROJECT_SOURCE_DIR}/.ci/sanitizer-ignorelist.txt)
    endif()
    target_link_options(${target} PUBLIC -fsanitize=${LAMAP_SANITIZE})
    if(LAMAP_SANITIZE MATCHES "thread")
      # Calls to TBB go to a substitute that the sanitizer can follow, see tests/tsan/README.md.
      target_include_directories(${target} BEFORE PRIVATE ${PROJECT_SOURCE_DIR}/tests/tsan)
    endif()
  endif()
  if(LAMAP_FUZZ)
    target_compile_options(${target} PRIVATE -fsanitize=fuzzer-no-link -fno-sanitize-recover=all)
  endif()
endfunction()

# lamap_unite_rooms(target): compiles the sources of each room (a folder of the target) as one translation unit. They
# include the same large headers, which take most of the time. LAMAP_UNITY_BUILD=OFF compiles each separately.
function(lamap_unite_rooms target)
  if(NOT LAMAP_UNITY_BUILD)
    return()
  endif()
  get_target_property(sources ${target} SOURCES)
  list(FILTER sources INCLUDE REGEX "\\.cpp$")
  foreach(source ${sources})
    get_filename_component(room ${source} DIRECTORY)
    string(MAKE_C_IDENTIFIER "${target}_${room}" group)
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${group})
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  # GCC's warning is for headers; here, sources are included.
  target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
endfunction()

# lamap_add_test(name SOURCES ... LIBRARIES ... [LABELS ...]): one GoogleTest program. Labels with special meaning:
#   threads   also built and run with ThreadSanitizer, as part of the target `threaded_tests`
#   stock     starts stock MRPT programs
function(lamap_add_test name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LIBRARIES;LABELS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  lamap_configure_target(${name})
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR}/tests)
  # Tests spend their time in the libraries, and compile a third faster like this. GCC's warnings of uninitialized
  # variables are false in the standard library then.
  target_compile_options(${name} PRIVATE
    $<$<CONFIG:Release,RelWithDebInfo>:-O1>
    $<$<AND:$<CXX_COMPILER_ID:GNU>,$<CONFIG:Release,RelWithDebInfo>>:-Wno-maybe-uninitialized>)
  if(LAMAP_SANITIZE)
    target_compile_definitions(${name} PRIVATE LAMAP_SANITIZED)
  endif()
  target_link_libraries(${name} PRIVATE ${ARG_LIBRARIES} GTest::gtest GTest::gtest_main)
  gtest_discover_tests(${name} DISCOVERY_TIMEOUT 60 PROPERTIES LABELS "${ARG_LABELS}")
  if("threads" IN_LIST ARG_LABELS)
    add_dependencies(threaded_tests ${name})
  endif()
endfunction()

# lamap_check_headers(target): adds to the target `check_headers` one translation unit for each public header of
# `target` that includes it twice and nothing else, with only the include paths that `target` gives its users.
function(lamap_check_headers target)
  get_target_property(source_dir ${target} SOURCE_DIR)
  file(GLOB_RECURSE headers CONFIGURE_DEPENDS RELATIVE ${LAMAP_INCLUDE_DIR} ${source_dir}/*.h)
  set(units)
  foreach(header ${headers})
    string(MAKE_C_IDENTIFIER ${header} unit)
    set(unit ${PROJECT_BINARY_DIR}/check_headers/${unit}.cpp)
    file(CONFIGURE OUTPUT ${unit} CONTENT "#include <${header}>\n#include <${header}>\n")
    list(APPEND units ${unit})
  endforeach()
  if(units)
    add_library(check_headers_of_${target} OBJECT EXCLUDE_FROM_ALL ${units})
    lamap_configure_target(check_headers_of_${target})
    target_compile_options(check_headers_of_${target} PRIVATE -O0)
    target_link_libraries(check_headers_of_${target} PRIVATE ${target})
    add_dependencies(check_headers check_headers_of_${target})
  endif()
endfunction()
