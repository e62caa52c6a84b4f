# Hashes the sources that decide bits (revision.h).
#   cmake -D source=FOLDER [-D out=FILE.cpp] -P common/revision.cmake
# writes FILE.cpp, or prints both hashes; with -D list=physics or =scenes, the files.  Included by
# CMakeLists.txt, it only defines the function.

# palpate_hashed(list source kind): the files that are hashed as `physics` or as `scenes`.
function(palpate_hashed list source kind)
  set(physics server/physics server/session common/math common/qp scenes/effects scenes/grid)
  set(scenes scenes common/math)
  set(files "")
  foreach(ending h cpp inl)
    foreach(folder IN LISTS ${kind})
      file(GLOB_RECURSE found RELATIVE ${source} ${source}/${folder}/*.${ending})
      list(APPEND files ${found})
    endforeach()
    # What these folders include of others.
    file(GLOB found RELATIVE ${source} ${source}/common/*.${ending} ${source}/scenes/*.${ending})
    list(APPEND files ${found})
  endforeach()
  list(REMOVE_DUPLICATES files)
  list(SORT files)
  set(${list} ${files} PARENT_SCOPE)
endfunction()

if(NOT CMAKE_SCRIPT_MODE_FILE)
  return()
endif()
if(list)
  palpate_hashed(files ${source} ${list})
  list(JOIN files "\n" files)
  execute_process(COMMAND ${CMAKE_COMMAND} -E echo "${files}")
  return()
endif()
foreach(kind physics scenes)
  palpate_hashed(files ${source} ${kind})
  set(lines "")
  foreach(file IN LISTS files)
    file(SHA256 ${source}/${file} hash)
    string(APPEND lines "${file} ${hash}\n")
  endforeach()
  string(SHA256 hash "${lines}")
  string(SUBSTRING ${hash} 0 12 ${kind})
endforeach()
if(NOT out)
  execute_process(COMMAND ${CMAKE_COMMAND} -E echo "physics ${physics}\nscenes ${scenes}")
  return()
endif()
file(WRITE ${out} "#include \"common/revision.h\"

namespace palpate {

const char* const kPhysicsRevision = \"${physics}\";
const char* const kScenesRevision = \"${scenes}\";

}  // namespace palpate
")
