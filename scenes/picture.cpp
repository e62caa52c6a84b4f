#include "scenes/picture.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "common/error.h"
#include "scenes/files/scene_bundle.h"
#include "scenes/mesh/triangle.h"
#include "scenes/picture_canvas.h"
#include "scenes/picture_tile.h"
#include "scenes/tree/tree_error.h"

namespace palpate {
namespace {

/// Returns colours that differ between neighbours: hues step by the golden ratio.
Colour ColourOf(std::size_t index) {
  const double hue = std::fmod(0.08 + 0.618033988749895 * static_cast<double>(index), 1.0);
  Colour c;
  for (int k = 0; k < 3; ++k) {
    const double at = std::abs(std::fmod(hue + k / 3.0, 1.0) * 6.0 - 3.0) - 1.0;
    c[k] = 0.42 + 0.5 * std::clamp(at, 0.0, 1.0);
  }
  return c;
}

}  // namespace

void DrawScene(const Scene& scene, std::optional<int> level, const std::string& png_file) {
  std::vector<const Body*> bodies;
  int levels = 0;
  for (const auto* list : {&scene.tools, &scene.objects}) {
    for (const Body& body : *list) {
      if (std::any_of(bodies.begin(), bodies.end(),
                      [&](const Body* other) { return SameGeometry(*other, body); })) {
        continue;
      }
      bodies.push_back(&body);
      levels = std::max(levels, body.tree.levels());
    }
  }
  if (level && (*level < 1 || *level > levels)) {
    throw UsageError("--level " + std::to_string(*level) + ": there is no such level; give 1 to " +
                     std::to_string(levels));
  }
  Canvas picture((level ? 2 : 1 + levels) * Tile::kSide,
                 static_cast<int>(bodies.size()) * Tile::kSide);
  for (int row = 0; row < static_cast<int>(bodies.size()); ++row) {
    const Body& body = *bodies[row];
    const std::vector<std::vector<Sphere>> balls = BallsByLevel(body.tree);
    Tile mesh(body.mesh);
    mesh.Draw(body.mesh, Colour(0.8, 0.74, 0.66));
    mesh.ShadeHollows();
    picture.Place(mesh, 0, row * Tile::kSide);
    for (int l = level ? *level - 1 : 0; l < (level ? *level : levels); ++l) {
      Tile tile(body.mesh);
      std::size_t count = 0;
      if (l < body.tree.levels()) {
        for (const Sphere& ball : balls[static_cast<std::size_t>(l)]) {
          tile.DrawSphere(ball.centre, ball.radius, ColourOf(count++));
        }
      }
      tile.ShadeHollows();
      picture.Place(tile, (level ? 1 : 1 + l) * Tile::kSide, row * Tile::kSide);
    }
  }
  picture.Save(png_file);
}

void DrawWhole(const Scene& scene, const std::string& png_file) {
  const auto placed = [](const Body& body) {
    TriangleMesh mesh = body.mesh;
    for (Vec3& v : mesh.vertices) v = body.X_WB.p + body.X_WB.q * v;
    return mesh;
  };
  std::vector<std::pair<TriangleMesh, Colour>> meshes;
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    meshes.emplace_back(placed(scene.objects[i]), 0.45 + 0.45 * ColourOf(i));
  }
  for (const Body& tool : scene.tools) meshes.emplace_back(placed(tool), Colour(1.0, 0.45, 0.1));
  Eigen::AlignedBox3d box;
  for (const auto& [mesh, colour] : meshes) box.extend(BoxOf(mesh));
  Tile tile(box.center(), 0.5 * 0.85 * box.diagonal().norm());
  for (const auto& [mesh, colour] : meshes) tile.Draw(mesh, colour);
  tile.ShadeHollows();
  Canvas picture(Tile::kSide, Tile::kSide);
  picture.Place(tile, 0, 0);
  picture.Save(png_file);
}

}  // namespace palpate
