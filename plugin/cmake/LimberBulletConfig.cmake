# Reads Bullet's own CONFIG package, whose variables are paths relative to BULLET_ROOT_DIR (Bullet's installation) or
# absolute, and whose libraries are names, files or targets (vcpkg).

# Sets `libraries` to BulletDynamics, BulletCollision and LinearMath of the package, `includes` to its include folders.
function(limber_bullet_of_config libraries includes)
  set(files BulletConfig.cmake bullet-config.cmake)
  if(LIMBER_DOUBLE)
    list(PREPEND files BulletConfig-float64.cmake)  # Debian's name
  endif()
  find_package(Bullet CONFIG REQUIRED CONFIGS ${files})

  set(found "")
  foreach(name IN ITEMS BulletDynamics BulletCollision LinearMath)
    set(library "")
    foreach(entry IN LISTS BULLET_LIBRARIES)
      if(entry MATCHES "(^|/|::|lib)${name}([-_.][^/]*)?$")
        set(library ${entry})
      endif()
    endforeach()
    if(NOT library)
      message(FATAL_ERROR "${Bullet_CONFIG} names no ${name}")
    endif()
    if(NOT TARGET ${library} AND NOT IS_ABSOLUTE "${library}")
      list(TRANSFORM BULLET_LIBRARY_DIRS REPLACE "^([^/].*)" "${BULLET_ROOT_DIR}/\\1" OUTPUT_VARIABLE folders)
      find_library(LIMBER_${name}_LIBRARY ${library} PATHS ${folders} NO_DEFAULT_PATH NO_CACHE REQUIRED)
      set(library ${LIMBER_${name}_LIBRARY})
    endif()
    list(APPEND found ${library})
  endforeach()
  list(TRANSFORM BULLET_INCLUDE_DIRS REPLACE "^([^/].*)" "${BULLET_ROOT_DIR}/\\1" OUTPUT_VARIABLE folders)
  set(${libraries} "${found}" PARENT_SCOPE)
  set(${includes} "${folders}" PARENT_SCOPE)
endfunction()
