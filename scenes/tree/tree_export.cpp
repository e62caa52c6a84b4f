#include "scenes/tree/tree_export.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <string_view>
#include <type_traits>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "common/error.h"
#include "common/math/elementary.h"
#include "scenes/mesh/units.h"
#include "scenes/shapes/shapes.h"
#include "scenes/tree/sph_file.h"
#include "scenes/tree/tree_error.h"

namespace palpate {
namespace {

using Bytes = std::vector<std::uint8_t>;
using Colour = std::array<std::uint8_t, 3>;

static_assert(std::endian::native == std::endian::little, "both formats are little-endian");

constexpr std::size_t kManyBalls = 100000;  // for more, an icosahedron each: 40 MB for 100,000
constexpr std::size_t kColours = 16;        // of a .glb

template <class T>
void Put(Bytes& bytes, T value) {
  static_assert(std::is_arithmetic_v<T>);
  const auto* const begin = reinterpret_cast<const std::uint8_t*>(&value);
  bytes.insert(bytes.end(), begin, begin + sizeof value);
}

void Put(Bytes& bytes, std::string_view text) {
  bytes.insert(bytes.end(), text.begin(), text.end());
}

void Put(Bytes& bytes, const Vec3& v) {
  for (int k = 0; k < 3; ++k) Put(bytes, static_cast<float>(v[k]));
}

/// Returns light hues, a golden section of the circle apart, so that consecutive balls differ.
Colour ColourOf(std::size_t ball) {
  const double turn = std::fmod(0.61803398875 * static_cast<double>(ball), 1.0);
  Colour colour{};
  for (int k = 0; k < 3; ++k) {
    const double apart = std::abs(std::fmod(6.0 * turn + 6.0 - 2.0 * k, 6.0) - 3.0);
    colour[static_cast<std::size_t>(k)] =
        static_cast<std::uint8_t>(90.0 + 150.0 * std::clamp(apart - 1.0, 0.0, 1.0));
  }
  return colour;
}

void PadTo4(Bytes& bytes, std::uint8_t with) {
  while (bytes.size() % 4 != 0) bytes.push_back(with);
}

/// Returns the icosphere's vertices, which are also its normals, and its triangles.
Bytes GlbBuffer(const TriangleMesh& ball) {
  Bytes buffer;
  for (const Vec3& v : ball.vertices) Put(buffer, v);
  for (const auto& triangle : ball.triangles) {
    for (const std::uint32_t v : triangle) Put(buffer, static_cast<std::uint16_t>(v));
  }
  PadTo4(buffer, 0);
  return buffer;
}

std::string GlbJson(const std::vector<Sphere>& balls, const std::string& name,
                    const TriangleMesh& ball, std::size_t buffer_bytes) {
  Vec3 low = ball.vertices[0], high = low;
  for (const Vec3& v : ball.vertices) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  const std::size_t corners = 12 * ball.vertices.size();
  std::string json = fmt::format(
      R"({{"asset":{{"version":"2.0","generator":"palpate-scene export"}},"scene":0,)"
      R"("scenes":[{{"nodes":[0]}}],"buffers":[{{"byteLength":{}}}],"bufferViews":[)"
      R"({{"buffer":0,"byteOffset":0,"byteLength":{},"target":34962}},)"
      R"({{"buffer":0,"byteOffset":{},"byteLength":{},"target":34963}}],"accessors":[)"
      R"({{"bufferView":0,"componentType":5126,"count":{},"type":"VEC3","min":[{},{},{}],)"
      R"("max":[{},{},{}]}},{{"bufferView":1,"componentType":5123,"count":{},"type":"SCALAR"}}],)",
      buffer_bytes, corners, corners, 6 * ball.triangles.size(), ball.vertices.size(),
      float(low.x()), float(low.y()), float(low.z()), float(high.x()), float(high.y()),
      float(high.z()), 3 * ball.triangles.size());
  const auto out = std::back_inserter(json);
  // Names in a bundle may contain anything.
  const std::string quoted =
      nlohmann::json(name).dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
  const auto comma = [](std::size_t i) { return i == 0 ? "" : ","; };
  const std::size_t colours = std::min(kColours, balls.size());
  json += R"("materials":[)";
  for (std::size_t c = 0; c < colours; ++c) {
    const Colour colour = ColourOf(c);
    const auto linear = [&](std::size_t k) { return Pow(double(colour[k]) / 255.0, 2.2); };
    fmt::format_to(out,
                   R"({}{{"pbrMetallicRoughness":{{"baseColorFactor":[{:.4f},{:.4f},{:.4f},1],)"
                   R"("metallicFactor":0,"roughnessFactor":0.7}}}})",
                   comma(c), linear(0), linear(1), linear(2));
  }
  json += R"(],"meshes":[)";
  for (std::size_t c = 0; c < colours; ++c) {
    fmt::format_to(out,
                   R"({}{{"primitives":[{{"attributes":{{"POSITION":0,"NORMAL":0}},"indices":1,)"
                   R"("material":{}}}]}})",
                   comma(c), c);
  }
  fmt::format_to(out, R"(],"nodes":[{{"name":{},"children":[)", quoted);
  for (std::size_t i = 0; i < balls.size(); ++i) fmt::format_to(out, "{}{}", comma(i), i + 1);
  json += "]}";
  for (std::size_t i = 0; i < balls.size(); ++i) {
    const Vec3& p = balls[i].centre;
    fmt::format_to(out, R"(,{{"mesh":{},"translation":[{:.9g},{:.9g},{:.9g}],"scale":[{:.9g},)",
                   i % kColours, p.x(), p.y(), p.z(), balls[i].radius);
    fmt::format_to(out, R"({:.9g},{:.9g}]}})", balls[i].radius, balls[i].radius);
  }
  return json + "]}";
}

}  // namespace

Bytes ToPly(const std::vector<Sphere>& balls, double metres_per_unit) {
  const TriangleMesh ball = MakeSphere(1.0, balls.size() > kManyBalls ? 20 : 80);
  Bytes bytes;
  Put(bytes, std::string_view(fmt::format(
                 "ply\nformat binary_little_endian 1.0\ncomment {} balls of a sphere tree, {} "
                 "vertices each\nelement vertex {}\nproperty float x\nproperty float y\nproperty "
                 "float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nelement "
                 "face {}\nproperty list uchar uint vertex_indices\nend_header\n",
                 balls.size(), ball.vertices.size(), balls.size() * ball.vertices.size(),
                 balls.size() * ball.triangles.size())));
  for (std::size_t i = 0; i < balls.size(); ++i) {
    const Colour colour = ColourOf(i);
    for (const Vec3& v : ball.vertices) {
      Put(bytes, Vec3((balls[i].centre + balls[i].radius * v) / metres_per_unit));
      bytes.insert(bytes.end(), colour.begin(), colour.end());
    }
  }
  for (std::size_t i = 0; i < balls.size(); ++i) {
    for (const auto& triangle : ball.triangles) {
      bytes.push_back(3);
      for (const std::uint32_t v : triangle) {
        Put(bytes, static_cast<std::uint32_t>(i * ball.vertices.size() + v));
      }
    }
  }
  return bytes;
}

Bytes ToGlb(const std::vector<Sphere>& balls, const std::string& name) {
  constexpr std::uint32_t kMagic = 0x46546C67, kJson = 0x4E4F534A, kBinary = 0x004E4942;
  const TriangleMesh ball = MakeSphere(1.0, 320);
  const Bytes buffer = GlbBuffer(ball);
  Bytes json;
  Put(json, std::string_view(GlbJson(balls, name, ball, buffer.size())));
  PadTo4(json, ' ');
  Bytes bytes;
  for (const std::size_t word :
       {std::size_t{kMagic}, std::size_t{2}, 12 + 8 + json.size() + 8 + buffer.size(), json.size(),
        std::size_t{kJson}}) {
    Put(bytes, static_cast<std::uint32_t>(word));
  }
  bytes.insert(bytes.end(), json.begin(), json.end());
  Put(bytes, static_cast<std::uint32_t>(buffer.size()));
  Put(bytes, kBinary);
  bytes.insert(bytes.end(), buffer.begin(), buffer.end());
  return bytes;
}

std::string ExportFormatOf(const std::string& file) {
  const std::string ending = std::filesystem::path(file).extension().string();
  if (ending != ".sph" && ending != ".ply" && ending != ".glb") {
    throw UsageError(file +
                     ": the extension must be .sph (Sphere-Tree Construction Toolkit), .ply or "
                     ".glb (for any viewer)");
  }
  return ending;
}

Bytes ExportTree(const Body& body, const TreeExportOptions& options, const std::string& file) {
  const std::string ending = ExportFormatOf(file);
  const int levels = body.tree.levels();
  if (options.level && (*options.level < 1 || *options.level > levels)) {
    throw UsageError(fmt::format("--level {}: the tree of {} has levels 1 to {}", *options.level,
                                 body.name, levels));
  }
  const auto balls = [&] {
    return BallsByLevel(body.tree)[static_cast<std::size_t>(options.level.value_or(levels) - 1)];
  };
  if (ending == ".glb") {
    if (!options.unit.empty()) {
      throw UsageError("--unit: a .glb is always in metres; drop it, or write a .sph or .ply");
    }
    return ToGlb(balls(), body.name);
  }
  const double unit = MetresPerUnit(options.unit.empty() ? "mm" : options.unit);
  if (ending == ".sph") {
    const std::string text = ToSph(SphOf(body.tree, options.level.value_or(0)), unit);
    return {text.begin(), text.end()};
  }
  return ToPly(balls(), unit);
}

}  // namespace palpate
