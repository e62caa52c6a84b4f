#include "tests/fuzz/targets/targets.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <new>

#include "client/viewer/foxglove.h"
#include "client/viewer/mouse_command.h"
#include "client/viewer/operate_command.h"
#include "client/viewer/replay_messages.h"
#include "common/dds/cdr.h"
#include "common/dds/cdr_reader.h"
#include "common/error.h"
#include "common/mcap/mcap_reader.h"
#include "common/qp/nearest_point.h"
#include "scenes/files/scene_bundle.h"
#include "scenes/files/scene_file.h"
#include "scenes/importer/mesh_reader.h"
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

/// A file of the project.
std::string File(const std::string& name) {
  std::ifstream in(std::string(PALPATE_SOURCE_DIR "/") + name, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

template <class T>
void FromBytes(std::span<const std::uint8_t> bytes) {
  T sample{};
  if (dds::FromCdr(bytes, sample)) {
    // What was read can be written, and read again.
    std::vector<std::uint8_t> again;
    dds::ToCdr(sample, again);
    T twice{};
    if (!dds::FromCdr(std::span<const std::uint8_t>(again), twice))
      Fault("CDR of our own is no CDR");
    dds::FreeContents(twice);
  }
  dds::FreeContents(sample);
}

template <class T>
std::string Cdr(std::uint8_t type, const T& sample) {
  std::vector<std::uint8_t> bytes{type};
  dds::ToCdr(sample, bytes);
  return {bytes.begin(), bytes.end()};
}

/// Bytes as numbers: mostly small whole ones, which make rows that are alike, parallel or none.
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

void SceneFile(const std::uint8_t* bytes, std::size_t size) {
  try {
    ParseScene(Text(bytes, size), "fuzzed.json");
  } catch (const Error& error) {
    if (std::string(error.what()).empty()) Fault("an error without a word");
  }
}

constexpr std::array kMeshNames{"a.obj", "a.stl", "a.ply", "a.gltf", "a.glb"};

void MeshFile(const std::uint8_t* bytes, std::size_t size) {
  if (size == 0) return;
  const std::string name = kMeshNames[bytes[0] % kMeshNames.size()];
  try {
    ReadMeshText(name, Text(bytes + 1, size - 1));
  } catch (const Error& error) {
    if (!std::string_view(error.what()).starts_with(name))
      Fault("an error without the file's name");
  } catch (const std::bad_alloc&) {
  }
}

void Bundle(const std::uint8_t* bytes, std::size_t size) {
  try {
    UnpackScene({bytes, size}, "fuzzed.bundle");
  } catch (const Error& error) {
    if (std::string(error.what()).empty()) Fault("an error without a word");
  }
}

void Recording(const std::uint8_t* bytes, std::size_t size) {
  try {
    mcap::Reader reader({bytes, size}, "fuzzed.mcap");
    mcap::Message message;
    std::size_t messages = 0;
    while (reader.Next(message)) {
      // A byte of the file stands for at most so many after decompression.
      if (++messages > 100'000'000) Fault("messages without an end");
    }
  } catch (const Error& error) {
    if (std::string(error.what()).empty()) Fault("an error without a word");
  }
}

void Client(const std::uint8_t* bytes, std::size_t size) {
  const auto read = [&](const auto& parse) {
    try {
      parse(Text(bytes, size));
    } catch (const Error& error) {
      if (std::string(error.what()).empty()) Fault("an error without a word");
    }
  };
  read([](std::string_view text) { foxglove::ParseRequest(text); });
  read([&](std::string_view) { foxglove::ParseMessage({bytes, size}); });
  read([](std::string_view text) { ParseOperateCommand(text); });
  read([](std::string_view text) {
    if (!ParseMouseCommand(text).X_WT.p.allFinite()) Fault("a pose that is no number");
  });
  read([](std::string_view text) {
    if (ParseReplayWish(text).request.replay == 0) Fault("a wish for no replay");
  });
}

void Wire(const std::uint8_t* bytes, std::size_t size) {
  if (size == 0) return;
  const std::span<const std::uint8_t> cdr(bytes + 1, size - 1);
  switch (bytes[0] % 16) {
    case 0:
      return FromBytes<wire::HapticPose>(cdr);
    case 1:
      return FromBytes<wire::Wrench>(cdr);
    case 2:
      return FromBytes<wire::SessionRequest>(cdr);
    case 3:
      return FromBytes<wire::SessionState>(cdr);
    case 4:
      return FromBytes<wire::SceneChange>(cdr);
    case 5:
      return FromBytes<wire::LeafTaken>(cdr);
    case 6:
      return FromBytes<wire::WholeRequest>(cdr);
    case 7:
      return FromBytes<wire::SceneWhole>(cdr);
    case 8:
      return FromBytes<wire::ReplayContents>(cdr);
    case 9:
      return FromBytes<wire::ReplayState>(cdr);
    case 10:
      return FromBytes<wire::ReplayRequest>(cdr);
    case 11:
      return FromBytes<wire::ToolState>(cdr);
    case 12:
      return FromBytes<wire::LoopStatistics>(cdr);
    case 13:
      return FromBytes<wire::StationStatistics>(cdr);
    case 14:
      return FromBytes<wire::SceneBundle>(cdr);
    default:
      return FromBytes<wire::GuideTarget>(cdr);
  }
}

void Qp(const std::uint8_t* bytes, std::size_t size) {
  constexpr int kMost = 64;
  Numbers numbers(bytes, size);
  double target[6];
  alignas(64) double a[6][kMost] = {}, b[kMost];
  std::fill(b, b + kMost, -1e300);  // as QpRows asks for beyond the last row
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
    if (!std::isfinite(x)) Fault("a pose that is no number");
  }
  if (result.status != QpStatus::kSolved) return;
  double scale = 1.0;
  for (int r = 0; r < rows; ++r) {
    for (const auto& column : a) scale = std::max(scale, std::abs(column[r]));
    scale = std::max(scale, std::abs(b[r]));
  }
  // Karush, Kuhn and Tucker: no row is violated, none pulls, and what is left over is theirs.
  // A sum is as exact as its greatest term is large: rows that nearly contradict each other meet
  // far off, with multipliers a million million times as large as what they add up to.  And a
  // multiplier that rounding takes below zero is none, which a row of length `scale` makes that
  // much of.
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
}

const std::vector<Target>& AllTargets() {
  static const std::vector<Target> targets = {
      {"scene_file", SceneFile,
       [] {
         std::vector<std::string> seeds;
         for (const char* name : {"cube", "calculus", "periodontal", "friction", "bunny-bunny"}) {
           seeds.push_back(File(std::string("scenes/catalogue/") + name + ".json"));
         }
         return seeds;
       }},
      {"mesh_file", MeshFile,
       [] {
         std::vector<std::string> seeds;
         for (std::uint32_t seed = 1; seed <= 4; ++seed) {
           test::AnyHand hand(seed);
           const TriangleMesh mesh = hand.Mesh();
           seeds.push_back('\0' + test::AnyObj(mesh, hand));
           seeds.push_back('\1' + test::AnyStl(mesh, hand));
           seeds.push_back('\2' + test::AnyPly(mesh, hand));
           seeds.push_back('\3' + test::Json({}));
           seeds.push_back('\4' + test::AnyGlb(mesh, hand));
         }
         return seeds;
       }},
      {"bundle", Bundle,
       [] {
         Scene scene;
         scene.name = "seed";
         const std::vector<std::uint8_t> bytes = PackScene(scene);
         return std::vector<std::string>{std::string(bytes.begin(), bytes.end())};
       }},
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
         wire::SessionRequest request{};
         wire::FromText("hand", request.station);
         wire::SessionState state{};
         wire::FromText("hand", state.station);
         std::uint8_t content[] = {1, 2, 3};
         wire::SceneBundle bundle{};
         wire::FromText("cube", bundle.scene);
         bundle.bundle._buffer = content;
         bundle.bundle._length = bundle.bundle._maximum = 3;
         return std::vector<std::string>{Cdr(0, wire::HapticPose{}),
                                         Cdr(1, wire::Wrench{}),
                                         Cdr(2, request),
                                         Cdr(3, state),
                                         Cdr(8, wire::ReplayContents{}),
                                         Cdr(11, wire::ToolState{}),
                                         Cdr(14, bundle)};
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
