#include "scenes/mesh/mesh_import.h"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>

#include <Eigen/Geometry>
#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>
extern "C" {
#include <sys/pidfd.h>  // glibc 2.36 declares it without C linkage
}

#include "common/error.h"
#include "common/files/project_files.h"
#include "common/files/whole_file.h"
#include "common/json/json_file.h"
#include "scenes/mesh/mesh_import_limits.h"
#include "scenes/mesh/mesh_references.h"
#include "scenes/mesh/mesh_report.h"
#include "scenes/mesh/triangle.h"
#include "scenes/mesh/units.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void FailToStart(const std::string& what, int error) {
  throw Error("palpate-import, which reads meshes, cannot be started (" + what + ": " +
              std::generic_category().message(error) +
              "); install palpate-common, or set PALPATE_PROGRAMS to its folder");
}

/// A file in memory that a child writes, and whose contents are read after it has ended; unlike
/// with a pipe, neither waits for the other.
class MemoryFile {
 public:
  explicit MemoryFile(const char* name) : descriptor_(memfd_create(name, MFD_CLOEXEC)) {
    if (descriptor_ < 0) FailToStart("memory", errno);
  }
  ~MemoryFile() {
    if (size_ > 0) munmap(text_, size_);
    close(descriptor_);
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  int descriptor() const { return descriptor_; }

  /// Returns what was written.  Call once, after the writer has ended.
  std::string_view Contents() {
    struct stat status {};
    if (fstat(descriptor_, &status) != 0 || status.st_size == 0) return {};
    const auto size = static_cast<std::size_t>(status.st_size);
    void* const text = mmap(nullptr, size, PROT_READ, MAP_PRIVATE, descriptor_, 0);
    if (text == MAP_FAILED) throw std::bad_alloc();
    text_ = text;
    size_ = size;
    return {static_cast<const char*>(text_), size_};
  }

 private:
  int descriptor_;
  void* text_ = nullptr;
  std::size_t size_ = 0;
};

/// A program that was started, and is waited for or killed.
class Child {
 public:
  /// Starts a program with default signals, no other descriptors, and no state that a thread of
  /// this process could have left half done, as posix_spawn provides.
  Child(const std::string& program, const std::string& file, int output, int errors) {
    posix_spawn_file_actions_t files;
    posix_spawnattr_t attributes;
    posix_spawn_file_actions_init(&files);
    posix_spawnattr_init(&attributes);
    posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&files, output, STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&files, errors, STDERR_FILENO);
    posix_spawn_file_actions_addclosefrom_np(&files, STDERR_FILENO + 1);
    sigset_t none, all;
    sigemptyset(&none);
    sigfillset(&all);
    posix_spawnattr_setsigmask(&attributes, &none);
    posix_spawnattr_setsigdefault(&attributes, &all);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
    std::string words[] = {program, "--log-level", "error", "--", file};
    char* arguments[] = {words[0].data(), words[1].data(), words[2].data(),
                         words[3].data(), words[4].data(), nullptr};
    const int error = posix_spawn(&pid_, program.c_str(), &files, &attributes, arguments, environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&files);
    if (error != 0) FailToStart(program, error);
  }

  /// Returns its wait status; kills it after `seconds`.
  int Wait(std::size_t seconds) {
    const int handle = pidfd_open(pid_, 0);
    pollfd ended{handle, POLLIN, 0};
    const bool in_time = handle >= 0 && poll(&ended, 1, static_cast<int>(1000 * seconds)) > 0;
    if (handle >= 0) close(handle);
    if (!in_time) kill(pid_, SIGKILL);
    int status = 0;
    while (waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
    }
    return status;
  }

 private:
  pid_t pid_ = -1;
};

