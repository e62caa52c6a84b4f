# Makes the reference pages of the library: cmake --build --preset release --target api-pages.
#
# Given: doxygen (searched if not given), source, version; generated, the folder of generated headers; out, the folder to fill.
# `also`: one more file to make pages from, which the test of the warnings uses.
# Headers are arranged as installed (install_headers.cmake), so that the pages show the include lines of a
# program.
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

# The map, the pages of the physics, and the decisions: each file, and the label of its page.  Links between these
# become links between pages; links to other files become plain text.
set(documents
    server/ARCHITECTURE.md architecture
    server/physics/README.md physics_step
    server/physics/surface/README.md physics_surface
    server/physics/contact/README.md physics_contact
    server/physics/solve/README.md physics_solve
    server/physics/solve/friction.md physics_friction
    server/physics/tree/README.md physics_tree
    server/physics/cut/README.md physics_cut
    server/physics/energy/README.md physics_energy
    server/DECISIONS.md decisions)
function(make_page file label)
  file(READ ${source}/${file} text)
  string(REGEX REPLACE "^# ([^\n]+)" "# \\1 {#${label}}" text "${text}")
  get_filename_component(folder ${source}/${file} DIRECTORY)
  string(REGEX MATCHALL "\\[[^][]+\\]\\([^()]+\\)" links "${text}")
  foreach(link IN LISTS links)
    string(REGEX REPLACE "^\\[(.*)\\]\\(([^#]*).*\\)$" "\\1" words "${link}")
    string(REGEX REPLACE "^\\[(.*)\\]\\(([^#]*).*\\)$" "\\2" target "${link}")
    set(to "${words}")
    if(target)
      get_filename_component(target ${target} ABSOLUTE BASE_DIR ${folder})
      file(RELATIVE_PATH target ${source} ${target})
      list(FIND documents ${target} at)
      if(NOT at EQUAL -1)
        math(EXPR at "${at} + 1")
        list(GET documents ${at} to)
        string(REPLACE "\n" " " words "${words}")
        string(REGEX REPLACE " +" " " words "${words}")
        set(to "\\ref ${to} \"${words}\"")
      endif()
    endif()
    string(REPLACE "${link}" "${to}" text "${text}")
  endforeach()
  file(WRITE ${out}/${label}.md "${text}")
endfunction()
# Names pages after their labels, not after the folder in which they were made.
set(pages "")
list(LENGTH documents count)
math(EXPR last "${count} - 1")
foreach(i RANGE 0 ${last} 2)
  math(EXPR j "${i} + 1")
  list(GET documents ${i} file)
  list(GET documents ${j} label)
  make_page(${file} ${label})
  list(APPEND pages ${out}/${label}.md)
endforeach()
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

pages(html "Palpate" NO ${out}/main_page.md ${out}/examples_page.md ${pages} ${out}/headers
      ${also})
# Python has the same names as C++, so its pages are separate.  A module is named after its file: palpate
# itself is __init__.pyi.
file(GLOB stubs ${source}/client/python/palpate/*.pyi)
foreach(stub IN LISTS stubs)
  get_filename_component(name ${stub} NAME)
  string(REPLACE "__init__" "palpate" name ${name})
  configure_file(${stub} ${out}/python/${name} COPYONLY)
endforeach()
pages(html/python "Palpate for Python" YES ${out}/python_page.md ${out}/python)
message(STATUS "The pages: ${out}/html/index.html")
