// Mesh files that are cut short, inconsistent, or fatal to read: each is refused with an Error that
// names the file, and this process survives.
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "scenes/catalogue.h"
#include "scenes/files/scene_bundle.h"
#include "scenes/files/scene_size.h"
#include "scenes/mesh/mesh_import.h"
#include "scenes/mesh/mesh_report.h"
#include "scenes/tree/sphere_tree_builder.h"
#include "tests/scenes/support.h"
#include "tests/support/exported_box.h"
#include "tests/support/program.h"
#include "tests/support/read_file.h"

namespace palpate {
namespace {

using test::ComplaintOf;
using test::ExportBox;
using test::FreshFolder;
using test::WriteFile;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

std::string Import(const std::string& file) {
  return ComplaintOf([&] { ImportMesh(file); });
}

TEST(DamagedMesh, OfTextCutAmongItsFacesSaysHowManyThereAre) {
  const std::string file = ExportBox("ply", FreshFolder() + "/box.ply");
  const std::string text = ReadWholeFile(file);
  const std::size_t body = text.find("end_header\n") + 11;
  std::size_t end = body;
  for (int line = 0; line < 8 + 5; ++line) end = text.find('\n', end) + 1;
  WriteFile(file, text.substr(0, end));
  EXPECT_THAT(Import(file), AllOf(StartsWith(file), HasSubstr("declares 12 elements 'face'"),
                                  HasSubstr("5 are present"), HasSubstr("export")));
}

TEST(DamagedMesh, IsRefusedWhereverItIsCut) {
  for (const auto& [format, name] :
       {std::pair{"ply", "t.ply"}, {"plyb", "b.ply"}, {"stlb", "b.stl"}, {"glb2", "b.glb"}}) {
    const std::string file = ExportBox(format, FreshFolder() + "/" + name);
    const std::string whole = ReadWholeFile(file);
    // The last bytes of a text may be part of a number, which nothing can detect.
    for (std::size_t bytes = 1; bytes + 3 < whole.size(); bytes += bytes < 200 ? 9 : 97) {
      WriteFile(file, whole.substr(0, bytes));
      EXPECT_THAT(Import(file), StartsWith(file)) << bytes << " bytes";
    }
  }
}

TEST(DamagedMesh, WhoseTextEndsAmongItsFacetsIsRefused) {
  const std::string file = ExportBox("stl", FreshFolder() + "/box.stl");
  const std::string text = ReadWholeFile(file);
  const std::size_t facet = text.find("facet", text.size() / 2);
  WriteFile(file, text.substr(0, text.find("facet", facet + 5)));
  EXPECT_THAT(Import(file), AllOf(StartsWith(file), HasSubstr("facets")));
}

TEST(DamagedMesh, WithoutAnySceneIsRefused) {
  const std::string file = FreshFolder() + "/empty.glb";
  const std::uint32_t header[] = {0x46546c67, 2, 24, 4, 0x4e4f534a, 0x20207d7b};  // "{}  "
  WriteFile(file, {reinterpret_cast<const char*>(header), sizeof header});
  EXPECT_THAT(Import(file), StartsWith(file));
  WriteFile(file, {reinterpret_cast<const char*>(header), 16});
  EXPECT_THAT(Import(file), StartsWith(file));
}

/// A chunk of a 3DS: type, length, contents.
std::string Chunk(std::uint16_t type, const std::string& contents) {
  const auto length = static_cast<std::uint32_t>(6 + contents.size());
  return std::string(reinterpret_cast<const char*>(&type), 2) +
         std::string(reinterpret_cast<const char*>(&length), 4) + contents;
}

template <class T>
std::string Bytes(std::initializer_list<T> values) {
  return {reinterpret_cast<const char*>(std::data(values)), values.size() * sizeof(T)};
}

TEST(DamagedMesh, WhoseKeyframesNameNoMeshIsReadOrRefused) {
  const std::string object =
      Chunk(0x4000, std::string("box\0", 4) +
                        Chunk(0x4100, Chunk(0x4110, Bytes<std::uint16_t>({3}) +
                                                        Bytes<float>({0, 0, 0, 1, 0, 0, 0, 1, 0})) +
                                          Chunk(0x4120, Bytes<std::uint16_t>({1, 0, 1, 2, 0}))));
  for (const std::string node : {"box", "bax"}) {
    const std::string header = node + std::string(1, '\0') + Bytes<std::uint16_t>({0, 0, 0xffff});
    const std::string keys = Chunk(0xb000, Chunk(0xb002, Chunk(0xb010, header)));
    const std::string file =
        WriteFile(FreshFolder() + "/" + node + ".3ds", Chunk(0x4d4d, Chunk(0x3d3d, object) + keys));
    try {
      EXPECT_EQ(ImportMesh(file).triangles.size(), 1u) << node;
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), AllOf(StartsWith(file), HasSubstr("export it again")));
      EXPECT_EQ(node, "bax");
    }
  }
}

