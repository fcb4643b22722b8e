# Install rules and the package that find_package(limber CONFIG) finds. The analysis and the import are
# sets of their own, so that only those who ask for COMPONENTS import need assimp, and so is the renderer
# (render/CMakeLists.txt).
include(CMakePackageConfigHelpers)
set(limber_package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/limber)

function(limber_install_set set_name)
  install(TARGETS ${ARGN} EXPORT ${set_name}
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
    LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
    RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR}
    INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
  install(EXPORT ${set_name} NAMESPACE limber:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/limber)
endfunction()

limber_install_set(limber-targets limber_core limber)
limber_install_set(limber-analysis-targets limber_analysis)
if(LIMBER_IMPORT)
  limber_install_set(limber-import-targets limber_import)
endif()
install(DIRECTORY include/limber DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.h")

configure_package_config_file(cmake/limber-config.cmake.in ${CMAKE_CURRENT_BINARY_DIR}/limber-config.cmake
  INSTALL_DESTINATION ${limber_package_dir})
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/limber-config-version.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES
  ${CMAKE_CURRENT_BINARY_DIR}/limber-config.cmake
  ${CMAKE_CURRENT_BINARY_DIR}/limber-config-version.cmake
  cmake/LimberBullet.cmake
  cmake/LimberBulletPrecision.cmake
  DESTINATION ${limber_package_dir})
