# Fails unless README contains EXAMPLE word for word, each line behind INDENT.
file(READ ${README} readme)
file(READ ${EXAMPLE} example)
string(REGEX REPLACE "\n(.)" "\n${INDENT}\\1" example "${INDENT}${example}")
string(FIND "${readme}" "${example}" place)
if(place EQUAL -1)
  message(FATAL_ERROR "${README} does not show ${EXAMPLE} as it is")
endif()
