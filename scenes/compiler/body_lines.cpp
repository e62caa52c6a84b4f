#include "scenes/compiler/body_lines.h"

#include <algorithm>
#include <string_view>

#include <spdlog/fmt/fmt.h>

#include "scenes/tree/tree_mode.h"

namespace palpate {
namespace {

std::string ModeOf(const SphereTree& tree) {
  switch (tree.origin) {
    case TreeOrigin::kUnknown:
      return "of a mode that is not known";
    case TreeOrigin::kFile:
      return "from a file";
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
    if (group.free) {
      static constexpr const char* kJoints[] = {"", ", on a hinge", ", on a slider",
                                                ", on a ball joint", ", on springs"};
      lines += fmt::format("  free {}: {:.3g} g{}\n", group.name, 1e3 * group.free->mass,
                           kJoints[static_cast<int>(group.free->joint.kind)]);
      continue;
    }
    lines += fmt::format("  moves {}: {} objects, in {:g} s{}\n", group.name,
                         std::ranges::count(scene.objects, i + 1, &Body::moved),
                         1e-3 * static_cast<double>(group.keys.back().at),
                         group.repeats ? ", again and again" : "");
  }
  if (scene.hands_meet) lines += "  tools touch each other: all hands act in one world\n";
  return lines;
}

}  // namespace palpate
