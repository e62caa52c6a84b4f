#include "scenes/compiler/scene_info.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

#include <spdlog/fmt/fmt.h>

#include "scenes/compiler/body_lines.h"
#include "scenes/files/scene_bundle.h"
#include "scenes/tree/tree_error.h"
#include "scenes/tree/tree_error_table.h"
#include "scenes/tree/tree_mode.h"

namespace palpate {
namespace {

constexpr std::size_t kSamples = 10007;  // of each surface; a prime, as other measurements use

struct Measured {
  const char* kind;  ///< "tool" or "object"
  const Body* body;
  BodyTreeError error;         ///< no levels: a ball, which is exact
  const Body* same = nullptr;  ///< an earlier body of the same geometry
};

std::vector<Measured> MeasureBodies(const Scene& scene) {
  std::vector<Measured> all;
  for (const auto* bodies : {&scene.tools, &scene.objects}) {
    for (const Body& body : *bodies) {
      Measured measured{bodies == &scene.tools ? "tool" : "object", &body, {body.name, {}}};
      const auto same = std::ranges::find_if(
          all, [&](const Measured& other) { return SameGeometry(*other.body, body); });
      if (same != all.end()) {
        measured.same = same->body;
        measured.error.levels = same->error.levels;
      } else if (body.tree.origin != TreeOrigin::kBall) {
        measured.error.levels = MeasureLevels(body.mesh, body.tree, kSamples);
      }
      all.push_back(std::move(measured));
    }
  }
  return all;
}

std::string FeaturesLine(const Features& features) {
  static constexpr const char* kFriction[] = {"off", "chapter", "coulomb"};
  const auto on = [](bool b) { return b ? "on" : "off"; };
  return fmt::format("  contact {}, friction {}, compliance {}\n",
                     features.contact == ContactModel::kSurface ? "surface" : "spheres",
                     kFriction[static_cast<int>(features.friction)], on(features.compliance));
}

std::string MaterialLines(const Body& body) {
  std::string text;
  for (std::size_t m = 0; m < body.materials.size(); ++m) {
    const auto leaves = body.leaf_material.empty()
                            ? std::ptrdiff_t(body.tree.leaves())
                            : std::count(body.leaf_material.begin(), body.leaf_material.end(), m);
    const Material& material = body.materials[m];
    if (body.grid) {
      text += fmt::format("    material {}{}, cut by burs at {:g} MPa and {:g} MPa s/mm\n", m,
                          material.name.empty() ? "" : ", " + material.name,
                          1e-6 * material.cutting_pressure, 1e-9 * material.cutting_viscosity);
      continue;
    }
    text += fmt::format(
        "    material {}, {} leaves: {}, friction {:g} static {:g} dynamic", m, leaves,
        std::isfinite(material.stiffness) ? fmt::format("{:g} N/m a leaf", material.stiffness)
                                          : "rigid",
        material.static_friction, material.dynamic_friction);
    text += '\n';
  }
  return text;
}

std::string PacketLines(const SphereTree& tree) {
  std::string text;
  const std::vector<std::vector<Sphere>> balls = BallsByLevel(tree);
  for (std::size_t l = 0; l < balls.size(); ++l) {
    const auto [smallest, largest] = std::ranges::minmax(balls[l], {}, &Sphere::radius);
    const std::size_t packets = tree.level(static_cast<int>(l)).size();
    text += fmt::format(
        "    level {}  {:6} spheres in {:5} packets ({:3.0f} % full)  radius {:.2f} to {:.2f} mm\n",
        l + 1, balls[l].size(), packets,
        100.0 * double(balls[l].size()) / double(kTreeArity * packets), 1e3 * smallest.radius,
        1e3 * largest.radius);
  }
  return text;
}

std::string ErrorLines(const Measured& of, const LengthUnit& unit) {
  if (of.same != nullptr) {
    return "    mesh and tree are those of " + of.same->name + ", and so are the errors\n";
  }
  if (of.error.levels.empty()) return "    a single ball is exact: it has no error\n";
  return LevelTable(of.error.levels, unit);
}

}  // namespace

std::string SceneInfo(const Scene& scene) {
  const std::vector<std::uint8_t> bytes = PackScene(scene);
  const std::string_view view(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  std::string text = fmt::format(
      "{}: {} bytes, XXH64 {:016x}, coupling {:g} N/m and {:g} N m/rad\n", scene.name, bytes.size(),
      HashBytes(view, 0), scene.coupling.stiffness, scene.coupling.torsional_stiffness);
  text += FeaturesLine(scene.features);
  const std::vector<Measured> bodies = MeasureBodies(scene);
  std::vector<BodyTreeError> errors;
  for (const Measured& of : bodies) errors.push_back(of.error);
  const LengthUnit unit = UnitOf(errors);
  for (const Measured& of : bodies) {
    text += BodyLine(of.kind, *of.body);
    if (of.same == nullptr) text += PacketLines(of.body->tree);
    text += ErrorLines(of, unit);
    if (of.kind == std::string_view("object")) text += MaterialLines(*of.body);
  }
  text += MovedLines(scene);
  if (std::ranges::any_of(errors, [](const BodyTreeError& e) { return !e.levels.empty(); })) {
    text += AboutLevelTable();
  }
  return text;
}

}  // namespace palpate