TEST(DamagedMesh, IsNotReadAsAnotherFormatThanItsName) {
  const std::string folder = FreshFolder();
  const std::string collada =
      "<?xml version=\"1.0\"?><COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" "
      "version=\"1.4.1\"></COLLADA>";
  for (const std::string name : {"a.glb", "a.gltf", "a.3ds", "a.stl", "a.ply"}) {
    const std::string file = folder + "/" + name;
    EXPECT_THAT(Import(WriteFile(file, collada)), StartsWith(file)) << name;
  }
  const std::string stl = ExportBox("stlb", folder + "/box.stl");
  for (const std::string name : {"box.glb", "box.ply", "box.3ds"}) {
    const std::string file = folder + "/" + name;
    std::filesystem::copy_file(stl, file);
    EXPECT_THAT(Import(file), StartsWith(file)) << name;
  }
}

TEST(DamagedMesh, ThatTakesTooMuchMemoryIsRefused) {
  // A sparse glTF accessor declares zeros without storing a byte for them.
  const std::string file = WriteFile(
      FreshFolder() + "/huge.gltf",
      R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
"buffers":[{"byteLength":8,"uri":"data:application/octet-stream;base64,AAAAAAAAAAA="}],
"bufferViews":[{"buffer":0,"byteLength":8}],
"accessors":[{"componentType":5126,"count":200000001,"type":"VEC3",
"sparse":{"count":1,"indices":{"bufferView":0,"componentType":5125},
"values":{"bufferView":0}}}]})");
  EXPECT_THAT(Import(file), StartsWith(file));
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // where memory has a limit
  EXPECT_THAT(Import(file), AllOf(HasSubstr("needs more memory"), HasSubstr("simplify it")));
#endif
}

TEST(DamagedMesh, IsReadByAProcessThatHasLimitedItself) {
  // A file that never begins: nobody writes into the pipe.
  const std::string pipe = FreshFolder() + "/pipe.obj";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  test::Program importer(test::OwnFolder() + "/palpate-import", {pipe});
  const std::string limits = "/proc/" + std::to_string(importer.id()) + "/limits";
  std::string found;
  for (int i = 0; i < 2000 && found.find("Max cpu time              10 ") == std::string::npos;
       ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    found = ReadWholeFile(limits);
  }
  EXPECT_THAT(found, HasSubstr("Max cpu time              10                   10 "));
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  while (importer.Runs() &&
         found.find("Max address space         1073741824 ") == std::string::npos) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    found = ReadWholeFile(limits);
  }
  EXPECT_THAT(found, HasSubstr("Max address space         1073741824           1073741824 "));
#endif
}

TEST(DamagedMesh, OfANeedleATreeIsBuiltInBoundedMemory) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "the sanitizers' memory has no limit";
#endif
  TriangleMesh cube = MakeBox(Vec3::Constant(1e-3));
  std::ranges::max_element(cube.vertices, {}, [](const Vec3& v) { return v.sum(); })->x() = 100.0;
  for (const TreeMode mode : {TreeMode::kInside, TreeMode::kBalanced}) {
    const auto build = [&] {
      const rlimit half_a_gigabyte{std::size_t{1} << 29, std::size_t{1} << 29};
      setrlimit(RLIMIT_AS, &half_a_gigabyte);
      BuildSphereTree(cube, 64, {}, mode);
      _exit(0);
    };
    EXPECT_EXIT(build(), testing::ExitedWithCode(0), "") << NameOf(mode);
  }
}

