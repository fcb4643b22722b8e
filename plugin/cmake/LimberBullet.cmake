# Defines the target limber::bullet: the Bullet that Limber is built against. Taken from, in this order:
#   1. LIMBER_BULLET_TARGET, a target named by the user
#   2. a target that the parent project already has (Conan, hand-written, Bullet's own source tree)
#   3. BULLET_INCLUDE_DIRS and BULLET_LIBRARIES, when the parent has set them
#   4. with LIMBER_USE_BULLET_CONFIG, Bullet's own CONFIG package, as of vcpkg or of Bullet's installation
#   5. CMake's FindBullet module (float), pkg-config bullet-float64 (double)
# The CONFIG package has to be asked for: on Debian its paths are relative, and it names a library that libbullet-dev
# does not ship. Variables that it left are told from good ones by the relative path.
if(TARGET limber::bullet)
  return()
endif()
set(LIMBER_BULLET_TARGET "" CACHE STRING "Target to use as Bullet; empty: look for one")
option(LIMBER_USE_BULLET_CONFIG "Use the CONFIG package that Bullet installs" OFF)

set(_limber_bullet_includes "")
if(LIMBER_BULLET_TARGET)
  set(_limber_bullet_libraries ${LIMBER_BULLET_TARGET})
elseif(TARGET Bullet::Bullet)
  set(_limber_bullet_libraries Bullet::Bullet)
elseif(TARGET Bullet::Dynamics)
  set(_limber_bullet_libraries Bullet::Dynamics)
elseif(TARGET BulletDynamics)
  set(_limber_bullet_libraries BulletDynamics BulletCollision LinearMath)
  if(BULLET_PHYSICS_SOURCE_DIR)
    set(_limber_bullet_includes ${BULLET_PHYSICS_SOURCE_DIR}/src)
  endif()
elseif(BULLET_LIBRARIES AND IS_ABSOLUTE "${BULLET_INCLUDE_DIRS}")
  set(_limber_bullet_libraries ${BULLET_LIBRARIES})
  set(_limber_bullet_includes ${BULLET_INCLUDE_DIRS})
elseif(LIMBER_USE_BULLET_CONFIG)
  include(${CMAKE_CURRENT_LIST_DIR}/LimberBulletConfig.cmake)
  limber_bullet_of_config(_limber_bullet_libraries _limber_bullet_includes)
elseif(LIMBER_DOUBLE)
  find_package(PkgConfig REQUIRED)
  pkg_check_modules(LIMBER_BULLET64 REQUIRED IMPORTED_TARGET GLOBAL bullet-float64)
  set(_limber_bullet_libraries PkgConfig::LIMBER_BULLET64)
else()
  if(NOT IS_ABSOLUTE "${BULLET_INCLUDE_DIR}")
    unset(BULLET_INCLUDE_DIR)  # left by the CONFIG package, and so are the libraries: the module would believe it
  endif()
  unset(BULLET_LIBRARIES)
  find_package(Bullet MODULE REQUIRED)
  set(_limber_bullet_libraries ${BULLET_LIBRARIES})
  set(_limber_bullet_includes ${BULLET_INCLUDE_DIRS})
endif()

# Imported, so that Bullet's headers are system headers to everyone: our warnings and yours stay silent there.
add_library(limber::bullet INTERFACE IMPORTED GLOBAL)
target_link_libraries(limber::bullet INTERFACE ${_limber_bullet_libraries})
target_include_directories(limber::bullet SYSTEM INTERFACE ${_limber_bullet_includes})
if(LIMBER_DOUBLE)
  target_compile_definitions(limber::bullet INTERFACE BT_USE_DOUBLE_PRECISION)
endif()

include(${CMAKE_CURRENT_LIST_DIR}/LimberBulletPrecision.cmake)
limber_check_bullet_precision("${_limber_bullet_libraries}" "${_limber_bullet_includes}")
