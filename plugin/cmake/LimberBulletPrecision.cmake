# Float headers with a double library crash at run time at best. Both kinds of Bullet have the same file names in
# other people's builds, so the kind is told by its targets' definitions or by linking.
include(CheckCXXSourceCompiles)

# Sets `result` to whether any of the targets among the libraries is compiled with BT_USE_DOUBLE_PRECISION.
function(limber_bullet_defines_double libraries result)
  set(${result} FALSE PARENT_SCOPE)
  foreach(library IN LISTS libraries)
    if(TARGET ${library})
      get_target_property(own ${library} COMPILE_DEFINITIONS)
      get_target_property(passed_on ${library} INTERFACE_COMPILE_DEFINITIONS)
      get_target_property(folder ${library} SOURCE_DIR)
      set(of_folder "")
      if(IS_DIRECTORY "${folder}")
        get_directory_property(of_folder DIRECTORY ${folder} COMPILE_DEFINITIONS)
      endif()
      if("${own};${passed_on};${of_folder}" MATCHES "BT_USE_DOUBLE_PRECISION")
        set(${result} TRUE PARENT_SCOPE)
      endif()
    endif()
  endforeach()
endfunction()

# Sets `result` to whether a program of the given precision links. Libraries that are yet to be built do not link
# in either, which accuses nobody.
function(limber_bullet_links precision libraries includes result)
  set(directive_float "#undef")
  set(directive_double "#define")
  set(CMAKE_REQUIRED_LIBRARIES ${libraries})
  set(CMAKE_REQUIRED_INCLUDES ${includes})
  set(CMAKE_REQUIRED_QUIET ON)
  unset(LIMBER_BULLET_LINKS CACHE)
  check_cxx_source_compiles("${directive_${precision}} BT_USE_DOUBLE_PRECISION
    #include <btBulletDynamicsCommon.h>
    int main(int, char** body) { reinterpret_cast<btRigidBody*>(body)->setDamping(0, 0); }" LIMBER_BULLET_LINKS)
  set(${result} ${LIMBER_BULLET_LINKS} PARENT_SCOPE)
  unset(LIMBER_BULLET_LINKS CACHE)
endfunction()

# Stops with a message when the Bullet that was found is plainly of the other precision.
function(limber_check_bullet_precision libraries includes)
  limber_bullet_defines_double("${libraries}" is_double)
  if(LIMBER_DOUBLE AND NOT is_double)
    limber_bullet_links(float "${libraries}" "${includes}" is_float)
    if(is_float)
      message(FATAL_ERROR "Limber is set to double precision (LIMBER_DOUBLE=ON), but this Bullet is built in "
        "single precision: ${libraries}")
    endif()
  elseif(NOT LIMBER_DOUBLE)
    if(NOT is_double)
      limber_bullet_links(double "${libraries}" "${includes}" is_double)
    endif()
    if(is_double)
      message(FATAL_ERROR "Limber is set to single precision (LIMBER_DOUBLE=OFF), but this Bullet is built in "
        "double precision: ${libraries}")
    endif()
  endif()
endfunction()
