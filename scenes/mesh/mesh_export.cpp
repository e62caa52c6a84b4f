#include "scenes/mesh/mesh_export.h"

#include <bit>
#include <filesystem>
#include <iterator>

#include <fmt/format.h>

#include "common/error.h"
#include "common/text/lower_case.h"
#include "scenes/mesh/mesh_report.h"

namespace palpate {
namespace {

static_assert(std::endian::native == std::endian::little, "both formats are little-endian");

template <class T>
void Put(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

template <class T>
void Put(std::string& bytes, const Vec3& v) {
  for (const double x : v) Put(bytes, static_cast<T>(x));
}

void PutColour(std::string& bytes, std::uint32_t colour) {
  for (const int shift : {16, 8, 0}) Put(bytes, static_cast<std::uint8_t>(colour >> shift));
}

std::string ToStl(const TriangleMesh& mesh, const MeshExportOptions& options) {
  std::string bytes = options.comment;
  bytes.resize(80, ' ');
  Put(bytes, static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3 &p = mesh.vertices[a], &q = mesh.vertices[b], &r = mesh.vertices[c];
    Put<float>(bytes, (q - p).cross(r - p).normalized());
    for (const Vec3& v : {p, q, r}) Put<float>(bytes, v / options.metres_per_unit);
    Put(bytes, std::uint16_t{0});
  }
  return bytes;
}

std::string ToPly(const TriangleMesh& mesh, const MeshExportOptions& options) {
  const bool coloured = !options.colours.empty();
  const char* const colour =
      coloured ? "property uchar red\nproperty uchar green\nproperty uchar blue\n" : "";
  std::vector<std::uint32_t> of_vertex(mesh.vertices.size());
  for (std::size_t t = 0; coloured && t < mesh.triangles.size(); ++t) {
    for (const std::uint32_t corner : mesh.triangles[t]) of_vertex[corner] = options.colours[t];
  }
  std::string bytes = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment {}\nelement vertex {}\n"
      "property double x\nproperty double y\nproperty double z\n{}element face {}\n"
      "property list uchar int vertex_indices\n{}end_header\n",
      options.comment, mesh.vertices.size(), colour, mesh.triangles.size(), colour);
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    Put<double>(bytes, mesh.vertices[v] / options.metres_per_unit);
    if (coloured) PutColour(bytes, of_vertex[v]);
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    Put(bytes, std::uint8_t{3});
    for (const std::uint32_t corner : mesh.triangles[t]) Put(bytes, corner);
    if (coloured) PutColour(bytes, options.colours[t]);
  }
  return bytes;
}

std::string ToObj(const TriangleMesh& mesh, const MeshExportOptions& options) {
  std::string text = "# " + options.comment + "\n";
  const auto out = std::back_inserter(text);
  for (const Vec3& v : mesh.vertices) {
    const Vec3 x = v / options.metres_per_unit;
    fmt::format_to(out, "v {} {} {}\n", x.x(), x.y(), x.z());  // as many digits as it needs
  }
  for (const auto& [a, b, c] : mesh.triangles) {
    fmt::format_to(out, "f {} {} {}\n", a + 1, b + 1, c + 1);
  }
  return text;
}

}  // namespace

std::string ExportMesh(const TriangleMesh& mesh, const std::string& file,
                       const MeshExportOptions& options) {
  const std::string ending = LowerCase(std::filesystem::path(file).extension().string());
  const auto write = ending == ".stl"   ? &ToStl
                     : ending == ".ply" ? &ToPly
                     : ending == ".obj" ? &ToObj
                                        : nullptr;
  if (write == nullptr) {
    throw Error(file + ": its ending is of no mesh that is written; give " +
                std::string(kExportedMeshes));
  }
  CheckNumbers(mesh);
  return write(mesh, options);
}

}  // namespace palpate
