# The window: wrong calls, and a user who plays with it in a virtual screen.
demo_run(record_without_window unit 2 "--record requires --window" --record a.rec)
demo_run(replay_without_window unit 2 "--replay needs --window, or --mode none" --replay a.rec)
demo_run(replay_with_scene unit 2 "--scene has no meaning with --replay" --replay a.rec --mode none --scene rope)
demo_run(window_with_out unit 2 "--out has no meaning with --window" --window --out a)
demo_run(unknown_setting unit 2 "there is no setting wobble" --window --set wobble=1)
demo_run(large_setting unit 2 "gravity is 99, must be from 0 to 30" --window --set gravity=99)
demo_run(split_without_window unit 2 "--split requires --window" --split)
demo_run(missing_replay unit 1 "cannot read no_such.rec" --mode none --replay no_such.rec)
if(NOT LIMBER_WINDOW)
  demo_run(no_window unit 1 "libglfw3-dev and libimgui-dev" --window)
  return()
endif()

demo_run_by(no_display unit 1 "cannot open a window" "${CMAKE_COMMAND};-E;env;--unset=DISPLAY" --window --count 1)
demo_run(unwritable_record unit 1 "cannot write /dev/null/a.rec" --window --count 1 --record /dev/null/a.rec)

find_package(Python3 COMPONENTS Interpreter)
if(Python3_FOUND AND NOT LIMBER_SANITIZE)
  add_test(NAME demo.window COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_SOURCE_DIR}/window_test.py
    $<TARGET_FILE:limber-demo> ${out}/window)
  set_tests_properties(demo.window PROPERTIES LABELS gl TIMEOUT 600 SKIP_RETURN_CODE 77
    ENVIRONMENT "MESA_SHADER_CACHE_DIR=${PROJECT_BINARY_DIR}/tests/shader_cache")
endif()
