#include "scenes/compiler/scene_info.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "common/error.h"
#include "common/files/output.h"
#include "scenes/compiler/body_lines.h"
#include "scenes/files/scene_bundle.h"
#include "scenes/tree/tree_error.h"
#include "scenes/tree/tree_error_table.h"
#include "scenes/tree/tree_mode.h"

namespace palpate {
namespace {

struct Measured {
  const char* kind;  ///< "tool" or "object"
  const Body* body;
  BodyTreeError error;         ///< no levels: a ball, which is exact
  const Body* same = nullptr;  ///< an earlier body of the same geometry
};

std::vector<Measured> MeasureBodies(const Scene& scene, std::size_t samples) {
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
        measured.error.levels = MeasureLevels(body.mesh, body.tree, samples);
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

void WriteFigures(const Scene& scene, const std::vector<Measured>& bodies,
                  const InfoOptions& options) {
  std::string csv;
  nlohmann::ordered_json json{{"scene", scene.name}, {"samples", options.samples}};
  json["bodies"] = nlohmann::ordered_json::array();
  for (const Measured& of : bodies) {
    const std::string_view mode = NameOf(of.body->tree.origin);
    csv += ToCsv(of.error, mode, csv.empty());
    nlohmann::ordered_json entry{{"body", of.body->name}, {"kind", of.kind}, {"mode", mode}};
    entry["levels"] = nlohmann::ordered_json::parse(ToJsonText(of.error))["levels"];
    json["bodies"].push_back(std::move(entry));
  }
  if (!options.csv.empty()) WriteOutput("--csv", options.csv, csv);
  if (!options.json.empty()) WriteOutput("--json", options.json, json.dump(2) + "\n");
}

}  // namespace

std::string SceneInfo(const Scene& scene, const InfoOptions& options) {
  for (const auto& [option, file] :
       {std::pair("--csv", options.csv), std::pair("--json", options.json)}) {
    if (!file.empty()) CheckOutput(option, file);  // before anything is measured
  }
  if (options.csv == "-" && options.json == "-") {
    throw UsageError("--csv - and --json - both use standard output; give a file for one of them");
  }
  const std::vector<std::uint8_t> bytes = PackScene(scene);
  const std::string_view view(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  std::string text = fmt::format(
      "{}: {} bytes, XXH64 {:016x}, coupling {:g} N/m and {:g} N m/rad\n", scene.name, bytes.size(),
      HashBytes(view, 0), scene.coupling.stiffness, scene.coupling.torsional_stiffness);
  text += FeaturesLine(scene.features);
  const std::vector<Measured> bodies = MeasureBodies(scene, options.samples);
  std::vector<BodyTreeError> errors;
  for (const Measured& of : bodies) errors.push_back(of.error);
  const LengthUnit unit = UnitOf(errors);
  for (const Measured& of : bodies) {
    text += BodyLine(of.kind, *of.body);
    if (of.same == nullptr) text += PacketLines(of.body->tree);
    text += ErrorLines(of, unit);
    if (of.kind == std::string_view("object")) text += MaterialLines(*of.body);
  }
  if (std::ranges::any_of(errors, [](const BodyTreeError& e) { return !e.levels.empty(); })) {
    text += AboutLevelTable();
  }
  WriteFigures(scene, bodies, options);
  return text;
}

}  // namespace palpate
