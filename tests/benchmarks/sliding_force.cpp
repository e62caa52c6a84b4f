#include "tests/benchmarks/sliding_force.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <utility>

#include <spdlog/fmt/fmt.h>

#include "scenes/mesh/curved_mesh.h"
#include "scenes/shapes/shapes.h"
#include "scenes/tree/sphere_tree_builder.h"
#include "server/physics/haptic_step.h"
#include "server/physics/scene_model.h"

namespace palpate::bench {
namespace {

/// The error of linearising the gap (2.10-2.17) in a step: the true gap of each active pair of
/// balls minus its row's [m].
double Truncation(const StepReport& report, const SphereTree& object) {
  double worst = report.diagnostics.truncation;  // of the rotation; a ball has none
  for (int c = 0; c < report.contacts; ++c) {
    const ActiveRow& row = report.active[static_cast<std::size_t>(c)];
    const auto leaf = static_cast<std::size_t>(row.id.b);
    const Vec3 centre(object.leaf_x[leaf], object.leaf_y[leaf], object.leaf_z[leaf]);
    const double gap =
        (report.X_WG.p - centre).norm() - (kSlidingBallRadius + object.leaf_radius[leaf]);
    worst = std::max(worst, std::abs(gap + row.offset));
  }
  return worst;
}

SphereTree TreeOf(const SlidingExperiment& experiment, const TriangleMesh& mesh,
                  std::size_t spheres) {
  return BuildSphereTree(
      mesh, spheres,
      [&](std::string_view stage, double done) {
        Progress(fmt::format("{} of {} spheres: {} {:.0f} % ...", experiment.object, spheres, stage,
                             100.0 * done));
      },
      experiment.tree);
}

}  // namespace

ForceErrors::ForceErrors(const SlidingPath& path, const std::vector<Vec3>& forces) {
  const std::size_t count = forces.size() - path.steady;
  for (std::size_t i = path.steady; i < forces.size(); ++i) {
    const Vec3 truth = kSlidingStiffness * kSlidingDepth * path.normal[i];
    const Vec3 delta = (truth - forces[i]) / truth.norm();
    x.push_back(delta.x());
    y.push_back(delta.y());
    for (int k = 0; k < 3; ++k) axis[k].Add(std::abs(delta[k]), count);
    magnitude.Add(delta.norm(), count);
    strength.Add(std::abs(forces[i].norm() / truth.norm() - 1.0), count);
    direction_deg.Add(
        180.0 / M_PI * std::atan2(truth.cross(forces[i]).norm(), truth.dot(forces[i])), count);
  }
}

TriangleMesh ObjectMesh(const SlidingExperiment& experiment, std::size_t triangles) {
  return experiment.cube() ? MakeBox(Vec3::Constant(kCubeSide))
                           : MakeEllipsoid(kEllipsoidAxes, triangles);
}

SlidingPath PathOf(const SlidingExperiment& experiment) {
  return experiment.cube() ? SlideOverCube(experiment.steps) : SlideOverEllipsoid(experiment.steps);
}

Scene SlidingScene(const SlidingExperiment& experiment, std::size_t spheres) {
  Scene scene;
  scene.name = "accuracy, " + experiment.object;
  scene.features = experiment.features;
  scene.coupling.stiffness = kSlidingStiffness;
  Body ball, object;
  ball.mesh = MakeSphere(kSlidingBallRadius, 320);
  ball.tree = SingleSphereTree(ball.mesh, {Vec3::Zero(), kSlidingBallRadius});
  object.mesh = ObjectMesh(experiment, experiment.triangles);
  if (experiment.tolerance > 0.0 && experiment.features.contact == ContactModel::kSurface) {
    object.mesh = RefineCurved(object.mesh, {.tolerance = experiment.tolerance}).mesh;
  }
  object.tree = TreeOf(experiment, object.mesh, spheres);
  scene.tools.push_back(std::move(ball));
  scene.objects.push_back(std::move(object));
  return scene;
}

SlidingForce MeasureSlidingForce(const SlidingExperiment& experiment, std::size_t spheres) {
  const SlidingPath path = PathOf(experiment);
  const Scene scene = SlidingScene(experiment, spheres);
  const HapticModel model = MakeModel(scene, scene.tools.front(), MakeObjects(scene));
  StepWorkspace workspace(model);
  BestOf step_us;
  std::vector<Vec3> forces;
  MeanMax truncation_um;
  using Clock = std::chrono::steady_clock;
  for (int r = 0; r < experiment.repeats; ++r) {
    Progress(fmt::format("{} of {} spheres: repeat {} of {} ...", experiment.object, spheres, r + 1,
                         experiment.repeats));
    StepState state;
    state.X_WG.p = path.hand.front();
    std::vector<double> us;
    for (std::size_t i = 0; i < path.hand.size(); ++i) {
      const auto begin = Clock::now();
      const StepReport report =
          HapticStep(model, {path.hand[i], Quat::Identity()}, state, workspace);
      const auto end = Clock::now();
      if (i >= path.steady) {
        us.push_back(std::chrono::duration<double, std::micro>(end - begin).count());
      }
      if (r > 0) continue;
      forces.push_back(report.wrench.force);
      if (i >= path.steady) {
        truncation_um.Add(1e6 * (scene.features.contact == ContactModel::kSpheres
                                     ? Truncation(report, scene.objects.front().tree)
                                     : report.diagnostics.truncation),
                          path.hand.size() - path.steady);
      }
    }
    step_us.Add(us);
  }
  Progress("");
  return {scene.objects.front().tree.leaves(),
          ObjectMesh(experiment, experiment.triangles).triangles.size(),
          scene.objects.front().mesh.triangles.size(),
          ForceErrors(path, forces),
          truncation_um,
          step_us};
}

}  // namespace palpate::bench