TEST(FilesOfMesh, AreTheBuffersThatItNamesToo) {
  const std::string folder = FreshFolder();
  const std::string file = ExportBox("gltf2", folder + "/box.gltf");
  EXPECT_THAT(FilesOfMesh(file), ElementsAre(file, folder + "/box.bin"));
  EXPECT_THAT(FilesOfMesh(ExportBox("glb2", folder + "/box.glb")),
              ElementsAre(folder + "/box.glb"));
  std::filesystem::remove(folder + "/box.bin");
  EXPECT_THAT(Import(file), AllOf(StartsWith(file), HasSubstr("box.bin")));
}

TEST(FilesOfMesh, MustStandBesideIt) {
  const std::string file = FreshFolder() + "/spy.gltf";
  for (const std::string uri : {"/etc/passwd", "../../secret.bin", "http://a/b", "%2e%2e/x"}) {
    WriteFile(file,
              R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":8,"uri":")" + uri + "\"}]}");
    EXPECT_THAT(ComplaintOf([&] { FilesOfMesh(file); }), HasSubstr("is outside")) << uri;
    EXPECT_THAT(Import(file), HasSubstr("is outside")) << uri;
  }
}

TEST(LoadScene, BuildsAnewWhereABufferOfItsMeshHasChanged) {
  const std::string folder = FreshFolder();
  ExportBox("gltf2", folder + "/box.gltf");
  const std::string scene =
      WriteFile(folder + "/s.json",
                R"({"tools":[{"name":"b","mesh":{"shape":"sphere","radius_m":0.1},"leaves":1}],
"objects":[{"name":"o","mesh":{"file":"box.gltf","unit":"m","origin":"file"},"leaves":8}]})");
  LoadOptions options;
  options.cache_dir = folder + "/cache";
  const auto box = [&] { return InspectMesh(LoadScene(scene, options).objects[0].mesh); };
  EXPECT_NEAR(box().box_max.maxCoeff(), 1.5, 1e-6);
  std::string buffer = ReadWholeFile(folder + "/box.bin");
  for (std::size_t i = 0; i + 4 <= buffer.size(); i += 4) {
    float value = 0;
    std::memcpy(&value, buffer.data() + i, 4);
    if (value != 1.5f) continue;
    value = 4.0f;
    std::memcpy(buffer.data() + i, &value, 4);
  }
  WriteFile(folder + "/box.bin", buffer);
  EXPECT_NEAR(box().box_max.maxCoeff(), 4.0, 1e-6);
}

TEST(SceneSize, HasABoundForBodiesOfOneGeometryToo) {
  const TriangleMesh mesh = MakeSphere(0.1, 20480);
  const SphereTree tree = SingleSphereTree(mesh, {Vec3::Zero(), 0.1});
  SceneSize size;
  std::size_t bodies = 0;
  EXPECT_THAT(ComplaintOf([&] {
                for (; bodies < 10'000; ++bodies) size.Add("last", mesh, tree);
              }),
              AllOf(HasSubstr("\"last\""), HasSubstr("more than 1024 MB")));
  EXPECT_NEAR(double(bodies), 2000.0, 200.0);  // half a megabyte each
}

Scene BallOnABall() {
  Scene scene;
  scene.name = "balls";
  Body ball{"ball", MakeSphere(0.005, 20), {}, {}};
  ball.tree = SingleSphereTree(ball.mesh, {Vec3::Zero(), 0.005});
  scene.tools = {ball};
  scene.objects = {ball};
  return scene;
}

TEST(UnpackScene, RefusesATreeOfManyLevels) {
  Scene deep = BallOnABall();
  SphereTree& tree = deep.objects[0].tree;
  for (int level = 0; level < 30000; ++level) {
    tree.level_begin.push_back(tree.level_begin.back() + 1);
    tree.packets.push_back(tree.packets.front());
  }
  EXPECT_THAT(ComplaintOf([&] { UnpackScene(PackScene(deep), "deep.palpate"); }),
              AllOf(StartsWith("deep.palpate"), HasSubstr("more than 24 levels")));
}

}  // namespace
}  // namespace palpate
