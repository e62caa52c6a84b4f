#include "scenes/files/mesh_scene.h"

#include <cmath>
#include <filesystem>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "common/error.h"
#include "scenes/files/scene_file.h"
#include "scenes/mesh/mesh_import.h"
#include "scenes/mesh/mesh_report.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

/// The usual size of what a hand feels [m]: a tooth, a tool, a statuette.
constexpr double kUsual_m = 0.05;
/// A mesh outside these sizes probably has another unit than was assumed [m].
constexpr double kLeast_m = 0.002, kMost_m = 2.0;
constexpr double kBallShare = 0.05;

std::string Size(const Vec3& size, double metres_per_unit) {
  const Vec3 m = metres_per_unit * size;
  const bool large = m.maxCoeff() >= 1.0;
  const Vec3 shown = large ? m : Vec3(1e3 * m);
  return fmt::format("{:.3g} x {:.3g} x {:.3g} {}", shown.x(), shown.y(), shown.z(),
                     large ? "m" : "mm");
}

std::string AboutUnit(const Vec3& size, const std::string& unit, bool guessed) {
  const double metres = MetresPerUnit(unit);
  std::string text = fmt::format("unit: {}, ", unit);
  if (guessed) {
    const std::string other = unit == "m" ? "mm" : "m";
    text += fmt::format("guessed by the size, so it is {}; in {} it would be {}",
                        Size(size, metres), other, Size(size, MetresPerUnit(other)));
  } else {
    text += fmt::format("as given, so it is {}", Size(size, metres));
  }
  const double longest = metres * size.maxCoeff();
  if (longest < kLeast_m || longest > kMost_m) text += ", an unusual size for an object to feel";
  return text + " (give the unit of the file with --unit m, cm, mm or inch)";
}

/// Returns the value with three significant digits, for people.
double Rounded(double value) {
  return std::stod(fmt::format("{:.3g}", value));
}

nlohmann::ordered_json ToJson(const std::string& name, const std::string& file,
                              const std::string& unit, const Vec3& size_m, double ball_m) {
  const double height_mm = Rounded(1e3 * (0.5 * size_m.y() + ball_m + 0.25 * size_m.maxCoeff()));
  return {{"name", name},
          {"description", "A mesh, and a ball to touch it with."},
          {"tools",
           {{{"name", "ball"},
             {"mesh", {{"shape", "sphere"}, {"radius_m", ball_m}}},
             {"leaves", 1},
             {"start", {{"position_mm", {0.0, height_mm, 0.0}}}}}}},
          {"objects",
           {{{"name", name == "ball" ? "object" : name},
             {"mesh", {{"file", file}, {"unit", unit}, {"origin", "box_centre"}}}}}},
          {"contact", "surface"},
          {"friction", "off"},
          {"coupling", {{"stiffness_N_per_m", 1000.0}, {"torsional_stiffness_Nm_per_rad", 1.0}}}};
}

}  // namespace

std::string_view GuessUnit(double longest_side) {
  return longest_side * std::sqrt(1e-3) < kUsual_m ? "m" : "mm";
}

MeshScene MakeMeshScene(const std::string& mesh_file, const MeshSceneOptions& options,
                        const std::string& folder) {
  const MeshReport report = InspectMesh(ImportMesh(mesh_file));
  if (!report.refusal.empty()) throw Error(mesh_file + ": " + report.refusal);
  const Vec3 size = report.box_max - report.box_min;
  const bool guessed = options.unit.empty();
  const std::string unit(guessed ? GuessUnit(size.maxCoeff()) : options.unit);
  const Vec3 size_m = MetresPerUnit(unit) * size;
  const bool given = options.ball_m > 0.0;
  const double ball_m = given ? options.ball_m : Rounded(kBallShare * size_m.maxCoeff());
  const fs::path path(mesh_file);
  const std::string name = SceneNameOf(path.extension() == ".gz" ? path.stem() : path);
  std::error_code ignored;
  const fs::path from = folder.empty() ? fs::path(".") : fs::path(folder);
  const std::string file = fs::proximate(mesh_file, from, ignored).string();

  MeshScene scene;
  scene.name = name;
  scene.text = ToJson(name, file, unit, size_m, ball_m).dump(2) + "\n";
  scene.assumptions = {
      fmt::format("{} is a mesh, {} triangles, {}: served as scene '{}'", mesh_file,
                  report.triangles, report.closed() ? "closed" : "open", name),
      AboutUnit(size, unit, guessed),
      fmt::format("tool: 'ball', a ball of {:.3g} mm radius{} (--ball MM for another)",
                  1e3 * ball_m, given ? "" : ", a twentieth of the longest side"),
      "contact: by the mesh's own triangles, hard, without friction, 1 N/mm between hand and tool"};
  for (const std::string& remark : report.remarks) scene.assumptions.push_back("note: " + remark);
  return scene;
}

}  // namespace palpate
