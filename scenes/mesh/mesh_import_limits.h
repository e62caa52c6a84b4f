#pragma once

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <string>
#include <system_error>

namespace palpate {

/// Limits on the process that reads a mesh file.
struct ImportLimits {
  std::size_t bytes;    ///< address space [bytes]
  std::size_t cpu_s;    ///< processor time [s]
  std::size_t clock_s;  ///< wall-clock time, for a machine that is busy otherwise [s]
};

/// Returns a gigabyte and ten seconds, and more in proportion for large files.  For 2 million
/// triangles, reading a binary STL took 3.4 bytes of memory per byte of the file, an OBJ 2.7, and
/// neither two seconds (tests/benchmarks/results/mesh-import.md).  By assimp, which reads 3DS, the
/// OBJ took 9.1: the limits allow twice that memory, and time for a slow machine.
inline ImportLimits ImportLimitsFor(const std::string& file) {
  std::error_code error;
  const auto size = std::filesystem::file_size(file, error);
  std::size_t bytes = error ? 0 : static_cast<std::size_t>(size);
  // DEFLATE compresses at most a thousand times; meshes compress some five times.
  if (file.ends_with(".gz")) bytes *= 8;
  constexpr std::size_t kGigabyte = std::size_t{1} << 30;
  const std::size_t cpu_s = 10 + bytes / 10'000'000;
  return {std::max(kGigabyte, kGigabyte / 4 + 20 * bytes), cpu_s, 3 * cpu_s};
}

inline constexpr const char* kNoMemoryToImport =
    "needs more memory than a mesh of its size does; it is damaged, export it again, or simplify "
    "it";

}  // namespace palpate
