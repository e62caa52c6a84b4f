#pragma once

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <string>
#include <system_error>

namespace palpate {

/// What the reading of a mesh file may take.
struct ImportLimits {
  std::size_t bytes;    ///< of address space
  std::size_t cpu_s;    ///< of processor time [s]
  std::size_t clock_s;  ///< until it must have ended, on a machine that is busy otherwise [s]
};

/// A gigabyte and ten seconds, and more in proportion for large files.  Of 2 million triangles, a
/// binary STL took 3.4 bytes for each of its own and an OBJ 2.7, and neither took two seconds
/// (tests/benchmarks/results/mesh-import.md); by assimp, which reads 3DS, the OBJ took 9.1: twice
/// that memory, and room for a slow machine.
inline ImportLimits ImportLimitsFor(const std::string& file) {
  std::error_code error;
  const auto size = std::filesystem::file_size(file, error);
  std::size_t bytes = error ? 0 : static_cast<std::size_t>(size);
  // DEFLATE packs a thousand times at most; meshes, some five times.
  if (file.ends_with(".gz")) bytes *= 8;
  constexpr std::size_t kGigabyte = std::size_t{1} << 30;
  const std::size_t cpu_s = 10 + bytes / 10'000'000;
  return {std::max(kGigabyte, kGigabyte / 4 + 20 * bytes), cpu_s, 3 * cpu_s};
}

inline constexpr const char* kNoMemoryToImport =
    "needs more memory than a mesh of its size does; it is damaged, export it again, or simplify "
    "it";

}  // namespace palpate
