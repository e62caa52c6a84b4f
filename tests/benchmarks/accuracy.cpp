// palpate-bench accuracy: force against analytic truth (chapter 2.5.1: eq. 2.36, Figs. 2.16-2.18).
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include <spdlog/fmt/fmt.h>

#include "common/files/output.h"
#include "scenes/mesh/mesh_query.h"
#include "server/physics/simd/kernels.h"
#include "tests/benchmarks/commands.h"
#include "tests/benchmarks/features.h"
#include "tests/benchmarks/figures.h"
#include "tests/benchmarks/machine.h"
#include "tests/benchmarks/sliding_force.h"

namespace palpate::bench {
namespace {

struct AccuracyOptions {
  SlidingExperiment experiment;
  double tolerance_um = 1e6 * SlidingExperiment{}.tolerance;
  std::string mode;  ///< empty: the mode that suits the contact
  std::vector<std::size_t> spheres{64, 512, 4096};
  FeatureOptions features{"surface", "off"};
  std::string json;
};

/// The chapter compares 64 spheres with "a polygonal mesh with over 4,000 triangles".
constexpr std::size_t kComparedTriangles = 4001;

Json ToJson(const MeanMax& m) {
  return {{"mean", m.mean}, {"max", m.max}};
}

void AddTo(Json& json, const ForceErrors& e) {
  json["force_error"] = {{"x", ToJson(e.axis[0])},
                         {"y", ToJson(e.axis[1])},
                         {"z", ToJson(e.axis[2])},
                         {"magnitude", ToJson(e.magnitude)},
                         {"strength", ToJson(e.strength)}};
  json["direction_deg"] = ToJson(e.direction_deg);
}

std::string Columns(const ForceErrors& e) {
  return fmt::format("{:>8.5f} {:>8.5f}  {:>8.5f} {:>8.5f}  {:>7.3f} {:>7.3f}", e.magnitude.mean,
                     e.magnitude.max, e.strength.mean, e.strength.max, e.direction_deg.mean,
                     e.direction_deg.max);
}

/// The god-object on the mesh itself, with flat triangles.  The object is convex and the ball's
/// centre outside it (5 mm of radius, 1 mm deep), so the contact is the mesh's nearest point.
ForceErrors OnMesh(const SlidingPath& path, const TriangleMesh& mesh) {
  const MeshQuery query(mesh);
  std::vector<Vec3> forces;
  for (const Vec3& hand : path.hand) {
    const Vec3 apart = hand - query.Nearest(hand).point;
    const double depth = std::max(0.0, kSlidingBallRadius - apart.norm());
    forces.push_back(kSlidingStiffness * depth * apart.normalized());
  }
  return {path, forces};
}

Json ToJson(const SlidingForce& m) {
  Json json{
      {"spheres", m.spheres}, {"triangles", m.triangles}, {"felt_triangles", m.felt_triangles}};
  AddTo(json, m.errors);
  json["truncation_um"] = ToJson(m.truncation_um);
  json["best_step_us"] = ToJson(PercentilesOf(m.step_us.best()));
  return json;
}

void Run(AccuracyOptions options) {
  options.experiment.features = options.features.features();
  options.experiment.tolerance = 1e-6 * options.tolerance_um;
  if (options.mode.empty()) options.mode = NameOf(ModeFor(options.experiment.features.contact));
  options.experiment.tree = TreeModeNamed(options.mode);
  std::vector<SlidingForce> rows;
  for (const std::size_t spheres : options.spheres) {
    rows.push_back(MeasureSlidingForce(options.experiment, spheres));
  }
  std::string table = fmt::format(
      "{}, {} contact: a ball of 5 mm slides at 1 N, {} samples, best of {} ({})\n"
      "  {:<22} {:^17}  {:^17}  {:^15}  {:>10} {:>10}\n"
      "  {:<22} {:>8} {:>8}  {:>8} {:>8}  {:>7} {:>7}  {:>10} {:>10}\n",
      options.experiment.object, options.features.contact, options.experiment.steps,
      options.experiment.repeats, ActiveKernels().name, "", "force error |dF|", "of the strength",
      "direction, deg", "truncation", "step p99.9", "spheres", "mean", "max", "mean", "max", "mean",
      "max", "max, um", "us");
  const auto add_row = [&](const SlidingForce& row, const std::string& name) {
    table += fmt::format("  {:<22} {}  {:>10.4f} {:>10.2f}\n", name, Columns(row.errors),
                         row.truncation_um.max, PercentilesOf(row.step_us.best()).p999);
  };
  for (const SlidingForce& row : rows) add_row(row, fmt::format("{}", row.spheres));
  Json json{{"object", options.experiment.object},
            {"contact", options.features.contact},
            {"mode", options.mode},
            {"steps", options.experiment.steps},
            {"repeats", options.experiment.repeats},
            {"simd", ActiveKernels().name},
            {"machine", ToJson(ThisMachine())}};
  if (rows.size() == 1) {
    json.update(ToJson(rows.front()));
  } else {
    for (const SlidingForce& row : rows) json["results"].push_back(ToJson(row));
  }
  if (!options.experiment.cube()) {
    const TriangleMesh mesh = ObjectMesh(options.experiment, kComparedTriangles);
    const ForceErrors on_mesh = OnMesh(PathOf(options.experiment), mesh);
    table += fmt::format("  {:<22} {}\n", fmt::format("mesh, {} triangles", mesh.triangles.size()),
                         Columns(on_mesh));
    json["mesh"]["triangles"] = mesh.triangles.size();
    AddTo(json["mesh"], on_mesh);
  }
  table += options.experiment.cube()
               ? "  chapter: mean about 0.05 at 4,096 spheres; truncation below 1 um\n"
               : "  chapter: max about 0.05 at 512 spheres; 64 spheres beat over 4,000 triangles; "
                 "truncation below 1 um\n";
  table += "  humans notice 6-8 % of a force's strength\n";
  std::fputs(table.c_str(), stderr);
  if (!options.json.empty()) WriteJson(options.json, json);
}

}  // namespace

void AddAccuracy(const CommandLine& app) {
  auto options = std::make_shared<AccuracyOptions>();
  SlidingExperiment& experiment = options->experiment;
  const CommandLine command = app.AddCommand(
      "accuracy",
      "force error of a ball that slides over a cube or an ellipsoid\n"
      "Compared with the analytic solution (chapter 2.5.1): a ball of 5 mm, commanded 1\n"
      "mm deep at 1 N/mm, translation only.");
  command.Footer(
      "Example: palpate-bench accuracy --object ellipsoid --contact spheres \\\n"
      "                       --spheres 8,64,512 --json -");
  Add(command, "--object", experiment.object, "cube (50 mm) or ellipsoid (40, 25, 30 mm)")
      .OneOf({"cube", "ellipsoid"});
  Add(command, "--spheres", options->spheres,
      "leaves of the object's tree; one row for each number.  They are felt with --contact "
      "spheres only")
      .Positive();
  Add(command, "--triangles", experiment.triangles,
      "ellipsoid: minimum number of triangles (20, 80, ..., 5120, 20480, 81920)")
      .Positive();
  Add(command, "--tolerance-um", options->tolerance_um,
      "ellipsoid, surface contact: distance of the mesh from the curved surface that it "
      "approximates, like \"curved\" in a scene; 0: feel the flat triangles")
      .Range(0.0, 1e6);
  options->features.AddTo(command);
  Add(command, "--mode", options->mode,
      "mode of the object's tree; default: balanced for spheres, else inside")
      .OneOf({kTreeModes.begin(), kTreeModes.end()});
  Add(command, "--steps", experiment.steps, "samples of steady sliding").Positive();
  AddRepeats(command, experiment.repeats);
  AddJson(command, options->json);
  command.Run([options] { Run(*options); });
}

}  // namespace palpate::bench
