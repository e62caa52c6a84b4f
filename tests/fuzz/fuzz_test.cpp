// Files that come from elsewhere, spoilt at random: each is read, or refused by an Error that names
// it.  assimp, which reads 3DS, may die of one, for it dies in a process of its own; nothing of
// ours may.  PALPATE_FUZZ_TRIES=1000000 palpate_fuzz_tests runs as many of each;
// PALPATE_FUZZ_TRY=17 writes that try's input into a file and runs it alone.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/error.h"
#include "scenes/files/scene_bundle.h"
#include "scenes/importer/mesh_reader.h"
#include "scenes/mesh/mesh_mend.h"
#include "scenes/mesh/mesh_report.h"
#include "scenes/mesh/mesh_solid.h"
#include "scenes/mesh/mesh_spike.h"
#include "scenes/scene_verdict.h"
#include "scenes/tree/sphere_tree_builder.h"
#include "server/physics/scene_model.h"
#include "tests/fuzz/spoilt_bytes.h"
#include "tests/fuzz/worker.h"
#include "tests/scenes/support.h"
#include "tests/support/exported_box.h"
#include "tests/support/optimised.h"
#include "tests/support/read_file.h"
#include "tests/support/written_mesh.h"

namespace palpate {
namespace {

using test::Code;
using test::Spoilt;
using test::Tries;
using test::Worker;
using testing::IsEmpty;

constexpr std::size_t kBriefly = test::kOptimised ? 3000 : 300;

std::string InputOf(const std::string& good, std::size_t number) {
  test::Random random(static_cast<std::uint32_t>(number) + 1);
  return Spoilt(good, random);
}

/// Runs the tries, or the one that the environment names, and tells their figures.
void Fuzz(const std::string& name, const std::vector<std::string>& seeds,
          const std::function<bool(const std::string& input, std::string& fault)>& run) {
  const auto input_of = [&](std::size_t n) { return InputOf(seeds[n % seeds.size()], n); };
  if (const char* const one = std::getenv("PALPATE_FUZZ_TRY")) {
    const std::string input = input_of(std::strtoull(one, nullptr, 10));
    const std::string file = testing::TempDir() + "fuzz-" + one + "-" + name;
    std::printf("%s\n", test::WriteFile(file, input).c_str());
    Worker::RunAll(1, [&](std::size_t, std::string& fault) { return run(input, fault); });
    return;
  }
  // What is not spoilt is accepted; and what is bound, read and laid out for that, each of the many
  // workers inherits.
  std::string complaint;
  EXPECT_TRUE(run(seeds.front(), complaint)) << complaint;
  const Tries tries =
      Worker::RunAll(test::TriesOr(kBriefly),
                     [&](std::size_t n, std::string& fault) { return run(input_of(n), fault); });
  std::printf("%s: %zu tries, %zu accepted, %zu deaths of assimp, %zu MB at most\n", name.c_str(),
              tries.done, tries.accepted, tries.deaths_in_theirs, tries.peak_bytes >> 20);
  EXPECT_THAT(tries.faults, IsEmpty());
  EXPECT_GT(tries.accepted, 0u) << "else nothing but refusals was tried";
  EXPECT_LT(tries.accepted, tries.done) << "else nothing was refused";
}

/// Of an Error's text, a fault where it does not name the file.
std::string FaultOf(const Error& error, const std::string& name) {
  const std::string text = error.what();
  return text.starts_with(name) ? "" : "a refusal does not name the file: " + text;
}

/// A box, and small meshes in other layouts of its format.
std::vector<std::string> SeedsOf(const std::string& file, const std::string& box) {
  std::vector<std::string> seeds{box};
  for (std::uint32_t seed = 1; seed <= 16; ++seed) {
    test::AnyHand hand(seed);
    const TriangleMesh mesh = hand.Mesh();
    if (file.ends_with("obj")) seeds.push_back(test::AnyObj(mesh, hand));
    if (file.ends_with("stl")) seeds.push_back(test::AnyStl(mesh, hand));
    if (file.ends_with("ply")) seeds.push_back(test::AnyPly(mesh, hand));
    if (file.ends_with("glb")) seeds.push_back(test::AnyGlb(mesh, hand));
  }
  return seeds;
}

class FuzzedMesh : public testing::TestWithParam<std::pair<const char*, const char*>> {};

/// All that the mesh's process does, and then what its user does with what came of it.
TEST_P(FuzzedMesh, IsReadOrRefusedByName) {
  const auto [exporter, name] = GetParam();
  const std::string folder = test::FreshFolder();
  const std::string file = folder + "/" + name;
  const std::string good = ReadWholeFile(test::ExportBox(exporter, file));
  Fuzz(name, SeedsOf(file, good), [&](const std::string& input, std::string& fault) {
    try {
      if (file.ends_with(".3ds")) Worker::Enter(Code::kTheirs);
      const std::string packet = PackMesh(ReadMeshText(file, input));
      Worker::Enter(Code::kOurs);
      ImportedMesh read = UnpackMesh(packet);
      if (!InspectMesh(read.mesh).refusal.empty()) return true;
      MendMesh(read.mesh, &read.groups);
      FindSpike(read.mesh);
      SolidOf(read.mesh);
      return true;
    } catch (const Error& error) {
      fault = FaultOf(error, file);
    } catch (const std::bad_alloc&) {  // palpate-import says so
    }
    return false;
  });
}

INSTANTIATE_TEST_SUITE_P(
    Files, FuzzedMesh,
    testing::Values(std::pair{"obj", "box.obj"}, std::pair{"stl", "text.stl"},
                    std::pair{"stlb", "binary.stl"}, std::pair{"ply", "text.ply"},
                    std::pair{"plyb", "binary.ply"}, std::pair{"3ds", "box.3ds"},
                    std::pair{"gltf2", "box.gltf"}, std::pair{"glb2", "box.glb"}),
    [](const auto& given) {
      std::string file = given.param.second;
      std::replace(file.begin(), file.end(), '.', '_');
      return file;
    });

Scene SmallScene() {
  Scene scene;
  scene.name = "small";
  Body ball{"ball", MakeSphere(0.005, 20), {}, {}};
  ball.tree = SingleSphereTree(ball.mesh, {Vec3::Zero(), 0.005});
  Body box{"box", MakeBox(Vec3(0.1, 0.2, 0.3)), {}, {}};
  box.tree = BuildSphereTree(box.mesh, 20);
  scene.tools = {ball};
  scene.objects = {box, box};
  scene.objects[1].name = "other";
  return scene;
}

/// What is wrong with a scene whose numbers the physics is to index with: said here once more, and
/// otherwise than the loader says it.
std::string FaultOf(const Scene& scene) {
  std::string fault;
  const auto check = [&](bool holds, const char* what) {
    if (!holds && fault.empty()) fault = what;
  };
  check(std::isfinite(scene.coupling.stiffness) && scene.coupling.stiffness > 0.0, "coupling");
  for (const auto* bodies : {&scene.tools, &scene.objects}) {
    for (const Body& body : *bodies) {
      for (const Vec3& v : body.mesh.vertices) check(v.allFinite(), "vertex");
      for (const auto& triangle : body.mesh.triangles) {
        for (const auto corner : triangle) check(corner < body.mesh.vertices.size(), "triangle");
      }
      const SphereTree& tree = body.tree;
      const std::size_t leaves = tree.leaves();
      for (const auto* column : {&tree.leaf_x, &tree.leaf_y, &tree.leaf_z, &tree.leaf_radius}) {
        check(column->size() == leaves, "leaves");
        for (const double x : *column) check(std::isfinite(x), "leaf");
      }
      for (const double r : tree.leaf_radius) check(r > 0.0, "radius");
      const auto& begin = tree.leaf_triangle_begin;
      check(begin.size() == leaves + 1 && std::ranges::is_sorted(begin) &&
                begin.back() == tree.leaf_triangle.size(),
            "leaves' triangles");
      for (const auto t : tree.leaf_triangle)
        check(t < body.mesh.triangles.size(), "leaf triangle");
      // Every leaf is reached once from the top.
      check(std::ranges::is_sorted(tree.level_begin) &&
                static_cast<std::size_t>(tree.level_begin.back()) == tree.packets.size(),
            "levels");
      std::vector<int> reached(leaves, 0);
      for (int l = 0; fault.empty() && l < tree.levels(); ++l) {
        const bool lowest = l + 1 == tree.levels();
        const std::size_t below = lowest ? leaves : tree.level(l + 1).size();
        for (const SpherePacket& packet : tree.level(l)) {
          for (const auto child : packet.child) {
            if (child < 0) continue;
            check(static_cast<std::size_t>(child) < below, "child");
            if (lowest && fault.empty()) ++reached[static_cast<std::size_t>(child)];
          }
        }
      }
      check(std::ranges::count(reached, 1) == static_cast<std::ptrdiff_t>(leaves), "way to a leaf");
      check(body.X_WB.p.allFinite() && std::abs(body.X_WB.q.norm() - 1.0) < 1e-6, "pose");
      check(!body.materials.empty() &&
                (body.leaf_material.empty() || body.leaf_material.size() == leaves),
            "materials");
      for (const auto m : body.leaf_material) check(m < body.materials.size(), "leaf's material");
    }
  }
  return fault;
}

/// What follows the header is spoilt, and the header made to agree: its checksum is no secret.
TEST(FuzzedBundle, IsReadOrRefusedByName) {
  constexpr std::size_t kHeader = 40, kKey = 16, kSize = 24, kChecksum = 32;
  const std::vector<std::uint8_t> bytes = PackScene(SmallScene());
  const std::string good(bytes.begin() + kHeader, bytes.end());
  const std::string name = "folder/small.palpate";
  Fuzz("small.palpate", {good}, [&](const std::string& input, std::string& fault) {
    std::vector<std::uint8_t> bundle(bytes.begin(), bytes.begin() + kHeader);
    bundle.insert(bundle.end(), input.begin(), input.end());
    std::uint64_t key = 0;
    std::memcpy(&key, bundle.data() + kKey, sizeof key);
    const std::uint64_t size = input.size(), checksum = HashBytes(input, key);
    std::memcpy(bundle.data() + kSize, &size, sizeof size);
    std::memcpy(bundle.data() + kChecksum, &checksum, sizeof checksum);
    try {
      const Scene scene = UnpackScene(bundle, name);
      fault = FaultOf(scene);
      if (!JudgeScene(scene).usable()) return true;  // the server goes no further
      const auto objects = MakeObjects(scene);
      for (const Body& tool : scene.tools) MakeModel(scene, tool, objects);
      return true;
    } catch (const Error& error) {
      fault = FaultOf(error, name);
    }
    return false;
  });
}

}  // namespace
}  // namespace palpate
