# cmake -DDEMO=<limber-demo> -DOUT=<folder> -P same_files.cmake
# Runs the demo twice and fails unless both runs write the same files, byte by byte.
cmake_minimum_required(VERSION 3.22)
foreach(run IN ITEMS first second)
  file(REMOVE_RECURSE ${OUT}/${run})
  execute_process(COMMAND ${DEMO} --size 320x180 --seconds 0.5 --fps 20 --no-video --out ${OUT}/${run}
    RESULT_VARIABLE code OUTPUT_QUIET)
  if(NOT code EQUAL 3) # too short to come to rest
    message(FATAL_ERROR "exit code ${code}")
  endif()
  file(GLOB ${run} RELATIVE ${OUT}/${run} ${OUT}/${run}/*)
endforeach()

if(NOT "${first}" STREQUAL "${second}" OR NOT "preview.png" IN_LIST first OR NOT "contact-sheet.png" IN_LIST first)
  message(FATAL_ERROR "other files: ${first}; ${second}")
endif()
foreach(name IN LISTS first)
  execute_process(COMMAND ${CMAKE_COMMAND} -E compare_files ${OUT}/first/${name} ${OUT}/second/${name}
    RESULT_VARIABLE differ)
  if(differ)
    message(FATAL_ERROR "${name} differs between two runs")
  endif()
endforeach()
