#include "scenes/files/scene_bundle.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/tree/sphere_tree_builder.h"
#include "tests/scenes/support.h"
#include "tests/support/read_file.h"

namespace palpate {
namespace {

using test::ComplaintOf;
using testing::AnyOf;
using testing::HasSubstr;

Scene BuiltSmallScene() {
  Scene scene;
  scene.name = "small";
  Body ball{"ball", MakeSphere(0.005, 20), {}, {}};
  ball.tree = SingleSphereTree(ball.mesh, {Vec3::Zero(), 0.005});
  ball.X_WB.p = Vec3(0, 0.1, 0);
  Body box{"box", MakeBox(Vec3(0.1, 0.2, 0.3)), {}, {}};
  box.tree = BuildSphereTree(box.mesh, 20);
  box.X_WB.q = Quat(0.6, 0, 0.8, 0);
  scene.tools = {ball};
  scene.objects = {box, box};
  scene.objects[1].name = "other";
  scene.coupling = {500, 0.25};
  scene.tuning = {2e-6, 1e-3, 16, 32, 6800, 5};
  scene.features = {ContactModel::kSpheres, FrictionModel::kCoulomb, true};
  scene.objects[1].materials = {{}, {2000, 0.8, 0.3}};
  scene.objects[1].leaf_material.assign(20, 0);
  scene.objects[1].leaf_material[7] = 1;
  scene.objects[1].moved = 1;
  MovedGroup& jaw = scene.moved.emplace_back();
  jaw.name = "jaw";
  jaw.point = {0.1, 0.2, 0.3};
  jaw.axis = Vec3::UnitY();
  jaw.keys = {{}, {500, 0.25, {0.01, 0.02, 0.03}}};
  jaw.repeats = false;
  FreeBody& free = scene.moved.emplace_back(MovedGroup{.name = "block"}).free.emplace();
  free.mass = 0.05;
  free.centre = {0.1, 0.2, 0.3};
  free.inertia << 3e-6, 1e-7, 2e-7, 1e-7, 4e-6, 3e-7, 2e-7, 3e-7, 5e-6;
  free.joint = {
      BodyJoint::Kind::kSprings, {0.4, 0.5, 0.6}, Vec3::UnitX(), -0.5, 0.25, 1e4, 2.0, 0.3, 0.01};
  scene.gravity = {0.0, -9.81, 0.0};
  return scene;
}

Scene SmallScene() {
  static const Scene built = BuiltSmallScene();
  return built;
}

bool SameMaterials(const std::vector<Material>& a, const std::vector<Material>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const Material& m, const Material& n) {
                      return m.stiffness == n.stiffness && m.static_friction == n.static_friction &&
                             m.dynamic_friction == n.dynamic_friction;
                    });
}

std::string Complaint(std::span<const std::uint8_t> bytes) {
  return ComplaintOf([&] { UnpackScene(bytes, "s.palpate"); });
}

// As earlier programs wrote it: the byte after that of compliance.
TEST(SceneBundle, RefusesASceneWhoseLeavesWearAway) {
  Scene scene = SmallScene();
  std::vector<std::uint8_t> bytes = PackScene(scene);
  scene.features.compliance = false;
  const std::vector<std::uint8_t> rigid = PackScene(scene);
  constexpr std::ptrdiff_t kHeader = 40, kChecksum = 32;
  *std::next(std::mismatch(bytes.begin() + kHeader, bytes.end(), rigid.begin() + kHeader).first) =
      1;
  const std::string payload(bytes.begin() + kHeader, bytes.end());
  const std::uint64_t checksum = HashBytes(payload, 0);
  std::memcpy(bytes.data() + kChecksum, &checksum, sizeof checksum);
  EXPECT_THAT(Complaint(bytes), HasSubstr("removes material leaf by leaf"));
}

