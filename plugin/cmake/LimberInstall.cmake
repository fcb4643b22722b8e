# Install rules, the package that find_package(limber CONFIG) finds, and .pc files. The analysis and the import are
# sets of their own, so that only those who ask for COMPONENTS import need assimp, and so is the renderer
# (render/CMakeLists.txt). Install components: runtime (shared libraries), dev, tools.
include(CMakePackageConfigHelpers)
set(limber_package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/limber)

function(limber_install_set set_name)
  install(TARGETS ${ARGN} EXPORT ${set_name}
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev
    LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT runtime NAMELINK_COMPONENT dev
    RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT runtime
    INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
  install(EXPORT ${set_name} NAMESPACE limber:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/limber COMPONENT dev)
endfunction()

# The path of `folder` as seen from `from`, both relative to the prefix or absolute.
function(limber_relative_path result from folder)
  cmake_path(ABSOLUTE_PATH from BASE_DIRECTORY ${CMAKE_INSTALL_PREFIX})
  cmake_path(ABSOLUTE_PATH folder BASE_DIRECTORY ${CMAKE_INSTALL_PREFIX})
  file(RELATIVE_PATH path ${from} ${folder})
  string(REGEX REPLACE "/$" "" path "${path}")
  set(${result} ${path} PARENT_SCOPE)
endfunction()

# limber_pkg_config(<name> <description> REQUIRES <packages...> LIBS <flags...>): installs <name>.pc, whose paths are
# relative to its own.
function(limber_pkg_config name description)
  cmake_parse_arguments(arg "" "" "REQUIRES;LIBS" ${ARGN})
  list(JOIN arg_REQUIRES ", " requires)
  list(JOIN arg_LIBS " " libs)
  set(cflags "")
  if(BUILD_SHARED_LIBS)
    set(cflags "-DLIMBER_SHARED")
  endif()
  set(pkgconfig_dir ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
  limber_relative_path(libdir ${pkgconfig_dir} ${CMAKE_INSTALL_LIBDIR})
  limber_relative_path(includedir ${pkgconfig_dir} ${CMAKE_INSTALL_INCLUDEDIR})
  configure_file(${PROJECT_SOURCE_DIR}/plugin/cmake/limber.pc.in ${CMAKE_CURRENT_BINARY_DIR}/${name}.pc @ONLY)
  install(FILES ${CMAKE_CURRENT_BINARY_DIR}/${name}.pc DESTINATION ${pkgconfig_dir} COMPONENT dev)
endfunction()

if(CMAKE_SYSTEM_NAME STREQUAL "Linux")
  set_target_properties(limber PROPERTIES INSTALL_RPATH "$ORIGIN")
  if(LIMBER_IMPORT)
    set_target_properties(limber_import PROPERTIES INSTALL_RPATH "$ORIGIN")
  endif()
endif()
limber_install_set(limber-targets limber_core limber)
limber_install_set(limber-analysis-targets limber_analysis)
if(LIMBER_IMPORT)
  limber_install_set(limber-import-targets limber_import)
endif()
install(DIRECTORY include/limber DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT dev FILES_MATCHING PATTERN "*.h")
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE ${PROJECT_SOURCE_DIR}/CHANGELOG.md
  DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT dev)

set(bullet_package bullet)
if(LIMBER_DOUBLE)
  set(bullet_package bullet-float64)
endif()
if(BUILD_SHARED_LIBS)
  limber_pkg_config(limber "Soft bodies for Bullet Physics worlds" REQUIRES eigen3 ${bullet_package} LIBS -llimber)
  limber_pkg_config(limber-core "Limber's meshes and networks: another name for limber" REQUIRES limber)
  limber_pkg_config(limber-analysis "Limber's analysis of networks: another name for limber" REQUIRES limber)
  set(import_needs "")
else()
  limber_pkg_config(limber-core "Limber's meshes and networks, without Bullet" REQUIRES eigen3 LIBS -llimber_core)
  limber_pkg_config(limber-analysis "Limber's analysis of networks" REQUIRES limber-core LIBS -llimber_analysis)
  limber_pkg_config(limber "Soft bodies for Bullet Physics worlds" REQUIRES limber-core ${bullet_package}
    LIBS -llimber ${CMAKE_THREAD_LIBS_INIT})
  set(import_needs assimp)
endif()
if(LIMBER_IMPORT)
  limber_pkg_config(limber-import "Limber's import of mesh files" REQUIRES limber-core ${import_needs}
    LIBS -llimber_import)
endif()

configure_package_config_file(cmake/limber-config.cmake.in ${CMAKE_CURRENT_BINARY_DIR}/limber-config.cmake
  INSTALL_DESTINATION ${limber_package_dir})
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/limber-config-version.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES
  ${CMAKE_CURRENT_BINARY_DIR}/limber-config.cmake
  ${CMAKE_CURRENT_BINARY_DIR}/limber-config-version.cmake
  cmake/LimberBullet.cmake
  cmake/LimberBulletConfig.cmake
  cmake/LimberBulletPrecision.cmake
  DESTINATION ${limber_package_dir} COMPONENT dev)
