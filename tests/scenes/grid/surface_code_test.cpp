#include "scenes/grid/surface_code.h"

#include <array>
#include <cmath>
#include <numbers>
#include <set>

#include <gtest/gtest.h>

#include "tests/scenes/grid/cut_block.h"

namespace palpate::test {
namespace {

/// Follows the header's description and shares no code with the encoder.
struct Reader {
  const std::vector<std::uint8_t>& code;
  std::size_t at = 0;

  std::size_t U8() { return code.at(at++); }
  std::size_t U16() {
    const std::size_t low = U8();
    return low + 256 * U8();
  }
};

SolidSurface Decode(const std::vector<std::uint8_t>& code, const Vec3& begin, double spacing) {
  SolidSurface surface;
  Reader read{code};
  const std::size_t vertices = read.U16(), quads = read.U16(), triangles = read.U16();
  if (vertices == 0) {
    EXPECT_EQ(code.size(), 6u);
    return surface;
  }
  for (std::size_t i = 0; i < vertices; ++i) {
    Vec3 step;
    for (int k = 0; k < 3; ++k) step[k] = static_cast<double>(read.U8());
    surface.vertices.push_back(begin + spacing * (step / 21.0 - Vec3::Constant(2.0)));
  }
  const auto index = [&] {
    return static_cast<std::uint32_t>(vertices <= 256 ? read.U8() : read.U16());
  };
  for (std::size_t i = 0; i < quads; ++i) {
    std::uint32_t c[4];
    for (std::uint32_t& corner : c) corner = index();
    surface.triangles.push_back({c[0], c[1], c[2]});
    surface.triangles.push_back({c[0], c[2], c[3]});
  }
  for (std::size_t i = 0; i < triangles; ++i) {
    auto& triangle = surface.triangles.emplace_back();
    for (std::uint32_t& corner : triangle) corner = index();
  }
  const bool same = code.size() - read.at == 1;
  for (std::size_t face = 0; face < quads + triangles; ++face) {
    const auto material = static_cast<std::uint8_t>(same ? code.back() : read.U8());
    surface.materials.insert(surface.materials.end(), face < quads ? 2 : 1, material);
  }
  EXPECT_EQ(read.at, same ? code.size() - 1 : code.size());
  return surface;
}

/// Each triangle and what lies behind it, in any order.
std::multiset<std::array<std::uint32_t, 4>> FacesOf(const SolidSurface& surface) {
  std::multiset<std::array<std::uint32_t, 4>> faces;
  for (std::size_t i = 0; i < surface.triangles.size(); ++i) {
    const auto& [a, b, c] = surface.triangles[i];
    faces.insert({a, b, c, surface.materials[i]});
  }
  return faces;
}

void ExpectSame(const SolidSurface& surface, const Vec3& begin, double spacing) {
  std::vector<std::uint8_t> code(7, 9);  // left from an earlier surface
  EncodeSurface(surface, begin, spacing, code);
  const SolidSurface decoded = Decode(code, begin, spacing);
  EXPECT_EQ(FacesOf(decoded), FacesOf(surface));
  ASSERT_EQ(decoded.vertices.size(), surface.triangles.empty() ? 0 : surface.vertices.size());
  for (std::size_t i = 0; i < decoded.vertices.size(); ++i) {
    const Vec3 off = decoded.vertices[i] - surface.vertices[i];
    ASSERT_LE(off.cwiseAbs().maxCoeff(), 1.0001 * spacing / 42.0);
  }
}

TEST(SurfaceCode, SaysWhatIsLeftOfEachBlockOfACut) {
  CutBlock block(50e-6, Quat::Identity());
  block.Go(Bur::Ball(0.5e-3), Vec3(-1e-3, 0.0, 0.0), Vec3(0.0, 0.0, -0.1e-3), 20e-6);
  const Lattice& lattice = block.solid.field().lattice();
  std::size_t with_triangles = 0;
  SolidSurface surface;
  for (int k = 0, number = 0; k < lattice.blocks[2]; ++k) {
    for (int j = 0; j < lattice.blocks[1]; ++j) {
      for (int i = 0; i < lattice.blocks[0]; ++i, ++number) {
        TakeSurface(block.solid, block.cut.field(), static_cast<std::size_t>(number), surface);
        with_triangles += !surface.triangles.empty();
        ExpectSame(surface, lattice.Point(8 * i, 8 * j, 8 * k), lattice.spacing);
      }
    }
  }
  EXPECT_GT(with_triangles, 20u);
}

TEST(SurfaceCode, TakesWiderIndicesAndAMaterialForEachTriangleWhereItMust) {
  SolidSurface surface;
  for (int i = 0; i < 600; ++i) {
    const double angle = std::numbers::pi * i / 300.0;
    surface.vertices.emplace_back(1e-4 * std::cos(angle), 1e-4 * std::sin(angle), -2e-5);
  }
  for (std::uint32_t i = 0; i + 2 < 600; ++i) {
    surface.triangles.push_back({0, i + 1, i + 2});
    surface.materials.push_back(static_cast<std::uint8_t>(i % 8));
  }
  ExpectSame(surface, Vec3::Zero(), 50e-6);
  surface.materials.assign(surface.materials.size(), 3);
  ExpectSame(surface, Vec3::Zero(), 50e-6);
}

}  // namespace
}  // namespace palpate::test
