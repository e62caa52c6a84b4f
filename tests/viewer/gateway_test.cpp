// The real palpate-viewer beside a real server: what viewers get, and what they cannot do to each
// other.
#include <algorithm>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <optional>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "common/dds/cdr.h"
#include "common/dds/cdr_reader.h"
#include "common/dds/topics.h"
#include "common/realtime/steady_clock.h"
#include "scenes/files/scene_bundle.h"
#include "tests/support/program.h"
#include "tests/support/random.h"
#include "tests/support/test_domain.h"
#include "tests/support/web_client.h"
#include "tests/viewer/viewer_program.h"

namespace palpate::test {
namespace {

using Json = nlohmann::json;
using testing::HasSubstr;

const int kDomain = OwnDomain();
enum : std::uint32_t {
  kToolState = 1,
  kStatistics,
  kSession,
  kChange,
  kBundle,
  kMouse,
  kStation,
  kWhole,
  kContents,
  kReplay,
  kAnswer
};

template <class T>
T Decoded(const WebClient::Message& message) {
  T sample{};
  EXPECT_TRUE(dds::FromCdr(message.payload, sample));
  return sample;
}

/// Without any library: where CDR puts the members of a ToolState.
double Member(const std::vector<std::uint8_t>& cdr, std::size_t index_after_tool) {
  std::size_t at = 4;
  for (int text = 0; text < 3; ++text) {
    at += (4 - at % 4) % 4;
    std::uint32_t length = 0;
    std::memcpy(&length, cdr.data() + at, 4);
    at += 4 + length;
  }
  at = 4 + (at - 4 + 7) / 8 * 8 + 8 * index_after_tool;
  double value = 0.0;
  std::memcpy(&value, cdr.data() + at, 8);
  return value;
}

std::unique_ptr<Program> StartServer(std::vector<std::string> scenes = {"cube"}) {
  std::vector<std::string> arguments{"--realtime", "off",      "--transport",
                                     "udp",        "--domain", std::to_string(kDomain)};
  for (const std::string& scene : scenes) {
    arguments.insert(arguments.end(), {"--scene", scene});
  }
  auto server = std::make_unique<Program>(PALPATE_BIN_DIR "/palpate-server", arguments);
  EXPECT_TRUE(server->Says("ready: ", 60.0)) << server->Output();
  return server;
}

std::unique_ptr<Program> StartStation(const std::string& id, const std::string& script = "") {
  return std::make_unique<Program>(
      PALPATE_BIN_DIR "/palpate-station",
      Joined({"--device", "scripted", "--scene", "cube", "--id", id, "--no-table", "--realtime",
              "off", "--transport", "udp", "--domain", std::to_string(kDomain)},
             script.empty() ? std::vector<std::string>{"--loop"}
                            : std::vector<std::string>{"--script", script}));
}

struct Gateway : ViewerProgram {
  explicit Gateway(std::vector<std::string> more = {}) : ViewerProgram(kDomain, std::move(more)) {}
};

TEST(Gateway, TellsEachViewerWhatItIsAndWhichChannelsThereAre) {
  Gateway gateway;
  WebClient viewer(gateway.port(), "foxglove.sdk.v1, foxglove.websocket.v1");
  ASSERT_TRUE(viewer.open());
  EXPECT_EQ(viewer.subprotocol(), "foxglove.sdk.v1");
  const Json info = viewer.NextJson("serverInfo");
  EXPECT_THAT(info.value("name", ""), HasSubstr("palpate-viewer"));
  EXPECT_EQ(info["capabilities"], Json::array({"clientPublish"}));
  EXPECT_EQ(info["supportedEncodings"], Json::array({"json"}));
  const Json channels = viewer.NextJson("advertise")["channels"];
  std::map<std::string, Json> by_topic;
  for (const Json& channel : channels) by_topic[channel["topic"]] = channel;
  for (const auto& [topic, schema] : std::map<std::string, std::string>{
           {"/palpate/tool_state", "palpate::ToolState"},
           {"/palpate/loop_statistics", "palpate::LoopStatistics"},
           {"/palpate/station_statistics", "palpate::StationStatistics"},
           {"/palpate/session_state", "palpate::SessionState"},
           {"/palpate/scene_change", "palpate::SceneChange"},
           {"/palpate/scene_whole", "palpate::SceneWhole"},
           {"/palpate/scene_bundle", "palpate::SceneBundle"}}) {
    ASSERT_TRUE(by_topic.contains(topic));
    EXPECT_EQ(by_topic[topic]["encoding"], "cdr");
    EXPECT_EQ(by_topic[topic]["schemaEncoding"], "omgidl");
    EXPECT_EQ(by_topic[topic]["schemaName"], schema);
    const std::string text = by_topic[topic]["schema"];
    EXPECT_THAT(text, HasSubstr("module palpate {"));
    EXPECT_THAT(text, HasSubstr("struct " + schema.substr(9) + " {"));
    EXPECT_THAT(text, testing::Not(HasSubstr("#include")));
  }
  EXPECT_EQ(by_topic["/palpate/mouse_state"]["encoding"], "json");
}

TEST(Gateway, LetsAViewerSubscribeToAllThatItOffersAndToNothingElse) {
  Gateway gateway;
  WebClient viewer(gateway.port());
  const Json channels = viewer.NextJson("advertise")["channels"];
  std::uint32_t id = 100;
  for (const Json& channel : channels) {
    viewer.Subscribe(++id, channel["id"]);
  }
  viewer.Subscribe(7777, 99);
  // Refusals come in the order of what is refused.
  EXPECT_THAT(viewer.NextStatus(),
              HasSubstr("subscription 7777 to channel 99 is refused: there is no such channel"));
}

TEST(Gateway, GivesLateViewersTheSceneAndTheSessionsAndThenTheTool) {
  const auto server = StartServer();
  const auto station = StartStation("held", PALPATE_SOURCE_DIR "/tests/integration/press.json");
  Gateway gateway;
  ASSERT_TRUE(gateway.KnowsScenes(1));
  ASSERT_TRUE(gateway.Until([](const Json& h) { return h["stations"] == Json::array({"held"}); }));

  const dds::Participant participant = dds::Participant::Service(kDomain);
  dds::CdrReader<wire::ToolState> direct(participant, dds::kToolStateTopic, dds::Qos::kStream);
  WebClient viewer(gateway.port());
  viewer.Subscribe(70, kBundle);
  viewer.Subscribe(71, kSession);
  viewer.Subscribe(72, kToolState);
  viewer.Subscribe(73, kStatistics);
  viewer.Subscribe(74, kStation);

  const auto bundle = viewer.Next(70);
  ASSERT_TRUE(bundle);
  auto scene = Decoded<wire::SceneBundle>(*bundle);
  EXPECT_STREQ(scene.scene, "cube");
  const std::span bytes(scene.bundle._buffer, scene.bundle._length);
  EXPECT_EQ(scene.hash, BundleHash(bytes));
  EXPECT_EQ(UnpackScene(bytes, "the viewer's").objects.at(0).name, "cube");
  dds::FreeContents(scene);

  const auto session = viewer.Next(71);
  ASSERT_TRUE(session);
  const auto held = Decoded<wire::SessionState>(*session);
  EXPECT_STREQ(held.station, "held");
  char run[32];
  std::snprintf(run, sizeof run, "%llx", static_cast<unsigned long long>(held.server_run));
  EXPECT_EQ(gateway.Health()["server_run"], run);

  // What the viewer sees of a pose is what a reader of DDS sees of it.
  std::map<std::uint64_t, wire::ToolState> truth;
  dds::CdrSample raw;
  wire::ToolState state{};
  std::optional<WebClient::Message> pressed;
  for (int i = 0; i < 1000 && !pressed; ++i) {
    auto message = viewer.Next(72);
    ASSERT_TRUE(message);
    while (direct.Take(raw, state)) truth[state.pose_sequence] = state;
    const auto seen = Decoded<wire::ToolState>(*message);
    if (seen.force_N[1] > 0.9 && truth.contains(seen.pose_sequence)) pressed = std::move(message);
  }
  ASSERT_TRUE(pressed);
  const auto seen = Decoded<wire::ToolState>(*pressed);
  const wire::ToolState& told = truth.at(seen.pose_sequence);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(Member(pressed->payload, 1 + i), told.haptic_position_m[i]);
    EXPECT_EQ(seen.haptic_position_m[i], told.haptic_position_m[i]);
    EXPECT_EQ(seen.graphic_position_m[i], told.graphic_position_m[i]);
    EXPECT_EQ(seen.force_N[i], told.force_N[i]);
  }
  EXPECT_EQ(seen.points, 1u);
  EXPECT_TRUE(viewer.Next(73));
  const auto arm = viewer.Next(74);
  ASSERT_TRUE(arm);
  EXPECT_STREQ(Decoded<wire::StationStatistics>(*arm).station, "held");

