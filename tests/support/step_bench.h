#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "server/physics/haptic_step.h"
#include "server/physics/tree/sphere_tree_query.h"
#include "tests/support/test_trees.h"

namespace palpate::test {

inline Pose At(double x, double y, double z) {
  return {Vec3(x, y, z), Quat::Identity()};
}

/// Assigns materials to an object's balls by position.
struct Paint {
  std::vector<Material> materials{Material{}};
  std::function<int(const Vec3&)> of = [](const Vec3&) { return 0; };
};

inline Paint AllOf(const Material& material) {
  return {{material}, [](const Vec3&) { return 0; }};
}

/// Runs steps of one tool against one object, with the hand's pose as input.
class Bench {
 public:
  Bench(std::vector<Ball> tool, std::vector<Ball> object, StepParameters parameters = {},
        Paint paint = {})
      : tool_(std::move(tool)),
        object_(std::move(object)),
        tool_tree_(MakeTree(tool_)),
        object_tree_(MakeTree(object_)),
        paint_(std::move(paint)),
        model_(tool_tree_, Objects(), parameters),
        state_(model_),
        workspace_(model_) {}

  StepReport Step(const Pose& X_WH) { return HapticStep(model_, X_WH, state_, workspace_); }
  StepReport Repeat(const Pose& X_WH, int steps) {
    StepReport report;
    for (int i = 0; i < steps; ++i) report = Step(X_WH);
    return report;
  }
  /// Returns the deepest overlap of any two balls at the graphic tool's pose, over all pairs.
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
  std::shared_ptr<const SceneObjects> Objects() {
    std::vector<std::uint8_t> leaf_material;
    for (std::size_t i = 0; i < object_tree_.leaves(); ++i) {
      leaf_material.push_back(static_cast<std::uint8_t>(
          paint_.of({object_tree_.leaf_x[i], object_tree_.leaf_y[i], object_tree_.leaf_z[i]})));
    }
    const PlacedTree placed{&object_tree_, {}, nullptr, leaf_material, paint_.materials};
    return std::make_shared<const SceneObjects>(std::span(&placed, 1));
  }
  std::vector<Ball> tool_, object_;
  SphereTree tool_tree_, object_tree_;
  Paint paint_;
  HapticModel model_;
  StepState state_;
  StepWorkspace workspace_;
};

}  // namespace palpate::test
