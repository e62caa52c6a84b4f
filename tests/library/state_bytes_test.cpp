#include "server/library/state_bytes.h"

#include <cstring>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "common/error.h"
#include "common/math/rotation.h"
#include "scenes/shapes/shapes.h"
#include "server/library/body_builder.h"
#include "server/library/proxy.h"
#include "server/physics/scene_model.h"
#include "tests/support/random.h"

namespace palpate::test {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// A box that lies on a rough block, by its mesh or by its leaves, of which `stiffness` makes soft
/// ones.
HapticModel RoughBlock(ContactModel contact, double width = 0.04, double stiffness = INFINITY) {
  Scene scene;
  scene.features = {contact, FrictionModel::kCoulomb, std::isfinite(stiffness)};
  const BodyOptions rough{.leaves = 64, .contact = contact, .material = {stiffness, 0.5, 0.3}};
  scene.objects.push_back(MakeBody("block", MakeBox({width, 0.04, 0.04}), rough));
  scene.objects.push_back(MakeBody("ball", MakeEllipsoid({0.01, 0.01, 0.01}, 200), rough));
  scene.objects.back().X_WB.p = {0.0, 0.022, 0.022};
  if (contact == ContactModel::kSurface && !scene.features.compliance) {
    scene.objects.back().moved = 1;
    MovedGroup& shakes = scene.moved.emplace_back();
    shakes.name = "shakes";
    shakes.keys = {{}, {50, 0.0, {0.0, 0.001, 0.0}}, {100, 0.0, {}}};
    shakes.repeats = true;
  }
  scene.tools.push_back(
      MakeBody("probe", MakeBox({0.01, 0.01, 0.01}), {.leaves = 32, .contact = contact}));
  return MakeModel(scene, scene.tools[0], MakeObjects(scene));
}

/// A hand that presses the probe on, turns it and draws it to and fro.
Pose HandAt(int step) {
  const double t = 0.01 * step;
  return {Vec3(0.006 * std::sin(t), 0.026 - 0.002 * std::sin(0.7 * t), 0.01 * std::cos(0.6 * t)),
          RotationExp(Vec3(0.3 * std::sin(0.5 * t), 0.2 * std::sin(t), 0.1))};
}

Bytes StateOfProxy(const Proxy& proxy) {
  return ToBytes(proxy.model(), {proxy.state(), proxy.start_depth()});
}

void ExpectToContinueAlike(Proxy& one, Proxy& other, int from, int to) {
  for (int step = from; step < to; ++step) {
    const StepReport a = one.Step(HandAt(step)), b = other.Step(HandAt(step));
    ASSERT_EQ(std::memcmp(&a.wrench, &b.wrench, sizeof a.wrench), 0) << step;
    ASSERT_EQ(std::memcmp(&a.X_WG.p, &b.X_WG.p, sizeof(Vec3)), 0) << step;
    ASSERT_EQ(std::memcmp(&a.X_WG.q, &b.X_WG.q, sizeof(Quat)), 0) << step;
    ASSERT_EQ(a.contacts, b.contacts);
  }
}

struct Case {
  ContactModel contact;
  double stiffness;
};
class StateBytes : public ::testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(Contact, StateBytes,
                         ::testing::Values(Case{ContactModel::kSurface, INFINITY},
                                           Case{ContactModel::kSpheres, INFINITY},
                                           Case{ContactModel::kSpheres, 800.0}));

TEST_P(StateBytes, LetAProxyOfAnEqualModelContinueToTheSameBits) {
  const auto [contact, stiffness] = GetParam();
  const HapticModel model = RoughBlock(contact, 0.04, stiffness);
  const HapticModel equal = RoughBlock(contact, 0.04, stiffness);
  Proxy proxy(model, HandAt(0));
  int touched = 0;
  for (int step = 0; step < 460; ++step) {
    touched += proxy.Step(HandAt(step)).contacts > 0;
    if (step % 150 != 149) continue;
    const Bytes bytes = StateOfProxy(proxy);
    const ProxyState state = StateOf(equal, bytes);
    EXPECT_EQ(ToBytes(equal, state), bytes);
    Proxy there(equal, state.step, state.start_depth), here(model, proxy.state(), 0.0);
    ExpectToContinueAlike(here, there, step + 1, step + 120);
  }
  EXPECT_GT(touched, 150);
}

void ExpectRefused(const HapticModel& model, const Bytes& bytes, const std::string& word) {
  try {
    StateOf(model, bytes);
    ADD_FAILURE() << "accepted, but should say: " << word;
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
  }
}

TEST_P(StateBytes, AreRefusedIfTheyAreOthers) {
  const auto [contact, stiffness] = GetParam();
  const HapticModel model = RoughBlock(contact, 0.04, stiffness);
  const Bytes bytes = StateOfProxy(Proxy(model, HandAt(0)));
  ExpectRefused(RoughBlock(contact, 0.0400001, stiffness), bytes, "another model");
  ExpectRefused(model, {}, "no state");
  Bytes of_another_revision = bytes;
  of_another_revision[16] = 'z';
  ExpectRefused(model, of_another_revision, "z");
  for (std::size_t size = 1; size < bytes.size(); size += 1 + size / 9) {
    ExpectRefused(model, Bytes(bytes.begin(), bytes.begin() + std::ptrdiff_t(size)), "state");
  }
  Random random(1);
  for (int i = 0; i < 80; ++i) {
    Bytes flipped = bytes;
    const auto bit = static_cast<std::size_t>(random.Uniform(0.0, 8.0 * double(bytes.size())));
    flipped[bit / 8] ^= static_cast<std::uint8_t>(1u << bit % 8);
    EXPECT_THROW(StateOf(model, flipped), Error) << bit;
  }
}

/// The hash at the end made right again, as an attacker would.
void Seal(Bytes& bytes) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (std::size_t i = 0; i + 8 < bytes.size(); ++i) hash = (hash ^ bytes[i]) * 0x100000001b3u;
  std::memcpy(bytes.data() + bytes.size() - 8, &hash, 8);
}

TEST_P(StateBytes, AreSafeToStepWhateverIsForged) {
  const auto [contact, stiffness] = GetParam();
  const HapticModel model = RoughBlock(contact, 0.04, stiffness);
  Proxy proxy(model, HandAt(0));
  for (int step = 0; step < 400; ++step) proxy.Step(HandAt(step));
  const Bytes bytes = StateOfProxy(proxy);
  Random random(2);
  int refused = 0;
  for (int i = 0; i < 150; ++i) {
    Bytes forged = bytes;
    const int flips = 1 + i % 3;
    for (int flip = 0; flip < flips; ++flip) {
      // Half of them among the small members, the others anywhere.
      const double most =
          flip % 2 == 0 ? std::min(3000.0, double(forged.size())) : double(forged.size());
      const auto bit = static_cast<std::size_t>(random.Uniform(8.0 * 40.0, 8.0 * most));
      forged[std::min(bit / 8, forged.size() - 9)] ^= static_cast<std::uint8_t>(1u << bit % 8);
    }
    Seal(forged);
    try {
      const ProxyState state = StateOf(model, forged);
      Proxy there(model, state.step, state.start_depth);
      for (int step = 400; step < 430; ++step) {
        const StepReport report = there.Step(HandAt(step));
        ASSERT_GE(report.contacts, 0);
      }
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 2);
  EXPECT_LT(refused, 150);
}

}  // namespace
}  // namespace palpate::test
