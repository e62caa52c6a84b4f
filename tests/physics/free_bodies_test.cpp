#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "scenes/shapes/shapes.h"
#include "server/physics/haptic_step.h"
#include "server/physics/limits.h"
#include "server/physics/scene_model.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/mesh_oracle.h"
#include "tests/support/test_scenes.h"

namespace palpate {
namespace {

using test::MakeMeshBody;
using test::MeshOracle;
using Kind = BodyJoint::Kind;

constexpr double kGravity = 9.81, kStep = 1e-3;

Body BlockNamed(const char* name, const Vec3& size, const Vec3& at = Vec3::Zero()) {
  return MakeMeshBody(name, MakeBox(size), Pose{at, Quat::Identity()});
}

FreeBody Solid(const Vec3& size, double mass, const Vec3& at) {
  const Vec3 s = size.cwiseAbs2();
  const Vec3 moments(s.y() + s.z(), s.x() + s.z(), s.x() + s.y());
  return {mass, at, (mass / 12.0 * moments).asDiagonal()};
}

/// Hands' tools, what stands still, and free boxes.
class FreeWorld {
 public:
  explicit FreeWorld(double mu = -1.0, const Vec3& gravity = Vec3(0.0, 0.0, -kGravity)) : mu_(mu) {
    scene_.features.contact = ContactModel::kSurface;
    if (mu >= 0.0) scene_.features.friction = FrictionModel::kCoulomb;
    scene_.gravity = gravity;
  }
  Body Rough(Body body) const {
    if (mu_ >= 0.0) body.materials[0].static_friction = body.materials[0].dynamic_friction = mu_;
    return body;
  }
  void AddTool(Body body) {
    scene_.tools.push_back(Rough(std::move(body)));
    scene_.hands_meet = scene_.tools.size() > 1;
  }
  void AddStill(Body body) { scene_.objects.push_back(Rough(std::move(body))); }
  void AddBody(const Vec3& size, const Vec3& at, double mass, const BodyJoint& joint = {}) {
    const std::string name = "body " + std::to_string(scene_.moved.size());
    Body body = Rough(BlockNamed(name.c_str(), size, at));
    body.moved = static_cast<std::uint32_t>(scene_.moved.size() + 1);
    FreeBody free = Solid(size, mass, at);
    free.joint = joint;
    scene_.moved.push_back({.name = name, .free = free});
    scene_.objects.push_back(std::move(body));
  }
  void Make() {
    if (scene_.tools.empty()) {
      AddTool(BlockNamed("far", Vec3::Constant(0.01), Vec3(0.0, 5.0, 0.0)));
      scene_.tools[0].X_WB.p = Vec3(0.0, 5.0, 0.0);
    }
    const auto objects = MakeObjects(scene_);
    for (const Body& tool : scene_.tools) {
      models_.push_back(std::make_unique<HapticModel>(MakeModel(scene_, tool, objects)));
    }
    std::vector<const HapticModel*> all;
    for (const auto& model : models_) all.push_back(model.get());
    for (const auto& model : *objects->free_bodies) all.push_back(model.get());
    for (const HapticModel* model : all) {
      states_.push_back(std::make_unique<StepState>(*model));
      workspaces_.push_back(std::make_unique<StepWorkspace>(*model));
      steps_.push_back({model, {}, states_.back().get(), workspaces_.back().get()});
    }
    for (std::size_t i = 0; i < hands(); ++i) {
      states_[i]->X_WG = states_[i]->X_WH = steps_[i].X_WH = scene_.tools[i].X_WB;
    }
    together_ = std::make_unique<TogetherWorkspace>(all);
  }
  std::size_t hands() const { return scene_.tools.size(); }
  void Step() {
    const std::uint64_t before = test::AllocationsOfThisThread();
    StepTogether(steps_, *together_);
    EXPECT_EQ(test::AllocationsOfThisThread(), before);
  }
  Pose& hand(std::size_t i) { return steps_[i].X_WH; }
  const StepReport& report(std::size_t member) const { return steps_[member].report; }
  const Vec3& force(std::size_t hand) const { return report(hand).wrench.force; }
  /// Of a free body: its pose relative to where it was placed.
  const Pose& X(std::size_t body) const { return states_[hands() + body]->X_WG; }
  BodyState& state(std::size_t body) { return states_[hands() + body]->body; }
  Vec3 centre(std::size_t body) const { return X(body) * scene_.moved[body].free->centre; }
  /// Returns whether any two meet, by the exact oracle.
  bool Meet() const {
    std::vector<std::pair<Body, Pose>> all;
    for (std::size_t i = 0; i < hands(); ++i) {
      all.push_back({scene_.tools[i], states_[i]->X_WG});
    }
    for (const Body& object : scene_.objects) {
      const Pose X = object.moved > 0 ? this->X(object.moved - 1) : Pose{};
      all.push_back({object, X * object.X_WB});
    }
    for (std::size_t a = 0; a < all.size(); ++a) {
      for (std::size_t b = a + 1; b < all.size(); ++b) {
        Scene pair;
        pair.features.contact = ContactModel::kSurface;
        pair.tools = {all[a].first};
        pair.objects = {all[b].first};
        pair.objects[0].X_WB = Pose{};
        if (MeshOracle(pair).Meet(all[b].second.Inverse() * all[a].second)) return true;
      }
    }
    return false;
  }

