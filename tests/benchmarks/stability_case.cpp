#include "tests/benchmarks/stability_case.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

#include "scenes/shapes/shapes.h"
#include "scenes/tree/sphere_tree_builder.h"
#include "server/physics/scene_model.h"

namespace palpate::bench {
namespace {

/// Body of a solid; trees are built once, because many cases place the same box differently.
const Body& BodyOf(const Solid& solid) {
  using Key = std::tuple<bool, double, double, double, std::size_t>;
  static std::map<Key, Body> made;
  const bool ball = solid.kind == Solid::Kind::kBall;
  const Key key{ball, solid.half.x(), solid.half.y(), solid.half.z(), solid.leaves};
  const auto [it, is_new] = made.try_emplace(key);
  Body& body = it->second;
  if (is_new) {
    const double radius = solid.half.x();
    body.mesh =
        ball ? MakeSphere(radius, solid.leaves == 1 ? 320 : 20480) : MakeBox(2 * solid.half);
    body.tree = ball && solid.leaves == 1 ? SingleSphereTree(body.mesh, {Vec3::Zero(), radius})
                                          : BuildSphereTree(body.mesh, solid.leaves);
  }
  return body;
}

double BallInBox(const Vec3& centre, double radius, const Solid& box, const Pose& X_WB) {
  const Vec3 p = X_WB.Inverse() * centre;
  const Vec3 beyond = p.cwiseAbs() - box.half;
  const double distance = beyond.cwiseMax(0.0).norm() + std::min(beyond.maxCoeff(), 0.0);
  return std::max(0.0, radius - distance);
}

/// Least overlap over the fifteen axes that can separate two boxes (Gottschalk et al. 1996).
double BoxInBox(const Solid& A, const Pose& X_WA, const Solid& B, const Pose& X_WB) {
  const Mat3 R_WA = X_WA.q.toRotationMatrix(), R_WB = X_WB.q.toRotationMatrix();
  const Vec3 between = X_WB.p - X_WA.p;
  double least = std::numeric_limits<double>::infinity();
  const auto look_along = [&](const Vec3& axis) {
    const double length = axis.norm();
    if (length < 1e-9) return;  // parallel edges: the faces' axes decide
    const double reach = (R_WA.transpose() * axis).cwiseAbs().dot(A.half) +
                         (R_WB.transpose() * axis).cwiseAbs().dot(B.half);
    least = std::min(least, (reach - std::abs(between.dot(axis))) / length);
  };
  for (int i = 0; i < 3; ++i) {
    look_along(R_WA.col(i));
    look_along(R_WB.col(i));
    for (int j = 0; j < 3; ++j) look_along(R_WA.col(i).cross(R_WB.col(j)));
  }
  return std::max(0.0, least);
}

}  // namespace

Solid Box(const Vec3& sides, std::size_t leaves, const Pose& X_WB) {
  return {Solid::Kind::kBox, 0.5 * sides, leaves, X_WB};
}

Solid Ball(double radius, std::size_t leaves, const Pose& X_WB) {
  return {Solid::Kind::kBall, Vec3::Constant(radius), leaves, X_WB};
}

double OverlapOf(const Solid& A, const Pose& X_WA, const Solid& B, const Pose& X_WB) {
  const bool a = A.kind == Solid::Kind::kBall, b = B.kind == Solid::Kind::kBall;
  if (a && b) return std::max(0.0, A.half.x() + B.half.x() - (X_WA.p - X_WB.p).norm());
  if (a) return BallInBox(X_WA.p, A.half.x(), B, X_WB);
  if (b) return BallInBox(X_WB.p, B.half.x(), A, X_WA);
  return BoxInBox(A, X_WA, B, X_WB);
}

bool Held(const StabilityCase& stability_case, const CaseRun& run) {
  return run.done > 0 && run.figure <= stability_case.bound && run.tunnelled == 0 &&
         run.nonfinite == 0 && run.penetration <= kAllowedOverlap;
}

std::vector<StabilityCase> StabilityCases() {
  std::vector<StabilityCase> all = ContactCases();
  for (auto* part : {TouchCases, LoopCases}) {
    for (StabilityCase& stability_case : part()) all.push_back(std::move(stability_case));
  }
  return all;
}

Trial::Trial(CaseRun& run, const Solid& tool, const std::vector<Solid>& objects, double stiffness)
    : Trial(run, tool, objects, stiffness, run.features,
            {.static_friction = 0.8, .dynamic_friction = 0.3}) {}

Trial::Trial(CaseRun& run, const Solid& tool, const std::vector<Solid>& objects, double stiffness,
             const Features& features, const Material& material)
    : run_(run), tool_(tool), objects_(objects) {
  scene_.features = features;
  scene_.coupling.stiffness = stiffness;
  scene_.tools.push_back(BodyOf(tool));
  for (const Solid& solid : objects) {
    scene_.objects.push_back(BodyOf(solid));
    scene_.objects.back().X_WB = solid.X_WB;
    scene_.objects.back().materials = {material};
  }
  model_ =
      std::make_unique<HapticModel>(MakeModel(scene_, scene_.tools.front(), MakeObjects(scene_)));
  workspace_ = std::make_unique<StepWorkspace>(*model_);
  if (features.contact == ContactModel::kSpheres) {
    oracle_ =
        std::make_unique<OverlapOracle>(scene_.tools.front().tree, scene_.objects, scene_.features);
  }
}

void Trial::Start(const Pose& X_WG) {
  state_ = StepState{};
  state_.X_WG = state_.X_WH = X_WG;
}

double Trial::Overlap(const Pose& X_WG) const {
  if (oracle_) return oracle_->At(X_WG).depth;
  double deepest = 0.0;
  for (const Solid& object : objects_) {
    deepest = std::max(deepest, OverlapOf(tool_, X_WG, object, object.X_WB));
  }
  return deepest;
}

StepReport Trial::Step(const Pose& X_WH) {
  const StepReport report = HapticStep(*model_, X_WH, state_, *workspace_);
  Check(report.X_WG, report.wrench);
  return report;
}

void Trial::Check(const Pose& X_WG, const Wrench& wrench) {
  if (run_.done % 256 == 0) {
    if (run_.stopped && run_.stopped()) throw Interrupted{};
    if (run_.progress) run_.progress(run_.done);
  }
  ++run_.done;
  const bool finite = X_WG.p.allFinite() && X_WG.q.coeffs().allFinite() &&
                      wrench.force.allFinite() && wrench.torque.allFinite();
  run_.nonfinite += !finite;
  if (expect_free_ && finite) run_.penetration = std::max(run_.penetration, Overlap(X_WG));
}

}  // namespace palpate::bench