TEST(SceneBundle, GivesBackTheScene) {
  const Scene scene = SmallScene();
  const auto bytes = PackScene(scene, 7);
  EXPECT_EQ(ContentKey(bytes, "s"), 7u);
  const Scene back = UnpackScene(bytes, "s");
  EXPECT_EQ(back.name, "small");
  EXPECT_EQ(back.coupling.stiffness, 500);
  EXPECT_EQ(back.coupling.torsional_stiffness, 0.25);
  EXPECT_EQ(back.tuning, scene.tuning);
  EXPECT_EQ(back.features.contact, ContactModel::kSpheres);
  EXPECT_EQ(back.features.friction, FrictionModel::kCoulomb);
  EXPECT_TRUE(back.features.compliance);
  EXPECT_EQ(back.gravity, scene.gravity);
  ASSERT_EQ(back.moved.size(), 2u);
  EXPECT_EQ(back.moved[0].keys[1].shift, scene.moved[0].keys[1].shift);
  EXPECT_FALSE(back.moved[0].free);
  const FreeBody &free = *scene.moved[1].free, &free_back = *back.moved[1].free;
  EXPECT_EQ(free_back.mass, free.mass);
  EXPECT_EQ(free_back.centre, free.centre);
  EXPECT_EQ(free_back.inertia, free.inertia);
  EXPECT_EQ(free_back.joint.kind, free.joint.kind);
  EXPECT_EQ(free_back.joint.point, free.joint.point);
  EXPECT_EQ(free_back.joint.high, free.joint.high);
  EXPECT_EQ(free_back.joint.torsional_damping, free.joint.torsional_damping);
  ASSERT_EQ(back.tools.size(), 1u);
  ASSERT_EQ(back.objects.size(), 2u);
  EXPECT_EQ(back.objects[1].name, "other");
  for (const auto& [a, b] : {std::pair{&scene.tools[0], &back.tools[0]},
                             {&scene.objects[0], &back.objects[0]},
                             {&scene.objects[1], &back.objects[1]}}) {
    EXPECT_EQ(a->name, b->name);
    EXPECT_EQ(a->X_WB.p, b->X_WB.p);
    EXPECT_EQ(a->X_WB.q.coeffs(), b->X_WB.q.coeffs());
    EXPECT_EQ(a->mesh.vertices, b->mesh.vertices);
    EXPECT_EQ(a->mesh.triangles, b->mesh.triangles);
    EXPECT_EQ(a->tree.leaf_x, b->tree.leaf_x);
    EXPECT_EQ(a->tree.leaf_y, b->tree.leaf_y);
    EXPECT_EQ(a->tree.leaf_z, b->tree.leaf_z);
    EXPECT_EQ(a->tree.leaf_radius, b->tree.leaf_radius);
    EXPECT_EQ(a->tree.level_begin, b->tree.level_begin);
    EXPECT_EQ(a->tree.leaf_triangle_begin, b->tree.leaf_triangle_begin);
    EXPECT_EQ(a->tree.leaf_triangle, b->tree.leaf_triangle);
    EXPECT_EQ(a->tree.centroid, b->tree.centroid);
    EXPECT_EQ(a->leaf_material, b->leaf_material);
    EXPECT_TRUE(SameMaterials(a->materials, b->materials));
    ASSERT_EQ(a->tree.packets.size(), b->tree.packets.size());
    for (std::size_t p = 0; p < a->tree.packets.size(); ++p) {
      EXPECT_EQ(std::memcmp(&a->tree.packets[p], &b->tree.packets[p], sizeof(SpherePacket)), 0);
    }
  }
  EXPECT_EQ(PackScene(back, 7), bytes);
}

TEST(SceneBundle, GivesBackHowItIsToBeSeen) {
  Scene scene = SmallScene();
  EXPECT_FALSE(UnpackScene(PackScene(scene), "s").first_sight.has_value());
  scene.objects[0].look = "gum";
  scene.objects[0].ambient.assign(scene.objects[0].mesh.vertices.size(), 200);
  scene.objects[0].margin = {Vec3(0, 1, 0), Vec3(1, 1, 0), Vec3(0, 1, 1)};
  scene.first_sight = {Vec3(1, 2, 3), 0.5, Vec3(0.6, 0, 0.8)};
  const Scene back = UnpackScene(PackScene(scene), "s");
  EXPECT_EQ(back.objects[0].look, "gum");
  EXPECT_EQ(back.objects[0].ambient, scene.objects[0].ambient);
  EXPECT_EQ(back.objects[0].margin, scene.objects[0].margin);
  EXPECT_TRUE(back.objects[1].margin.empty());
  EXPECT_EQ(back.objects[1].look, "");
  ASSERT_TRUE(back.first_sight.has_value());
  EXPECT_EQ(back.first_sight->centre, scene.first_sight->centre);
  EXPECT_EQ(back.first_sight->radius, 0.5);
  EXPECT_EQ(back.first_sight->from, scene.first_sight->from);

  scene.objects[0].margin[1].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(Complaint(PackScene(scene)), HasSubstr("a margin is invalid"));
  scene.objects[0].margin.clear();
  scene.objects[0].ambient.pop_back();
  EXPECT_THAT(Complaint(PackScene(scene)), HasSubstr("the vertices' light does not add up"));
}

