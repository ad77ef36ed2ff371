# What `cmake --install` brings: header, libraries, and how CMake and pkg-config find them.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(rvdnav_targets rvdnav_core)
set_target_properties(rvdnav_core PROPERTIES EXPORT_NAME core)
if(RVDNAV_SHARED)
  list(APPEND rvdnav_targets rvdnav)
  set_target_properties(rvdnav PROPERTIES VERSION ${PROJECT_VERSION} SOVERSION ${rvdnav_abi})
endif()
install(TARGETS ${rvdnav_targets} EXPORT rvdnav)
install(FILES include/rvdnav/rvdnav.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/rvdnav)

set(rvdnav_cmake_dir ${CMAKE_INSTALL_LIBDIR}/cmake/rvdnav)
install(EXPORT rvdnav NAMESPACE rvdnav:: FILE rvdnavConfig.cmake DESTINATION ${rvdnav_cmake_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/rvdnavConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/rvdnavConfigVersion.cmake DESTINATION ${rvdnav_cmake_dir})

if(RVDNAV_SHARED)
  configure_file(cmake/rvdnav.pc.in rvdnav.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/rvdnav.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endif()
