#include "scenes/importer/mesh_reader.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>
#include <vector>

#include <Eigen/Geometry>
#include <spdlog/fmt/fmt.h>
#include <unistd.h>
#include <zlib.h>

#include "common/error.h"
#include "common/files/whole_file.h"
#include "scenes/importer/readers.h"
#include "scenes/mesh/mesh_format.h"

namespace palpate {
namespace {

[[noreturn]] void RefuseLarge(const std::string& file) {
  throw Error(file + ": holds more than 2 GiB; simplify the mesh first");
}

std::string Unpack(const std::string& file) {
  const int fd = OpenRegularFile(file, kLargestMeshFile);
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> gz(gzdopen(fd, "rb"), gzclose);
  if (!gz) {
    close(fd);
    throw Error(file + ": cannot be unpacked; there is no memory left");
  }
  std::string text;
  std::array<char, 1 << 16> block;
  for (;;) {
    const int got = gzread(gz.get(), block.data(), block.size());
    int status = Z_OK;
    const char* why = gzerror(gz.get(), &status);
    if (got < 0 || (got == 0 && status != Z_OK && status != Z_STREAM_END)) {
      throw Error(file + ": is damaged (" + why + "); fetch it again");
    }
    if (got == 0) return text;
    text.append(block.data(), got);
    if (text.size() > kLargestMeshFile) RefuseLarge(file);
  }
}

/// Reads a file with the reader of its format.
FileContents ReadAsNamed(const std::string& file, std::string_view text) {
  static constexpr struct {
    const char* format;
    FileContents (*read)(const std::string& file, std::string_view text);
  } kReaders[] = {{"obj", ReadObj},   {"stl", ReadStl},  {"ply", ReadPly},
                  {"gltf", ReadGltf}, {"glb", ReadGltf}, {"3ds", Read3ds}};
  const std::string format = KnownMeshFormatOf(file);
  try {
    return std::ranges::find(kReaders, format,
                             [](const auto& r) { return std::string_view(r.format); })
        ->read(file, text);
  } catch (const Error& error) {
    const std::string why = error.what();
    throw Error(why.starts_with(file) ? why : file + ": " + why);
  }
}

/// How far a mesh is from its origin, and how large it is.
struct Place {
  double farthest = 0.0, longest = 0.0;
};

Place PlaceOf(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Vec3& v : mesh.vertices) {
    if (v.allFinite()) box.extend(v);
  }
  if (box.isEmpty()) return {};
  return {std::max(box.min().cwiseAbs().maxCoeff(), box.max().cwiseAbs().maxCoeff()),
          box.sizes().maxCoeff()};
}

/// Returns whether neighbouring numbers are further apart than a hand feels, so triangles collapse.
bool IsTooCoarse(double step, const Place& place) {
  constexpr double kCoarsest = 1e-4;  // of the longest side: 5 um of 50 mm
  return step > kCoarsest * place.longest;
}

/// Not inlined: where GCC 12 rounds two numbers at once (-O3), it drops both conversions.
[[gnu::noinline]] double InSingle(double x) {
  return static_cast<float>(x);
}

/// Rounds each coordinate to single precision relative to a point near the mesh.  Corners that a
/// program computed separately in double differ in digits that nobody feels, and become equal.
void Round(const Place& place, TriangleMesh& mesh) {
  Vec3 by = Vec3::Zero();
  if (IsTooCoarse(kSingleStep * place.farthest, place)) {
    for (int axis = 0; axis < 3; ++axis) by[axis] = std::trunc(mesh.vertices.front()[axis]);
  }
  if (!by.allFinite()) return;
  for (Vec3& v : mesh.vertices) {
    for (int axis = 0; axis < 3; ++axis) v[axis] = InSingle(v[axis] - by[axis]) + by[axis];
  }
}

/// Returns the bits of a place, also for NaN, and the same for 0 and -0.
std::array<std::uint64_t, 3> BitsOf(const Vec3& place) {
  std::array<std::uint64_t, 3> bits;
  const Vec3 positive_zero = place + Vec3::Zero();
  std::memcpy(bits.data(), positive_zero.data(), sizeof bits);
  return bits;
}

/// Merges vertices at the same place; keeps the order of first use.
void Weld(TriangleMesh& mesh) {
  constexpr std::uint32_t kFree = 0xffffffffu;
  // An open hash table of the vertices that are kept, at most half full (Knuth's multiplicative
  // hash, The Art of Computer Programming 3, 6.4).
  const int bits_of_slot = std::bit_width(2 * mesh.vertices.size() + 1);
  const std::size_t last = (std::size_t{1} << bits_of_slot) - 1;
  std::vector<std::uint32_t> slots(last + 1, kFree);
  std::vector<std::uint32_t> renamed(mesh.vertices.size());
  std::uint32_t kept = 0;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    const auto bits = BitsOf(mesh.vertices[v]);
    std::uint64_t hash = 0;
    for (const std::uint64_t part : bits) {
      hash = (hash ^ part) * 0x9e3779b97f4a7c15u;
      hash ^= hash >> 32;
    }
    std::size_t slot = hash * 0x9e3779b97f4a7c15u >> (64 - bits_of_slot);
    while (slots[slot] != kFree && BitsOf(mesh.vertices[slots[slot]]) != bits) {
      slot = (slot + 1) & last;
    }
    if (slots[slot] == kFree) {
      slots[slot] = kept;
      mesh.vertices[kept++] = mesh.vertices[v];
    }
    renamed[v] = slots[slot];
  }
  mesh.vertices.resize(kept);
  for (auto& triangle : mesh.triangles) {
    for (std::uint32_t& v : triangle) v = renamed[v];
  }
}

}  // namespace

double FarthestOf(const TriangleMesh& mesh) {
  return PlaceOf(mesh).farthest;
}

ImportedMesh ReadMeshFile(const std::string& file) {
  return ReadMeshText(file,
                      IsPackedMesh(file) ? Unpack(file) : ReadWholeFile(file, kLargestMeshFile));
}

ImportedMesh ReadMeshText(const std::string& file, std::string_view text) {
  auto [read, step] = ReadAsNamed(file, text);
  const Place place = PlaceOf(read.mesh);
  if (IsTooCoarse(step, place)) {
    throw Error(fmt::format(
        "{}: is {:.3g} across and lies {:.3g} from its origin, where its numbers, of single "
        "precision, are {:.2g} apart; move the mesh to its origin in a mesh editor and export it "
        "again",
        file, place.longest, place.farthest, step));
  }
  if (!read.mesh.vertices.empty()) Round(place, read.mesh);
  Weld(read.mesh);
  return read;
}

}  // namespace palpate