  viewer.SendText(R"({"op": "unsubscribe", "subscriptionIds": [72]})");
  // What it still hears comes the same way, once a second, and is what time goes by: tool states
  // that were on their way have come before the second of these, and some sixty more would.
  const auto two_more = [&] {
    while (viewer.Next(73, 0.0)) {
    }
    return viewer.Next(73) && viewer.Next(73);
  };
  ASSERT_TRUE(two_more());
  while (viewer.Next(72, 0.0)) {
  }
  ASSERT_TRUE(two_more());
  EXPECT_FALSE(viewer.Next(72, 0.0));
}

TEST(Gateway, GivesEachViewerToolStatesAtTheRateThatItIsTold) {
  const auto server = StartServer();
  const auto station = StartStation("a");
  Gateway gateway({"--rate", "20"});
  WebClient viewer(gateway.port());
  viewer.Subscribe(1, kToolState);
  ASSERT_TRUE(viewer.Next(1));
  // 50 ms apart on average: by the states' own numbers, one a millisecond, or where the station
  // could not keep that, by the clock.
  const std::int64_t begin_ns = SteadyNanoseconds();
  const std::uint64_t first = Decoded<wire::ToolState>(*viewer.Next(1)).pose_sequence;
  std::uint64_t last = first;
  constexpr int kFrames = 40;
  for (int i = 0; i < kFrames; ++i) {
    const auto next = viewer.Next(1);
    ASSERT_TRUE(next);
    last = Decoded<wire::ToolState>(*next).pose_sequence;
  }
  const double by_clock_ms = 1e-6 * static_cast<double>(SteadyNanoseconds() - begin_ns);
  EXPECT_GE(std::max(static_cast<double>(last - first), by_clock_ms), 0.85 * 50 * kFrames);
}

TEST(Gateway, LetsAStalledViewerLoseFramesAndNobodyElse) {
  const auto server = StartServer();
  const auto station = StartStation("a");
  Gateway gateway({"--rate", "60"});
  ASSERT_TRUE(gateway.KnowsScenes(1));
  WebClient stalled(gateway.port(), "foxglove.websocket.v1", "", 4096);
  WebClient lively(gateway.port());
  // It does not read: the bundle is more than the kernel holds for it.
  stalled.Subscribe(2, kBundle);
  stalled.Subscribe(1, kToolState);
  lively.Subscribe(1, kToolState);
  std::uint64_t last = 0;
  const auto follow = [&] {
    const auto next = lively.Next(1);
    if (next) last = Decoded<wire::ToolState>(*next).pose_sequence;
    return next.has_value();
  };
  bool dropped = false;
  for (int i = 0; i < 3000 && !dropped; ++i) {
    ASSERT_TRUE(follow());
    if (i % 60 == 59) dropped = gateway.Health()["frames_dropped"].get<int>() > 20;
  }
  EXPECT_TRUE(dropped);
  // When it reads again, the newest is what it gets: one frame, and what comes from now on.
  ASSERT_TRUE(stalled.Next(2));
  const auto next = stalled.Next(1);
  ASSERT_TRUE(next);
  EXPECT_GE(Decoded<wire::ToolState>(*next).pose_sequence + 200, last);
}

TEST(Gateway, KeepsItsViewersWhileTheServerIsGoneAndShowsThemItsSuccessor) {
  auto server = StartServer();
  Gateway gateway;
  ASSERT_TRUE(gateway.KnowsScenes(1));
  WebClient viewer(gateway.port());
  viewer.Subscribe(1, kBundle);
  viewer.Subscribe(2, kToolState);
  const auto before = viewer.Next(1);
  ASSERT_TRUE(before);
  server->Signal(SIGKILL);
  EXPECT_EQ(server->Exit(), -SIGKILL);
  viewer.Run(0.3);
  EXPECT_TRUE(viewer.open());
  EXPECT_EQ(gateway.Health()["scenes"], Json::array({"cube"})) << "what is known stays";
  const Json run_before = gateway.Health()["server_run"];

  server = StartServer({"friction"});
  const auto after = viewer.Next(1);
  ASSERT_TRUE(after);
  auto old_scene = Decoded<wire::SceneBundle>(*before);
  auto new_scene = Decoded<wire::SceneBundle>(*after);
  EXPECT_NE(old_scene.server_run, new_scene.server_run);
  EXPECT_STREQ(new_scene.scene, "friction");
  dds::FreeContents(old_scene);
  dds::FreeContents(new_scene);
  EXPECT_EQ(gateway.Health()["scenes"], Json::array({"friction"}));
  EXPECT_NE(gateway.Health()["server_run"], run_before);

  server.reset();
  server = StartServer();
  const auto station = StartStation("a");
  EXPECT_TRUE(viewer.Next(2));
  EXPECT_TRUE(viewer.open());
}

TEST(Gateway, TellsItsHealthWhateverAStationIsCalled) {
  Gateway gateway;
  const dds::Participant participant = dds::Participant::Service(kDomain);
  dds::Writer<wire::SessionState> states(participant, dds::kSessionStateTopic, dds::Qos::kSession);
  wire::SessionState state{};
  wire::FromText("caf\xe9", state.station);  // Latin-1
  state.server_run = 1;
  state.phase = palpate_SESSION_ACTIVE;
  ASSERT_TRUE(states.Write(state));
  EXPECT_TRUE(gateway.Until([](const Json& health) { return health["stations"].size() == 1; }));
}

TEST(Gateway, GivesASceneOverHttpWithItsHashAndCompressed) {
  const auto server = StartServer();
  Gateway gateway;
  ASSERT_TRUE(gateway.KnowsScenes(1));
  const HttpAnswer plain = Get(gateway.port(), "/scene/cube.bundle");
  EXPECT_EQ(plain.status, 200);
  const std::span bytes(reinterpret_cast<const std::uint8_t*>(plain.body.data()),
                        plain.body.size());
  EXPECT_EQ(UnpackScene(bytes, "the gateway's").name, "cube");
  char etag[32];
  std::snprintf(etag, sizeof etag, "\"%016llx\"",
                static_cast<unsigned long long>(BundleHash(bytes)));
  EXPECT_EQ(plain.headers.at("etag"), etag);
  EXPECT_EQ(Get(gateway.port(), "/scene/cube.bundle", {{"If-None-Match", etag}}).status, 304);
  std::string packed_tag;
  for (int time = 0; time < 2; ++time) {  // packed, and kept
    const HttpAnswer packed =
        Get(gateway.port(), "/scene/cube.bundle", {{"Accept-Encoding", "gzip, br"}});
    EXPECT_EQ(packed.status, 200);
    EXPECT_EQ(packed.headers.at("content-encoding"), "gzip");
    packed_tag = packed.headers.at("etag");
    EXPECT_LT(packed.body.size(), plain.body.size());
    EXPECT_EQ(packed.body.substr(0, 2), "\x1f\x8b");
  }
  // A tag names the very bytes, and a cache is told what they depend on.
  EXPECT_NE(packed_tag, etag);
  EXPECT_EQ(Get(gateway.port(), "/scene/cube.bundle", {{"If-None-Match", packed_tag}}).status, 200);
  const HttpAnswer unchanged =
      Get(gateway.port(), "/scene/cube.bundle",
          {{"If-None-Match", "\"other\", " + packed_tag}, {"Accept-Encoding", "gzip"}});
  EXPECT_EQ(unchanged.status, 304);
  EXPECT_EQ(unchanged.headers.at("etag"), packed_tag);
  EXPECT_EQ(unchanged.headers.at("vary"), "Accept-Encoding");
  EXPECT_EQ(Get(gateway.port(), "/scene/none.bundle").status, 404);
}

TEST(Gateway, ServesThePageAndNothingBesideIt) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("palpate_page_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder / "page/assets");
  std::ofstream(folder / "secret.txt") << "secret";
  std::ofstream(folder / "page/index.html") << "<p>the page";
  std::ofstream(folder / "page/assets/a1.js") << "plain";
  std::ofstream(folder / "page/assets/a1.js.gz") << "packed";
  Gateway gateway({"--page", (folder / "page").string()});
  const HttpAnswer index = Get(gateway.port(), "/?x=1");
  EXPECT_EQ(index.status, 200);
  EXPECT_EQ(index.body, "<p>the page");
  EXPECT_EQ(index.headers.at("content-type"), "text/html; charset=utf-8");
  EXPECT_THAT(index.headers.at("content-security-policy"), HasSubstr("frame-ancestors 'none'"));
  EXPECT_THAT(index.headers.at("content-security-policy"),
              HasSubstr("script-src 'self' 'wasm-unsafe-eval';"))
      << "what makes coarser meshes of the page's";
  EXPECT_EQ(Get(gateway.port(), "/assets/a1.js").body, "plain");
  const HttpAnswer packed = Get(gateway.port(), "/assets/a1.js", {{"Accept-Encoding", "gzip"}});
  EXPECT_EQ(packed.body, "packed");
  EXPECT_EQ(packed.headers.at("content-encoding"), "gzip");
  EXPECT_EQ(packed.headers.at("content-type"), "text/javascript; charset=utf-8");
  EXPECT_THAT(packed.headers.at("cache-control"), HasSubstr("immutable"));
  for (const char* path : {"/../secret.txt", "/%2e%2e/secret.txt", "/assets/../../secret.txt",
                           "/..%2fsecret.txt", "//../secret.txt", "/secret.txt"}) {
    const HttpAnswer answer = Get(gateway.port(), path);
    EXPECT_GE(answer.status, 400) << path;
    EXPECT_THAT(answer.body, testing::Not(HasSubstr("secret"))) << path;
  }
  EXPECT_EQ(Get(gateway.port(), "/", {}, "HEAD").body, "");
  EXPECT_EQ(Get(gateway.port(), "/", {}, "POST").status, 405);
  EXPECT_EQ(Get(gateway.port(), "/", {{"X", std::string(20'000, 'x')}}).status, 400);
  std::filesystem::remove_all(folder);
}

TEST(Gateway, SaysThatThePageIsNotBuiltAndHowToBuildIt) {
  const std::filesystem::path empty =
      std::filesystem::temp_directory_path() / ("palpate_no_page_" + std::to_string(getpid()));
  std::filesystem::create_directories(empty);
  Gateway gateway({"--page", empty.string()});
  const HttpAnswer index = Get(gateway.port(), "/");
  EXPECT_EQ(index.status, 200);
  EXPECT_THAT(index.body, HasSubstr(empty.string()));
  std::filesystem::remove(empty);
  EXPECT_THAT(index.body, HasSubstr("cmake --build --preset release --target page"));
}

TEST(Gateway, TurnsAwayPagesFromElsewhereAndViewersBeyondItsMost) {
  Gateway gateway({"--max-viewers", "2", "--allow-origin", "https://app.example.org"});
  const std::string own = "http://127.0.0.1:" + std::to_string(gateway.port());
  const std::string v1 = "foxglove.websocket.v1";
  EXPECT_EQ(Handshake(gateway.port(), v1).status, 101);
  EXPECT_EQ(Handshake(gateway.port(), v1, own).status, 101);
  const HttpAnswer evil = Handshake(gateway.port(), v1, "http://evil.example");
  EXPECT_EQ(evil.status, 403);
  EXPECT_THAT(evil.body, HasSubstr("its Origin is 'http://evil.example'"));
  EXPECT_THAT(evil.body, HasSubstr("--allow-origin"));
  EXPECT_EQ(Handshake(gateway.port(), v1, "null").status, 403);
  EXPECT_EQ(Handshake(gateway.port(), "chat").status, 400);
  EXPECT_EQ(Handshake(gateway.port(), "").status, 400);
  ASSERT_TRUE(gateway.Until([](const Json& health) { return health["viewers"] == 0; }));
  {
    WebClient one(gateway.port(), "foxglove.websocket.v1", own);
    WebClient two(gateway.port(), "foxglove.websocket.v1", "https://app.example.org");
    EXPECT_TRUE(one.open());
    EXPECT_TRUE(two.open());
    EXPECT_EQ(Handshake(gateway.port(), v1).status, 503);
  }
  EXPECT_TRUE(gateway.Until([](const Json& health) { return health["viewers"] == 0; }));
  EXPECT_TRUE(WebClient(gateway.port()).open());
}

TEST(Gateway, LetsDesktopApplicationsLookAndTakeNothing) {
  const auto server = StartServer();
  Gateway gateway;
  ASSERT_TRUE(gateway.KnowsScenes(1));
  WebClient viewer(gateway.port(), "foxglove.websocket.v1", "file://");
  ASSERT_TRUE(viewer.open());
  EXPECT_EQ(viewer.NextJson("serverInfo")["capabilities"], Json::array());
  viewer.Subscribe(1, kBundle);
  EXPECT_TRUE(viewer.Next(1));
  viewer.Subscribe(9, kMouse);
  EXPECT_THAT(viewer.NextStatus(), HasSubstr("no such channel"));
  viewer.SendMouse({{"op", "take"}, {"scene", "cube"}});
  EXPECT_THAT(viewer.NextStatus(), HasSubstr("may look"));
  EXPECT_EQ(viewer.closed(), 1008);
  EXPECT_EQ(gateway.Health()["mice"], 0);
}

TEST(Gateway, HasRoomForNewcomersHoweverManyConnectionsAreKept) {
  Gateway gateway({"--max-viewers", "300"});
  std::vector<std::unique_ptr<KeptConnection>> kept;
  for (int i = 0; i < 250; ++i) {
    kept.push_back(std::make_unique<KeptConnection>(gateway.port()));
    ASSERT_TRUE(kept.back()->Get("/")) << i;
  }
  EXPECT_EQ(Get(gateway.port(), "/").status, 200);
  EXPECT_EQ(Handshake(gateway.port(), "foxglove.websocket.v1").status, 101);
}

TEST(Gateway, KeepsNoConnectionForItsHealthAndNoneForLongBetweenRequests) {
  Gateway gateway;
  EXPECT_EQ(
      Get(gateway.port(), "/healthz", {{"Connection", "keep-alive"}}).headers.at("connection"),
      "close");
  KeptConnection fresh(gateway.port());
  KeptConnection answered(gateway.port());
  ASSERT_TRUE(answered.Get("/"));
  EXPECT_TRUE(answered.Closed());
  EXPECT_TRUE(fresh.Get("/")) << "who has asked nothing yet is given more time";
}

TEST(Gateway, SaysLittleToWhoSendsMuch) {
  Gateway gateway;
  WebClient viewer(gateway.port());
  const std::string much(60'000, 'x');
  viewer.SendText(
      Json{{"op", "advertise"}, {"channels", {{{"id", 1}, {"topic", much}, {"encoding", "cdr"}}}}}
          .dump());
  EXPECT_LT(viewer.NextJson("status").value("message", much).size(), 500u);
  viewer.SendText(Json{{"op", much}}.dump());
  EXPECT_LT(viewer.NextJson("status").value("message", much).size(), 500u);
  viewer.Subscribe(9, kMouse);
  viewer.SendMouse({{"op", "take"}, {"scene", much}});
  EXPECT_LT(viewer.NextJson("status").value("message", much).size(), 500u);
  EXPECT_TRUE(viewer.open());
}

TEST(Gateway, EndsTheConnectionThatSendsWhatIsNotOfTheProtocolAndNoOther) {
  Gateway gateway;
  WebClient other(gateway.port());
  const std::vector<std::function<void(WebClient&)>> offences = {
      [](WebClient& v) { v.SendText("hello"); },
      [](WebClient& v) { v.SendText("[1, 2"); },
      [](WebClient& v) { v.SendText(R"({"op": "subscribe"})"); },
      [](WebClient& v) { v.SendText(R"({"op": "subscribe", "subscriptions": [{"id": -1}]})"); },
      [](WebClient& v) { v.SendBinary(""); },
      [](WebClient& v) { v.SendBinary(std::string("\x01\x00", 2)); },
      [](WebClient& v) { v.SendBinary(std::string("\x07\x01\0\0\0{}", 7)); },
      [](WebClient& v) { v.SendBinary(std::string("\x01\x01\0\0\0{}", 7)); }};
  for (std::size_t i = 0; i < offences.size(); ++i) {
    WebClient viewer(gateway.port());
    ASSERT_TRUE(viewer.open());
    offences[i](viewer);
    const Json status = viewer.NextJson("status");
    ASSERT_FALSE(status.is_null()) << i;
    EXPECT_EQ(status["level"], 2);
    EXPECT_THAT(status.value("message", ""), HasSubstr("this connection ends: it sent"));
    EXPECT_EQ(viewer.closed(), 1008) << i;
  }
  WebClient large(gateway.port());
  large.SendText("{\"op\": \"" + std::string(200'000, 'x') + "\"}");
  large.closed();  // with 1009, or at once: the rest of it is not waited for
  EXPECT_FALSE(large.open());
  WebClient newer(gateway.port());
  newer.SendText(R"({"op": "getParameters", "parameterNames": []})");
  EXPECT_THAT(newer.NextStatus(), HasSubstr("'getParameters'"));
  newer.Subscribe(1, 99);
  EXPECT_THAT(newer.NextStatus(), HasSubstr("no such channel"));
  EXPECT_TRUE(newer.open());
  EXPECT_TRUE(other.open());
  EXPECT_TRUE(gateway.Until([](const Json& health) { return health["viewers"] == 2; }));
}

TEST(Gateway, OutlivesAnyBytesAtItsPort) {
  Gateway gateway;
  WebClient other(gateway.port());
  Random random(77);
  for (int i = 0; i < 300; ++i) {
    WebClient viewer(gateway.port());
    ASSERT_TRUE(viewer.open());
    for (int n = 0; n < 5; ++n) {
      std::string bytes;
      for (std::size_t k = random.Below(60); k > 0; --k) {
        bytes += static_cast<char>(random.Below(256));
      }
      if (random.Below(2) == 0) {
        viewer.SendBinary(bytes);
      } else {
        viewer.SendText(bytes);  // mostly not UTF-8 either
      }
    }
    Get(gateway.port(), fmt::format("/{}%z", random.Below(1000)));
  }
  EXPECT_TRUE(other.open());
  EXPECT_TRUE(gateway.Until([](const Json& health) { return health["viewers"] == 1; }));
}

/// The mouse's news until its phase is as wanted.
Json MouseUntil(WebClient& viewer, const std::string& phase) {
  for (;;) {
    const auto message = viewer.Next(9);
    if (!message) return {};
    Json news = Json::parse(message->payload.begin(), message->payload.end());
    if (news.value("phase", "") == phase) return news;
  }
}

/// The mouse of this viewer once it holds the tool of a scene.
Json Taken(WebClient& viewer, const std::string& scene = "cube") {
  viewer.Subscribe(9, kMouse);
  viewer.SendMouse({{"op", "take"}, {"scene", scene}});
  Json held = MouseUntil(viewer, "active");
  EXPECT_FALSE(held.is_null());
  return held;
}

/// The tool's state once it meets a condition; frames before are passed over.
bool ToolUntil(WebClient& viewer, const std::function<bool(const wire::ToolState&)>& condition) {
  for (int i = 0; i < 1000; ++i) {
    const auto message = viewer.Next(1);
    if (!message) return false;
    if (condition(Decoded<wire::ToolState>(*message))) return true;
  }
  return false;
}

/// What the server says once a mouse has left.
std::string Left(const Json& held) {
  return "station " + held.value("station", "?") + ": ended: the station left";
}

TEST(Mouse, TakesAToolAndPressesItAndLetsItGo) {
  const auto server = StartServer();
  Gateway gateway;
  ASSERT_TRUE(gateway.KnowsScenes(1));
  WebClient viewer(gateway.port());
  viewer.Subscribe(1, kToolState);
  viewer.Subscribe(9, kMouse);
  viewer.SendMouse({{"op", "take"}, {"scene", "cube"}, {"tool", "ball"}});
  const Json held = MouseUntil(viewer, "active");
  const std::string station = held.value("station", "");
  EXPECT_THAT(station, testing::MatchesRegex("mouse_[0-9a-f]+_1"));
  EXPECT_EQ(held.value("tool", ""), "ball");
  // The cube's top face is at 25 mm, the ball's radius 5 mm; 10 mm deep: 10 N.
  viewer.SendMouse({{"op", "pose"}, {"p", {0.0, 0.020, 0.0}}, {"q", {1, 0, 0, 0}}});
  EXPECT_TRUE(ToolUntil(viewer, [&](const wire::ToolState& tool) {
    return station == tool.station && tool.force_N[1] > 9.9 && tool.graphic_position_m[1] > 0.0299;
  }));
  // Far deeper: no more than 20 mm of it, 20 N.
  viewer.SendMouse({{"op", "pose"}, {"p", {0.0, -0.2, 0.0}}, {"q", {1, 0, 0, 0}}});
  double most = 0.0;
  EXPECT_TRUE(ToolUntil(viewer, [&](const wire::ToolState& tool) {
    most = std::max(most, tool.force_N[1]);
    return tool.force_N[1] > 19.9;
  }));
  EXPECT_LT(most, 20.1);
  viewer.SendMouse({{"op", "release"}});
  EXPECT_FALSE(MouseUntil(viewer, "ended").is_null());
  EXPECT_TRUE(server->Says(Left(held)));
  EXPECT_TRUE(gateway.Until([](const Json& health) { return health["mice"] == 0; }));
}

TEST(Mouse, IsRefusedAToolThatIsTakenAndToldWhy) {
  const auto server = StartServer();
  const auto station = StartStation("first");
  ASSERT_TRUE(server->Says("station first: active"));
  Gateway gateway;
  ASSERT_TRUE(gateway.KnowsScenes(1));
  WebClient viewer(gateway.port());
  viewer.Subscribe(9, kMouse);
  viewer.SendMouse({{"op", "take"}, {"scene", "cube"}});
  const Json refused = MouseUntil(viewer, "refused");
  EXPECT_THAT(refused.value("reason", ""), HasSubstr("is driven by station 'first'"));
  EXPECT_THAT(viewer.NextStatus(), HasSubstr("is driven by station 'first'"));
  viewer.SendMouse({{"op", "take"}, {"scene", "--help"}});
  EXPECT_THAT(MouseUntil(viewer, "refused").value("reason", ""),
              HasSubstr("no server serves scene '--help'"));
  viewer.SendMouse({{"op", "dance"}});
  EXPECT_THAT(viewer.NextStatus(), HasSubstr("the tool is refused"));
  EXPECT_THAT(viewer.NextStatus(), HasSubstr("give one of take, pose, release, whole"));
  EXPECT_TRUE(viewer.open());
}

TEST(Mouse, LetsGoWhenItsPageGoesAndAllowsNoMoreThanItsMost) {
  const auto server = StartServer({"cube", "friction"});
  Gateway gateway({"--max-mice", "1"});
  ASSERT_TRUE(gateway.KnowsScenes(2));
  WebClient other(gateway.port());
  other.Subscribe(9, kMouse);
  Json held;
  {
    WebClient viewer(gateway.port());
    held = Taken(viewer);
    other.SendMouse({{"op", "take"}, {"scene", "friction"}});
    EXPECT_THAT(MouseUntil(other, "refused").value("reason", ""), HasSubstr("--max-mice"));
  }
  EXPECT_TRUE(server->Says(Left(held)));
  EXPECT_TRUE(gateway.Until([](const Json& health) { return health["mice"] == 0; }));
  other.SendMouse({{"op", "take"}, {"scene", "friction"}});
  EXPECT_FALSE(MouseUntil(other, "active").is_null());
}

TEST(Mouse, LeavesTheMiceOfAnotherGatewayAlone) {
  const auto server = StartServer({"cube", "friction"});
  Gateway one, two;
  ASSERT_TRUE(one.KnowsScenes(2));
  ASSERT_TRUE(two.KnowsScenes(2));
  WebClient first(one.port()), second(two.port());
  const Json held = Taken(first), other = Taken(second, "friction");
  EXPECT_NE(held["station"], other["station"]);
  second.SendMouse({{"op", "release"}});
  EXPECT_TRUE(server->Says(Left(other)));
  EXPECT_EQ(one.Health()["mice"], 1);
  first.SendMouse({{"op", "release"}});
  EXPECT_TRUE(server->Says(Left(held)));
}

TEST(Mouse, LetsGoOfAPageThatStandsStill) {
  const auto server = StartServer();
  Gateway gateway;
  ASSERT_TRUE(gateway.KnowsScenes(1));
  WebClient viewer(gateway.port());
  const Json held = Taken(viewer);
  EXPECT_TRUE(server->Says(Left(held), 60.0)) << "nothing is read any more, so no ping is answered";
}

/// What a replayer says, without one.
class Replayer {
 public:
  Replayer() {
    wire::ReplayContents contents{};
    contents.replay = kNumber;
    wire::FromText("lesson.mcap", contents.recording);
    contents.length_s = 60;
    EXPECT_TRUE(contents_.Write(contents));
    Tell(1.5, 0);
  }
  void Tell(double at_s, std::uint64_t request) {
    wire::ReplayState state{};
    state.replay = kNumber;
    state.at_s = at_s;
    state.request = request;
    EXPECT_TRUE(states_.Write(state));
  }
  std::optional<wire::ReplayRequest> Asked() {
    wire::ReplayRequest request{};
    for (int i = 0; i < 2000; ++i) {
      if (requests_.Take(request)) return request;
      usleep(10'000);
    }
    return std::nullopt;
  }

  static constexpr std::uint64_t kNumber = 0xfedcba9876543210;

 private:
  dds::Participant participant_ = dds::Participant::Service(kDomain);
  dds::Writer<wire::ReplayContents> contents_{participant_, dds::kReplayContentsTopic,
                                              dds::Qos::kSession};
  dds::Writer<wire::ReplayState> states_{participant_, dds::kReplayStateTopic, dds::Qos::kSession};
  dds::Reader<wire::ReplayRequest> requests_{participant_, dds::kReplayRequestTopic,
                                             dds::Qos::kRecordSession};
};

Json NextOf(WebClient& viewer, std::uint32_t subscription) {
  const auto message = viewer.Next(subscription);
  return message ? Json::parse(message->payload) : Json();
}

TEST(Replay, IsToldToPagesAndSteeredByThemAlsoWhereNobodyTakesATool) {
  Gateway gateway({"--max-mice", "0"});
  WebClient viewer(gateway.port());
  EXPECT_EQ(viewer.NextJson("serverInfo")["capabilities"], Json::array({"clientPublish"}));
  viewer.Subscribe(20, kContents);
  viewer.Subscribe(21, kReplay);
  viewer.Subscribe(22, kAnswer);
  Replayer replayer;
  EXPECT_EQ(NextOf(viewer, 20)["recording"], "lesson.mcap");
  const Json state = NextOf(viewer, 21);
  EXPECT_EQ(state["replay"], "fedcba9876543210");
  EXPECT_EQ(state["at_s"], 1.5);
  viewer.SendReplay({{"replay", state["replay"]},
                     {"tag", 7},
                     {"wish", "add_bookmark"},
                     {"value", 1.25},
                     {"text", "the slip"}});
  const auto asked = replayer.Asked();
  ASSERT_TRUE(asked);
  EXPECT_EQ(asked->replay, Replayer::kNumber);
  EXPECT_EQ(asked->wish, palpate_REPLAY_ADD_BOOKMARK);
  EXPECT_EQ(asked->value, 1.25);
  EXPECT_STREQ(asked->text, "the slip");
  EXPECT_THAT(asked->by, HasSubstr("the page at 127.0.0.1:"));
  EXPECT_NE(asked->request, 0u);
  EXPECT_EQ(NextOf(viewer, 22),
            Json({{"tag", 7}, {"request", fmt::format("{:x}", asked->request)}, {"refusal", ""}}));
  replayer.Tell(2.5, asked->request);
  EXPECT_EQ(NextOf(viewer, 21)["request"], fmt::format("{:x}", asked->request));
  // Who comes later hears of it, too.
  WebClient late(gateway.port());
  late.Subscribe(20, kContents);
  late.Subscribe(21, kReplay);
  EXPECT_EQ(NextOf(late, 20)["length_s"], 60);
  EXPECT_EQ(NextOf(late, 21)["at_s"], 2.5);
  // The mouse stays ruled out.
  viewer.SendMouse({{"op", "take"}, {"scene", "cube"}});
  EXPECT_THAT(viewer.NextStatus(), HasSubstr("--max-mice"));
  EXPECT_EQ(viewer.closed(), 1008);
}

TEST(Replay, AnswersWishesThatCannotBeFulfilledAndStandsThoseThatAreNone) {
  Gateway gateway;
  WebClient viewer(gateway.port());
  viewer.Subscribe(22, kAnswer);
  viewer.SendReplay({{"replay", "1"}, {"tag", 3}, {"wish", "play"}});
  const Json answer = NextOf(viewer, 22);
  EXPECT_EQ(answer["tag"], 3);
  EXPECT_THAT(answer.value("refusal", ""), HasSubstr("not there any more"));
  viewer.SendReplay({{"op", "take"}, {"scene", "cube"}});
  EXPECT_THAT(viewer.NextStatus(), HasSubstr("/palpate/replay:1: "));
  // Each channel is what it was advertised for.
  viewer.SendMouse({{"replay", "1"}, {"tag", 3}, {"wish", "play"}});
  EXPECT_THAT(viewer.NextStatus(), HasSubstr("/palpate/mouse:1: "));
  EXPECT_TRUE(viewer.open());
}

TEST(Replay, IsSeenAndNotSteeredByWhoMayOnlyLookNorWhereTheGatewayRulesItOut) {
  struct Case {
    std::vector<std::string> options;
    const char* origin;
    testing::Matcher<std::string> why;
  };
  const auto ruled_out = AllOf(HasSubstr("give /palpate/mouse or /palpate/operate, encoding json"),
                               HasSubstr("--no-steering"));
  for (const Case& of :
       {Case{{}, "file://", HasSubstr("may look")}, Case{{"--no-steering"}, "", ruled_out}}) {
    Gateway gateway(of.options);
    Replayer replayer;
    WebClient viewer(gateway.port(), "foxglove.websocket.v1", of.origin);
    viewer.Subscribe(21, kReplay);
    const Json state = NextOf(viewer, 21);
    EXPECT_EQ(state["at_s"], 1.5);
    viewer.Subscribe(22, kAnswer);
    EXPECT_THAT(viewer.NextStatus(), HasSubstr("no such channel"));
    viewer.SendReplay({{"replay", state["replay"]}, {"tag", 1}, {"wish", "pause"}});
    EXPECT_THAT(viewer.NextStatus(), of.why);
    EXPECT_EQ(viewer.closed(), 1008);
  }
}

TEST(Replay, TellsAPageThatMayOnlyLookThatItMayPublishNothing) {
  Gateway gateway({"--no-steering", "--max-mice", "0"});
  // From this host it could decide about stations; from elsewhere, as a proxy says, it cannot.
  WebClient viewer(gateway.port(), "foxglove.websocket.v1", "", 0,
                   {{"X-Forwarded-For", "192.168.0.7"}});
  EXPECT_EQ(viewer.NextJson("serverInfo")["capabilities"], Json::array());
  viewer.SendReplay({{"replay", "1"}, {"tag", 1}, {"wish", "pause"}});
  EXPECT_THAT(viewer.NextStatus(),
              AllOf(HasSubstr("--max-mice"), HasSubstr("--no-steering"), Not(HasSubstr("give"))));
}

TEST(Gateway, EndsOnASignalAndTakesLeaveOfViewersAndMice) {
  const auto server = StartServer();
  Gateway gateway;
  ASSERT_TRUE(gateway.KnowsScenes(1));
  WebClient viewer(gateway.port());
  const Json held = Taken(viewer);
  gateway.program().Signal(SIGTERM);
  EXPECT_EQ(viewer.closed(), 1001);
  EXPECT_EQ(gateway.program().Exit(), 0) << gateway.program().Output();
  EXPECT_TRUE(server->Says(Left(held)));
}

TEST(Gateway, EndsInOrderWithAConnectionOpen) {
  Gateway gateway;
  KeptConnection fresh(gateway.port()), answered(gateway.port());
  ASSERT_TRUE(answered.Get("/"));
  gateway.program().Signal(SIGTERM);
  EXPECT_EQ(gateway.program().Exit(), 0) << gateway.program().Output();
}

TEST(Gateway, SaysWhichPortItCannotHave) {
  Gateway gateway;
  Program second(PALPATE_BIN_DIR "/palpate-viewer",
                 {"--http", std::to_string(gateway.port()), "--domain", std::to_string(kDomain)});
  EXPECT_EQ(second.Exit(), 1);
  EXPECT_THAT(second.Output(), HasSubstr("port " + std::to_string(gateway.port())));
  EXPECT_THAT(second.Output(), HasSubstr("give another --http"));
}

}  // namespace
}  // namespace palpate::test
