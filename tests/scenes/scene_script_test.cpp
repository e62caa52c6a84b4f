// Every scene of the chapter that has no test elsewhere: its hand's script, played from end to end.

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "scenes/catalogue.h"
#include "scenes/json_file.h"
#include "scenes/pose_script.h"
#include "scenes/scene_file.h"
#include "server/physics/scene_model.h"
#include "server/physics/start_pose.h"
#include "server/physics/tree/sphere_tree_query.h"

namespace palpate {
namespace {

/// One millisecond of a run.
struct Moment {
  std::string label;
  Pose X_WH;
  StepReport report;
  std::set<std::string> touched;  ///< names of objects that push
};

struct Playback {
  Scene scene;
  std::vector<Moment> moments;

  const Moment& last() const { return moments.back(); }
  double Largest(const std::function<double(const Moment&)>& figure) const {
    double largest = -1e300;
    for (const Moment& m : moments) largest = std::max(largest, figure(m));
    return largest;
  }
  std::size_t Count(const std::function<bool(const Moment&)>& holds) const {
    return static_cast<std::size_t>(std::count_if(moments.begin(), moments.end(), holds));
  }
  std::set<std::string> Touched() const {
    std::set<std::string> all;
    for (const Moment& m : moments) all.insert(m.touched.begin(), m.touched.end());
    return all;
  }
};

/// Plays the script and checks what must hold in every scene.
Playback Play(const std::string& name, double greatest_force) {
  Playback run;
  run.scene = LoadScene(name);
  const PoseScript script = PoseScript::Load(
      std::filesystem::path(FindSceneFile(name)).replace_extension(".path.json").string());
  const HapticModel model = MakeModel(run.scene, run.scene.tools[0], MakeObjects(run.scene));
  StepWorkspace workspace(model);
  StepState state(model);
  const StartPose start = ResolveStart(model, script.At(0.0), workspace);
  EXPECT_EQ(start.depth, 0.0) << "the script starts inside an object";
  state.X_WG = start.X_WG;
  state.X_WH = script.At(0.0);
  constexpr std::uint32_t kBad = kFaultBadPose | kFaultRowsFull | kFaultUnsolved;
  const auto steps = static_cast<int>(std::ceil(script.duration() * 1000.0));
  int bad = 0;
  for (int i = 0; i <= steps; ++i) {
    Moment m;
    m.X_WH = script.At(1e-3 * i);
    m.label = script.LabelAt(1e-3 * i);
    m.report = HapticStep(model, m.X_WH, state, workspace);
    bad += (m.report.faults & kBad) != 0;
    for (int c = 0; c < m.report.contacts; ++c) {
      const int object = model.objects().ObjectOf(m.report.active[c].object_leaf);
      m.touched.insert(run.scene.objects[static_cast<std::size_t>(object)].name);
    }
    run.moments.push_back(std::move(m));
  }
  EXPECT_EQ(bad, 0) << "steps with a bad pose, too many rows or an unsolved problem";
  const double force = run.Largest([](const Moment& m) { return m.report.wrench.force.norm(); });
  EXPECT_TRUE(std::isfinite(force));
  EXPECT_LT(force, greatest_force);
  EXPECT_GT(force, 0.1);
  EXPECT_GT(run.Count([](const Moment& m) { return m.report.contacts > 0; }),
            run.moments.size() / 20);
  // The hand ends in free space, and the tool with it.
  EXPECT_EQ(run.last().report.contacts, 0);
  EXPECT_EQ(run.last().report.wrench.force.norm(), 0.0);
  EXPECT_LT((run.last().report.X_WG.p - run.last().X_WH.p).norm(), 1e-9);
  return run;
}

TEST(SceneScript, PeriodontalProbeReachesThePocketsFloorAndFeelsATorqueWhenTurned) {
  const Playback run = Play("periodontal", 4.0);
  EXPECT_EQ(run.Touched(), (std::set<std::string>{"gingiva", "tooth"}));
  // The pocket is 6 mm deep below the neck; the hand goes 1.5 mm deeper.
  const double lowest = run.Largest([](const Moment& m) { return -m.report.X_WG.p.y(); });
  EXPECT_GT(lowest, 0.0055);
  double before = 0.0;
  double turned = 0.0;
  for (const Moment& m : run.moments) {
    const double torque = m.report.wrench.torque.norm();
    if (m.label == "into the pocket") before = std::max(before, torque);
    if (m.label == "turn in the pocket") turned = std::max(turned, torque);
  }
  EXPECT_GT(turned, 3.0 * before);
  EXPECT_TRUE(run.scene.features.compliance);
}

TEST(SceneScript, OralCavityProbeTouchesAll28TeethAndEveryTissue) {
  const Playback run = Play("oral-cavity", 4.0);
  std::size_t leaves = 0;
  for (const Body& object : run.scene.objects) leaves += object.tree.leaves();
  EXPECT_EQ(leaves, 32u * 512u);
  const std::set<std::string> touched = run.Touched();
  for (const Body& object : run.scene.objects)
    EXPECT_TRUE(touched.contains(object.name)) << object.name;
}

TEST(SceneScript, PipesLetTheBunnyThroughAll17) {
  const Playback run = Play("pipes", 12.0);
  const std::string file = FindSceneFile("pipes");
  const SceneDescription description = ParseScene(ReadWholeFile(file), file);
  ASSERT_EQ(description.objects.size(), 17u);
  std::size_t at = 0;
  for (const BodyDescription& pipe : description.objects) {
    SCOPED_TRACE(pipe.name);
    const double inner_radius = pipe.mesh.values[0];
    const double s = 0.5 * pipe.mesh.values[2];  // the middle of the pipe's curve
    const double bend = pipe.mesh.values[3];
    const double a = 0.5 * bend;
    const Vec3 middle = bend > 0.0 ? Vec3(s / a * (1.0 - std::cos(a)), 0.0, s / a * std::sin(a))
                                   : Vec3(0.0, 0.0, s);
    const Vec3 ahead(std::sin(a), 0.0, std::cos(a));
    const Vec3 middle_W = pipe.X_WB.p + pipe.X_WB.q * middle;
    const Vec3 ahead_W = pipe.X_WB.q * ahead;
    // The centroid crosses the middle's plane within the bore, after the pipe before it.
    const auto side = [&](std::size_t i) {
      return (run.moments[i].report.X_WG.p - middle_W).dot(ahead_W);
    };
    const auto off = [&](std::size_t i) {
      return (run.moments[i].report.X_WG.p - middle_W).norm();
    };
    ++at;
    while (at < run.moments.size() &&
           !(side(at - 1) <= 0.0 && side(at) > 0.0 && off(at) < inner_radius)) {
      ++at;
    }
    ASSERT_LT(at, run.moments.size()) << "the centroid does not pass";
  }
}

TEST(SceneScript, FrictionSlidesAlongBothDirectionsInContact) {
  const Playback run = Play("friction", 6.0);
  EXPECT_EQ(run.scene.features.friction, FrictionModel::kCoulomb);
  EXPECT_EQ(run.scene.objects[0].materials[0].static_friction, 0.8);
  EXPECT_EQ(run.scene.objects[0].materials[0].dynamic_friction, 0.3);
  for (const auto& [label, along, across] :
       {std::tuple{"slide along z", 2, 0}, {"slide along x", 0, 2}}) {
    SCOPED_TRACE(label);
    double low = 1e300;
    double high = -1e300;
    Vec3 friction = Vec3::Zero();
    for (const Moment& m : run.moments) {
      if (m.label != label || m.report.contacts == 0) continue;
      low = std::min(low, m.report.X_WG.p[along]);
      high = std::max(high, m.report.X_WG.p[along]);
      for (int c = 0; c < m.report.contacts; ++c) {
        friction += m.report.active[static_cast<std::size_t>(c)].friction.cwiseAbs();
      }
    }
    EXPECT_GT(high - low, 0.0015);
    EXPECT_GT(friction[along], 2.0 * friction[across]);  // as in Fig. 2.25
  }
}

TEST(SceneScript, CalculusIsScrapedOffAndItsFrictionGoesWithIt) {
  const Playback run = Play("calculus", 8.0);
  EXPECT_TRUE(run.scene.features.removal);
  // The chapter's Fig. 2.26: friction along the strokes, y, summed over each pass [N s].
  std::array<double, 5> friction{};
  int removed = 0;
  for (const Moment& m : run.moments) {
    removed += m.report.removals;
    if (!m.label.starts_with("scrape, pass ")) continue;
    double& sum = friction.at(static_cast<std::size_t>(m.label.back() - '1'));
    for (int c = 0; c < m.report.contacts; ++c) {
      sum += 1e-3 * std::abs(m.report.active[static_cast<std::size_t>(c)].friction.y());
    }
  }
  EXPECT_GT(removed, 90);
  EXPECT_GT(friction[0], 0.3);
  EXPECT_LT(friction[3], 0.05 * friction[0]);
  EXPECT_LT(friction[4], 0.02 * friction[0]);
}

TEST(SceneScript, MouldIsSqueezedOnTenThousandPairsAtOnce) {
  const Playback run = Play("mould", 6.0);
  EXPECT_GT(run.Largest([](const Moment& m) { return m.report.predicted_pairs; }), 10000.0);
}

}  // namespace
}  // namespace palpate