/// Throws Error with the reason why there is no mesh.
[[noreturn]] void Refuse(const std::string& file, const std::string& program, int status,
                         std::string_view said, const ImportLimits& limits) {
  const std::string prefix = "palpate-import: ";
  if (WIFEXITED(status) && said.starts_with(prefix)) {
    said.remove_prefix(prefix.size());
    throw Error(std::string(said.substr(0, said.find_last_not_of('\n') + 1)));
  }
  if (WIFEXITED(status) && WEXITSTATUS(status) == 127 && !said.empty()) {  // from the loader
    throw Error("palpate-import, which reads meshes, cannot be started (" +
                std::string(said.substr(0, said.find('\n'))) + "); install what is missing");
  }
  if (WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    if (signal == SIGHUP || signal == SIGINT || signal == SIGQUIT || signal == SIGTERM) {
      throw Error(file + ": reading it was interrupted");
    }
    if (signal == SIGKILL || signal == SIGXCPU) {
      throw Error(file + ": was not read within " + std::to_string(limits.cpu_s) +
                  " s; it is damaged, export it again, or simplify it");
    }
    throw Error(file + ": is damaged: reading it crashes (" + strsignal(signal) +
                "); export it again, or in another format");
  }
  throw Error(file + ": was not read (palpate-import ended with " +
              std::to_string(WEXITSTATUS(status)) + "); export it again, or see the output of '" +
              program + " " + file + "' says");
}

}  // namespace

TriangleMesh ImportMesh(const std::string& file, std::vector<MeshGroup>* groups) {
  std::error_code ignored;
  if (!fs::exists(file, ignored)) throw Error(file + ": there is no such file; check the name");
  KnownMeshFormatOf(file);
  const ImportLimits limits = ImportLimitsFor(file);
  const std::string program = (fs::path(ProgramFolder()) / "palpate-import").string();
  MemoryFile mesh("mesh"), errors("errors");
  const int status =
      Child(program, file, mesh.descriptor(), errors.descriptor()).Wait(limits.clock_s);
  if (status != 0) Refuse(file, program, status, errors.Contents(), limits);
  ImportedMesh read;
  try {
    read = UnpackMesh(mesh.Contents());
  } catch (const Error& error) {
    throw Error(file + ": is damaged (" + error.what() + "); export it again");
  }
  if (groups != nullptr) groups->insert(groups->end(), read.groups.begin(), read.groups.end());
  return std::move(read.mesh);
}

std::vector<std::string> FilesOfMesh(const std::string& file) {
  std::vector<std::string> files{file};
  // A compressed mesh that refers to other files is rejected when it is read.
  const std::string format = MeshFormatOf(file);
  if (IsPackedMesh(file) || (format != "gltf" && format != "glb")) return files;
  for (const MeshReference& reference :
       FindMeshReferences(file, ReadWholeFile(file, kLargestMeshFile))) {
    files.push_back(reference.file);
  }
  return files;
}

void PlaceMesh(const MeshPlacement& placement, TriangleMesh& mesh) {
  const Eigen::AlignedBox3d box = BoxOf(mesh);
  double scale = placement.metres_per_unit;
  if (placement.longest_side) scale = *placement.longest_side / box.sizes().maxCoeff();
  Vec3 origin = Vec3::Zero();
  if (placement.origin == MeshPlacement::Origin::kBoxCentre) {
    origin = 0.5 * (box.min() + box.max());
  } else if (placement.origin == MeshPlacement::Origin::kCentroid) {
    origin = InspectMesh(mesh).centroid;
  }
  for (Vec3& v : mesh.vertices) v = scale * (v - origin);
}

std::string UnitRemark(const MeshPlacement& placement, const TriangleMesh& mesh) {
  if (placement.longest_side) return "";
  const double longest = BoxOf(mesh).sizes().maxCoeff();
  const double number = longest / placement.metres_per_unit;
  const auto likely = LikelierUnit(number, placement.metres_per_unit);
  if (!likely) return "";
  const auto taken = std::ranges::find(kUnits, placement.metres_per_unit, MetresPerUnit);
  const std::string said =
      fmt::format("in {} its longest side is {:.3g} mm",
                  taken == kUnits.end() ? std::string_view("its unit") : *taken, 1e3 * longest);
  if (likely->empty()) {
    return said +
           ", and no other unit gives it a size that a hand feels; say by \"longest_side_m\" how "
           "long it is to be";
  }
  return fmt::format(
      "{}; its file more likely means {}, which makes it {:.3g} mm: give \"unit\": \"{}\"", said,
      *likely, 1e3 * number * MetresPerUnit(*likely), *likely);
}

}  // namespace palpate
