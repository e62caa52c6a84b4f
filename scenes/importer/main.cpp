// palpate-import: reads one mesh file for the program that started it, so that a damaged file
// crashes this process and not that one.

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <new>
#include <string>
#include <system_error>

#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include "common/error.h"
#include "common/program/command_line.h"
#include "common/program/log.h"
#include "scenes/importer/mesh_reader.h"
#include "scenes/mesh/mesh_import_limits.h"

namespace palpate {
namespace {

/// Sets a limit, but not above the one that its user has set already, which cannot be raised.
void Limit(__rlimit_resource what, std::size_t most) {
  rlimit limit{};
  bool done = getrlimit(what, &limit) == 0;
  limit.rlim_max = std::min<rlim_t>(limit.rlim_max, most);
  limit.rlim_cur = limit.rlim_max;
  done = done && setrlimit(what, &limit) == 0;
  if (!done) {
    throw Error("cannot limit itself (" + std::generic_category().message(errno) + ")");
  }
}

/// Sets all limits, before the file is read.
void LimitItself(const std::string& file) {
  // End with the parent, because nobody would take the mesh.
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  prctl(PR_SET_DUMPABLE, 0);  // no core dump, not by a handler either
  const ImportLimits limits = ImportLimitsFor(file);
  Limit(RLIMIT_CORE, 0);
  Limit(RLIMIT_CPU, limits.cpu_s);
  Limit(RLIMIT_FSIZE, limits.bytes);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  // The sanitizers reserve terabytes of address space that they never use.
  Limit(RLIMIT_AS, limits.bytes);
#endif
}

void Write(const std::string& bytes) {
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t wrote = write(STDOUT_FILENO, bytes.data() + done, bytes.size() - done);
    if (wrote < 0 && errno == EINTR) continue;
    if (wrote < 0)
      throw Error("cannot write the mesh (" + std::generic_category().message(errno) + ")");
    done += static_cast<std::size_t>(wrote);
  }
}

int Main(int argc, char** argv) {
  const CommandLine app(
      "Reads a mesh (OBJ, STL, PLY, 3DS, glTF) for the other programs, which start it.\n"
      "It limits its own time and memory, so that a damaged file cannot end the program\n"
      "that needs the mesh.  Run by hand, it tells whether a file can be read.",
      "palpate-import", "Example: palpate-import tooth.stl");
  std::string file;
  std::string log_level = "info";
  int domain = 0;
  app.Add("MESH", file, "mesh file, which may be compressed (.gz)").Required();
  AddCommonOptions(app, "accepted for consistency, but not used: this program does not communicate",
                   domain, log_level);
  if (!ParseCommandLine(app, argc, argv)) return 0;
  SetUpLog("palpate-import", log_level);
  LimitItself(file);
  try {
    const ImportedMesh read = ReadMeshFile(file);
    if (isatty(STDOUT_FILENO) != 0) {
      std::printf("%s: %zu triangles, %zu vertices, %zu named parts\n", file.c_str(),
                  read.mesh.triangles.size(), read.mesh.vertices.size(), read.groups.size());
    } else {
      Write(PackMesh(read));
    }
  } catch (const std::bad_alloc&) {
    throw Error(file + ": " + kNoMemoryToImport);
  }
  return 0;
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  return palpate::RunProgram("palpate-import", [&] { return palpate::Main(argc, argv); });
}
