# What only our own build wants: a default build type, warnings as errors, sanitizers.
if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Build type" FORCE)
endif()
set(CMAKE_CXX_STANDARD 17)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)

find_program(LIMBER_CCACHE ccache)
if(LIMBER_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${LIMBER_CCACHE})
endif()

add_compile_options(-Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wsign-conversion)
if(LIMBER_WERROR)
  add_compile_options(-Werror)
endif()
if(LIMBER_SANITIZE)
  # Without the checks of pointers, which take as long to compile as the rest: bad ones are the address sanitizer's,
  # but misaligned ones and wrong dynamic types then go unseen. Uses of variables after their block ended are looked for
  # with the long tests only: that takes a quarter of the time to compile.
  add_compile_options(-fsanitize=${LIMBER_SANITIZE} -fno-sanitize=null,object-size,pointer-overflow,alignment,vptr
    -fno-sanitize-recover=all -fno-omit-frame-pointer $<$<NOT:$<BOOL:${LIMBER_LONG_TESTS}>>:-fno-sanitize-address-use-after-scope>)
  add_link_options(-fsanitize=${LIMBER_SANITIZE})
endif()
