#include "tests/fuzz/targets/targets.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <new>

#include "client/viewer/class_room.h"
#include "client/viewer/foxglove.h"
#include "client/viewer/page_messages.h"
#include "common/dds/cdr.h"
#include "common/dds/cdr_reader.h"
#include "common/error.h"
#include "common/json/pose_script.h"
#include "common/mcap/mcap_reader.h"
#include "common/qp/nearest_point.h"
#include "scenes/files/scene_bundle.h"
#include "scenes/files/scene_file.h"
#include "scenes/importer/mesh_reader.h"
#include "scenes/mesh/mesh_mend.h"
#include "scenes/mesh/mesh_report.h"
#include "scenes/mesh/mesh_solid.h"
#include "scenes/mesh/mesh_spike.h"
#include "scenes/scene_verdict.h"
#include "scenes/shapes/shapes.h"
#include "scenes/tree/sphere_tree_builder.h"
#include "server/physics/scene_model.h"
#include "tests/support/written_mesh.h"

namespace palpate::fuzz {
namespace {

[[noreturn]] void Fault(const char* what) {
  std::fprintf(stderr, "fault: %s\n", what);
  std::abort();
}

std::string_view Text(const std::uint8_t* bytes, std::size_t size) {
  return {reinterpret_cast<const char*>(bytes), size};
}

/// Content of a file of the project.
std::string File(const std::string& name) {
  std::ifstream in(std::string(PALPATE_SOURCE_DIR "/") + name, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// The catalogue's files with that ending, from the first dot on.
std::vector<std::string> Catalogue(std::string_view ending) {
  std::vector<std::string> names, texts;
  for (const auto& entry :
       std::filesystem::directory_iterator(PALPATE_SOURCE_DIR "/scenes/catalogue")) {
    const std::string name = entry.path().filename();
    if (name.substr(name.find('.')) == ending) names.push_back(name);
  }
  std::ranges::sort(names);
  for (const std::string& name : names) texts.push_back(File("scenes/catalogue/" + name));
  return texts;
}

/// Whether the bytes are a T.  What was read can be written again, is no longer than before and
/// means the same; cut short it is no T.
template <class T>
bool FromBytes(std::span<const std::uint8_t> bytes) {
  // A copy, so that a sanitizer sees a read beyond its end.
  const std::vector<std::uint8_t> given(bytes.begin(), bytes.end());
  T sample{};
  const bool read = dds::FromCdr(std::span(given), sample);
  if (read) {
    std::vector<std::uint8_t> own, again;
    dds::ToCdr(sample, own);
    if (own.size() > given.size()) Fault("CDR of our own is longer than what it was read from");
    T twice{}, cut{};
    if (!dds::FromCdr(std::span<const std::uint8_t>(own), twice)) Fault("our own CDR is none");
    dds::ToCdr(twice, again);
    if (again != own) Fault("CDR of our own means something else");
    for (const std::size_t size : {own.size() - 1, own.size() / 2}) {
      if (dds::FromCdr(std::span<const std::uint8_t>(own).first(size), cut))
        Fault("CDR is cut off");
    }
    dds::FreeContents(twice);
  }
  dds::FreeContents(sample);
  return read;
}

template <class T>
std::string Cdr(std::uint8_t type, const T& sample) {
  std::vector<std::uint8_t> bytes{type};
  dds::ToCdr(sample, bytes);
  return {bytes.begin(), bytes.end()};
}

/// The types, chosen by an input's first byte.
template <class... T>
struct TypesThatTravel {
  static bool Read(std::uint8_t type, std::span<const std::uint8_t> cdr) {
    static constexpr bool (*kRead[])(std::span<const std::uint8_t>) = {FromBytes<T>...};
    return kRead[type % sizeof...(T)](cdr);
  }
  static std::vector<std::string> Seeds() {
    std::uint8_t type = 0;
    return {Cdr(type++, T{})...};
  }
};
using Types =
    TypesThatTravel<wire::HapticPose, wire::Wrench, wire::SessionRequest, wire::SessionState,
                    wire::LoopWhole, wire::WholeRequest, wire::SceneWhole, wire::ReplayContents,
                    wire::ReplayState, wire::ReplayRequest, wire::ToolState, wire::LoopStatistics,
                    wire::StationStatistics, wire::SceneBundle, wire::GuideTarget, wire::SolidBlock,
                    wire::CutLog>;

/// Whether a text can be read; if not, the Error must name the file.
template <class Read>
bool ReadOrRefused(const char* file, Read read) {
  try {
    read();
    return true;
  } catch (const Error& error) {
    if (!std::string_view(error.what()).starts_with(file))
      Fault("an error without the file's name");
  } catch (const std::bad_alloc&) {
  }
  return false;
}

void Check(bool holds, const char* what) {
  if (!holds) Fault(what);
}

/// Checks the numbers that the physics uses as indices, independently of the loader.
void CheckTree(const SphereTree& tree, std::size_t triangles) {
  const std::size_t leaves = tree.leaves();
  for (const auto* column : {&tree.leaf_x, &tree.leaf_y, &tree.leaf_z, &tree.leaf_radius}) {
    Check(column->size() == leaves, "leaves");
    for (const double x : *column) Check(std::isfinite(x), "leaf");
  }
  for (const double r : tree.leaf_radius) Check(r >= 0.0, "radius");  // of 0: JudgeScene refuses
  const auto& begin = tree.leaf_triangle_begin;
  Check(begin.size() == leaves + 1 && std::ranges::is_sorted(begin) &&
            begin.back() == tree.leaf_triangle.size(),
        "leaves' triangles");
  for (const auto t : tree.leaf_triangle) Check(t < triangles, "leaf triangle");
  Check(std::ranges::is_sorted(tree.level_begin) &&
            static_cast<std::size_t>(tree.level_begin.back()) == tree.packets.size(),
        "levels");
  // Every leaf is reached from the top exactly once.
  std::vector<int> reached(leaves, 0);
  for (int l = 0; l < tree.levels(); ++l) {
    const bool lowest = l + 1 == tree.levels();
    const std::size_t below = lowest ? leaves : tree.level(l + 1).size();
    for (const SpherePacket& packet : tree.level(l)) {
      for (const auto child : packet.child) {
        if (child < 0) continue;
        Check(static_cast<std::size_t>(child) < below, "child");
        if (lowest) ++reached[static_cast<std::size_t>(child)];
      }
    }
  }
  Check(std::ranges::count(reached, 1) == static_cast<std::ptrdiff_t>(leaves), "way to a leaf");
}

void CheckScene(const Scene& scene) {
  Check(std::isfinite(scene.coupling.stiffness) && scene.coupling.stiffness > 0.0, "coupling");
  for (const auto* bodies : {&scene.tools, &scene.objects}) {
    for (const Body& body : *bodies) {
      for (const Vec3& v : body.mesh.vertices) Check(v.allFinite(), "vertex");
      for (const auto& triangle : body.mesh.triangles) {
        for (const auto corner : triangle) Check(corner < body.mesh.vertices.size(), "triangle");
      }
      CheckTree(body.tree, body.mesh.triangles.size());
      Check(body.X_WB.p.allFinite() && std::abs(body.X_WB.q.norm() - 1.0) < 1e-6, "pose");
      Check(!body.materials.empty() &&
                (body.leaf_material.empty() || body.leaf_material.size() == body.tree.leaves()),
            "materials");
      for (const auto m : body.leaf_material) Check(m < body.materials.size(), "leaf's material");
    }
  }
}

std::string SmallBundle() {
  Scene scene;
  scene.name = "small";
  Body ball{"ball", MakeSphere(0.005, 20), {}, {}};
  ball.tree = SingleSphereTree(ball.mesh, {Vec3::Zero(), 0.005});
  Body box{"box", MakeBox(Vec3(0.1, 0.2, 0.3)), {}, {}};
  box.tree = BuildSphereTree(box.mesh, 20);
  scene.tools = {ball};
  scene.objects = {box, box};
  scene.objects[1].name = "other";
  const std::vector<std::uint8_t> bytes = PackScene(scene);
  return {bytes.begin(), bytes.end()};
}

constexpr std::size_t kBundleHeader = 40;

/// Makes a bundle of `content` with a matching header: its checksum is no secret.
std::vector<std::uint8_t> BundleOf(std::string_view content) {
  constexpr std::size_t kKey = 16, kSize = 24, kChecksum = 32;
  static const std::string header = SmallBundle().substr(0, kBundleHeader);
  std::string bundle = header;
  bundle += content;
  std::uint64_t key = 0;
  std::memcpy(&key, bundle.data() + kKey, sizeof key);
  const std::uint64_t size = content.size(), checksum = HashBytes(content, key);
  std::memcpy(bundle.data() + kSize, &size, sizeof size);
  std::memcpy(bundle.data() + kChecksum, &checksum, sizeof checksum);
  return {bundle.begin(), bundle.end()};
}

/// Turns bytes into numbers, mostly small integers, which make rows that are equal, parallel or
/// zero.
class Numbers {
 public:
  Numbers(const std::uint8_t* bytes, std::size_t size) : bytes_(bytes), left_(size) {}
  double Next() {
    if (left_ == 0) return 0.0;
    const auto byte = static_cast<std::int8_t>(*bytes_);
    ++bytes_;
    --left_;
    if (byte == 127 && left_ >= 8) {
      double any;
      std::memcpy(&any, bytes_, 8);
      bytes_ += 8;
      left_ -= 8;
      return std::isfinite(any) ? std::clamp(any, -1e3, 1e3) : 0.0;
    }
    return byte / 8.0;
  }
  std::size_t left() const { return left_; }

 private:
  const std::uint8_t* bytes_;
  std::size_t left_;
};

}  // namespace

bool SceneFile(const std::uint8_t* bytes, std::size_t size) {
  return ReadOrRefused("fuzzed.json", [&] {
    const SceneDescription scene = ParseScene(Text(bytes, size), "fuzzed.json");
    Check(!scene.tools.empty() && !scene.objects.empty(), "a scene of nothing");
    Check(std::isfinite(scene.coupling.stiffness) && scene.coupling.stiffness > 0.0, "no coupling");
    for (const auto* bodies : {&scene.tools, &scene.objects}) {
      for (const BodyDescription& body : *bodies) {
        Check(body.X_WB.p.allFinite() && std::abs(body.X_WB.q.norm() - 1.0) < 1e-9, "no pose");
        Check(body.leaves <= kMaxLeaves && body.mesh.size.allFinite(), "no body");
      }
    }
  });
}

bool Script(const std::uint8_t* bytes, std::size_t size) {
  return ReadOrRefused("fuzzed.json", [&] {
    const PoseScript script = PoseScript::Parse(Text(bytes, size), "fuzzed.json");
    Check(std::isfinite(script.duration()) && script.duration() >= 0.0, "no duration");
    for (int k = 0; k <= 20; ++k) {
      const Pose X = script.At(script.duration() * k / 20.0);
      Check(X.p.allFinite() && std::abs(X.q.norm() - 1.0) < 1e-9, "no pose");
    }
  });
}

constexpr std::array kMeshNames{"a.obj", "a.stl", "a.ply", "a.gltf", "a.glb"};

bool MeshFile(const std::uint8_t* bytes, std::size_t size) {
  if (size == 0) return false;
  const char* const name = kMeshNames[bytes[0] % kMeshNames.size()];
  return ReadOrRefused(name, [&] {
    // Everything that the mesh's process does, and what its user does with the result.
    ImportedMesh read = UnpackMesh(PackMesh(ReadMeshText(name, Text(bytes + 1, size - 1))));
    if (!InspectMesh(read.mesh).refusal.empty()) return;
    MendMesh(read.mesh, &read.groups);
    FindSpike(read.mesh);
    SolidOf(read.mesh);
  });
}

bool Bundle(const std::uint8_t* bytes, std::size_t size) {
  const std::vector<std::uint8_t> bundle = BundleOf(Text(bytes, size));
  return ReadOrRefused("fuzzed.bundle", [&] {
    const Scene scene = UnpackScene(bundle, "fuzzed.bundle");
    CheckScene(scene);
    if (!JudgeScene(scene).usable()) return;  // where the server stops, too
    const auto objects = MakeObjects(scene);
    for (const Body& tool : scene.tools) MakeModel(scene, tool, objects);
  });
}

bool Recording(const std::uint8_t* bytes, std::size_t size) {
  return ReadOrRefused("fuzzed.mcap", [&] {
    mcap::Reader reader({bytes, size}, "fuzzed.mcap");
    mcap::Message message;
    std::size_t messages = 0;
    while (reader.Next(message)) {
      // Bounded: a byte of the file decompresses to a limited number of bytes.
      if (++messages > 100'000'000) Fault("messages without an end");
    }
  });
}

bool Client(const std::uint8_t* bytes, std::size_t size) {
  bool any = false;
  const auto read = [&](const auto& parse) {
    try {
      parse(Text(bytes, size));
      any = true;
    } catch (const Error& error) {
      if (std::string_view(error.what()).empty()) Fault("an error without a word");
    }
  };
  read([](std::string_view text) { foxglove::ParseRequest(text); });
  read([&](std::string_view) { foxglove::ParseMessage({bytes, size}); });
  read([](std::string_view text) { ParseOperateCommand(text); });
  read([](std::string_view text) { ParseClassCommand(text); });
  read([](std::string_view text) {
    if (!ParseMouseCommand(text).X_WT.p.allFinite()) Fault("a pose that is not a number");
  });
  read([](std::string_view text) {
    if (ParseReplayWish(text).request.replay == 0) Fault("a wish for no replay");
  });
  return any;
}

bool Wire(const std::uint8_t* bytes, std::size_t size) {
  return size > 0 && Types::Read(bytes[0], {bytes + 1, size - 1});
}

bool Qp(const std::uint8_t* bytes, std::size_t size) {
  constexpr int kMost = 64;
  Numbers numbers(bytes, size);
  double target[6];
  alignas(64) double a[6][kMost] = {}, b[kMost];
  std::fill(b, b + kMost, -1e300);  // as QpRows demands after the last row
  for (double& t : target) t = numbers.Next();
  int rows = 0;
  for (; rows < kMost && numbers.left() > 0; ++rows) {
    for (auto& column : a) column[rows] = numbers.Next();
    b[rows] = numbers.Next();
  }
  QpRows given{};
  given.count = rows;
  for (int i = 0; i < 6; ++i) given.a[i] = a[i];
  given.b = b;
  const QpResult result = SolveNearestPoint(target, given, nullptr, 0);
  for (const double x : result.x) {
    if (!std::isfinite(x)) Fault("a pose that is not a number");
  }
  if (result.status != QpStatus::kSolved) return false;
  double scale = 1.0;
  for (int r = 0; r < rows; ++r) {
    for (const auto& column : a) scale = std::max(scale, std::abs(column[r]));
    scale = std::max(scale, std::abs(b[r]));
  }
  // Karush-Kuhn-Tucker: no row is violated, no multiplier is negative, and the multipliers explain
  // the residual.  A sum is only as exact as its greatest term: rows that nearly contradict each
  // other meet far off, with multipliers a million million times as large as their sum.  A
  // multiplier that rounding makes slightly negative counts as zero, times the length `scale` of
  // its row.
  double left_over[6], greatest = 1.0;
  for (int i = 0; i < 6; ++i) {
    left_over[i] = result.x[i] - target[i];
    greatest = std::max({greatest, std::abs(result.x[i]), std::abs(target[i])});
  }
  for (int k = 0; k < result.active; ++k) {
    if (!(result.multiplier[k] >= -1e-9)) Fault("a row that pulls");
    for (int i = 0; i < 6; ++i) {
      const double pull = result.multiplier[k] * a[i][result.row[k]];
      left_over[i] -= pull;
      greatest = std::max(greatest, std::abs(pull));
    }
  }
  for (const double l : left_over) {
    if (!(std::abs(l) <= 1e-9 * scale * greatest)) Fault("not the nearest point");
  }
  double size_of_x = 1.0;
  for (const double x : result.x) size_of_x = std::max(size_of_x, std::abs(x));
  for (int r = 0; r < rows; ++r) {
    double gap = -b[r];
    for (int i = 0; i < 6; ++i) gap += a[i][r] * result.x[i];
    if (!(gap >= -1e-6 * scale * size_of_x)) Fault("a row that is violated");
  }
  return true;
}

const std::vector<Target>& AllTargets() {
  static const std::vector<Target> targets = {
      {"scene_file", SceneFile, [] { return Catalogue(".json"); }},
      {"script", Script, [] { return Catalogue(".path.json"); }},
      {"mesh_file", MeshFile,
       [] {
         std::vector<std::string> seeds;
         for (std::uint32_t seed = 1; seed <= 4; ++seed) {
           test::AnyHand hand(seed);
           const TriangleMesh mesh = hand.Mesh();
           seeds.push_back('\0' + test::AnyObj(mesh, hand));
           seeds.push_back('\1' + test::AnyStl(mesh, hand));
           seeds.push_back('\2' + test::AnyPly(mesh, hand));
           seeds.push_back('\4' + test::AnyGlb(mesh, hand));
         }
         seeds.push_back(
             "\3"
             R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],
"bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,
"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})");
         return seeds;
       }},
      {"bundle", Bundle,
       [] { return std::vector<std::string>{SmallBundle().substr(kBundleHeader)}; }},
      {"recording", Recording,
       [] {
         return std::vector<std::string>{
             File("tests/replayer/golden/ellipsoid.mcap").substr(0, 20'000)};
       }},
      {"client", Client,
       [] {
         return std::vector<std::string>{
             R"({"op":"subscribe","subscriptions":[{"id":1,"channelId":2}]})",
             R"({"op":"advertise","channels":[{"id":1,"topic":"/palpate/mouse","encoding":"json","schemaName":""}]})",
             R"({"op":"take","scene":"bunny-bunny","tool":"bunny"})",
             R"({"op":"pose","p":[0.0,0.1,0.0],"q":[1,0,0,0]})",
             R"({"replay":"5f3a","tag":2,"wish":"seek","value":12.5})",
             std::string("\x01\x01\x00\x00\x00{\"op\":\"release\"}", 20)};
       }},
      {"wire", Wire,
       [] {
         std::vector<std::string> seeds = Types::Seeds();
         wire::SessionRequest request{};
         wire::FromText("hand", request.station);
         seeds.push_back(Cdr(2, request));
         wire::SessionState state{};
         wire::FromText("hand", state.station);
         seeds.push_back(Cdr(3, state));
         std::uint8_t content[] = {1, 2, 3};
         wire::SceneBundle bundle{};
         wire::FromText("cube", bundle.scene);
         bundle.bundle._buffer = content;
         bundle.bundle._length = bundle.bundle._maximum = 3;
         seeds.push_back(Cdr(13, bundle));
         return seeds;
       }},
      {"qp", Qp,
       [] {
         std::string rows = "\x10\x08\x00\xf8\x01\x02";
         rows += std::string("\x08\x00\x00\x00\x00\x00\x04", 7);
         rows += std::string("\x00\x08\x00\x00\x00\x00\x04", 7);
         rows += std::string("\xf8\x00\x00\x00\x00\x00\x04", 7);
         return std::vector<std::string>{rows};
       }},
  };
  return targets;
}

}  // namespace palpate::fuzz
