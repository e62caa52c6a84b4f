# Makes the pages of the library's interface: cmake --build --preset release --target api-pages.
#
# Given: doxygen (looked for where it is not known), source, version; generated, where headers that are made lie; out, the folder to fill.
# `also`: one more file to make pages of; the test of the warnings has one.
# Headers are laid out as they are installed (install_headers.cmake), so that the pages' include lines are
# those of a program.
find_program(doxygen doxygen)
if(NOT doxygen)
  message(FATAL_ERROR "the pages need doxygen: deploy/setup --for tests installs it")
endif()
file(REMOVE_RECURSE ${out})
file(MAKE_DIRECTORY ${out})
set(folders ${source} ${generated})
set(include headers)
set(CMAKE_INSTALL_PREFIX ${out})
set(ENV{DESTDIR} "")
include(${source}/server/library/install_headers.cmake)
file(COPY ${source}/server/library/palpate.h DESTINATION ${out}/headers)

# Pages are named for their labels, not for the folder that they were made in.
file(READ ${source}/server/ARCHITECTURE.md text)
string(REGEX REPLACE "^# ([^\n]+)" "# \\1 {#architecture}" text "${text}")
file(WRITE ${out}/architecture.md "${text}")
foreach(page main_page examples_page python_page)
  configure_file(${source}/server/library/pages/${page}.md ${out}/${page}.md COPYONLY)
endforeach()

# pages(html title of_python input...): below ${out}/${html}.
function(pages html title of_python)
  list(TRANSFORM ARGN REPLACE "(.+)" "\"\\1\"")
  list(JOIN ARGN " " input)
  configure_file(${source}/server/library/pages/Doxyfile.in ${out}/Doxyfile @ONLY)
  execute_process(COMMAND ${doxygen} ${out}/Doxyfile RESULT_VARIABLE result)
  if(result)
    message(FATAL_ERROR "the pages have warnings (above): mend the comments that they name")
  endif()
  if(NOT EXISTS ${out}/${html}/index.html)
    message(FATAL_ERROR "${doxygen} wrote no ${out}/${html}/index.html")
  endif()
endfunction()

pages(html "Palpate" NO ${out}/main_page.md ${out}/examples_page.md ${out}/architecture.md
      ${out}/headers ${also})
# Python's names are C++'s, so its pages are apart.  A module is named for its file: palpate itself is
# __init__.pyi.
file(GLOB stubs ${source}/client/python/palpate/*.pyi)
foreach(stub IN LISTS stubs)
  get_filename_component(name ${stub} NAME)
  string(REPLACE "__init__" "palpate" name ${name})
  configure_file(${stub} ${out}/python/${name} COPYONLY)
endforeach()
pages(html/python "Palpate for Python" YES ${out}/python_page.md ${out}/python)
message(STATUS "The pages: ${out}/html/index.html")
