#pragma once

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "server/physics/haptic_step.h"
#include "server/physics/sphere_tree_query.h"
#include "tests/support/test_trees.h"

namespace palpate::test {

inline Pose At(double x, double y, double z) {
  return {Vec3(x, y, z), Quat::Identity()};
}

/// One tool against one object, with the hand's pose as input.
class Bench {
 public:
  Bench(std::vector<Ball> tool, std::vector<Ball> object, StepParameters parameters = {},
        const Material& material = {})
      : tool_(std::move(tool)),
        object_(std::move(object)),
        material_(material),
        tool_tree_(MakeTree(tool_)),
        object_tree_(MakeTree(object_)),
        model_(tool_tree_, Objects(), parameters),
        workspace_(model_) {}

  StepReport Step(const Pose& X_WH) { return HapticStep(model_, X_WH, state_, workspace_); }
  StepReport Repeat(const Pose& X_WH, int steps) {
    StepReport report;
    for (int i = 0; i < steps; ++i) report = Step(X_WH);
    return report;
  }
  /// Deepest overlap of any two balls at the graphic tool's pose, by all pairs.
  double Penetration() const {
    double deepest = 0.0;
    for (const Ball& t : tool_) {
      const Vec3 c = state_.X_WG * t.center;
      for (const Ball& o : object_) {
        deepest = std::max(deepest, t.radius + o.radius - (c - o.center).norm());
      }
    }
    return deepest;
  }
  StepState& state() { return state_; }
  const HapticModel& model() const { return model_; }
  StepWorkspace& workspace() { return workspace_; }

 private:
  std::shared_ptr<const ObjectForest> Objects() {
    const PlacedTree placed{&object_tree_, {}, nullptr, {}, std::span(&material_, 1)};
    return HapticModel::MakeObjects(std::span(&placed, 1));
  }
  std::vector<Ball> tool_, object_;
  Material material_;
  SphereTree tool_tree_, object_tree_;
  HapticModel model_;
  StepState state_;
  StepWorkspace workspace_;
};

}  // namespace palpate::test
