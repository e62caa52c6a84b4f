// Hands that do little of each shipped exercise, or do it badly: a new exercise joins by itself.
#include <algorithm>
#include <filesystem>
#include <functional>
#include <map>
#include <numbers>

#include <gmock/gmock.h>
#include <spdlog/fmt/fmt.h>

#include "client/course/exercise.h"
#include "client/replayer/score/score_report.h"
#include "common/math/rotation.h"

namespace palpate::test {
namespace {

using Keys = std::vector<PoseScript::Key>;
const std::string kShipped = PALPATE_SOURCE_DIR "/client/course/exercises";

/// The motion of an exercise's expert, and where and when his tool touches.
struct Model {
  Keys keys;
  double begin_s = 0.0, end_s = 0.0;  ///< of contact
  double middle_s = 0.0;              ///< in contact, and nearest to the middle of that time
  Vec3 into = Vec3::Zero();           ///< unit: against the mean force
  double extent = 0.0;                ///< diagonal of what is touched [m]

  PoseScript script() const { return PoseScript(keys); }
  /// Returns the motion up to a part of the time from first to last contact.
  PoseScript Until(double part) const {
    const double end = begin_s + part * (end_s - begin_s);
    Keys begun = keys;
    std::erase_if(begun, [&](const PoseScript::Key& key) { return key.t >= end; });
    begun.push_back({end, script().At(end), ""});
    return PoseScript(begun);
  }
  /// Returns the motion, displaced while it touches.
  PoseScript Displaced(const Vec3& by, const Quat& turn = Quat::Identity()) const {
    Keys changed = keys;
    for (PoseScript::Key& key : changed) {
      if (key.t < begin_s - 0.5 || key.t > end_s + 0.5) continue;
      key.X_WH = {key.X_WH.p + by, turn * key.X_WH.q};
    }
    return PoseScript(changed);
  }
  /// Returns the motion with one push, half a second long to either side of its middle.
  PoseScript Pushing(double by_m) const {
    const double at = std::max(0.6, middle_s);
    Keys changed = keys;
    std::erase_if(changed, [&](const auto& key) { return std::abs(key.t - at) < 0.51; });
    for (const double t : {at - 0.5, at, at + 0.5}) {
      Pose X_WH = script().At(t);
      if (t == at) X_WH.p += by_m * into;
      changed.push_back({t, X_WH, ""});
    }
    std::ranges::sort(changed, {}, &PoseScript::Key::t);
    return PoseScript(changed);
  }
  /// Returns the motion with a rest.
  PoseScript Resting(double at, double for_s) const {
    Keys changed = keys;
    for (PoseScript::Key& key : changed) key.t += key.t > at ? for_s : 0.0;
    for (const double t : {at, at + for_s}) changed.push_back({t, script().At(at), ""});
    std::ranges::stable_sort(changed, {}, &PoseScript::Key::t);
    return PoseScript(changed);
  }
};

/// @param path  the expert's.   @param pace  at which the other hands move, compared with his.
Model ModelOf(const std::string& expert, const HandPath& path, double pace) {
  Model model{PoseScript::Load(expert).keys()};
  for (PoseScript::Key& key : model.keys) key.t /= pace;
  Vec3 force = Vec3::Zero();
  Eigen::AlignedBox3d touched;
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (!path.touches(i)) continue;
    if (touched.isEmpty()) model.begin_s = path.time_s[i] / pace;
    model.end_s = path.time_s[i] / pace;
    force += path.force_N[i];
    touched.extend(path.tool()[i].p);
  }
  const double middle_s = 0.5 * (model.begin_s + model.end_s);
  model.middle_s = model.begin_s;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const double at = path.time_s[i] / pace;
    const bool is_nearer = std::abs(at - middle_s) < std::abs(model.middle_s - middle_s);
    if (path.touches(i) && is_nearer) model.middle_s = at;
  }
  model.into = -force.normalized();
  model.extent = touched.diagonal().norm();
  return model;
}

