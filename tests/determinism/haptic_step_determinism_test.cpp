#include <array>
#include <cmath>
#include <functional>
#include <thread>

#include <gtest/gtest.h>
#include <xmmintrin.h>

#include "common/math/rotation.h"
#include "scenes/shapes/shapes.h"
#include "scenes/tree/sphere_tree_builder.h"
#include "server/physics/scene_model.h"
#include "tests/support/step_bench.h"

namespace palpate {
namespace {

using test::AllOf;
using test::At;
using test::Bench;
using test::Floor;
using test::Paint;
using test::Random;
using test::RandomBalls;

/// Hash of every bit of a run of poses and wrenches (FNV-1a, 64 bits).
class BitHash {
 public:
  void Add(const StepReport& report) {
    AddBytes(report.wrench.force.data(), 3 * sizeof(double));
    AddBytes(report.wrench.torque.data(), 3 * sizeof(double));
    AddBytes(report.X_WG.p.data(), 3 * sizeof(double));
    AddBytes(report.X_WG.q.coeffs().data(), 4 * sizeof(double));
    AddBytes(&report.faults, sizeof(report.faults));
  }
  std::uint64_t value() const { return hash_; }

 private:
  void AddBytes(const void* data, std::size_t n) {
    const auto* bytes = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < n; ++i) hash_ = (hash_ ^ bytes[i]) * 0x100000001b3ull;
  }
  std::uint64_t hash_ = 0xcbf29ce484222325ull;
};

std::uint64_t Run(const StepParameters& parameters, const Paint& paint) {
  Random random(59);
  Bench bench(RandomBalls(random, 150, 0.02, 0.004), RandomBalls(random, 400, 0.05, 0.004),
              parameters, paint);
  bench.state().X_WG = At(0.0, 0.0, 0.12);
  BitHash hash;
  Pose X = At(0.0, 0.0, 0.12), goal = X;
  for (int i = 0; i < 1500; ++i) {
    if (i % 250 == 0) {
      goal.p = random.InCube(0.05);
      goal.q = random.Rotation();
    }
    X.p += 0.02 * (goal.p - X.p);
    X.q = RotationExp(0.02 * RotationLog(goal.q * X.q.conjugate())) * X.q;
    hash.Add(bench.Step(X));
  }
  return hash.value();
}

std::uint64_t GoldenRun(FrictionModel friction = FrictionModel::kOff) {
  StepParameters parameters;
  parameters.features.friction = friction;
  Material rough;
  rough.static_friction = 0.8;
  rough.dynamic_friction = 0.3;
  return Run(parameters, AllOf(rough));
}

/// The same with soft and rigid slices of 2 mm, counting every output.
std::uint64_t GoldenRunOfMaterials() {
  StepParameters parameters;
  parameters.features.compliance = true;
  const Paint slices{{Material{.stiffness = 200.0}, Material{}, Material{}},
                     [](const Vec3& c) { return static_cast<int>(500.0 * (c.x() + 1.0)) % 3; }};
  return Run(parameters, slices);
}

/// A large ellipsoid, and a small one or a box as the tool.  Coarse, because without optimisation,
/// or with sanitizers, a step takes a hundred times as long.
Scene MeshScene(bool box) {
  const auto body = [](TriangleMesh mesh, std::size_t leaves) {
    Body made;
    made.mesh = std::move(mesh);
    made.tree = BuildSphereTree(made.mesh, leaves);
    return made;
  };
  Scene scene;
  scene.tools.push_back(box ? body(MakeBox(Vec3(0.01, 0.02, 0.015)), 32)
                            : body(MakeEllipsoid(Vec3(0.01, 0.015, 0.02), 80), 32));
  scene.objects.push_back(body(MakeEllipsoid(Vec3(0.04, 0.025, 0.03), 320), 64));
  return scene;
}

/// Between meshes: the tool wanders over the large ellipsoid.
std::uint64_t GoldenRunOfMeshes(const std::array<Scene, 2>& scenes) {
  BitHash hash;
  for (const Scene& scene : scenes) {
    const HapticModel model = MakeModel(scene, scene.tools.front(), MakeObjects(scene));
    StepWorkspace workspace(model);
    StepState state(model);
    state.X_WG.p = Vec3(0.0, 0.0, 0.08);
    Random random(61);
    Pose X = state.X_WG, goal = X;
    for (int i = 0; i < 240; ++i) {
      if (i % 80 == 0) {
        goal.p = random.InCube(0.04);
        goal.q = random.Rotation();
      }
      X.p += 0.06 * (goal.p - X.p);
      X.q = RotationExp(0.06 * RotationLog(goal.q * X.q.conjugate())) * X.q;
      hash.Add(HapticStep(model, X, state, workspace));
    }
  }
  return hash.value();
}

// Debug and Release builds, every SIMD level and every machine give this hash.  Only an intended
// change of the physics may change it.
constexpr std::uint64_t kGoldenHash = 9439665412190326790u;
constexpr std::uint64_t kGoldenChapterHash = 12772718893363948445u;
constexpr std::uint64_t kGoldenCoulombHash = 16843774313738242704u;
constexpr std::uint64_t kGoldenHashOfMaterials = 3924097277385133357u;
constexpr std::uint64_t kGoldenHashOfMeshes = 7634417535695629458u;

/// Runs `check` with each inner loop that this machine supports.
void AtEverySimdLevel(const std::function<void()>& check) {
  const Kernels* level[3];
  const int levels = AvailableKernels(level);
  const Kernels& chosen = ActiveKernels();
  for (int k = 0; k < levels; ++k) {
    SCOPED_TRACE(level[k]->name);
    UseKernels(*level[k]);
    check();
  }
  UseKernels(chosen);
}

TEST(HapticStepDeterminism, GivesTheGoldenBitsAtEverySimdLevel) {
  AtEverySimdLevel([] {
    EXPECT_EQ(GoldenRun(), kGoldenHash);
    EXPECT_EQ(GoldenRun(FrictionModel::kChapter), kGoldenChapterHash);
    EXPECT_EQ(GoldenRun(FrictionModel::kCoulomb), kGoldenCoulombHash);
    EXPECT_EQ(GoldenRunOfMaterials(), kGoldenHashOfMaterials);
  });
}

// A test of its own, so that another core may run it: without optimisation it takes most of a
// minute.
TEST(HapticStepDeterminism, GivesTheGoldenBitsBetweenMeshesAtEverySimdLevel) {
  const std::array<Scene, 2> scenes{MeshScene(false), MeshScene(true)};
  AtEverySimdLevel([&] { EXPECT_EQ(GoldenRunOfMeshes(scenes), kGoldenHashOfMeshes); });
}

TEST(HapticStepDeterminism, GivesTheGoldenBitsInEveryThread) {
  std::uint64_t hash[2] = {0, 0};
  std::thread other([&] { hash[1] = GoldenRun(); });
  hash[0] = GoldenRun();
  other.join();
  EXPECT_EQ(hash[0], kGoldenHash);
  EXPECT_EQ(hash[1], kGoldenHash);
}

// MXCSR of hosts: rounding downward, upward and to zero; subnormal numbers taken for zero, as after
// -ffast-math; every exception a signal.
TEST(HapticStepDeterminism, GivesTheSameBitsWhateverArithmeticTheHostHasLeft) {
  const auto run = [](unsigned host) {
    const unsigned before = _mm_getcsr();
    const auto as_host = [&](const auto& call) {
      _mm_setcsr(host);
      auto result = call();
      EXPECT_EQ(_mm_getcsr() & 0xFFC0, host);
      _mm_setcsr(before);
      return result;
    };
    const Scene scene = MeshScene(false);
    const HapticModel model =
        as_host([&] { return MakeModel(scene, scene.tools.front(), MakeObjects(scene)); });
    StepWorkspace workspace(model);
    StepState state(model);
    state.X_WG.p = Vec3(0.0, 0.0, 0.08);
    BitHash hash;
    for (int i = 0; i < 60; ++i) {
      const Pose X = At(1e-4 * i, 3e-5 * i, 0.08 - 2e-3 * i);
      hash.Add(as_host([&] { return HapticStep(model, X, state, workspace); }));
    }
    return hash.value();
  };
  constexpr unsigned kUsual = 0x1F80;
  for (const unsigned host : {0x3F80u, 0x5F80u, 0x7F80u, 0x9FC0u, 0x0000u}) {
    EXPECT_EQ(run(host), run(kUsual)) << std::hex << host;
  }
}

TEST(HapticStepDeterminism, GivesTheSameBitsFromACopiedState) {
  Random random(60);
  Bench bench(RandomBalls(random, 100, 0.02, 0.004), Floor(0.05, 0.004, 0.004));
  bench.state().X_WG = At(0.0, 0.0, 0.05);
  StepWorkspace second(bench.model());
  for (int i = 0; i < 2000; ++i) {
    Pose X = At(0.0, 1e-3 * std::sin(0.01 * i), 0.05 - 3e-5 * i);
    X.q = RotationExp(Vec3(1e-3 * i, 0.0, 0.0));
    StepState copy = bench.state();
    BitHash a, b;
    b.Add(HapticStep(bench.model(), X, copy, second));
    a.Add(bench.Step(X));
    ASSERT_EQ(a.value(), b.value()) << i;
  }
}

}  // namespace
}  // namespace palpate