TEST(SceneBundle, SaysHowEachTreeStandsForItsMesh) {
  Scene scene = SmallScene();
  EXPECT_EQ(scene.tools[0].tree.origin, TreeOrigin::kBall);
  EXPECT_EQ(scene.objects[0].tree.origin, TreeOrigin::kInside);
  for (int origin = 0; origin <= static_cast<int>(TreeOrigin::kBall); ++origin) {
    scene.objects[1].tree.origin = static_cast<TreeOrigin>(origin);
    const Scene back = UnpackScene(PackScene(scene, 0, Remarks::kKeep), "s");
    EXPECT_EQ(back.tools[0].tree.origin, TreeOrigin::kBall);
    EXPECT_EQ(back.objects[0].tree.origin, TreeOrigin::kInside);
    EXPECT_EQ(back.objects[1].tree.origin, scene.objects[1].tree.origin);
  }
  // Without remarks, as it travels, a scene has the same bytes in every version.
  const auto travelling = PackScene(scene);
  scene.objects[1].tree.origin = TreeOrigin::kUnknown;
  EXPECT_EQ(PackScene(scene), travelling);
  EXPECT_EQ(UnpackScene(travelling, "s").objects[0].tree.origin, TreeOrigin::kUnknown);
  scene.objects[1].tree.origin = static_cast<TreeOrigin>(99);
  EXPECT_THAT(Complaint(PackScene(scene, 0, Remarks::kKeep)),
              HasSubstr("its tree has an unknown origin"));
}

TEST(SceneBundle, KeepsGeometryThatBodiesShareOnce) {
  Scene one = SmallScene();
  one.objects.pop_back();
  EXPECT_LT(PackScene(SmallScene()).size(), PackScene(one).size() + 300);
}

TEST(SceneBundle, ReadsBytesThatAreNotAligned) {
  const auto bytes = PackScene(SmallScene());
  for (std::size_t offset = 1; offset < 8; ++offset) {
    std::vector<std::uint8_t> moved(offset, 0);
    moved.insert(moved.end(), bytes.begin(), bytes.end());
    EXPECT_EQ(UnpackScene(std::span(moved).subspan(offset), "s").name, "small");
  }
}

TEST(SceneBundle, RefusesEveryBeginningOfItself) {
  const auto bytes = PackScene(SmallScene());
  for (std::size_t size = 0; size < bytes.size(); size += size < 100 ? 1 : 97) {
    // A separate copy, so that a sanitizer detects a read beyond its end.
    const std::vector<std::uint8_t> part(bytes.begin(), bytes.begin() + size);
    EXPECT_THAT(Complaint(part), HasSubstr(size == 0 ? "is not a Palpate scene" : "is cut short"));
  }
}

TEST(SceneBundle, RefusesWhatIsLongerThanItSays) {
  auto bytes = PackScene(SmallScene());
  bytes.push_back(0);
  EXPECT_THAT(Complaint(bytes), HasSubstr("is longer than it says"));
}

TEST(SceneBundle, RefusesEveryFlippedBit) {
  const auto good = PackScene(SmallScene());
  for (std::size_t bit = 0; bit < 8 * good.size(); bit += bit < 8 * 40 ? 1 : 61) {
    auto bytes = good;
    bytes[bit / 8] ^= std::uint8_t(1u << bit % 8);
    const std::string complaint = Complaint(bytes);
    if (bit < 64) {
      EXPECT_THAT(complaint, HasSubstr("is not a Palpate scene bundle"));
    } else if (bit < 96) {
      EXPECT_THAT(complaint, HasSubstr("bundle version"));
    } else {
      EXPECT_THAT(complaint,
                  AnyOf(HasSubstr("is damaged"), HasSubstr("cut short"), HasSubstr("longer")));
    }
  }
}

TEST(SceneBundle, RefusesForeignFilesAndOtherVersions) {
  const std::string foreign = "solid box\nfacet normal 0 0 1\n";
  EXPECT_THAT(Complaint({reinterpret_cast<const std::uint8_t*>(foreign.data()), foreign.size()}),
              HasSubstr("s.palpate: is not a Palpate scene bundle; make one with"));
  EXPECT_FALSE(LooksLikeBundle(foreign));
  auto bytes = PackScene(SmallScene());
  EXPECT_TRUE(LooksLikeBundle({reinterpret_cast<const char*>(bytes.data()), bytes.size()}));
  bytes[8] = 99;
  EXPECT_THAT(Complaint(bytes),
              HasSubstr("has bundle version 99, this program reads 2; build it again"));
}

