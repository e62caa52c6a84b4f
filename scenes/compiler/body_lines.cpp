#include "scenes/compiler/body_lines.h"

#include <algorithm>
#include <string_view>
#include <vector>

#include <spdlog/fmt/fmt.h>

#include "common/error.h"
#include "common/text/nearest_word.h"
#include "scenes/tree/tree_mode.h"

namespace palpate {
namespace {

std::string ModeOf(const SphereTree& tree) {
  switch (tree.origin) {
    case TreeOrigin::kUnknown:
      return "of a mode that is not known";
    case TreeOrigin::kFile:
      return "from a .sph file";
    case TreeOrigin::kBall:
      return "exactly the ball it is";
    default:
      return "mode \"" + std::string(NameOf(tree.origin)) + "\"";
  }
}

}  // namespace

std::string BodyLine(const char* kind, const Body& body) {
  const Vec3& p = body.X_WB.p;
  return fmt::format(
      "  {} {}: {} leaves in {} levels, {}, {} triangles, {} vertices, at ({:g}, {:g}, {:g}) mm\n",
      kind, body.name, body.tree.leaves(), body.tree.levels(), ModeOf(body.tree),
      body.mesh.triangles.size(), body.mesh.vertices.size(), 1e3 * p.x(), 1e3 * p.y(), 1e3 * p.z());
}

std::string MovedLines(const Scene& scene) {
  std::string lines;
  for (std::size_t i = 0; i < scene.moved.size(); ++i) {
    const MovedGroup& group = scene.moved[i];
    lines += fmt::format("  moves {}: {} objects, in {:g} s{}\n", group.name,
                         std::ranges::count(scene.objects, i + 1, &Body::moved),
                         1e-3 * static_cast<double>(group.keys.back().at),
                         group.repeats ? ", again and again" : "");
  }
  if (scene.hands_meet) lines += "  tools touch each other: all hands act in one world\n";
  return lines;
}

const Body& FindBody(const Scene& scene, const std::string& name) {
  if (name.empty()) return scene.objects.front();
  std::vector<std::string_view> names;
  for (const auto* bodies : {&scene.objects, &scene.tools}) {
    for (const Body& body : *bodies) {
      if (body.name == name) return body;
      names.push_back(body.name);
    }
  }
  throw UsageError("--body " + name + ": there is no such body in " + scene.name +
                   DidYouMeanOneOf(name, names));
}

}  // namespace palpate