 private:
  double mu_;
  Scene scene_;
  std::vector<std::unique_ptr<HapticModel>> models_;
  std::vector<std::unique_ptr<StepState>> states_;
  std::vector<std::unique_ptr<StepWorkspace>> workspaces_;
  std::vector<ToolStep> steps_;
  std::unique_ptr<TogetherWorkspace> together_;
};

TEST(FreeBodies, FallAsGalileoSays) {
  FreeWorld world;
  world.AddBody(Vec3::Constant(0.02), Vec3::Zero(), 0.05);
  world.Make();
  for (int i = 1; i <= 300; ++i) {
    world.Step();
    // Implicit Euler: the velocity of a step is that at its end.
    ASSERT_NEAR(world.centre(0).z(), -0.5 * kGravity * kStep * kStep * i * (i + 1), 1e-12 * i) << i;
  }
  EXPECT_NEAR(world.state(0).v.z(), -kGravity * 0.3, 1e-9);
}

TEST(FreeBodies, KeepMomentumAndEnergyInFlight) {
  FreeWorld world(-1.0, Vec3::Zero());
  const Vec3 size(0.01, 0.03, 0.06);
  world.AddBody(size, Vec3::Zero(), 0.04);
  world.Make();
  const FreeBody body = Solid(size, 0.04, Vec3::Zero());
  const Vec3 L = body.inertia * Vec3(0.2, 20.0, 0.1);  // about the middle axis, which tumbles
  world.state(0).momentum = L;
  world.state(0).v = Vec3(0.1, -0.2, 0.3);
  const auto energy = [&] {
    const Mat3 R = world.X(0).q.toRotationMatrix();
    const Vec3 l = world.state(0).momentum;
    return 0.5 * l.dot(R * body.inertia.inverse() * R.transpose() * l);
  };
  const double before = energy();
  for (int i = 0; i < 2000; ++i) {
    world.Step();
    ASSERT_LE((world.state(0).momentum - L).norm(), 1e-6 * L.norm()) << i;
    ASSERT_NEAR(energy(), before, 2e-3 * before) << i;
  }
  EXPECT_LE((world.centre(0) - 2.0 * Vec3(0.1, -0.2, 0.3)).norm(), 1e-9);
}

TEST(FreeBodies, SwingAsAPhysicalPendulum) {
  FreeWorld world;
  const Vec3 size(0.01, 0.01, 0.2);
  const double m = 0.1, d = 0.09;
  world.AddBody(size, Vec3(0.0, 0.0, -d), m, {.kind = Kind::kHinge, .axis = Vec3::UnitY()});
  world.Make();
  const double inertia = m / 12.0 * (0.01 * 0.01 + 0.2 * 0.2) + m * d * d;
  world.state(0).rate = 0.3;
  const double amplitude = 0.3 / std::sqrt(m * kGravity * d / inertia);
  std::vector<double> crossings;
  double before = 0.0, most = 0.0;
  for (int i = 1; i <= 10'000; ++i) {
    world.Step();
    const double now = world.state(0).joint;
    if (before < 0.0 && now >= 0.0) crossings.push_back(kStep * (i - now / (now - before)));
    before = now;
    most = std::max(most, (world.X(0) * Vec3::Zero()).norm());
  }
  const double period =
      (crossings.back() - crossings.front()) / static_cast<double>(crossings.size() - 1);
  const double small = 2.0 * M_PI * std::sqrt(inertia / (m * kGravity * d));
  EXPECT_NEAR(period, small * (1.0 + amplitude * amplitude / 16.0), 1e-3 * small);
  EXPECT_LE(most, 1e-6);  // of the joint's drift
}

TEST(FreeBodies, RestWhereTheyAreLetDown) {
  FreeWorld world(0.3);
  world.AddStill(BlockNamed("plate", Vec3(0.2, 0.2, 0.01), Vec3(0.0, 0.0, -0.005)));
  world.AddBody(Vec3(0.02, 0.03, 0.01), Vec3(0.0, 0.0, 0.0052), 0.02);
  world.AddBody(Vec3(0.02, 0.02, 0.01), Vec3(0.003, 0.0, 0.0156), 0.02);
  world.Make();
  for (int i = 0; i < 400; ++i) {
    world.Step();
    ASSERT_EQ(world.report(1).faults | world.report(2).faults, 0u) << i;
    if (i % 40 == 0) {
      ASSERT_FALSE(world.Meet()) << i;
    }
  }
  EXPECT_NEAR(world.centre(0).z(), 0.005, 5e-6);
  EXPECT_NEAR(world.centre(1).z(), 0.015, 1e-5);
  EXPECT_TRUE(world.state(0).sleeps);
  EXPECT_TRUE(world.state(1).sleeps);
  const Pose rests = world.X(1);
  for (int i = 0; i < 1000; ++i) world.Step();
  EXPECT_EQ(world.X(1).p, rests.p);
}

TEST(FreeBodies, SlideDownASlopeThatIsSteeperThanTheirFriction) {
  constexpr double kMu = 0.3;
  for (const double over : {0.99, 1.01, 1.5}) {
    const double angle = std::atan(over * kMu);
    FreeWorld world(kMu, kGravity * Vec3(std::sin(angle), 0.0, -std::cos(angle)));
    world.AddStill(BlockNamed("plate", Vec3(0.4, 0.2, 0.01), Vec3(0.0, 0.0, -0.005)));
    world.AddBody(Vec3(0.02, 0.02, 0.01), Vec3(0.0, 0.0, 0.005001), 0.02);
    world.Make();
    for (int i = 0; i < 300; ++i) world.Step();
    const double a = kGravity * (std::sin(angle) - kMu * std::cos(angle));
    const double way = over < 1.0 ? 0.0 : 0.5 * a * 0.3 * 0.301;
    EXPECT_NEAR(world.centre(0).x(), way, 0.01 * way + 2e-6) << over;
  }
}

// The hand feels the box's friction on the plate, mu m g, and no more.
TEST(FreeBodies, ArePushedWithTheForceOfTheirFriction) {
  constexpr double kMu = 0.4, kMass = 0.1;
  FreeWorld world(kMu);
  world.AddTool(BlockNamed("tool", Vec3(0.01, 0.01, 0.006), Vec3(-0.02, 0.0, 0.006)));
  world.AddStill(BlockNamed("plate", Vec3(0.4, 0.2, 0.01), Vec3(0.0, 0.0, -0.005)));
  world.AddBody(Vec3(0.02, 0.02, 0.012), Vec3(0.0, 0.0, 0.006001), kMass);
  world.Make();
  double mean = 0.0;
  for (int i = 0; i < 1500; ++i) {
    world.hand(0).p.x() += 2e-5;
    world.Step();
    ASSERT_EQ(world.report(0).faults & ~kFaultFriction, 0u) << i;
    if (i % 100 == 0) {
      ASSERT_FALSE(world.Meet()) << i;
    }
    if (i >= 1200) mean += world.force(0).x() / 300.0;
  }
  EXPECT_GT(world.centre(0).x(), 0.01);
  EXPECT_NEAR(mean, -kMu * kMass * kGravity, 0.02 * kMu * kMass * kGravity);
  EXPECT_NEAR(world.centre(0).y(), 0.0, 2e-5);
}

// A lever in balance: F a = k theta.
TEST(FreeBodies, HoldALeverByTheSpringOfItsHinge) {
  FreeWorld world(-1.0, Vec3::Zero());
  world.AddTool(BlockNamed("tool", Vec3(0.004, 0.02, 0.004), Vec3(0.08, 0.0, 0.02)));
  world.AddBody(Vec3(0.2, 0.01, 0.01), Vec3(0.1, 0.0, 0.0), 0.05,
                {.kind = Kind::kHinge,
                 .axis = Vec3::UnitY(),
                 .torsional_stiffness = 0.5,
                 .torsional_damping = 0.01});
  world.Make();
  for (int i = 0; i < 3000; ++i) {
    world.hand(0).p.z() = std::max(0.003, 0.02 - 1e-5 * i);
    world.Step();
  }
  const double angle = world.state(0).joint;
  const Vec3 force = -world.force(0);
  double arm = 0.0;
  for (int k = 0; k < world.report(0).contacts; ++k) {
    const ActiveRow& row = world.report(0).active[static_cast<std::size_t>(k)];
    arm += row.contact_W.cross(-row.force * row.normal).y();
  }
  EXPECT_GT(angle, 0.01);
  EXPECT_GT(force.norm(), 0.05);
  EXPECT_NEAR(arm, 0.5 * angle, 2e-3 * 0.5 * angle);
  EXPECT_FALSE(world.Meet());
}

// Two hands carry a box by friction alone, as long as mu F >= m g / 2 on each side.
TEST(FreeBodies, AreCarriedByTwoHandsThatPinchHardEnough) {
  constexpr double kMu = 0.5, kMass = 0.1;
  for (const double over : {0.9, 1.2}) {
    FreeWorld world(kMu);
    const double squeeze = over * 0.5 * kMass * kGravity / kMu / 1000.0;  // by 1 N/mm
    world.AddTool(BlockNamed("left", Vec3(0.01, 0.02, 0.02), Vec3(-0.0151, 0.0, 0.0105)));
    world.AddTool(BlockNamed("right", Vec3(0.01, 0.02, 0.02), Vec3(0.0151, 0.0, 0.0105)));
    world.AddStill(BlockNamed("table", Vec3(0.2, 0.2, 0.01), Vec3(0.0, 0.0, -0.005)));
    world.AddBody(Vec3(0.02, 0.02, 0.02), Vec3(0.0, 0.0, 0.010002), kMass);
    world.Make();
    for (int i = 0; i < 1000; ++i) {
      const double in = std::min(1.0, i / 200.0) * (1e-4 + squeeze);
      const double up = std::clamp((i - 300) / 400.0, 0.0, 1.0) * 0.004;
      world.hand(0).p = Vec3(-0.0151 + in, 0.0, 0.0105 + up);
      world.hand(1).p = Vec3(0.0151 - in, 0.0, 0.0105 + up);
      world.Step();
      if (i % 100 == 0) {
        ASSERT_FALSE(world.Meet()) << i;
      }
    }
    if (over > 1.0) {
      EXPECT_NEAR(world.centre(0).z(), 0.01 + 0.004 - 0.5 * kMass * kGravity / 1000.0, 3e-4);
    } else {
      EXPECT_LE(world.centre(0).z(), 0.0102);
    }
  }
}

// Against its limit a slider is a wall; before it, its spring.
TEST(FreeBodies, StopAtTheLimitsOfTheirSlider) {
  FreeWorld world(-1.0, Vec3::Zero());
  world.AddTool(BlockNamed("tool", Vec3(0.01, 0.01, 0.006), Vec3(-0.02, 0.0, 0.0)));
  world.AddBody(Vec3(0.02, 0.02, 0.012), Vec3::Zero(), 0.05,
                {.kind = Kind::kSlider,
                 .axis = Vec3::UnitX(),
                 .low = -0.001,
                 .high = 0.004,
                 .stiffness = 100.0,
                 .damping = 2.0});
  world.Make();
  for (int i = 0; i < 4000; ++i) {
    world.hand(0).p.x() = std::min(-0.02 + 1e-5 * i, -0.008);
    world.Step();
    ASSERT_LE(world.state(0).joint, 0.004 + 1e-9) << i;
    if (i == 900) {  // at rest against the spring: hand and spring in series
      for (int k = 0; k < 500; ++k) world.Step();
      const double given = -0.011 + 0.015;
      EXPECT_NEAR(-world.force(0).x(), 1000.0 * 100.0 / 1100.0 * given, 2e-3);
    }
  }
  EXPECT_NEAR(world.state(0).joint, 0.004, 1e-9);
  EXPECT_NEAR(-world.force(0).x(), 1000.0 * (-0.008 + 0.015 - 0.004), 2e-3);
  EXPECT_LE(world.X(0).p.cwiseAbs().tail<2>().maxCoeff(), 1e-9);
  EXPECT_FALSE(world.Meet());
}

// Thrown at its limit, which it reaches after several sub-steps of one step.
TEST(FreeBodies, StopAtALimitHoweverFast) {
  for (const Kind kind : {Kind::kSlider, Kind::kHinge}) {
    FreeWorld world(-1.0, Vec3::Zero());
    world.AddBody(Vec3(0.02, 0.02, 0.1), Vec3(0.0, 0.0, -0.05), 0.05,
                  {.kind = kind, .axis = Vec3::UnitX(), .low = -0.05, .high = 0.0301});
    world.Make();
    world.state(0).rate = kind == Kind::kSlider ? 4.0 : 40.0;
    for (int i = 0; i < 60; ++i) {
      world.Step();
      ASSERT_LE(world.state(0).joint, 0.0301 + 1e-7) << i;
    }
    EXPECT_NEAR(world.state(0).joint, 0.0301, 1e-7);
  }
}

// A loose tooth: pressed where its springs are, it gives by F / k; pressed above, it tilts, too.
TEST(FreeBodies, GiveWayAsTheSixSpringsOfALigament) {
  FreeWorld world(-1.0, Vec3::Zero());
  world.AddTool(BlockNamed("tool", Vec3(0.01, 0.004, 0.004), Vec3(-0.012, 0.0, 0.008)));
  world.AddBody(Vec3(0.008, 0.008, 0.02), Vec3::Zero(), 0.002,
                {.kind = Kind::kSprings,
                 .point = Vec3(0.0, 0.0, -0.005),
                 .stiffness = 5e4,
                 .damping = 5.0,
                 .torsional_stiffness = 2.0,
                 .torsional_damping = 1e-3});
  world.Make();
  for (int i = 0; i < 3000; ++i) {
    world.hand(0).p.x() = std::min(-0.012 + 2e-6 * i, -0.008);
    world.Step();
  }
  double torque = 0.0, force = 0.0;
  for (int k = 0; k < world.report(0).contacts; ++k) {
    const ActiveRow& row = world.report(0).active[static_cast<std::size_t>(k)];
    const Vec3 pushes = -row.force * row.normal;
    force += pushes.x();
    torque += (row.contact_W - Vec3(0.0, 0.0, -0.005)).cross(pushes).y();
  }
  EXPECT_GT(force, 0.5);
  const Vec3 moved = world.X(0) * Vec3(0.0, 0.0, -0.005) - Vec3(0.0, 0.0, -0.005);
  EXPECT_NEAR(5e4 * moved.x(), force, 2e-3 * force);
  EXPECT_NEAR(2.0 * RotationLog(world.X(0).q).y(), torque, 5e-3 * torque);
}

// A ball joint's pendulum keeps its distance, and the momentum about the vertical.
TEST(FreeBodies, SwingAboutABallJoint) {
  FreeWorld world;
  world.AddBody(Vec3(0.02, 0.01, 0.1), Vec3(0.04, 0.0, -0.06), 0.1, {.kind = Kind::kBall});
  world.Make();
  world.state(0).momentum = Vec3(0.0, 1e-3, 2e-3);
  for (int i = 0; i < 3000; ++i) {
    world.Step();
    ASSERT_LE((world.X(0) * Vec3::Zero()).norm(), 5e-6) << i;
    ASSERT_NEAR(world.state(0).momentum.z(), 2e-3, 2e-5) << i;
  }
}

// Hands that wander among bodies: nothing ever meets, no force jumps out of bounds, and round a
// closed path the hand gets nothing back.
TEST(FreeBodies, NeverMeetWhereverAHandPushesThem) {
  for (const unsigned seed : {1u, 3u, 23u}) {
    FreeWorld world(seed == 3 ? 0.0 : 0.3);
    world.AddTool(BlockNamed("tool", Vec3(0.008, 0.008, 0.03), Vec3(0.0, 0.0, 0.03)));
    world.AddStill(BlockNamed("plate", Vec3(0.08, 0.08, 0.01), Vec3(0.0, 0.0, -0.005)));
    world.AddStill(BlockNamed("wall", Vec3(0.01, 0.08, 0.03), Vec3(0.0405, 0.0, 0.016)));
    world.AddBody(Vec3(0.02, 0.02, 0.01), Vec3(0.015, 0.0, 0.005002), 0.03);
    world.AddBody(Vec3(0.01, 0.03, 0.008), Vec3(-0.02, 0.005, 0.004002), 0.005);
    world.AddBody(Vec3(0.006, 0.006, 0.006), Vec3(0.015, 0.001, 0.013004), 0.001);
    world.Make();
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    Vec3 from(0.0, 0.0, 0.03), to = from;
    double work = 0.0;
    for (int i = 0; i < 4000; ++i) {
      if (i % 250 == 0) {
        from = to;
        to = i + 250 == 4000 ? Vec3(0.0, 0.0, 0.03)
                             : Vec3(0.03 * uniform(random), 0.03 * uniform(random),
                                    0.018 + 0.006 * uniform(random));
      }
      const double s = (i % 250 + 1) / 250.0;
      const Vec3 p = from + s * s * (3.0 - 2.0 * s) * (to - from);
      work -= world.force(0).dot(p - world.hand(0).p);
      world.hand(0).p = p;
      world.hand(0).q = RotationExp(Vec3(0.3 * std::sin(2e-3 * i), 0.2 * std::sin(3e-3 * i), 0.0));
      world.Step();
      ASSERT_TRUE(world.force(0).allFinite());
      ASSERT_LE(world.force(0).norm(), 60.0) << i;
      if (i % 50 == 0) {
        ASSERT_FALSE(world.Meet()) << seed << " " << i;
      }
    }
    EXPECT_GE(work, -2e-3) << seed;
  }
}

// A hand far from all bodies feels what it feels alone, to the bit.
TEST(FreeBodies, ThatAreFarChangeNoBit) {
  FreeWorld with, without;
  for (FreeWorld* world : {&with, &without}) {
    world->AddTool(BlockNamed("tool", Vec3::Constant(0.01), Vec3(0.0, 0.0, 0.01)));
    world->AddStill(BlockNamed("plate", Vec3(0.1, 0.1, 0.01), Vec3(0.0, 0.0, -0.005)));
    world->AddBody(Vec3::Constant(0.01), Vec3(0.0, 0.4, 0.3), 0.02);
  }
  with.Make();
  without.Make();
  without.state(0).sleeps = true;
  for (int i = 0; i < 300; ++i) {
    for (FreeWorld* world : {&with, &without}) {
      world->hand(0).p = Vec3(1e-5 * i, 0.0, 0.01 - 3e-5 * i);
      world->hand(0).q = RotationExp(Vec3(1e-3 * i, 0.0, 0.0));
      world->Step();
    }
    ASSERT_EQ(with.force(0), without.force(0)) << i;
  }
  EXPECT_GT(with.force(0).z(), 0.5);
}

}  // namespace
}  // namespace palpate
