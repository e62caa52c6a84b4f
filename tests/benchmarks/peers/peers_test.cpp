#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/error.h"
#include "scenes/shapes/shapes.h"
#include "tests/benchmarks/peers/peer.h"

namespace palpate::bench {
namespace {

constexpr double kCube = 0.05, kRadius = 0.005, kDeep = 1e-3;

/// How far a rigid contact may yield at 1 N [m]: MuJoCo's is soft, Bullet has two 20 um margins.
constexpr double kGive = 40e-6;

/// Runs each test with every installed peer.
class InstalledPeers : public testing::TestWithParam<PeerKind> {
 protected:
  /// Moves a tool down to `kDeep` inside the cube's top face, and holds it there.
  /// @param clearance  from the tool's centre to its lowest point.
  PeerStep Rest(PeerScene scene, double clearance) const {
    scene.objects = {{&cube_, {}}};
    const double rest = 0.5 * kCube + clearance;
    const auto peer = GetParam().make(scene, {Vec3(0.003, rest + 1e-3, 0.004)});
    PeerStep step;
    for (int i = 1; i <= 1000; ++i) {
      const double moved = 2e-3 * std::min(1.0, i / 200.0);
      step = peer->Step({Vec3(0.003, rest + 1e-3 - moved, 0.004)});
    }
    return step;
  }
  static void ExpectOneNewton(const PeerStep& step, double stiffness) {
    EXPECT_NEAR(step.wrench.force.y(), stiffness * kDeep, stiffness * kGive);
    EXPECT_NEAR(step.wrench.force.x(), 0.0, stiffness * kGive);
    EXPECT_NEAR(step.wrench.force.z(), 0.0, stiffness * kGive);
  }

  TriangleMesh cube_ = MakeBox(Vec3::Constant(kCube));
};

TEST_P(InstalledPeers, HoldABallOnABoxWithTheSpringsForce) {
  const TriangleMesh ball = MakeSphere(kRadius, 320);
  const PeerScene scene{.tool = &ball, .ball = kRadius};
  ExpectOneNewton(Rest(scene, kRadius), scene.coupling.stiffness);
}

TEST_P(InstalledPeers, HoldABoxFlatOnABoxMeshAgainstMesh) {
  const TriangleMesh box = MakeBox(Vec3::Constant(0.02));
  const PeerScene scene{.tool = &box};
  const PeerStep step = Rest(scene, 0.01);
  ExpectOneNewton(step, scene.coupling.stiffness);
  EXPECT_GE(step.contacts, 1);
  // The face is 20 mm wide and may yield at its edges.
  EXPECT_LT(step.X_WG.q.vec().norm(), 0.5 * kGive / 0.01);
}

TEST_P(InstalledPeers, StandWhereTheHandIsInFreeSpace) {
  // A tool whose frame is not at its centroid.
  TriangleMesh box = MakeBox(Vec3::Constant(0.02));
  for (Vec3& v : box.vertices) v += Vec3(0.1, 0.2, 0.3);
  const PeerScene scene{
      .tool = &box, .centroid = Vec3(0.1, 0.2, 0.3), .objects = {{&cube_, {Vec3(0, -1, 0)}}}};
  const Pose hand{Vec3(0.2, 0.1, 0.0), Quat(0.6, 0.0, 0.8, 0.0)};
  const auto peer = GetParam().make(scene, hand);
  for (int i = 0; i < 100; ++i) {
    const PeerStep step = peer->Step(hand);
    EXPECT_LT(step.wrench.force.norm(), 1e-9);
    EXPECT_LT((step.X_WG.p - hand.p).norm(), 1e-12);
  }
}

auto Installed() {
  std::vector<PeerKind> kinds;
  for (const PeerKind& kind : PeerKinds()) {
    if (kind.installed()) kinds.push_back(kind);
  }
  return testing::ValuesIn(kinds);
}
std::string Name(const testing::TestParamInfo<PeerKind>& peer) {
  return peer.param.name;
}

// A build may have no peers at all.
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(InstalledPeers);
INSTANTIATE_TEST_SUITE_P(Installed, InstalledPeers, Installed(), Name);

TEST(PeerKinds, NameTheirPackageWhetherItIsThereOrNot) {
  std::set<std::string> ids;
  for (const PeerKind& kind : PeerKinds()) {
    EXPECT_TRUE(ids.insert(kind.id).second) << kind.id << " stands there twice";
    EXPECT_THAT(kind.package, testing::MatchesRegex("lib.*-dev"));
    EXPECT_EQ(kind.installed(), static_cast<bool>(kind.make)) << kind.name;
    EXPECT_THAT(HowToInstall(kind), testing::HasSubstr("`apt-get install " + kind.package + "`"));
  }
  EXPECT_THAT(ids, testing::UnorderedElementsAre("bullet", "ode", "mujoco"));
}

TEST(PeersOfALibrary, AreMadeLikeThoseThatAreBuiltIn) {
  const std::vector<PeerKind> kinds = PeersOf(PALPATE_BIN_DIR "/palpate_peer_for_tests.so");
  ASSERT_EQ(kinds.size(), 1U);
  EXPECT_TRUE(kinds[0].installed());
  EXPECT_EQ(kinds[0].package, "palpate_peer_for_tests.so");
  const Pose hand{Vec3(1.0, 2.0, 3.0)};
  const TriangleMesh ball = MakeSphere(kRadius, 320);
  const auto peer = kinds[0].make({.tool = &ball, .ball = kRadius}, hand);
  EXPECT_EQ(peer->Step(hand).X_WG.p, hand.p);
  EXPECT_THROW(kinds[0].make({.tool = &ball}, hand), Error) << "its error is the project's";
}

TEST(PeersOfALibrary, NameTheFileThatHasNone) {
  const auto error = [](const std::string& file) -> std::string {
    try {
      PeersOf(file);
    } catch (const UsageError& e) {
      return e.what();
    }
    return "nothing";
  };
  EXPECT_THAT(error("nowhere.so"), testing::HasSubstr("--peers nowhere.so: "));
  EXPECT_THAT(error("nowhere.so"), testing::HasSubstr("No such file"));
  // A library of the system, which this program has loaded itself.
  EXPECT_THAT(error("/lib/x86_64-linux-gnu/libm.so.6"),
              testing::HasSubstr("has no function PalpatePeers; tests/benchmarks/peers/peer.h"));
}

}  // namespace
}  // namespace palpate::bench
