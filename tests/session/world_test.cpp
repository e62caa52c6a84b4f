#include "server/session/world.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <random>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "common/dds/wire.h"
#include "common/math/rotation.h"
#include "scenes/shapes/shapes.h"
#include "server/physics/scene_model.h"
#include "server/session/servo_loop.h"
#include "tests/session/ball_tool.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/mesh_oracle.h"
#include "tests/support/test_scenes.h"

namespace palpate::test {
namespace {

Pose At(double x, double z) {
  return {Vec3(x, 0.0, z), Quat::Identity()};
}

/// Boxes far above a floor.
Scene Boxes(std::size_t count, const Vec3& size = Vec3(0.02, 0.02, 0.01)) {
  Scene scene;
  for (std::size_t i = 0; i < count; ++i) {
    scene.tools.push_back(MakeMeshBody("box-" + std::to_string(i), MakeBox(size)));
  }
  scene.objects.push_back(MakeMeshBody("floor", MakeBox(Vec3(0.2, 0.2, 0.01)), At(0.0, -0.105)));
  scene.features.contact = ContactModel::kSurface;
  scene.hands_meet = true;
  return scene;
}

/// The hands of a scene, each with its loop, all in one world.
class Hands {
 public:
  explicit Hands(Scene scene) : scene_(std::move(scene)) {
    const auto objects = MakeObjects(scene_);
    std::vector<const HapticModel*> of_world;
    for (const Body& tool : scene_.tools) {
      models_.push_back(std::make_unique<HapticModel>(MakeModel(scene_, tool, objects)));
      of_world.push_back(models_.back().get());
    }
    world_ = std::make_shared<World>(of_world);
    for (std::size_t i = 0; i < models_.size(); ++i) Renew(i);
  }

  /// Gives a tool another hand, as a session that follows another.
  void Renew(std::size_t i) {
    loops_.resize(std::max(loops_.size(), i + 1));
    clocks_.resize(loops_.size());
    loops_[i] = std::make_unique<ServoLoop>(world_, i);
    clocks_[i] = Hand{};
  }
  wire::Wrench Send(std::size_t i, const Pose& X_WH) {
    wire::HapticPose pose = clocks_[i].At(X_WH.p);
    wire::FromPose(X_WH, pose.position_m, pose.orientation_wxyz);
    return SendAsItIs(i, pose);
  }
  wire::Wrench SendAsItIs(std::size_t i, const wire::HapticPose& pose) {
    wire::Wrench answer{};
    EXPECT_TRUE(loops_[i]->OnPose(pose, answer));
    return answer;
  }
  /// Begins the forces of a hand, and moves it until they are full.
  void Begin(std::size_t i, const Pose& X) {
    loop(i).Start(X);
    for (int k = 0; k < 220; ++k) Send(i, X);
  }
  /// Begins with two hands, box 0 above box 1, 2 mm into each other: 1 N by both springs.
  void Press() {
    loop(0).Start(At(0.0, 0.011));
    loop(1).Start(At(0.0, 0.0));
    for (int k = 0; k < 400; ++k) {
      Send(0, At(0.0, 0.0108 - std::min(k, 280) * 1e-5));
      Send(1, At(0.0, 0.0));
    }
  }
  /// Returns how far the first free body has moved.
  Vec3 Block() {
    LoopSnapshot snapshot;
    EXPECT_TRUE(loop(0).ReadSnapshot(snapshot));
    return snapshot.X_moved[0].p;
  }
  ServoLoop& loop(std::size_t i) { return *loops_[i]; }
  Hand& clock(std::size_t i) { return clocks_[i]; }
  World& world() { return *world_; }
  const std::shared_ptr<World>& world_of_all() const { return world_; }
  const Scene& scene() const { return scene_; }
  const HapticModel& model(std::size_t i) const { return *models_[i]; }

