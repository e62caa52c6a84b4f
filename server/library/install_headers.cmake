# Run when the library is installed.  The headers keep the folders of the sources, below include/palpate, and
# their include lines are changed to match, so they cannot collide with a user's own common/error.h.  Only
# palpate/scenes.h, which includes palpate/physics.h, palpate/devices/wrench_limiter.h, and the headers that they
# include are installed.
#
# Given: folders, which are searched for headers; include, the prefix's folder of headers.
cmake_policy(PUSH)
cmake_policy(SET CMP0057 NEW)  # if(IN_LIST)
set(target "$ENV{DESTDIR}${CMAKE_INSTALL_PREFIX}/${include}/palpate")
set(todo server/library/scenes.h devices/wrench_limiter.h)
set(done "")
while(todo)
  list(POP_FRONT todo header)
  list(APPEND done ${header})
  foreach(folder IN LISTS folders)
    if(EXISTS "${folder}/${header}")
      file(READ "${folder}/${header}" text)
    endif()
  endforeach()
  string(REGEX MATCHALL "#include \"[^\"]+\"" lines "${text}")
  foreach(line IN LISTS lines)
    string(REGEX REPLACE "#include \"(.*)\"" "\\1" other "${line}")
    if(NOT other IN_LIST done AND NOT other IN_LIST todo)
      list(APPEND todo ${other})
    endif()
  endforeach()
  string(REPLACE "#include \"" "#include \"palpate/" text "${text}")
  string(REPLACE "palpate/server/library/physics.h" "palpate/physics.h" text "${text}")
  string(REGEX REPLACE "^server/library/(physics|scenes)\\.h$" "\\1.h" place ${header})
  file(WRITE "${target}/${place}" "${text}")
endwhile()
list(LENGTH done count)
message(STATUS "Installed: ${count} headers below ${target}")
cmake_policy(POP)
