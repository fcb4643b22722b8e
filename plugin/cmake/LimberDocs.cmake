# The target limber_docs: pages of the public headers by Doxygen, in build/<preset>/docs/html. A warning is an error.
find_package(Doxygen QUIET)
if(NOT TARGET Doxygen::doxygen)
  return()
endif()
set(DOXYGEN_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/docs)
set(DOXYGEN_STRIP_FROM_INC_PATH plugin/include render/include render/view/include)
set(DOXYGEN_JAVADOC_AUTOBRIEF YES)
set(DOXYGEN_MACRO_EXPANSION YES)
set(DOXYGEN_EXPAND_ONLY_PREDEF YES)
set(DOXYGEN_PREDEFINED "LIMBER_API=" "LIMBER_BULLET_PRECISION=bullet_float")
set(DOXYGEN_HAVE_DOT NO)
set(DOXYGEN_QUIET YES)
set(DOXYGEN_WARN_IF_UNDOCUMENTED NO)  # members whose names say all
set(DOXYGEN_WARN_AS_ERROR FAIL_ON_WARNINGS)
# "#points", a number of points, is no link
set(DOXYGEN_INPUT_FILTER "sed -E 's/(.)#([a-z])/\\1\\\\#\\2/g'")
doxygen_add_docs(limber_docs plugin/include render/include render/view/include
  WORKING_DIRECTORY ${PROJECT_SOURCE_DIR} COMMENT "Pages of the public headers")