TEST(SceneBundle, RefusesAScenesThatContradictsItselfThoughItsChecksumIsRight) {
  using Mend = void (*)(Body&);
  const std::pair<Mend, const char*> cases[] = {
      {[](Body& b) { b.mesh.triangles[0][1] = 99; }, "a triangle names no vertex"},
      {[](Body& b) { b.mesh.vertices[0].x() = NAN; }, "a vertex is not finite"},
      {[](Body& b) { b.tree.leaf_x.pop_back(); }, "the leaves' counts differ"},
      {[](Body& b) { b.tree.leaf_radius[3] = -1; }, "a leaf is not a ball"},
      {[](Body& b) { b.tree.leaf_triangle[0] = 12; }, "a leaf names no triangle"},
      {[](Body& b) { b.tree.leaf_triangle_begin[1] = 9999; }, "do not add up"},
      {[](Body& b) { b.tree.level_begin[1] = 2; }, "the levels do not add up"},
      {[](Body& b) { b.tree.level_begin.pop_back(); }, "the levels do not add up"},
      {[](Body& b) { b.tree.packets[0].child[1] = 7; }, "children are out of order"},
      {[](Body& b) { b.tree.packets[0].child[0] = -1; }, "an empty lane is not empty"},
      {[](Body& b) { b.tree.packets.back().radius[0] = NAN; }, "a node is not a ball"},
      {[](Body& b) { b.tree.centroid.x() = INFINITY; }, "the centroid is not finite"},
      {[](Body& b) { b.X_WB.q.w() = 5; }, "the pose of a body is invalid"},
      {[](Body& b) { b.name = "a\n  verdict: good"; }, R"('a\n  verdict: good' is not a name)"},
      {[](Body& b) { b.name = "../a"; }, "'../a' is not a name"},
      {[](Body& b) { b.name = std::string(65, 'x'); }, "is not a name"},
      {[](Body& b) { b.materials.clear(); }, "a body is made of nothing"},
      {[](Body& b) { b.materials[0].stiffness = 0; }, "a material is invalid"},
      {[](Body& b) { b.materials[0].stiffness = NAN; }, "a material is invalid"},
      {[](Body& b) { b.materials[0].dynamic_friction = 0.1; }, "a material is invalid"},
      {[](Body& b) { b.materials[0].static_friction = INFINITY; }, "a material is invalid"},
      {[](Body& b) { b.leaf_material = {0}; }, "the leaves' materials do not add up"},
      {[](Body& b) { b.leaf_material.assign(20, 1); }, "a leaf names no material"},
  };
  for (const auto& [mend, why] : cases) {
    Scene scene = SmallScene();
    mend(scene.objects[0]);
    const std::string complaint = Complaint(PackScene(scene));
    EXPECT_THAT(complaint, HasSubstr("is inconsistent (")) << why;
    EXPECT_THAT(complaint, HasSubstr(why));
  }
  Scene scene = SmallScene();
  scene.coupling.stiffness = 0;
  EXPECT_THAT(Complaint(PackScene(scene)), HasSubstr("stiffness_N_per_m"));
  scene = SmallScene();
  scene.tuning.queries = 2'000'000'000;
  EXPECT_THAT(Complaint(PackScene(scene)), HasSubstr("queries is"));
  scene = SmallScene();
  scene.features.friction = static_cast<FrictionModel>(3);
  EXPECT_THAT(Complaint(PackScene(scene)), HasSubstr("its features are not known"));
}

TEST(WriteFileAtomically, ReplacesAFileAndLeavesNothingElse) {
  const std::string folder = test::FreshFolder();
  const std::string file = folder + "/file";
  const std::uint8_t bytes[] = {'o', 'n', 'e'};
  WriteFileAtomically(file, bytes);
  WriteFileAtomically(file, std::span(bytes).first(2));
  EXPECT_EQ(ReadWholeFile(file), "on");
  const std::filesystem::directory_iterator all(folder);
  EXPECT_EQ(std::distance(begin(all), end(all)), 1);
}

TEST(WriteFileAtomically, SaysWhereItCannotWrite) {
  const std::string folder = test::FreshFolder();
  const std::uint8_t bytes[] = {1};
  test::WriteFile(folder + "/file", "x");
  EXPECT_THAT(ComplaintOf([&] { WriteFileAtomically(folder + "/file/below", bytes); }),
              HasSubstr("file/below: cannot be written"));
  EXPECT_THAT(ComplaintOf([&] { WriteFileAtomically(folder, bytes); }),
              HasSubstr("cannot be written"));
  EXPECT_THAT(ComplaintOf([&] { WriteFileAtomically(folder + "/none/file", bytes); }),
              HasSubstr(folder + "/none"));
  EXPECT_FALSE(std::filesystem::exists(folder + "/none")) << "a save makes no folders";
}

}  // namespace
}  // namespace palpate
