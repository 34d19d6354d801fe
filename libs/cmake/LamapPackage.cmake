# Where `cmake --install` puts the files, and the CMake package `mrpt-lamap` with its target mrpt-lamap::lamap.
# The installed tree can be moved as a whole.

include(CMakePackageConfigHelpers)

set(LAMAP_INSTALL_CMAKEDIR ${CMAKE_INSTALL_LIBDIR}/cmake/mrpt-lamap)
set(LAMAP_INSTALL_SHAREDIR ${CMAKE_INSTALL_DATADIR}/mrpt-lamap)

# Below 1.0 every minor version may change the binary interface.
set_target_properties(lamap_mrpt PROPERTIES
  VERSION ${PROJECT_VERSION}
  SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})

install(TARGETS lamap_mrpt EXPORT mrpt-lamap-targets
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
  INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(TARGETS lamap RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(TARGETS lamap_commands LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/mrpt-lamap)
foreach(header ${LAMAP_PUBLIC_HEADERS})
  cmake_path(GET header PARENT_PATH room)
  install(FILES libs/${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/${room})
endforeach()
install(DIRECTORY share/ini share/examples DESTINATION ${LAMAP_INSTALL_SHAREDIR})
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})

install(EXPORT mrpt-lamap-targets NAMESPACE mrpt-lamap:: DESTINATION ${LAMAP_INSTALL_CMAKEDIR})
configure_package_config_file(libs/cmake/mrpt-lamap-config.cmake.in
  ${PROJECT_BINARY_DIR}/mrpt-lamap-config.cmake
  INSTALL_DESTINATION ${LAMAP_INSTALL_CMAKEDIR}
  PATH_VARS LAMAP_INSTALL_SHAREDIR)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/mrpt-lamap-config-version.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES
  ${PROJECT_BINARY_DIR}/mrpt-lamap-config.cmake
  ${PROJECT_BINARY_DIR}/mrpt-lamap-config-version.cmake
  DESTINATION ${LAMAP_INSTALL_CMAKEDIR})
