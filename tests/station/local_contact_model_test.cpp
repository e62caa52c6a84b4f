#include "client/station/local_contact_model.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "common/step_fault.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/milliseconds.h"
#include "tests/support/random.h"

namespace palpate {
namespace {

using test::Random;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();
const CouplingSpring kSpring{1000.0, 1.0, Vec3(0.01, 0.02, -0.01)};

/// A server with a single plane: its rows hold everywhere, as one point of a tool that only
/// translates meets the plane.
struct PlaneServer {
  Vec3 normal = Vec3::UnitZ();
  double height = 0.0;

  Reply AnswerTo(const Pose& X_WH, std::int64_t time_ns) const {
    Reply reply;
    reply.pose_time_ns = time_ns;
    const double depth = height - normal.dot(X_WH * kSpring.reference);
    reply.X_WG = X_WH;
    if (depth <= 0.0) return reply;
    reply.X_WG.p += depth * normal;
    reply.wrench.force = kSpring.stiffness * depth * normal;
    reply.local = {1, {{{normal, Vec3::Zero(), 0.0}}}, 0.005, std::numbers::pi, 0.05};
    return reply;
  }
};

Pose At(const Vec3& p) {
  return {p - kSpring.reference, Quat::Identity()};
}

Reply RandomReply(Random& random, const Pose& X_WH) {
  Reply reply;
  reply.X_WG = {X_WH.p + random.InCube(0.002), RotationExp(random.InCube(0.02)) * X_WH.q};
  reply.local.count = 1 + random.Below(LocalRows::kMost);
  for (int i = 0; i < reply.local.count; ++i) {
    reply.local.row[static_cast<std::size_t>(i)] = {random.Direction(), random.InCube(0.05),
                                                    random.Uniform(-0.001, 0.0)};
  }
  reply.local.region_m = 0.005;
  reply.local.region_rad = 0.1;
  reply.local.valid_s = 0.05;
  reply.wrench = {random.InCube(3.0), random.InCube(0.1)};
  return reply;
}

double Distance(const Wrench& a, const Wrench& b) {
  return (a.force - b.force).norm() + (a.torque - b.torque).norm();
}

/// The wrench after all blends, without more replies.
LocalContactModel::Evaluation Settled(LocalContactModel& model, std::int64_t now_ns,
                                      const Pose& X_WH) {
  for (int i = 0; i < 40; ++i) model.At(now_ns + i * 100'000'000'000, X_WH);
  return model.At(now_ns, X_WH);
}

LocalContactModel ModelOf(const Reply& reply, const Pose& answered) {
  LocalContactModel model;
  model.SetSpring(kSpring);
  model.Take(reply, answered);
  return model;
}

TEST(LocalContactModel, GivesNothingBeforeTheFirstReply) {
  LocalContactModel model;
  model.SetSpring(kSpring);
  EXPECT_EQ(Distance(model.At(kMs, At(Vec3(0, 0, -1))).wrench, {}), 0.0);
}

TEST(LocalContactModel, GivesTheRepliesWrenchAtThePoseThatItAnswers) {
  Random random(1);
  for (int i = 0; i < 1000; ++i) {
    const Pose X_WH{random.InCube(0.1), random.Rotation()};
    const Reply reply = RandomReply(random, X_WH);
    LocalContactModel model = ModelOf(reply, X_WH);
    EXPECT_LT(Distance(Settled(model, 0, X_WH).wrench, reply.wrench), 1e-9);
  }
}

TEST(LocalContactModel, IsTheServersOwnStepOnAPlaneWhateverTheDelay) {
  Random random(2);
  for (int i = 0; i < 300; ++i) {
    PlaneServer server{random.Direction(), random.Uniform(-0.1, 0.1)};
    const Vec3 on_plane = server.height * server.normal;
    const Pose X_WH = At(on_plane - 0.002 * server.normal);
    LocalContactModel model = ModelOf(server.AnswerTo(X_WH, 0), X_WH);
    const Pose now = At(on_plane + random.InCube(0.002));
    EXPECT_LT(Distance(Settled(model, 0, now).wrench, server.AnswerTo(now, 0).wrench), 1e-9);
  }
}

TEST(LocalContactModel, GivesExactlyNothingWhereNoRowHoldsTheTool) {
  PlaneServer server;
  const Pose pressed = At(Vec3(0, 0, -0.001));
  LocalContactModel model = ModelOf(server.AnswerTo(pressed, 0), pressed);
  EXPECT_EQ(Distance(Settled(model, 0, At(Vec3(0.001, 0, 0.002))).wrench, {}), 0.0);
}

// The server's spring goes on past half a turn, up to a full one; so does this one, a tick ahead.
TEST(LocalContactModel, ResistsATurnBeyondHalfATurnTheSameWay) {
  const auto pulled = [](double degrees) { return std::min(degrees, 360.0) * M_PI / 180.0; };
  const auto turned = [](double degrees) {
    const Quat q = RotationExp(Vec3(0.0, 0.0, -degrees * M_PI / 180.0));
    return Pose{kSpring.reference - q * kSpring.reference, q};
  };
  // Contacts on either side, 50 mm from the reference point, that let the tool turn one way only.
  const LocalRow left{Vec3::UnitY(), Vec3(0.0, 0.0, 0.05), 0.0},
      right{-Vec3::UnitY(), Vec3(0.0, 0.0, 0.05), 0.0};
  for (double degrees = 5.0; degrees < 700.0; degrees += 0.5) {
    Reply reply;
    reply.pose_time_ns = kMs;
    reply.wrench.torque.z() = pulled(degrees);
    reply.local = {2, {{left, right}}, 0.005, 0.1, 0.05};
    LocalContactModel model = ModelOf(reply, turned(degrees));
    for (const double ahead : {-0.4, 0.0, 0.4}) {
      const auto now = Settled(model, kMs, turned(degrees + ahead));
      ASSERT_TRUE(now.evaluated);
      ASSERT_NEAR(now.wrench.torque.z(), pulled(degrees + ahead), 0.016) << degrees;
      ASSERT_LT(now.wrench.force.norm(), 1e-9);
    }
  }
}

TEST(LocalContactModel, ScalesFrictionDownWithTheNormalForceAndNeverUp) {
  PlaneServer server;
  const Pose pressed = At(Vec3(0, 0, -0.002));
  Reply reply = server.AnswerTo(pressed, 0);
  reply.wrench.force.x() = 0.8;  // not explained by the rows
  LocalContactModel model = ModelOf(reply, pressed);
  const auto at = [&](double z) { return Settled(model, 0, At(Vec3(0, 0, z))).wrench.force; };
  EXPECT_LT((at(-0.001) - Vec3(0.4, 0, 1.0)).norm(), 1e-9);
  EXPECT_LT((at(-0.004) - Vec3(0.8, 0, 4.0)).norm(), 1e-9);
  EXPECT_EQ(at(0.001), Vec3::Zero());
}

TEST(LocalContactModel, FadesToNothingOverAnotherRegionAndAnotherLife) {
  PlaneServer server;
  const Pose pressed = At(Vec3(0, 0, -0.002));
  LocalContactModel model = ModelOf(server.AnswerTo(pressed, 0), pressed);
  double last = 3.0;
  for (double x = 0.0; x < 0.02; x += 1e-4) {
    const auto out = Settled(model, 0, At(Vec3(x, 0, -0.002)));
    const double force = out.wrench.force.z();
    EXPECT_LE(force, last + 1e-12);
    if (x <= 0.005) {
      EXPECT_NEAR(force, 2.0, 1e-9) << x;
    }
    if (x >= 0.0101) {
      EXPECT_EQ(force, 0.0) << x;
    }
    if (x > 0.0051) {
      EXPECT_TRUE(out.beyond_region) << x;
    }
    last = force;
  }
  EXPECT_NEAR(Settled(model, 50 * kMs, pressed).wrench.force.z(), 2.0, 1e-9);
  EXPECT_EQ(Settled(model, 100 * kMs, pressed).wrench.force.z(), 0.0);
}

TEST(LocalContactModel, PressingDeeperLeavesNoRegion) {
  PlaneServer server;
  const Pose pressed = At(Vec3(0, 0, -0.001));
  LocalContactModel model = ModelOf(server.AnswerTo(pressed, 0), pressed);
  const auto out = Settled(model, 0, At(Vec3(0, 0, -0.02)));
  EXPECT_NEAR(out.wrench.force.z(), 20.0, 1e-9);
  EXPECT_FALSE(out.beyond_region);
}

TEST(LocalContactModel, ChangesNoFasterThanTheHandDoes) {
  // The nearest point of a convex set moves no further than the point that it is nearest to, so the
  // spring's force changes by at most 2 k |dx|; the rest is the fade's slope times the faded force.
  Random random(3);
  for (int i = 0; i < 300; ++i) {
    const Pose answered{random.InCube(0.1), random.Rotation()};
    LocalContactModel model = ModelOf(RandomReply(random, answered), answered);
    Settled(model, 0, answered);
    const Vec3 from = random.InCube(0.01), step = 1e-6 * random.Direction();
    const auto at = [&](const Vec3& d) { return model.At(0, {answered.p + d, answered.q}).wrench; };
    const Wrench there = at(from);
    // Friction may double that; forces stay below 100 N, and the fade's slope is 1.5 / 5 mm.
    const double most = 3.0 * 2.0 * 1000.0 + (1.5 / 0.005) * 100.0;
    EXPECT_LT((at(from + step).force - there.force).norm(), most * step.norm());
  }
}

TEST(LocalContactModel, TakesANewReplyWithoutAJumpAndForgetsTheOldOne) {
  PlaneServer low{Vec3::UnitZ(), 0.0}, high{Vec3::UnitZ(), 0.001};
  const Pose pressed = At(Vec3(0, 0, -0.001));
  LocalContactModel model = ModelOf(low.AnswerTo(pressed, 0), pressed);
  Settled(model, 0, pressed);
  std::int64_t now = 0;
  double last = model.At(now, pressed).wrench.force.z();
  EXPECT_NEAR(last, 1.0, 1e-9);
  const Reply reply = high.AnswerTo(pressed, 0);
  model.Take(reply, pressed);
  for (int quarter = 1; quarter <= 120; ++quarter) {  // at 4 kHz
    now += kMs / 4;
    const double force = model.At(now, pressed).wrench.force.z();
    EXPECT_GE(force, last);
    EXPECT_LE(force - last, 0.25 * 1.0) << "an implicit step of a quarter of kBlend_s";
    last = force;
  }
  EXPECT_NEAR(last, 2.0, 1e-4);
}

TEST(LocalContactModel, HoldsNothingInFreeSpaceForLongerThanItBlends) {
  PlaneServer server;
  const Pose pressed = At(Vec3(0, 0, -0.003)), free = At(Vec3(0.1, 0, 0.05));
  LocalContactModel model = ModelOf(server.AnswerTo(pressed, 0), pressed);
  Settled(model, 0, pressed);
  for (int ms = 1; ms <= 60; ++ms) {
    model.Take(server.AnswerTo(free, ms * kMs), free);
    const double force = model.At(ms * kMs, free).wrench.force.norm();
    if (ms > 30) {
      EXPECT_EQ(force, 0.0) << ms;
    }
  }
}

TEST(LocalContactModel, RemembersAWallThatTheToolHasLeft) {
  PlaneServer server;
  const Pose pressed = At(Vec3(0, 0, -0.001)), off = At(Vec3(0, 0, 0.002));
  LocalContactModel model = ModelOf(server.AnswerTo(pressed, 0), pressed);
  model.At(0, pressed);
  model.Take(server.AnswerTo(off, kMs), off);
  const Pose back = At(Vec3(0, 0, -0.002));
  EXPECT_NEAR(Settled(model, kMs, back).wrench.force.z(), 2.0, 1e-9);
  // However high the tool has bounced, the wall is where it was and nowhere else.
  const Pose high = At(Vec3(0.003, 0, 0.1));
  model.SetSpring(kSpring);  // as a station does with each pose
  model.Take(server.AnswerTo(high, 2 * kMs), high);
  EXPECT_NEAR(Settled(model, 2 * kMs, back).wrench.force.z(), 2.0, 1e-9);
  EXPECT_NEAR(Settled(model, 2 * kMs, At(Vec3(-0.005, 0, -0.002))).wrench.force.z(), 2.0, 1e-9);
  EXPECT_EQ(Settled(model, 2 * kMs, At(Vec3(0.0101, 0, -0.002))).wrench.force.z(), 0.0);
}

TEST(LocalContactModel, ForgetsWithTheSession) {
  PlaneServer server;
  const Pose pressed = At(Vec3(0, 0, -0.001)), off = At(Vec3(0, 0, 0.002));
  const Pose back = At(Vec3(0, 0, -0.002));
  for (const bool by_fault : {true, false}) {
    LocalContactModel model = ModelOf(server.AnswerTo(pressed, 0), pressed);
    model.At(0, pressed);
    if (by_fault) {
      Reply begin;
      begin.X_WG = off;
      begin.faults = kFaultNotStarted;
      model.Take(begin, off);
      model.At(kMs, off);
    } else {
      model.Forget();
    }
    model.Take(server.AnswerTo(off, 2 * kMs), off);
    EXPECT_EQ(Settled(model, 2 * kMs, back).wrench.force.norm(), 0.0) << by_fault;
  }
}

TEST(LocalContactModel, ForgetsAWallThatTheServersToolHasPassed) {
  PlaneServer server;
  const Pose pressed = At(Vec3(0, 0, -0.001)), below = At(Vec3(0, 0, -0.002));
  LocalContactModel model = ModelOf(server.AnswerTo(pressed, 0), pressed);
  Reply free;
  free.X_WG = below;
  free.pose_time_ns = kMs;
  model.At(0, pressed);
  model.Take(free, below);
  EXPECT_EQ(Settled(model, kMs, below).wrench.force.norm(), 0.0);
}

TEST(LocalContactModel, SwitchedOffGivesTheWrenchAsItCame) {
  PlaneServer server;
  const Pose pressed = At(Vec3(0, 0, -0.002));
  LocalContactModel model = ModelOf(server.AnswerTo(pressed, 0), pressed);
  model.Enable(false);
  EXPECT_EQ(model.At(kMs, At(Vec3(0, 0, 0.1))).wrench.force,
            server.AnswerTo(pressed, 0).wrench.force);
}

TEST(LocalContactModel, TakesRowsThatNoStepCanHaveMadeForNone) {
  PlaneServer server;
  const Pose pressed = At(Vec3(0, 0, -0.002)), elsewhere = At(Vec3(0, 0, -0.004));
  const Reply sound = server.AnswerTo(pressed, 0);
  using Lie = void (*)(Reply&);
  const Lie lies[] = {
      [](Reply& r) { r.local.row[0].normal.x() = kNaN; },
      [](Reply& r) { r.local.row[0].normal.setZero(); },
      [](Reply& r) { r.local.row[0].normal *= 1e200; },
      [](Reply& r) { r.local.row[0].lever_cross_normal.y() = kInf; },
      [](Reply& r) { r.local.row[0].lever_cross_normal.y() = 1e6; },
      [](Reply& r) { r.local.row[0].offset = kNaN; },
      [](Reply& r) { r.local.row[0].offset = 1.0; },
      [](Reply& r) { r.local.row[0].offset = -kInf; },
      [](Reply& r) { r.local.count = -1; },
      [](Reply& r) { r.local.count = 7; },
      [](Reply& r) { r.local.region_m = kNaN; },
      [](Reply& r) { r.local.region_rad = -1.0; },
      [](Reply& r) { r.local.valid_s = 0.0; },
      [](Reply& r) { r.X_WG.p.x() = kInf; },
      [](Reply& r) { r.X_WG.q.w() = 3.0; },
  };
  for (const Lie lie : lies) {
    Reply reply = sound;
    lie(reply);
    LocalContactModel model = ModelOf(reply, pressed);
    const auto out = Settled(model, 0, elsewhere);
    EXPECT_FALSE(out.evaluated) << &lie - lies;
    EXPECT_EQ(out.wrench.force, sound.wrench.force) << &lie - lies;
  }
}

TEST(LocalContactModel, StaysFiniteWhateverRowsItIsGiven) {
  Random random(4);
  for (int i = 0; i < 2000; ++i) {
    const Pose X_WH{random.InCube(0.1), random.Rotation()};
    LocalContactModel model;
    model.SetSpring(kSpring);
    for (int k = 0; k < 4; ++k) {
      Reply reply = RandomReply(random, X_WH);
      LocalRow& row = reply.local.row[static_cast<std::size_t>(random.Below(LocalRows::kMost))];
      switch (random.Below(6)) {
        case 0:
          reply.local.row[0] = {Vec3::UnitX(), Vec3::Zero(), 9e-5};  // contradictory
          reply.local.row[1] = {-Vec3::UnitX(), Vec3::Zero(), 9e-5};
          break;
        case 1:
          reply.local.row.fill(reply.local.row[0]);
          break;
        case 2:
          row.normal = Vec3::Constant(kNaN);
          break;
        case 3:
          row.offset = -1e300;
          break;
        case 4:
          reply.X_WG.p = random.InCube(1e6);
          break;
        default:
          break;
      }
      model.Take(reply, X_WH);
      const auto out = model.At(k * kMs, {X_WH.p + random.InCube(0.02), random.Rotation()});
      ASSERT_TRUE(out.wrench.force.allFinite() && out.wrench.torque.allFinite());
    }
  }
}

TEST(LocalContactModel, RecoversFromAReplyThatIsNotFinite) {
  PlaneServer server;
  const Pose pressed = At(Vec3(0, 0, -0.002));
  Reply bad = server.AnswerTo(pressed, 0);
  bad.wrench.force.x() = kNaN;
  LocalContactModel model = ModelOf(bad, pressed);
  EXPECT_TRUE(std::isnan(model.At(kMs, pressed).wrench.force.x())) << "the limiter's to refuse";
  model.Take(server.AnswerTo(pressed, 0), pressed);
  EXPECT_NEAR(model.At(2 * kMs, pressed).wrench.force.z(), 2.0, 1e-9);
}

TEST(LocalContactModel, GivesEqualBitsForEqualCallsAndAllocatesNothing) {
  const auto run = [] {
    Random random(5);
    LocalContactModel model;
    model.SetSpring(kSpring);
    Wrench last;
    for (int i = 0; i < 500; ++i) {
      const Pose X_WH{random.InCube(0.01), RotationExp(random.InCube(0.1))};
      model.Take(RandomReply(random, X_WH), X_WH);
      last = model.At(i * kMs, {X_WH.p + random.InCube(0.001), X_WH.q}).wrench;
    }
    return last;
  };
  const Wrench once = run();
  const std::uint64_t before = test::AllocationsOfThisThread();
  const Wrench again = run();
  EXPECT_EQ(test::AllocationsOfThisThread(), before);
  EXPECT_EQ(Distance(once, again), 0.0);
}

}  // namespace
}  // namespace palpate
