# Writes what ctest has to know of one executable of tests: each suite of it is one entry, NAME/Suite,
# and one process, for the start of a process costs more than most tests.  Run after the executable is
# linked, with
#   -D executable=FILE -D name=NAME -D out=FILE -D launcher=COMMAND -D each=REGEX -D without=FILTER
#   -D "properties=NAME VALUE..."
# `each`: suites whose name matches have a process for each test, NAME/Suite.Test.  `without`: a filter of
# GoogleTest's, of tests that are left out.
execute_process(COMMAND ${executable} --gtest_list_tests OUTPUT_VARIABLE list
                COMMAND_ERROR_IS_FATAL ANY TIMEOUT 60)
if(without)
  set(without "-${without}")
endif()
string(REPLACE ";" "," list "${list}")  # in what a parameter is shown as
string(REPLACE "\n" ";" list "${list}")
set(content "")
function(entry test filter)
  string(APPEND content "add_test([=[${name}/${test}]=] ${launcher} \"${executable}\" [=[--gtest_filter=${filter}${without}]=])
set_tests_properties([=[${name}/${test}]=] PROPERTIES ${properties})\n")
  set(content "${content}" PARENT_SCOPE)
endfunction()
set(suite "")
foreach(line IN LISTS list)
  string(REGEX REPLACE " *#.*$" "" line "${line}")
  if(line MATCHES "^([^ ].*)\\.$")
    set(suite "${CMAKE_MATCH_1}")
    set(told no)
    continue()
  elseif(NOT line MATCHES "^  [^ ]" OR "${suite}${line}" MATCHES "DISABLED_")
    continue()
  endif()
  string(STRIP "${line}" test)
  if(each AND suite MATCHES "${each}")
    entry("${suite}.${test}" "${suite}.${test}")
  elseif(NOT told)
    entry("${suite}" "${suite}.*")
    set(told yes)
  endif()
endforeach()
file(WRITE ${out} "${content}")
