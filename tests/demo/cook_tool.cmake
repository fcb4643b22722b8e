# Tests of the tool limber-cook: its parts, its results, and every kind of invalid call.
set(cooked ${CMAKE_CURRENT_BINARY_DIR}/cooked)
file(MAKE_DIRECTORY ${cooked})
set(meshes ${PROJECT_SOURCE_DIR}/meshes)

# cook_run(<name> <label> <exit code> <text that must be printed> <arguments...>): without a text, nothing must be
# printed
function(cook_run name label code text)
  set(empty OFF)
  if(text STREQUAL "")
    set(empty ON)
  endif()
  add_test(NAME cook.${name} COMMAND ${CMAKE_COMMAND} -DCODE=${code} "-DTEXT=${text}" -DEMPTY=${empty}
    -P ${CMAKE_CURRENT_SOURCE_DIR}/expect_exit.cmake -- $<TARGET_FILE:limber-cook> ${ARGN})
  # suppresses leaks inside OSMesa
  set_tests_properties(cook.${name} PROPERTIES LABELS ${label} TIMEOUT 600
    ENVIRONMENT_MODIFICATION "LSAN_OPTIONS=set:suppressions=${PROJECT_SOURCE_DIR}/tests/lsan.supp")
endfunction()

# a body, and the demo with this body
cook_run(automatic scene 0 "filled with" ${meshes}/cube.obj -o ${cooked}/filled.limber --runs 0)
cook_run(pipeline scene 0 "12 triangles" ${meshes}/cube.obj -o ${cooked}/cube.limber --braces pipeline --runs 2
  --json ${cooked}/cube.json)
demo_run(cooked_body scene 0 "end check   passed" --mode none --mesh ${cooked}/cube.limber --count 2)
set_tests_properties(demo.cooked_body PROPERTIES DEPENDS cook.pipeline)

# the precision of Bullet has no effect on cooking
if(LIMBER_DOUBLE)
  return()
endif()

add_executable(limber_cook_tool_tests cook_parts_test.cpp cook_body_test.cpp ../import/temporary_folder.cpp)
target_include_directories(limber_cook_tool_tests PRIVATE ..)
target_link_libraries(limber_cook_tool_tests PRIVATE limber_cook_tool GTest::gtest_main)
target_compile_definitions(limber_cook_tool_tests PRIVATE LIMBER_MESH_DIR="${PROJECT_SOURCE_DIR}/meshes")
limber_gtest(limber_cook_tool_tests unit LONG CookBody.theFileHolds*)

# a body with each other rule, its report and picture
cook_run(equal_length scene 0 "6 brace" ${meshes}/cube.obj -o ${cooked}/equal.limber --braces equal-length --runs 0)
cook_run(two_ring scene 0 "10 brace" ${meshes}/cube.obj -o ${cooked}/two_ring.limber --braces two-ring --runs 0)
cook_run(bare scene 0 "18 structural" ${meshes}/cube.obj -o ${cooked}/bare.limber --braces none --runs 0)
cook_run(simplified scene 0 "a skin of" ${meshes}/icosphere.obj -o ${cooked}/coarse.limber --points 20
  --braces two-ring --skin sparse --neighbours 8 --masses area --runs 0)
cook_run(material scene 0 "tetrahedra" ${meshes}/cube.obj -o ${cooked}/material.limber --material --points 40 --runs 0)
cook_run(picture gl 0 "body" ${meshes}/l_shape.obj -o ${cooked}/l_shape.limber --braces two-ring --runs 0
  --picture ${cooked}/l_shape.png --size 160x120)
cook_run(report gl 0 "18 structural" --report ${cooked}/bare.limber --runs 1 --json ${cooked}/bare.json
  --picture ${cooked}/bare.png --size 160x120)
cook_run(extreme_report scene 0 "not known whether it carries its own weight"
  --report ${PROJECT_SOURCE_DIR}/tests/cook/golden/version-1.limber)
set_tests_properties(cook.extreme_report PROPERTIES TIMEOUT 60)
cook_run(quiet unit 0 "" ${meshes}/cube.obj -o ${cooked}/quiet.limber --braces none --quiet)
set_tests_properties(cook.report PROPERTIES DEPENDS cook.bare)

