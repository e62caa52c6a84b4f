// Effects from users' libraries: loaded by scene files, run by the step, whatever they do.
#include "scenes/effects/effects.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/files/bundle_hash.h"
#include "common/math/rotation.h"
#include "scenes/catalogue.h"
#include "scenes/files/effect_file.h"
#include "scenes/files/scene_bundle.h"
#include "scenes/scene_verdict.h"
#include "server/physics/scene_model.h"
#include "server/session/servo_loop.h"
#include "tests/session/ball_tool.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/complaint.h"
#include "tests/support/effects_scene.h"
#include "tests/support/folder.h"

namespace palpate::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr const char* kWrong = PALPATE_WRONG_EFFECT;

std::string Wrong(int way, int from_cycle = 0) {
  return std::string(R"({"name": ")") + kWrong + R"(", "way": )" + std::to_string(way) +
         R"(, "from_cycle": )" + std::to_string(from_cycle) + "}";
}

class EffectsTest : public testing::Test {
 protected:
  /// The catalogue's cube with effects.
  std::string File(const std::string& effects) const {
    const std::string file = folder_ / "mine.json";
    std::ofstream(file) << CubeWithEffects(effects);
    return file;
  }
  Scene Load(const std::string& effects) const { return LoadScene(File(effects)); }
  std::string LoadError(const std::string& effects) const {
    return ComplaintOf([&] { Load(effects); });
  }

  const Folder folder_;
  const TrustedEffects trusted_{folder_.path() + ":" PALPATE_TEST_EFFECTS ":" +
                                std::filesystem::path(PALPATE_NO_EFFECT).parent_path().string()};
};

/// A loop in free space, in the state a session starts it in.
struct Loop {
  explicit Loop(const Scene& scene)
      : model(MakeModel(scene, scene.tools[0], MakeObjects(scene))), loop(model) {
    loop.Start({kFree, Quat::Identity()});
  }
  wire::Wrench At(const Vec3& p) {
    wire::Wrench answer{};
    EXPECT_TRUE(loop.OnPose(hand.At(p), answer));
    return answer;
  }
  LoopCounters Counters() {
    loop.RequestCounters();
    At(kFree);
    LoopCounters counters;
    EXPECT_TRUE(loop.ReadCounters(counters));
    return counters;
  }

  static inline const Vec3 kFree{0.0, 0.04, 0.0};
  HapticModel model;
  ServoLoop loop;
  Hand hand;
};

TEST_F(EffectsTest, ShippedOnesActByTheirParameters) {
  Loop viscous(Load(R"({"name": "viscous", "damping_N_s_per_m": 5})"));
  Loop forbidden(Load(R"({"name": "forbidden", "centre_mm": [0, 30, 0], "radius_mm": 12,
                          "stiffness_N_per_m": 1000})"));
  Loop magnet(Load(R"({"name": "magnet", "curve_mm": [[-9, 50, 0], [9, 50, 0], [9, 50, 9]],
                       "reach_mm": 20, "force_N": 2})"));
  Loop spring(Load(R"({"name": "moving_spring", "from_mm": [0, 40, 0], "to_mm": [10, 40, 0],
                       "period_s": 1, "stiffness_N_per_m": 100, "most_N": 5})"));
  Loop stick(Load(R"({"name": "stick", "force_N": 0.5, "stiffness_N_per_m": 1000})"));
  Loop vibration(Load(R"({"name": "vibration", "along": [0, 0, 1], "force_N": 0.3,
                          "rate_Hz": 50})"));
  for (int i = 1; i <= 501; ++i) {
    const Vec3 moving(1e-5 * i, 0.04, 0.0);  // 10 mm/s
    const wire::Wrench brakes = viscous.At(moving);
    const wire::Wrench pushes = forbidden.At(Loop::kFree), draws = magnet.At(Loop::kFree);
    const wire::Wrench leads = spring.At(Loop::kFree), sticks = stick.At(moving);
    const wire::Wrench shakes = vibration.At(Loop::kFree);
    if (i < 300) continue;
    ASSERT_NEAR(brakes.force_N[0], -0.05, 1e-9);
    ASSERT_NEAR(pushes.force_N[1], 2.0, 1e-9);
    ASSERT_NEAR(draws.force_N[1], 2.0, 1e-9);
    ASSERT_NEAR(sticks.force_N[0], -0.5, 1e-9);
    if (i == 501) {
      ASSERT_NEAR(leads.force_N[0], 1.0, 1e-9) << "half a period after cycle 0";
    }
    ASSERT_LE(std::abs(shakes.force_N[2]), 0.3 + 1e-12);
    // In rows after the contacts', one for passive and one for active effects.
    ASSERT_NEAR(pushes.passive_force_N[1], 2.0, 1e-9);
    ASSERT_NEAR(draws.active_force_N[1], 2.0, 1e-9);
    ASSERT_EQ(draws.passive_force_N[1], 0.0);
  }
}

TEST_F(EffectsTest, StandInTheRowOfWhatTheyPromiseAndRampInAndFadeWithTheForce) {
  Loop loop(Load(R"({"name": "viscous", "damping_N_s_per_m": 5, "damping_Nm_s_per_rad": 0.02},
      {"name": "moving_spring", "from_mm": [0, 40, 0], "to_mm": [10, 40, 0], "period_s": 1,
       "stiffness_N_per_m": 100, "most_N": 5})"));
  constexpr double kTurn_rad_s = 0.5;
  wire::Wrench answer{};
  const auto at = [&](int i, double z) {
    wire::HapticPose pose = loop.hand.At(Vec3(0.0, 0.04 + 2e-5 * i, z));
    wire::FromPose({wire::ToVec3(pose.position_m), RotationExp({0.0, 0.0, 1e-3 * kTurn_rad_s * i})},
                   pose.position_m, pose.orientation_wxyz);
    EXPECT_TRUE(loop.loop.OnPose(pose, answer));
  };
  const auto expect = [&](int i, double gain) {
    const double s = 1.0 - std::abs(2e-3 * i - 1.0), share = s * s * (3.0 - 2.0 * s);
    const double passive[6] = {0.0, -5.0 * 0.02, 0.0, 0.0, 0.0, -0.02 * kTurn_rad_s};
    const double active[6] = {100.0 * 0.01 * share, -100.0 * 2e-5 * i, 0.0, 0.0, 0.0, 0.0};
    for (int k = 0; k < 6; ++k) {
      const auto part = [k](const auto& force, const auto& torque) {
        return k < 3 ? force[k] : torque[k - 3];
      };
      ASSERT_NEAR(part(answer.passive_force_N, answer.passive_torque_Nm), gain * passive[k], 1e-8);
      ASSERT_NEAR(part(answer.active_force_N, answer.active_torque_Nm), gain * active[k], 1e-12);
      const double sum = k < 3 ? answer.force_N[k] : answer.torque_Nm[k - 3];
      ASSERT_NEAR(sum, gain * (passive[k] + active[k]), 1e-8) << k;
    }
  };
  for (int i = 0; i < 600; ++i) {
    at(i, 0.0);
    if (i > 100) expect(i, std::min(1.0, (i + 1) / 200.0));
  }
  for (int n = 1; n <= 3; ++n) {
    at(600, 1e9);  // not a pose of a hand: the last wrench fades
    expect(599, 1.0 - n / 20.0);
  }
}

TEST_F(EffectsTest, ActAtTheToolsOriginWhereverItsReferenceIs) {
  const palpate_effect pull{
      .abi = 1, .passive = 0, .parameters = {}, .step = [](auto*, double*, auto* out) {
        out->force_N[1] = 2.0;
        return 0;
      }};
  const Effects effects({Effect{"pull", 0, {}, &pull}});
  EffectState state = effects.Begin();
  EffectWrenches given;
  const Quat turned(Eigen::AngleAxisd(0.5 * std::numbers::pi, Vec3::UnitZ()));
  ASSERT_TRUE(effects.Step({Vec3::Zero(), turned}, {}, Vec3(0.0, 0.0, 0.1), state, given));
  EXPECT_TRUE(given.active.force.isApprox(Vec3(0.0, 2.0, 0.0)));
  EXPECT_TRUE(given.active.torque.isApprox(Vec3(0.2, 0.0, 0.0)));
}

TEST_F(EffectsTest, TellTheTwistSmoothlyAndNoneOfALeap) {
  static double seen[6];
  const palpate_effect look{
      .abi = 1, .passive = 0, .parameters = {}, .step = [](auto* in, double*, auto*) {
        for (int i = 0; i < 3; ++i) seen[i] = in->velocity_m_s[i], seen[3 + i] = in->turn_rad_s[i];
        return 0;
      }};
  const Effects effects({Effect{"look", 0, {}, &look}});
  EffectState state = effects.Begin();
  for (int i = 0; i < 200; ++i) {
    EffectWrenches given;
    const double t = 1e-3 * i;
    effects.Step(
        {Vec3(5.0 + 0.2 * t, 0.0, -0.1 * t), Quat(Eigen::AngleAxisd(3.0 * t, Vec3::UnitX()))}, {},
        Vec3::Zero(), state, given);
    if (i == 0) {
      EXPECT_EQ(seen[0], 0.0) << "where it was before is not known";
    }
  }
  EXPECT_NEAR(seen[0], 0.2, 1e-9);
  EXPECT_NEAR(seen[2], -0.1, 1e-9);
  EXPECT_NEAR(seen[3], 3.0, 1e-5);
  EffectWrenches given;
  effects.Step({Vec3(6.0, 0.0, 0.0), Quat::Identity()}, {}, Vec3::Zero(), state, given);
  EXPECT_EQ(seen[0], 0.0);
}

TEST_F(EffectsTest, IsOffOnceItFailedAndItsFaultIsCountedOnce) {
  for (const int way : {1, 2, 3, 4, 5}) {
    SCOPED_TRACE(way);
    Loop loop(Load(Wrong(way, 250) + R"(, {"name": "forbidden", "centre_mm": [0, 30, 0],
                                          "radius_mm": 12, "stiffness_N_per_m": 1000})"));
    wire::Wrench answer{};
    for (int i = 0; i < 250; ++i) {
      answer = loop.At(Loop::kFree);
      ASSERT_EQ(answer.faults, kFaultNone);
    }
    EXPECT_EQ(answer.force_N[0], 0.25);
    answer = loop.At(Loop::kFree);
    EXPECT_EQ(answer.faults, kFaultEffect);
    for (int i = 0; i < 300; ++i) {
      EXPECT_EQ(answer.force_N[0], 0.0);
      EXPECT_NEAR(answer.force_N[1], 2.0, 1e-9) << "the other goes on";
      answer = loop.At(Loop::kFree);
      ASSERT_EQ(answer.faults, kFaultNone);
    }
    const LoopCounters counters = loop.Counters();
    EXPECT_EQ(counters.faulted_steps, 1u);
    EXPECT_EQ(FaultWords(counters.faults), "effect off");
  }
}

TEST_F(EffectsTest, LeaveContactAsItIsAndItsRowsToTheStation) {
  Loop without(Load("")), with(Load(R"({"name": "vibration"}, {"name": "viscous"})"));
  for (int i = 0; i < 400; ++i) {
    const Vec3 p(1e-5 * i, 0.029, 0.0);
    const wire::Wrench own = without.At(p), answer = with.At(p);
    for (int k = 0; k < 3; ++k) {
      const double given = answer.passive_force_N[k] + answer.active_force_N[k];
      ASSERT_NEAR(answer.force_N[k] - given, own.force_N[k], 1e-12);
      ASSERT_EQ(answer.graphic_position_m[k], own.graphic_position_m[k]);
    }
    ASSERT_EQ(answer.rows, own.rows);
    ASSERT_EQ(answer.row_force_N[0], own.row_force_N[0]);
    ASSERT_TRUE(i <= 250 || answer.rows == 1);
  }
}

TEST_F(EffectsTest, AllocateNothingInTheLoopWhateverTheyDo) {
  if (!kCountsAllocations) GTEST_SKIP() << "a sanitizer brings an allocator of its own";
  Loop loop(Load(Wrong(1, 100) + R"(, {"name": "stick"}, {"name": "viscous"})"));
  loop.At(Loop::kFree);
  const std::uint64_t before = AllocationsOfThisThread();
  for (int i = 0; i < 500; ++i) loop.At(Vec3(1e-5 * i, 0.04, 0.0));
  EXPECT_EQ(AllocationsOfThisThread(), before);
}

TEST_F(EffectsTest, GoOnFromACopyOfTheirState) {
  const Scene scene = Load(R"({"name": "stick"}, {"name": "moving_spring", "from_mm": [0, 40, 0],
                               "to_mm": [10, 40, 0]}, {"name": "viscous"})");
  const HapticModel model = MakeModel(scene, scene.tools[0], MakeObjects(scene));
  StepWorkspace workspace(model);
  StepState state(model), kept(model);
  state.X_WG.p = Loop::kFree;
  const auto at = [](int i) {
    return Pose{Vec3(3e-5 * (i % 70), 0.04, 1e-5 * i), Quat::Identity()};
  };
  for (int i = 0; i < 333; ++i) HapticStep(model, at(i), state, workspace);
  kept = state;
  std::vector<Wrench> first;
  for (int i = 333; i < 600; ++i)
    first.push_back(HapticStep(model, at(i), state, workspace).wrench);
  for (int i = 333; i < 600; ++i) {
    const Wrench again = HapticStep(model, at(i), kept, workspace).wrench;
    ASSERT_EQ(again.force, first[static_cast<std::size_t>(i - 333)].force);
    ASSERT_FALSE(again.force.isZero(0.0));
  }
}

TEST_F(EffectsTest, HoldWhatPassiveOnesPromise) {
  for (const char* passive :
       {R"({"name": "viscous", "damping_Nm_s_per_rad": 0.01})", R"({"name": "stick"})",
        R"({"name": "forbidden", "radius_mm": 30, "stiffness_N_per_m": 2000})"}) {
    const Scene scene = Load(passive);
    ASSERT_NE(scene.effects[0].of->passive, 0);
    EXPECT_LE(EnergyGiven(scene.effects[0], Vec3::Zero(), 0.05), kNoEnergy) << passive;
    EXPECT_TRUE(JudgeEffects(scene).usable());
  }
  const Verdict swirls = JudgeEffects(Load(Wrong(6)));
  ASSERT_EQ(swirls.faults.size(), 1u);
  EXPECT_THAT(swirls.faults[0], AllOf(HasSubstr("claims to be passive, but gives the hand"),
                                      HasSubstr("omit .passive")));
  EXPECT_THAT(JudgeEffects(Load(Wrong(4))).faults.at(0), HasSubstr("failed"));
  // Only somewhere: the energy is summed along many more paths than the others are tried on.
  EXPECT_FALSE(JudgeEffects(Load(Wrong(4, 5000))).usable());
  // Effects that rightly make no such promise.
  for (const char* active :
       {R"({"name": "moving_spring", "from_mm": [-20, 0, 0], "to_mm": [20, 0, 0]})",
        R"({"name": "vibration", "rate_Hz": 50})"}) {
    const Scene scene = Load(active);
    EXPECT_EQ(scene.effects[0].of->passive, 0);
    EXPECT_GT(EnergyGiven(scene.effects[0], Vec3::Zero(), 0.05), kNoEnergy) << active;
  }
}

TEST_F(EffectsTest, AreNotUsableIfTheyFailCrashTakeLongOrGiveOtherBits) {
  // By wrong_effect.cpp's ways, from the first cycle and from a later one.
  for (const auto& [way, word] : {std::pair{1, "not finite"},
                                  {2, "not finite"},
                                  {3, "beyond"},
                                  {4, "returned"},
                                  {5, "exception"},
                                  {7, "step crashed"},
                                  {8, "of the loop's millisecond"},
                                  {9, "same arguments"},
                                  {10, "same arguments"},
                                  {11, "ended the process"}}) {
    const Verdict verdict = JudgeEffects(Load(Wrong(way, 100)));
    ASSERT_EQ(verdict.faults.size(), 1u) << way;
    EXPECT_THAT(verdict.faults[0], HasSubstr(word)) << way;
  }
}

TEST_F(EffectsTest, SaysWithLineAndFieldWhatAnEntryLacks) {
  EXPECT_THAT(LoadError(R"({"name": "viscus"})"),
              AllOf(HasSubstr("mine.json:2: effects[0].name: there is no effect \"viscus\""),
                    HasSubstr(" viscous"), HasSubstr("has a / or ends in .so, and counts")));
  EXPECT_THAT(LoadError(R"({"name": "viscous", "damping_N_s_per_metre": 1})"),
              AllOf(HasSubstr("damping_N_s_per_metre"), HasSubstr("damping_N_s_per_m\"")));
  EXPECT_THAT(LoadError(R"({"name": "viscous", "damping_N_s_per_m": 1000})"),
              AllOf(HasSubstr("effects[0].damping_N_s_per_m: "), HasSubstr("20")));
  EXPECT_THAT(LoadError(R"({"name": "viscous", "damping_N_s_per_m": "much"})"),
              HasSubstr("effects[0].damping_N_s_per_m: "));
  EXPECT_THAT(LoadError(R"({"name": "viscous", "damping_N_s_per_m": [1, 2, 3]})"),
              HasSubstr("effects[0].damping_N_s_per_m: "));
  EXPECT_THAT(LoadError(R"({"name": "forbidden", "radius_mm": 1, "centre_mm": [1, 2]})"),
              HasSubstr("effects[0].centre_mm: is no point; give [x, y, z]"));
  EXPECT_THAT(LoadError(R"({"name": "forbidden"})"), HasSubstr("radius_mm"));
  EXPECT_THAT(LoadError(R"({"name": "magnet", "curve_mm": [[1, 2, 3]]})"),
              HasSubstr("effects[0].curve_mm"));
  EXPECT_THAT(LoadError(R"({"damping_N_s_per_m": 1})"), HasSubstr("effects[0]"));
  EXPECT_THAT(
      LoadError(R"({"name": "sub/mine.so"})"),
      AllOf(HasSubstr(folder_.path() + "/sub/mine.so"), HasSubstr("counts from the scene file")));
}

TEST_F(EffectsTest, SaysWhyAFileIsNoEffect) {
  EXPECT_THAT(LoadError(R"({"name": ")" PALPATE_NO_EFFECT R"("})"),
              AllOf(HasSubstr("effects[0].name: no effect could be loaded"),
                    HasSubstr("build it as a shared object"), HasSubstr(PALPATE_NO_EFFECT)));
  EXPECT_THAT(LoadError(R"({"name": ")" PALPATE_EFFECT_WITHOUT_SYMBOL R"("})"),
              HasSubstr("has no palpate_the_effect; define that"));
  EXPECT_THAT(LoadError(R"({"name": ")" PALPATE_EFFECT_OF_TOMORROW R"("})"),
              AllOf(HasSubstr("palpate_the_effect.abi is 1000 but this version supports 1 to 1; "
                              "build it with the "),
                    HasSubstr("build it with the palpate_effect.h of this version")));
}

TEST_F(EffectsTest, IsFoundBesideTheSceneFileAndRefusedOnceItsFileHasChanged) {
  const std::string mine = folder_ / "mine.so";
  std::filesystem::copy(kWrong, mine);
  Scene scene = Load(R"({"name": "mine.so"})");
  EXPECT_EQ(scene.effects.at(0).file, "mine.so");
  const std::uint64_t hash = BundleHash(PackScene(scene));
  EXPECT_NE(hash, BundleHash(PackScene(Load(R"({"name": "mine.so", "way": 1})"))));
  scene.effects[0].hash ^= 1;
  EXPECT_NE(hash, BundleHash(PackScene(scene))) << "the file's content counts";
  std::filesystem::remove(mine);
  std::filesystem::copy(PALPATE_BIN_DIR "/effects/stick.so", mine);
  EXPECT_THAT(LoadError(R"({"name": "mine.so"})"), HasSubstr("restart the program"));
}

TEST_F(EffectsTest, BundleLoadsTheSameFileAndRefusesAnother) {
  const std::string bundle = folder_ / "mine.palpate", mine = folder_ / "mine.so";
  std::filesystem::create_directory(folder_ / "made");
  std::filesystem::copy(kWrong, folder_ / "made/mine.so");
  const Scene scene = [&] {
    const TrustedEffects made(folder_ / "made");
    return Load(R"({"name": "made/mine.so", "from_cycle": 7},
                   {"name": "magnet", "curve_mm": [[0, 0, 0], [1, 1, 1]]})");
  }();
  WriteBytes(bundle, PackScene(scene));
  const auto error = [&] { return ComplaintOf([&] { LoadScene(bundle); }); };
  EXPECT_THAT(error(), AllOf(HasSubstr("mine.palpate: was made with an effect mine.so of the hash"),
                             HasSubstr("which was not found; give the folder")));
  std::filesystem::copy(PALPATE_BIN_DIR "/effects/stick.so", mine);
  EXPECT_THAT(error(), HasSubstr(mine + " is another one (hash "));
  const TrustedEffects made("/nowhere:" + (folder_ / "made"));
  const Scene loaded = LoadScene(bundle);
  ASSERT_EQ(loaded.effects.size(), 2u);
  EXPECT_EQ(loaded.effects[0].values, scene.effects[0].values);
  EXPECT_EQ(loaded.effects[1].values, scene.effects[1].values);
  EXPECT_EQ(loaded.effects[0].of, scene.effects[0].of);
  EXPECT_EQ(PackScene(loaded), PackScene(scene));
}

TEST(UntrustedEffects, AreNotRunFromBesideASceneABundleOrByALink) {
  const Folder stranger, own;
  const std::string effect = stranger / "mine.so", scene = stranger / "mine.json",
                    bundle = stranger / "mine.palpate";
  std::filesystem::copy(kWrong, effect);
  const auto load_as = [&](const std::string& name) {
    std::ofstream(scene) << CubeWithEffects(R"({"name": ")" + name + "\"}");
    return LoadScene(scene);
  };
  {
    const TrustedEffects trusted(stranger.path());
    WriteBytes(bundle, PackScene(load_as("mine.so")));
  }
  const auto is_refused = [&](const std::string& file) {
    return AllOf(HasSubstr(file), HasSubstr("--effects "), HasSubstr(stranger.path()));
  };
  std::filesystem::create_directory(stranger / "below");
  std::filesystem::copy(effect, stranger / "below/mine.so");
  std::filesystem::create_symlink(std::filesystem::absolute(kWrong), stranger / "link.so");
  for (const std::string& folders :
       {std::string(), std::string(":"), own.path(), stranger / "nowhere", own / "../"}) {
    SCOPED_TRACE(folders);
    const TrustedEffects trusted(folders);
    for (const std::string& name :
         {std::string("mine.so"), std::string("./mine.so"), effect, std::string("link.so"),
          std::string("below/mine.so"), std::string("below/../mine.so")}) {
      EXPECT_THAT(ComplaintOf([&] { load_as(name); }),
                  AllOf(HasSubstr("effects[0].name"), is_refused(name)));
    }
    EXPECT_THAT(ComplaintOf([&] { LoadScene(bundle); }), is_refused(effect));
  }
  const TrustedEffects trusted(stranger.path() + "/");
  EXPECT_EQ(LoadScene(bundle).effects.at(0).file, "mine.so");
  EXPECT_THAT(ComplaintOf([&] { load_as("below/mine.so"); }), HasSubstr("--effects "));
  std::ofstream(own / "mine.json") << CubeWithEffects(R"({"name": "mine.so"})");
  EXPECT_EQ(LoadScene(own / "mine.json").effects.at(0).file, "mine.so") << "of a trusted folder";
}

TEST_F(EffectsTest, NeedsNoneOfThemToDrawASceneAndSaysSoToWhoWouldFeelIt) {
  const std::vector<std::uint8_t> bytes = PackScene(Load(R"({"name": "viscous"})"));
  Scene drawn = UnpackScene(bytes, "it");
  EXPECT_EQ(drawn.effects.at(0).of, nullptr);
  const auto error = [&] {
    return ComplaintOf([&] { MakeModel(drawn, drawn.tools[0], MakeObjects(drawn)); });
  };
  EXPECT_THAT(error(), HasSubstr("effect viscous.so: is not loaded"));
  LoadEffects(drawn.effects, ".", "it");
  EXPECT_EQ(error(), "no complaint");
  drawn.effects[0].values[0][0] = std::nan("");
  EXPECT_THAT(error(), HasSubstr("its parameters do not match the effect"));
}

}  // namespace
}  // namespace palpate::test