struct Motion {
  const char* name;
  double most_points;
  std::function<PoseScript(const Model&)> of;
};
/// By rising part of the task that is done.
const std::vector<Motion> kParts = {
    {"nothing", 0,
     [](const Model& m) {
       const Pose& start = m.keys.front().X_WH;
       return PoseScript({{0, start, ""}, {1, {start.p - 0.005 * m.into, start.q}, ""}});
     }},
    {"a scratch", 20, [](const Model& m) { return m.Until(0.01); }},
    {"a tenth", 25, [](const Model& m) { return m.Until(0.1); }},
    {"a half", 67, [](const Model& m) { return m.Until(0.5); }},
    {"two thirds", 69, [](const Model& m) { return m.Until(0.67); }},
};
/// The whole task with a single mistake.
const std::vector<Motion> kMistakes = {
    {"aside", 69,
     [](const Model& m) {
       return m.Displaced({std::max(1.5e-3, 0.3 * m.extent), 0, 0});
     }},
    {"pressed", 100, [](const Model& m) { return m.Displaced(1e-3 * m.into); }},
    {"tilted", 100,
     [](const Model& m) {
       return m.Displaced(Vec3::Zero(), RotationExp({0, 0, 20 * std::numbers::pi / 180}));
     }},
    {"pushed", 100, [](const Model& m) { return m.Pushing(3e-3); }},
};

Motion Moved(const char* name, const Vec3& by_mm) {
  return {name, 69, [by_mm](const Model& m) { return m.Displaced(1e-3 * by_mm); }};
}
Motion Resting(const char* name, double at, double for_s) {
  return {name, 69, [=](const Model& m) { return m.Resting(at, for_s); }};
}
/// And what an exercise's own text names as a mistake: none passes.
const std::multimap<std::string, Motion> kNamed = {
    {"bone-window", Moved("2 mm too deep", {0, 0, -2})},
    {"bone-window", Moved("into the nerve", {0, -3, -3})},
    {"calculus-detection", Resting("rests on smooth root, too", 13.5, 2.5)},
    {"caries-excavation", Moved("into the pulp", {0, -2, 0})},
    {"cavity-class-1", Moved("into the pulp", {0, -3, 0})},
    {"crown-margin", Moved("1 mm too high", {0, 1, 0})},
    {"light-force", Moved("not down to the floor", {0, 1.5, 0})},
    {"margin-walking", Moved("not down to the floor", {0, 1.5, 0})},
    {"nodule-palpation", Moved("too lightly", {0, 4, 0})},
    {"nodule-palpation", Resting("rests elsewhere, too", 2.0, 3.5)},
    {"pocket-depth", Moved("not down to the floor", {0, 1.5, 0})},
    {"six-sites", Moved("not down to the floor", {0, 1.5, 0})},
    {"subgingival-removal", Moved("into the floor, past the deposit", {0, -2.5, 0})},
    {"supragingival-calculus", Moved("in the gum", {0, -2.5, 0})},
};

std::vector<std::string> Shipped() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(kShipped)) {
    const std::string name = entry.path().filename().string();
    if (name.ends_with(kExerciseEnding)) names.push_back(name);
  }
  std::ranges::sort(names);
  return names;
}

class Adversary : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Shipped, Adversary, testing::ValuesIn(Shipped()), [](const auto& name) {
  std::string text = name.param.substr(0, name.param.find('.'));
  std::erase(text, '-');
  return text;
});

TEST_P(Adversary, GetsPointsOnlyAsFarAsTheTaskIsDone) {
  const Exercise exercise = LoadExercise(kShipped + "/" + GetParam());
  std::vector<Motion> motions = kParts;
  motions.insert(motions.end(), kMistakes.begin(), kMistakes.end());
  const auto [first, last] = kNamed.equal_range(exercise.name);
  for (auto it = first; it != last; ++it) motions.push_back(it->second);
  EXPECT_NE(first, last) << "name what its text calls a mistake";
  const Report report = Rehearse(exercise, [&](const HandPath& path) {
    // A bur cuts where it goes, at any pace; this one halves the time of the test.
    const double pace = AsksForCuts(exercise.criteria) ? 2.0 : 1.0;
    const Model model = ModelOf(exercise.expert, path, pace);
    std::vector<PoseScript> hands;
    for (const Motion& motion : motions) hands.push_back(motion.of(model));
    return hands;
  });
  const double expert = report.grades.at(0).value().points;
  EXPECT_GE(expert, 88.0);
  EXPECT_FALSE(report.grades.at(1)) << "nothing was touched";
  double before = 0.0;
  std::string row = fmt::format("| `{}` | {:.0f} |", exercise.name, expert);
  for (std::size_t i = 0; i < motions.size(); ++i) {
    const double points = report.grades.at(i + 1) ? report.grades[i + 1]->points : 0.0;
    const std::string what = fmt::format("{}: {:.1f} points", motions[i].name, points);
    row += fmt::format(" {:.0f} |", points);
    EXPECT_LE(points, motions[i].most_points) << what;
    EXPECT_LE(points, expert + 1.0) << what;
    if (i >= kParts.size()) continue;
    EXPECT_GE(points, before) << what;
    before = points;
  }
  std::puts(row.c_str());  // of a table: what each motion earns
}

}  // namespace
}  // namespace palpate::test