# invalid calls, which must be refused with the reason
cook_run(nothing unit 2 "a MESH to cook is missing")
cook_run(no_output unit 2 "-o BODY.limber is missing" ${meshes}/cube.obj)
cook_run(other_ending unit 2 "cube.obj does not end in .limber" ${meshes}/cube.obj -o cube.obj)
cook_run(unknown_rule unit 2 "--braces: glue not in" ${meshes}/cube.obj -o a.limber --braces glue)
cook_run(no_weight unit 2 "0 is not between" ${meshes}/cube.obj -o a.limber --brace-weight 0)
cook_run(nan_weld unit 2 "nan is not a finite number" ${meshes}/cube.obj -o a.limber --weld nan)
cook_run(length_and_braces unit 2 "--length has no meaning with --braces" ${meshes}/cube.obj -o a.limber --braces none
  --length 2)
cook_run(few_points unit 2 "7 is not between 8" ${meshes}/cube.obj -o a.limber --points 7)
cook_run(report_and_mesh unit 2 "MESH has no meaning with --report" ${meshes}/cube.obj --report a.limber)
cook_run(cooked_and_points unit 2 "--points has no meaning for a .limber file" a.limber -o b.limber --points 50)
cook_run(report_and_rule unit 2 "--braces has no meaning with --report" --report a.limber --braces none)
cook_run(cap_without_pipeline unit 2 "--max-braces has no meaning with --braces none" ${meshes}/cube.obj -o a.limber
  --braces none --max-braces 1)
cook_run(material_and_braces unit 2 "--braces has no meaning with --material" ${meshes}/cube.obj -o a.limber
  --material --braces none)
cook_run(spacing_alone unit 2 "--spacing needs --material" ${meshes}/cube.obj -o a.limber --spacing 1)
cook_run(spacing_and_points unit 2 "--spacing and --points say the same" ${meshes}/cube.obj -o a.limber --material
  --spacing 1 --points 40)
cook_run(skin_alone unit 2 "--skin needs --points" ${meshes}/cube.obj -o a.limber --braces none --skin dense)
cook_run(neighbours_alone unit 2 "--neighbours needs --skin sparse" ${meshes}/cube.obj -o a.limber --points 8
  --neighbours 8)
cook_run(size_alone unit 2 "--size needs --picture" ${meshes}/cube.obj -o a.limber --size 100x100)
cook_run(missing_mesh unit 1 "no_such.obj" no_such.obj -o ${cooked}/a.limber)
cook_run(missing_body unit 1 "cannot read no_such.limber" --report no_such.limber)
file(WRITE ${CMAKE_CURRENT_BINARY_DIR}/foreign.limber "v 0 0 0, a text that is long enough to be a head\n")
cook_run(foreign_body unit 1 "foreign.limber: not a .limber file: it does not begin with the bytes of one" --report
  ${CMAKE_CURRENT_BINARY_DIR}/foreign.limber)
cook_run(json_to_a_pipe unit 0 "\"points\": 8" ${meshes}/cube.obj -o ${cooked}/piped.limber --runs 0 --quiet
  --json /dev/stdout)
cook_run(unwritable_body unit 1 "cannot write /dev/null/a.limber" ${meshes}/cube.obj -o /dev/null/a.limber)
cook_run(unwritable_json unit 1 "cannot write /dev/null/a.json" ${meshes}/cube.obj -o ${cooked}/a.limber
  --json /dev/null/a.json)
cook_run(unwritable_picture unit 1 "cannot write /dev/null/a.png" ${meshes}/cube.obj -o ${cooked}/a.limber
  --picture /dev/null/a.png)

# All models of assimp's own tests are cooked or refused with a reason; none may crash, hang or exceed the
# memory limit.
# Not with sanitizers, which need more address space than the limit and ten times as long.
find_package(Python3 COMPONENTS Interpreter)
if(Python3_FOUND AND LIMBER_LONG_TESTS AND NOT LIMBER_SANITIZE)
  add_test(NAME cook.assimp_models COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_SOURCE_DIR}/cook_models.py
    $<TARGET_FILE:limber-cook>)
  set_tests_properties(cook.assimp_models PROPERTIES LABELS scene TIMEOUT 600 PROCESSORS 2 SKIP_RETURN_CODE 77)
endif()