 private:
  Scene scene_;
  std::vector<std::unique_ptr<HapticModel>> models_;
  std::shared_ptr<World> world_;
  std::vector<std::unique_ptr<ServoLoop>> loops_;
  std::vector<Hand> clocks_;
};

// Springs in series: half of k d on each side, whoever speaks first.
TEST(World, LetsTwoHandsFeelEachOther) {
  Hands hands(Boxes(2));
  hands.Press();
  const wire::Wrench upper = hands.Send(0, At(0.0, 0.008)), lower = hands.Send(1, At(0.0, 0.0));
  EXPECT_NEAR(upper.force_N[2], 1.0, 2e-3);
  EXPECT_NEAR(upper.force_N[2] + lower.force_N[2], 0.0, 1e-9);
  EXPECT_EQ(upper.hands, 3u);
  EXPECT_EQ(lower.step, upper.step + 1);
  EXPECT_GT(upper.contacts, 0u);
  EXPECT_EQ(upper.rows, 0u) << "a station alone cannot know how the other gives way";
}

/// A floor with a free block on it, beside which the hands' boxes come down.
Scene WithABlock(std::size_t hands) {
  Scene scene = Boxes(hands);
  scene.hands_meet = hands > 1;
  scene.gravity = Vec3(0.0, 0.0, -9.81);
  scene.features.friction = FrictionModel::kCoulomb;
  scene.objects[0].materials[0] = {.static_friction = 0.4, .dynamic_friction = 0.4};
  Body block = MakeMeshBody("block", MakeBox(Vec3(0.02, 0.02, 0.01)), At(0.03, -0.09499));
  block.moved = 1;
  const double mass = 0.1, wide = mass / 12.0 * 5e-4, flat = mass / 12.0 * 8e-4;
  scene.moved.push_back(
      {.name = "block",
       .free = FreeBody{mass, block.X_WB.p, Vec3(wide, wide, flat).asDiagonal(), {}}});
  scene.objects.push_back(std::move(block));
  return scene;
}

// A lone hand pushes it along; a hand that begins again finds it where it was placed; and the same
// poses give the same bits.
TEST(World, LetsAHandPushAFreeBody) {
  Hands hands(WithABlock(1)), again(WithABlock(1));
  for (int session = 0; session < 2; ++session) {
    for (int i = 0; i < 1500; ++i) {
      for (Hands* of : {&hands, &again}) {
        if (i == 0) of->loop(0).Start(At(0.0, -0.094));
      }
      const Pose at = At(1.5e-5 * i, -0.094);
      const wire::Wrench felt = hands.Send(0, at), same = again.Send(0, at);
      for (int k = 0; k < 3; ++k) ASSERT_EQ(felt.force_N[k], same.force_N[k]) << i;
      if (i == 500) {
        EXPECT_EQ(felt.force_N[0], 0.0) << "nothing is near";
        EXPECT_NEAR(hands.Block().x(), 0.0, 1e-6);
      }
      if (i == 1499) {
        EXPECT_NEAR(hands.Block().x(), 0.0125 - 0.4e-3, 1e-4) << "mu m g of its spring";
      }
    }
  }
}

// While both hands are there, half a millisecond passes with a pose of either.
TEST(World, LetsFreeBodiesFallAsFastWithTwoHandsAsWithOne) {
  for (const std::size_t count : {1u, 2u}) {
    Scene scene = WithABlock(count);
    scene.objects.back().X_WB.p.z() = -0.05;
    scene.moved[0].free->centre.z() = -0.05;
    Hands hands(std::move(scene));
    for (std::size_t k = 0; k < count; ++k) hands.loop(k).Start(At(0.1 * (1.0 + k), 0.0));
    for (int i = 0; i < 60; ++i) {
      for (std::size_t k = 0; k < count; ++k) hands.Send(k, At(0.1 * (1.0 + k), 0.0));
    }
    const double fallen = hands.Block().z();
    EXPECT_NEAR(fallen, -0.5 * 9.81 * 0.06 * 0.06, 6e-4) << count;
  }
}

// To the last bit: a scene with two tools costs a lone hand nothing but room.
TEST(World, IsThatOfOneToolWhereNoOtherHandIs) {
  for (const std::size_t number : {0u, 1u}) {
    Hands hands(Boxes(2));
    Scene alone = Boxes(2);
    alone.hands_meet = false;
    const HapticModel model = MakeModel(alone, alone.tools[number], MakeObjects(alone));
    ServoLoop loop(model);
    Hand hand;
    const auto at = [](int i) {
      const double t = 1e-3 * i;
      return Pose{Vec3(0.02 * std::sin(5.0 * t), 0.0, -0.094 + 0.003 * std::sin(9.0 * t)),
                  RotationExp(Vec3(0.1 * std::sin(3.0 * t), 0.0, 0.2 * t))};
    };
    hands.loop(number).Start(At(0.0, -0.09));
    loop.Start(At(0.0, -0.09));
    for (int i = 0; i < 1500; ++i) {
      const wire::Wrench in_world = hands.Send(number, at(i));
      wire::HapticPose pose = hand.At(at(i).p);
      wire::FromPose(at(i), pose.position_m, pose.orientation_wxyz);
      wire::Wrench answer{};
      ASSERT_TRUE(loop.OnPose(pose, answer));
      for (int k = 0; k < 3; ++k) {
        ASSERT_EQ(answer.force_N[k], in_world.force_N[k]) << i;
        ASSERT_EQ(answer.torque_Nm[k], in_world.torque_Nm[k]) << i;
        ASSERT_EQ(answer.graphic_position_m[k], in_world.graphic_position_m[k]) << i;
      }
      ASSERT_EQ(answer.rows, in_world.rows) << i;
    }
  }
}

/// How the other hand of a pressing pair dies.
enum class Death { kSilent, kNotFinite, kJumps };

// The force on the living hand goes to nothing without a step, and its tool then is where it is.
TEST(World, LetsGoOfAHandThatDies) {
  for (const Death death : {Death::kSilent, Death::kNotFinite, Death::kJumps}) {
    for (const std::size_t dies : {0u, 1u}) {
      Hands hands(Boxes(2));
      hands.Press();
      const std::size_t lives = 1 - dies;
      const Pose X = lives == 0 ? At(0.0, 0.008) : At(0.0, 0.0);
      double before = hands.Send(lives, X).force_N[2];
      int faded_after = 0;
      for (int i = 1; i <= 100; ++i) {
        if (death != Death::kSilent) {
          wire::HapticPose pose = hands.clock(dies).At(Vec3(0.0, 0.0, 0.5));
          if (death == Death::kNotFinite) {
            pose.position_m[0] = std::numeric_limits<double>::quiet_NaN();
          }
          const wire::Wrench answer = hands.SendAsItIs(dies, pose);
          EXPECT_LE(std::abs(answer.force_N[2]), 1.0 + 1e-2);
        }
        const wire::Wrench answer = hands.Send(lives, X);
        const double force = answer.force_N[2];
        ASSERT_LE(std::abs(force - before), 0.12) << i;  // a twentieth of k d, 2 N, and its own
        ASSERT_LE(std::abs(force), std::abs(before) + 1e-9) << i;
        before = force;
        if (force == 0.0 && faded_after == 0) faded_after = i;
        if (faded_after > 0) {
          ASSERT_EQ(answer.hands, 1u << lives);
        }
      }
      EXPECT_GT(faded_after, 0) << int(death);
      EXPECT_LE(faded_after, int(World::kPatience) + 21) << int(death);
      // Until it begins again, in a free place, it feels nothing and is nowhere.
      wire::Wrench answer = hands.Send(dies, At(0.3, 0.0));
      EXPECT_NE(answer.faults & kFaultNotStarted, 0u);
      EXPECT_EQ(answer.force_N[2], 0.0);
      EXPECT_EQ(hands.loop(dies).voids(), 1u);
    }
  }
}

TEST(World, LetsNoToolBeginInAnother) {
  Hands hands(Boxes(2));
  hands.Begin(0, At(0.0, 0.0));
  for (const double z : {0.0, 0.009, 0.0099}) {
    const std::uint32_t voids = hands.loop(1).voids();
    hands.loop(1).Start(At(0.0, z));
    EXPECT_NE(hands.Send(1, At(0.0, z)).faults & kFaultNotStarted, 0u) << z;
    EXPECT_EQ(hands.loop(1).voids(), voids + 1);
    EXPECT_EQ(hands.loop(1).start_sequence(), 0u);
    EXPECT_EQ(hands.Send(0, At(0.0, 0.0)).force_N[2], 0.0);
  }
  hands.loop(1).Start(At(0.0, 0.0101));
  const wire::Wrench answer = hands.Send(1, At(0.0, 0.0101));
  EXPECT_EQ(answer.faults, 0u);
  EXPECT_EQ(answer.hands, 3u);
  EXPECT_NE(hands.loop(1).start_sequence(), 0u);
}

// A hand that has lost its tool to another never gets that one's force.
TEST(World, SendsNothingToAHandWhoseToolAnotherHolds) {
  Hands hands(Boxes(2));
  hands.Press();
  for (int i = 0; i < 100; ++i) hands.Send(0, At(0.0, 0.008));
  EXPECT_NE(hands.Send(1, At(0.0, 0.0)).faults & kFaultNotStarted, 0u);
  ServoLoop next(hands.world_of_all(), 1);
  Hand clock;
  next.Start(At(0.05, 0.0));
  wire::Wrench answer{};
  for (int i = 0; i < 220; ++i) next.OnPose(clock.At(Vec3(0.05, 0.0, 0.0)), answer);
  EXPECT_EQ(answer.hands, 2u) << "the upper hand has been silent";
  wire::HapticPose bad = hands.clock(1).At(Vec3::Zero());
  bad.position_m[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(hands.SendAsItIs(1, bad).force_N[2], 0.0);
}

// A small tool inside a hollow one would meet none of its triangles.
TEST(World, LetsNoToolBeginInsideAnotherWithoutTouchingIt) {
  for (const std::size_t large : {0u, 1u}) {
    Scene scene = Boxes(2);
    scene.tools[large] = MakeMeshBody("large", MakeBox(Vec3(0.1, 0.1, 0.1)));
    Hands hands(std::move(scene));
    hands.Begin(large, At(0.0, 0.0));
    hands.loop(1 - large).Start(At(0.0, 0.0));
    EXPECT_NE(hands.Send(1 - large, At(0.0, 0.0)).faults & kFaultNotStarted, 0u);
  }
}

// A session that ends says so: no patience, and nothing is left for the next ones to wait for.
TEST(World, FadesAHandThatLeavesAtOnceAndIsEmptyWhenAllHaveLeft) {
  Hands hands(Boxes(2));
  hands.Press();
  double before = hands.Send(0, At(0.0, 0.008)).force_N[2];
  const std::uint64_t steps = hands.world().steps();
  hands.loop(1).Leave();
  EXPECT_EQ(hands.world().steps(), steps + 1);
  EXPECT_EQ(hands.world().there(), 3u);
  for (int i = 0; i < 20; ++i) {
    const double force = hands.Send(0, At(0.0, 0.008)).force_N[2];
    ASSERT_LE(std::abs(force - before), 0.12) << i;
    before = force;
  }
  EXPECT_EQ(hands.world().there(), 1u);
  hands.loop(0).Leave();
  EXPECT_EQ(hands.world().there(), 0u);
  for (const std::size_t first : {0u, 1u}) {
    Hands pair(Boxes(2));
    pair.Press();
    pair.loop(first).Leave();
    pair.loop(1 - first).Leave();
    EXPECT_EQ(pair.world().there(), 0u);
  }
  hands.Renew(0);
  hands.loop(0).Leave();  // had no pose
  EXPECT_EQ(hands.world().steps(), steps + 22);
}

// A mouse is answered less often than an arm: it is slow, not dead.
TEST(World, WaitsForASlowHandAsLongAsItUsuallyTakes) {
  for (const int pause : {5, 20, 60}) {
    Hands hands(Boxes(2));
    hands.Begin(0, At(0.0, 0.011));
    hands.loop(1).Start(At(0.0, 0.0));
    for (int i = 0; i < 20000; ++i) {
      const wire::Wrench answer = hands.Send(0, At(0.0, 0.011 - std::min(i, 3000) * 1e-6));
      if (i % pause == 0) hands.Send(1, At(0.0, 0.0));
      if (i > 1000) {
        ASSERT_EQ(answer.hands, 3u) << pause << ' ' << i;
      }
    }
    EXPECT_EQ(hands.loop(1).voids(), 0u);
    EXPECT_NEAR(hands.Send(0, At(0.0, 0.008)).force_N[2], 1.0, 2e-3);
    for (int i = 0; i < 600 && hands.world().Holds(1, 2); ++i) hands.Send(0, At(0.0, 0.008));
    EXPECT_EQ(hands.Send(0, At(0.0, 0.008)).force_N[2], 0.0) << "and then it is dead";
  }
}

// A new session may come for a tool that its former hand still holds.
TEST(World, FadesTheFormerHandBeforeTheNextOneBegins) {
  Hands hands(Boxes(2));
  hands.Press();
  hands.Renew(1);
  double before = hands.Send(0, At(0.0, 0.008)).force_N[2];
  int begun_after = 0;
  for (int i = 1; i <= 100 && begun_after == 0; ++i) {
    hands.loop(1).Start(At(0.05, 0.0));
    const wire::Wrench next = hands.Send(1, At(0.05, 0.0));
    if ((next.faults & kFaultNotStarted) == 0) begun_after = i;
    const double force = hands.Send(0, At(0.0, 0.008)).force_N[2];
    ASSERT_LE(std::abs(force - before), 0.24) << i;  // poses of both count
    before = force;
  }
  EXPECT_GT(begun_after, int(World::kPatience) / 2);
  EXPECT_EQ(before, 0.0);
}

const Vec3 kSmall(0.012, 0.012, 0.008);

/// Three hands that swing through each other, with pauses, faults and jumps.
class Storm {
 public:
  struct Sent {
    std::size_t hand;
    wire::HapticPose pose;
    bool start;
    Pose X_start;
    wire::Wrench answer;
  };

  explicit Storm(std::uint32_t seed) : random_(seed) {}

  /// Does the same to other hands, and compares.
  static void Repeat(const std::vector<Sent>& all, std::size_t from, Hands& hands) {
    hands.world().BeginAt(all[from].answer.step - 1);
    for (std::size_t i = from; i < all.size(); ++i) {
      const Sent& sent = all[i];
      if (sent.start) hands.loop(sent.hand).Start(sent.X_start);
      wire::Wrench answer = hands.SendAsItIs(sent.hand, sent.pose);
      answer.step_time_s = sent.answer.step_time_s;
      answer.answer = sent.answer.answer;
      ASSERT_EQ(std::memcmp(&answer, &sent.answer, sizeof answer), 0) << i;
    }
  }
  std::vector<Sent> Run(Hands& hands, int poses) {
    std::vector<Sent> all;
    std::array<double, 3> away{};  // until when a hand sends nothing
    for (int i = 0; i < poses; ++i) {
      const auto hand = std::size_t(random_() % 3);
      const double t = 1e-3 * i / 3.0;
      if (random_() % 900 == 0) away[hand] = t + 0.1;
      if (t < away[hand]) continue;
      Sent sent{hand, hands.clock(hand).At(HandAt(t, hand).p), false, {}, {}};
      wire::FromPose(HandAt(t, hand), sent.pose.position_m, sent.pose.orientation_wxyz);
      if (random_() % 500 == 0) sent.pose.position_m[0] = 1e300;
      if (random_() % 700 == 0) hands.clock(hand).sequence += 3;
      if (!(hands.world().there() >> hand & 1u) && random_() % 10 == 0) {
        sent.start = true;
        sent.X_start = HandAt(t, hand);
        hands.loop(hand).Start(sent.X_start);
      }
      const std::uint64_t allocations = AllocationsOfThisThread();
      sent.answer = hands.SendAsItIs(hand, sent.pose);
      EXPECT_EQ(AllocationsOfThisThread(), allocations);
      all.push_back(sent);
    }
    return all;
  }

 private:
  static Pose HandAt(double t, std::size_t hand) {
    const double a = t + 2.1 * double(hand);
    return {Vec3(0.014 * std::sin(3.0 * a), 0.012 * std::cos(4.0 * a), 0.010 * std::sin(5.0 * a)),
            RotationExp(Vec3(0.3 * std::sin(2.0 * a), 0.4 * std::cos(a), 0.0))};
  }
  std::mt19937 random_;
};

TEST(World, NeverLetsToolsMeetAndGivesTheSameBitsForTheSameOrder) {
  for (const std::uint32_t seed : {1u, 2u}) {
    Hands hands(Boxes(3, kSmall)), same(Boxes(3, kSmall));
    const auto all = Storm(seed).Run(hands, 9000);
    int touched = 0, forces = 0, absent = 0;
    std::vector<std::unique_ptr<MeshOracle>> oracles;
    for (std::size_t b = 0; b < 3; ++b) {
      Scene pair = hands.scene();
      pair.objects = {pair.tools[b]};
      pair.tools.resize(1);
      oracles.push_back(std::make_unique<MeshOracle>(pair));
    }
    Storm::Repeat(all, 0, same);
    Hands again(Boxes(3, kSmall));
    std::array<Pose, 3> X_WG;
    for (const Storm::Sent& sent : all) {
      if (sent.start) again.loop(sent.hand).Start(sent.X_start);
      again.SendAsItIs(sent.hand, sent.pose);
      const std::uint32_t there = again.world().there();
      forces += Vec3(wire::ToVec3(sent.answer.force_N)).norm() > 0.1 ? 1 : 0;
      touched += sent.answer.contacts > 0 ? 1 : 0;
      absent += there != 7u ? 1 : 0;
      for (std::size_t a = 0; a < 3; ++a) X_WG[a] = again.world().state(a).X_WG;
      for (std::size_t a = 0; a < 3; ++a) {
        for (std::size_t b = a + 1; b < 3; ++b) {
          if ((there >> a & there >> b & 1u) == 0) continue;
          ASSERT_FALSE(oracles[b]->Meet(X_WG[b].Inverse() * X_WG[a])) << sent.answer.step;
        }
      }
    }
    EXPECT_GT(touched, 1000);
    EXPECT_GT(forces, 1000);
    EXPECT_GT(absent, 100);
  }
}

// A recording may begin in the middle: where no tool is there, nothing is left of what was.
TEST(World, RemembersNothingOfToolsThatAreNotThere) {
  Hands hands(Boxes(3, kSmall));
  Storm storm(7);
  std::vector<Storm::Sent> all = storm.Run(hands, 6000);
  for (int i = 0; i < 60; ++i) {  // of a hand that has not begun, while all others are silent
    hands.Renew(0);
    Storm::Sent sent{0, hands.clock(0).At(Vec3(0.0, 0.0, 0.05)), false, {}, {}};
    sent.answer = hands.SendAsItIs(0, sent.pose);
    all.push_back(sent);
  }
  ASSERT_EQ(all.back().answer.hands, 0u);
  for (std::size_t i = 0; i < 3; ++i) hands.Renew(i);
  const std::size_t from = all.size();
  for (const Storm::Sent& sent : storm.Run(hands, 6000)) all.push_back(sent);
  Hands fresh(Boxes(3, kSmall));
  Storm::Repeat(all, from, fresh);
}

TEST(WorldOfThreads, IsSteppedByOneAtATime) {
  Hands hands(Boxes(2));
  hands.Press();
  const std::uint64_t before = hands.world().steps();
  std::array<double, 2> last{};
  const auto drive = [&](std::size_t i) {
    for (int k = 0; k < 2000; ++k) {
      last[i] = hands.Send(i, At(0.0, i == 0 ? 0.008 : 0.0)).force_N[2];
    }
  };
  std::thread other([&] { drive(1); });
  drive(0);
  other.join();
  EXPECT_EQ(hands.world().steps(), before + 4000);
  // Whoever was last alone has let the other go.
  for (const double force : last) {
    EXPECT_TRUE(std::abs(force) < 1.01) << force;
  }
}

}  // namespace
}  // namespace palpate::test
