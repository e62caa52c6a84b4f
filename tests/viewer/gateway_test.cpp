// The real palpate-viewer beside a real server: what viewers get, and that they cannot disturb each
// other.
#include "tests/viewer/gateway.h"

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "client/viewer/topic_feed.h"
#include "common/dds/cdr.h"
#include "common/realtime/steady_clock.h"
#include "scenes/files/scene_bundle.h"
#include "tests/support/folder.h"

namespace palpate::test {
namespace {

using Json = nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

template <class T>
T Decoded(const WebClient::Message& message) {
  T sample{};
  EXPECT_TRUE(dds::FromCdr(message.payload, sample));
  return sample;
}

std::unique_ptr<Program> StartServer(const std::vector<std::string>& scenes) {
  std::vector<std::string> arguments{"--realtime", "off",      "--transport",
                                     "udp",        "--domain", std::to_string(kDomain)};
  for (const std::string& scene : scenes) arguments.insert(arguments.end(), {"--scene", scene});
  auto server = std::make_unique<Program>(PALPATE_BIN_DIR "/palpate-server", arguments);
  EXPECT_TRUE(server->Says("ready: ", 60.0)) << server->Output();
  return server;
}

/// One server for all tests of a suite, and for each test a gateway that knows its scenes.
class AtServer : public testing::Test {
 protected:
  static void SetUpTestSuite() { server_ = StartServer({"cube", "friction"}); }
  static void TearDownTestSuite() { server_.reset(); }
  void SetUp() override { ASSERT_TRUE(gateway_.KnowsScenes(2)); }
  void TearDown() override {
    if (!station_) return;
    station_->Signal(SIGTERM);
    EXPECT_TRUE(server_->Says(": ended: the station left")) << "the next test wants its tool";
  }
  void StartStation(const std::string& id, const std::vector<std::string>& script = {"--loop"}) {
    station_ = std::make_unique<Program>(
        PALPATE_BIN_DIR "/palpate-station",
        Joined({"--device", "scripted", "--scene", "cube", "--id", id, "--no-table", "--realtime",
                "off", "--transport", "udp", "--domain", std::to_string(kDomain)},
               script));
    ASSERT_TRUE(server_->Says("station " + id + ": active"));
  }

  static inline std::unique_ptr<Program> server_;
  Gateway gateway_;
  std::unique_ptr<Program> station_;
};
class Mouse : public AtServer {};
class Scenes : public AtServer {};
class Succession : public AtServer {};

TEST(Gateway, TellsEachViewerWhichChannelsThereAreAndLetsItSubscribeToThemAlone) {
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
           {"/palpate/scene_whole", "palpate::SceneWhole"},
           {"/palpate/solid_block", "palpate::SolidBlock"},
           {"/palpate/scene_bundle", "palpate::SceneBundle"}}) {
    ASSERT_TRUE(by_topic.contains(topic));
    EXPECT_EQ(by_topic[topic]["encoding"], "cdr");
    EXPECT_EQ(by_topic[topic]["schemaEncoding"], "omgidl");
    EXPECT_EQ(by_topic[topic]["schemaName"], schema);
    const std::string text = by_topic[topic]["schema"];
    EXPECT_THAT(text, HasSubstr("module palpate {"));
    EXPECT_THAT(text, HasSubstr("struct " + schema.substr(9) + " {"));
    EXPECT_THAT(text, Not(HasSubstr("#include")));
  }
  EXPECT_EQ(by_topic["/palpate/mouse_state"]["encoding"], "json");
  std::uint32_t id = 100;
  for (const Json& channel : channels) viewer.Subscribe(++id, channel["id"]);
  viewer.Subscribe(7777, 99);
  // Refusals come in the order of the requests.
  EXPECT_THAT(viewer.NextStatus(),
              HasSubstr("subscription 7777 to channel 99 is refused: there is no such channel"));
}

TEST_F(Scenes, AreGivenToLateViewersWithTheSessionsAndThenTheTool) {
  Gateway& gateway = gateway_;
  StartStation("held", {"--script", PALPATE_SOURCE_DIR "/tests/integration/press.json"});
  ASSERT_TRUE(gateway.Until([](const Json& h) { return h["stations"] == Json::array({"held"}); }));

  const dds::Participant participant = dds::Participant::Service(kDomain);
  dds::CdrReader<wire::ToolState> direct(participant, dds::kToolStateTopic, dds::Qos::kStream);
  WebClient viewer(gateway.port());
  viewer.Subscribe(70, TopicFeed::kSceneBundle);
  viewer.Subscribe(71, TopicFeed::kSessionState);
  viewer.Subscribe(72, TopicFeed::kToolState);
  viewer.Subscribe(73, TopicFeed::kLoopStatistics);
  viewer.Subscribe(74, TopicFeed::kStationStatistics);

  const auto bundle = viewer.Next(70);
  ASSERT_TRUE(bundle);
  auto scene = Decoded<wire::SceneBundle>(*bundle);
  const std::span bytes(scene.bundle._buffer, scene.bundle._length);
  EXPECT_EQ(scene.hash, BundleHash(bytes));
  EXPECT_EQ(UnpackScene(bytes, "the viewer's").name, scene.scene);
  dds::FreeContents(scene);

  const auto session = viewer.Next(71);
  ASSERT_TRUE(session);
  const auto held = Decoded<wire::SessionState>(*session);
  EXPECT_STREQ(held.station, "held");
  EXPECT_EQ(gateway.Health()["server_run"], fmt::format("{:x}", held.server_run));

  // A viewer sees of a pose what a reader of DDS sees.
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
  // It still hears statistics once a second, which come the same way.  Tool states that were on
  // their way come before the second of these; a subscription that went on would bring some sixty
  // more.
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

TEST_F(Scenes, HaveToolStatesAtTheRateThatAGatewayIsTold) {
  StartStation("a");
  Gateway gateway({"--rate", "20"});
  WebClient viewer(gateway.port());
  viewer.Subscribe(1, TopicFeed::kToolState);
  ASSERT_TRUE(viewer.Next(1));
  // 50 ms apart on average: by the states' numbers, one a millisecond, or by the clock if the
  // station could not keep up.
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

TEST_F(Scenes, LoseFramesForAStalledViewerAndForNobodyElse) {
  StartStation("a");
  Gateway gateway({"--rate", "60"});
  ASSERT_TRUE(gateway.KnowsScenes(2));
  WebClient stalled(gateway.port(), kV1, "", 4096);
  WebClient lively(gateway.port());
  // It does not read, and the bundles are more than the kernel buffers for it.
  stalled.Subscribe(2, TopicFeed::kSceneBundle);
  stalled.Subscribe(1, TopicFeed::kToolState);
  lively.Subscribe(1, TopicFeed::kToolState);
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
  // When it reads again it gets the newest: one frame, and those that come from now on.
  ASSERT_TRUE(stalled.Next(2));
  const auto next = stalled.Next(1);
  ASSERT_TRUE(next);
  EXPECT_GE(Decoded<wire::ToolState>(*next).pose_sequence + 200, last);
}

TEST_F(Succession, KeepsTheViewersWhileThereIsNoServerAndShowsThemTheNext) {
  WebClient viewer(gateway_.port());
  viewer.Subscribe(1, TopicFeed::kSceneBundle);
  viewer.Subscribe(2, TopicFeed::kToolState);
  ASSERT_TRUE(viewer.Next(1));
  const auto before = viewer.Next(1);
  ASSERT_TRUE(before);
  server_->Signal(SIGKILL);
  EXPECT_EQ(server_->Exit(), -SIGKILL);
  viewer.Run(0.3);
  EXPECT_TRUE(viewer.open());
  const Json health = gateway_.Health();
  EXPECT_EQ(health["scenes"], Json::array({"cube", "friction"})) << "what is known stays";

  server_ = StartServer({"friction"});
  const auto after = viewer.Next(1);
  ASSERT_TRUE(after);
  auto old_scene = Decoded<wire::SceneBundle>(*before);
  auto new_scene = Decoded<wire::SceneBundle>(*after);
  EXPECT_NE(old_scene.server_run, new_scene.server_run);
  EXPECT_STREQ(new_scene.scene, "friction");
  dds::FreeContents(old_scene);
  dds::FreeContents(new_scene);
  EXPECT_EQ(gateway_.Health()["scenes"], Json::array({"friction"}));
  EXPECT_NE(gateway_.Health()["server_run"], health["server_run"]);

  server_.reset();
  server_ = StartServer({"cube"});
  StartStation("a");
  EXPECT_TRUE(viewer.Next(2)) << station_->Output() << server_->Output();
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

TEST_F(Scenes, ComeOverHttpWithTheirHashAndCompressed) {
  Gateway& gateway = gateway_;
  const HttpAnswer plain = Get(gateway.port(), "/scene/cube.bundle");
  EXPECT_EQ(plain.status, 200);
  const std::span bytes(reinterpret_cast<const std::uint8_t*>(plain.body.data()),
                        plain.body.size());
  EXPECT_EQ(UnpackScene(bytes, "the gateway's").name, "cube");
  const std::string etag = fmt::format("\"{:016x}\"", BundleHash(bytes));
  EXPECT_EQ(plain.headers.at("etag"), etag);
  EXPECT_EQ(Get(gateway.port(), "/scene/cube.bundle", {{"If-None-Match", etag}}).status, 304);
  std::string packed_tag;
  for (int time = 0; time < 2; ++time) {  // first packed, then kept
    const HttpAnswer packed =
        Get(gateway.port(), "/scene/cube.bundle", {{"Accept-Encoding", "gzip, br"}});
    EXPECT_EQ(packed.status, 200);
    EXPECT_EQ(packed.headers.at("content-encoding"), "gzip");
    packed_tag = packed.headers.at("etag");
    EXPECT_LT(packed.body.size(), plain.body.size());
    EXPECT_EQ(packed.body.substr(0, 2), "\x1f\x8b");
  }
  // A tag names exact bytes, and a cache is told what they depend on.
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

TEST(Gateway, ServesThePageAndNothingBesideItOrSaysHowToBuildIt) {
  const Folder folder;
  const std::string page = folder / "page";
  std::filesystem::create_directories(page + "/assets");
  Gateway gateway({"--page", page});
  const HttpAnswer none = Get(gateway.port(), "/");
  EXPECT_EQ(none.status, 200);
  EXPECT_THAT(none.body,
              AllOf(HasSubstr(page), HasSubstr("cmake --build --preset release --target page")));
  std::ofstream(folder / "secret.txt") << "secret";
  std::ofstream(page + "/index.html") << "<p>the page";
  std::ofstream(page + "/assets/a1.js") << "plain";
  std::ofstream(page + "/assets/a1.js.gz") << "packed";
  const HttpAnswer index = Get(gateway.port(), "/?x=1");
  EXPECT_EQ(index.status, 200);
  EXPECT_EQ(index.body, "<p>the page");
  EXPECT_EQ(index.headers.at("content-type"), "text/html; charset=utf-8");
  EXPECT_THAT(index.headers.at("content-security-policy"),
              HasSubstr("script-src 'self' 'wasm-unsafe-eval';"))
      << "what makes coarser meshes of the page's";
  EXPECT_EQ(Get(gateway.port(), "/assets/a1.js").body, "plain");
  const HttpAnswer packed = Get(gateway.port(), "/assets/a1.js", {{"Accept-Encoding", "gzip"}});
  EXPECT_EQ(packed.body, "packed");
  EXPECT_EQ(packed.headers.at("content-encoding"), "gzip");
  EXPECT_EQ(packed.headers.at("content-type"), "text/javascript; charset=utf-8");
  EXPECT_THAT(packed.headers.at("cache-control"), HasSubstr("immutable"));
  for (const char* path : {"/../secret.txt", "/%2e%2e/secret.txt", "/secret.txt"}) {
    const HttpAnswer answer = Get(gateway.port(), path);
    EXPECT_GE(answer.status, 400) << path;
    EXPECT_THAT(answer.body, Not(HasSubstr("secret"))) << path;
  }
  const HttpAnswer head = Get(gateway.port(), "/", {}, "HEAD");
  EXPECT_EQ(head.headers.at("content-length"), "11");
  EXPECT_EQ(head.body, "");
  EXPECT_EQ(Get(gateway.port(), "/", {}, "POST").status, 405);
  EXPECT_EQ(Get(gateway.port(), "/", {{"X", std::string(20'000, 'x')}}).status, 400);
}

TEST(Gateway, LetsInPagesOfItsOwnAndThoseThatAreNamed) {
  Gateway gateway({"--allow-origin", "https://app.example.org"});
  for (const std::string& origin :
       {std::string(), "http://127.0.0.1:" + std::to_string(gateway.port()),
        std::string("https://app.example.org")}) {
    EXPECT_EQ(Handshake(gateway.port(), kV1, origin).status, 101) << origin;
  }
  const HttpAnswer evil = Handshake(gateway.port(), kV1, "http://evil.example");
  EXPECT_EQ(evil.status, 403);
  EXPECT_THAT(evil.body,
              AllOf(HasSubstr("its Origin is 'http://evil.example'"), HasSubstr("--allow-origin")));
  for (const char* other : {"chat", ""}) EXPECT_EQ(Handshake(gateway.port(), other).status, 400);
  EXPECT_TRUE(gateway.HasViewers(0));
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

TEST(Gateway, KeepsNoConnectionForItsHealthNoneForLongAndEndsInOrderWithOneOpen) {
  Gateway gateway;
  EXPECT_EQ(
      Get(gateway.port(), "/healthz", {{"Connection", "keep-alive"}}).headers.at("connection"),
      "close");
  KeptConnection fresh(gateway.port());
  KeptConnection answered(gateway.port());
  ASSERT_TRUE(answered.Get("/"));
  EXPECT_TRUE(answered.Closed());
  EXPECT_TRUE(fresh.Get("/")) << "who has asked nothing yet is given more time";
  gateway.program().Signal(SIGTERM);
  EXPECT_EQ(gateway.program().Exit(), 0) << gateway.program().Output();
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
  viewer.Subscribe(9, TopicFeed::kMouseState);
  viewer.SendMouse({{"op", "take"}, {"scene", much}});
  EXPECT_LT(viewer.NextJson("status").value("message", much).size(), 500u);
  EXPECT_TRUE(viewer.open());
}

TEST(Gateway, EndsTheConnectionThatSendsWhatIsNotOfTheProtocolAndNoOther) {
  Gateway gateway;
  WebClient other(gateway.port());
  const std::vector<std::function<void(WebClient&)>> offences = {
      [](WebClient& v) { v.SendText("hello"); },
      [](WebClient& v) { v.SendText(R"({"op": "subscribe"})"); },
      [](WebClient& v) { v.SendBinary(""); },
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
  large.closed();  // with 1009, or at once: it does not wait for the rest
  EXPECT_FALSE(large.open());
  WebClient newer(gateway.port());
  newer.SendText(R"({"op": "getParameters", "parameterNames": []})");
  EXPECT_THAT(newer.NextStatus(), HasSubstr("'getParameters'"));
  newer.Subscribe(1, 99);
  EXPECT_THAT(newer.NextStatus(), HasSubstr("no such channel"));
  EXPECT_TRUE(newer.open());
  EXPECT_TRUE(other.open());
  EXPECT_TRUE(gateway.HasViewers(2));
}

/// Reads the mouse's news until its phase is `phase`.
Json MouseUntil(WebClient& viewer, const std::string& phase) {
  for (;;) {
    const auto message = viewer.Next(9);
    if (!message) return {};
    Json news = Json::parse(message->payload.begin(), message->payload.end());
    if (news.value("phase", "") == phase) return news;
  }
}

/// Takes the tool of a scene; returns the mouse's news once it holds it.
Json Taken(WebClient& viewer, const std::string& scene = "cube") {
  viewer.Subscribe(9, TopicFeed::kMouseState);
  viewer.SendMouse({{"op", "take"}, {"scene", scene}});
  Json held = MouseUntil(viewer, "active");
  EXPECT_FALSE(held.is_null());
  return held;
}

/// Reads tool states until one meets the condition.
bool ToolUntil(WebClient& viewer, const std::function<bool(const wire::ToolState&)>& condition) {
  for (int i = 0; i < 1000; ++i) {
    const auto message = viewer.Next(1);
    if (!message) return false;
    if (condition(Decoded<wire::ToolState>(*message))) return true;
  }
  return false;
}

/// What the server logs once a mouse has left.
std::string Left(const Json& held) {
  return "station " + held.value("station", "?") + ": ended: the station left";
}

TEST_F(Mouse, TakesAToolAndPressesItAndLetsItGo) {
  WebClient viewer(gateway_.port());
  viewer.Subscribe(1, TopicFeed::kToolState);
  viewer.Subscribe(9, TopicFeed::kMouseState);
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
  // Far deeper, no more than 20 mm of it count: 20 N.
  viewer.SendMouse({{"op", "pose"}, {"p", {0.0, -0.2, 0.0}}, {"q", {1, 0, 0, 0}}});
  double most = 0.0;
  EXPECT_TRUE(ToolUntil(viewer, [&](const wire::ToolState& tool) {
    most = std::max(most, tool.force_N[1]);
    return tool.force_N[1] > 19.9;
  }));
  EXPECT_LT(most, 20.1);
  viewer.SendMouse({{"op", "release"}});
  EXPECT_FALSE(MouseUntil(viewer, "ended").is_null());
  EXPECT_TRUE(server_->Says(Left(held)));
  EXPECT_TRUE(gateway_.Until([](const Json& health) { return health["mice"] == 0; }));
}

TEST_F(Mouse, IsRefusedAToolThatIsTakenAndToldWhy) {
  StartStation("first");
  WebClient viewer(gateway_.port());
  viewer.Subscribe(9, TopicFeed::kMouseState);
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

TEST_F(Mouse, LetsGoWhenItsPageGoesAndAllowsNoMoreThanItsMost) {
  Gateway gateway({"--max-mice", "1"});
  ASSERT_TRUE(gateway.KnowsScenes(2));
  WebClient other(gateway.port());
  other.Subscribe(9, TopicFeed::kMouseState);
  Json held;
  {
    WebClient viewer(gateway.port());
    held = Taken(viewer);
    other.SendMouse({{"op", "take"}, {"scene", "friction"}});
    EXPECT_THAT(MouseUntil(other, "refused").value("reason", ""), HasSubstr("--max-mice"));
  }
  EXPECT_TRUE(server_->Says(Left(held)));
  EXPECT_TRUE(gateway.Until([](const Json& health) { return health["mice"] == 0; }));
  other.SendMouse({{"op", "take"}, {"scene", "friction"}});
  held = MouseUntil(other, "active");
  EXPECT_FALSE(held.is_null());
  other.SendMouse({{"op", "release"}});
  EXPECT_TRUE(server_->Says(Left(held)));
}

TEST_F(Mouse, LeavesTheMiceOfAnotherGatewayAlone) {
  Gateway two;
  ASSERT_TRUE(two.KnowsScenes(2));
  WebClient first(gateway_.port()), second(two.port());
  const Json held = Taken(first), other = Taken(second, "friction");
  EXPECT_NE(held["station"], other["station"]);
  second.SendMouse({{"op", "release"}});
  EXPECT_TRUE(server_->Says(Left(other)));
  EXPECT_EQ(gateway_.Health()["mice"], 1);
  first.SendMouse({{"op", "release"}});
  EXPECT_TRUE(server_->Says(Left(held)));
}

TEST_F(Mouse, LetsGoOfAPageThatStandsStill) {
  WebClient viewer(gateway_.port());
  const Json held = Taken(viewer);
  EXPECT_TRUE(server_->Says(Left(held), 60.0))
      << "nothing is read any more, so no ping is answered";
}

/// Stands in for a replayer.
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
    return Eventually([&] { return requests_.Take(request); }) ? std::optional(request)
                                                               : std::nullopt;
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
  viewer.Subscribe(20, TopicFeed::kReplayContents);
  viewer.Subscribe(21, TopicFeed::kReplayState);
  viewer.Subscribe(22, TopicFeed::kReplayAnswer);
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
  // A late viewer hears of it, too.
  WebClient late(gateway.port());
  late.Subscribe(20, TopicFeed::kReplayContents);
  late.Subscribe(21, TopicFeed::kReplayState);
  EXPECT_EQ(NextOf(late, 20)["length_s"], 60);
  EXPECT_EQ(NextOf(late, 21)["at_s"], 2.5);
  // Taking a tool stays ruled out.
  viewer.SendMouse({{"op", "take"}, {"scene", "cube"}});
  EXPECT_THAT(viewer.NextStatus(), HasSubstr("--max-mice"));
  EXPECT_EQ(viewer.closed(), 1008);
}

TEST(Replay, AnswersWishesThatCannotBeFulfilledAndStandsThoseThatAreNone) {
  Gateway gateway;
  WebClient viewer(gateway.port());
  viewer.Subscribe(22, TopicFeed::kReplayAnswer);
  viewer.SendReplay({{"replay", "1"}, {"tag", 3}, {"wish", "play"}});
  const Json answer = NextOf(viewer, 22);
  EXPECT_EQ(answer["tag"], 3);
  EXPECT_THAT(answer.value("refusal", ""), HasSubstr("has ended"));
  viewer.SendReplay({{"op", "take"}, {"scene", "cube"}});
  EXPECT_THAT(viewer.NextStatus(), HasSubstr("/palpate/replay:1: "));
  // Each channel takes only what it was advertised for.
  viewer.SendMouse({{"replay", "1"}, {"tag", 3}, {"wish", "play"}});
  EXPECT_THAT(viewer.NextStatus(), HasSubstr("/palpate/mouse:1: "));
  EXPECT_TRUE(viewer.open());
}

TEST(Replay, IsSeenAndNotSteeredByWhoMayOnlyLookNorWhereTheGatewayRulesItOut) {
  struct Case {
    std::vector<std::string> options;
    const char* origin;
    Gateway::Headers headers;
    bool publishes;
    testing::Matcher<std::string> why;
  };
  const std::vector<Case> cases = {
      // Desktop applications.
      {{}, "file://", {}, false, HasSubstr("may look")},
      {{"--no-steering"},
       "",
       {},
       true,
       AllOf(HasSubstr("give /palpate/mouse or /palpate/operate, encoding json"),
             HasSubstr("--no-steering"))},
      // From this host it could decide about stations; from elsewhere, as the proxy's header says,
      // not.
      {{"--no-steering", "--max-mice", "0"},
       "",
       {{"X-Forwarded-For", "192.168.0.7"}},
       false,
       AllOf(HasSubstr("--max-mice"), HasSubstr("--no-steering"), Not(HasSubstr("give")))}};
  for (const Case& of : cases) {
    Gateway gateway(of.options);
    Replayer replayer;
    WebClient viewer(gateway.port(), kV1, of.origin, 0, of.headers);
    EXPECT_EQ(viewer.NextJson("serverInfo")["capabilities"].empty(), !of.publishes);
    viewer.Subscribe(21, TopicFeed::kReplayState);
    const Json state = NextOf(viewer, 21);
    EXPECT_EQ(state["at_s"], 1.5);
    viewer.Subscribe(22, TopicFeed::kReplayAnswer);
    EXPECT_THAT(viewer.NextStatus(), HasSubstr("no such channel"));
    if (!of.publishes) {
      viewer.Subscribe(23, TopicFeed::kMouseState);
      EXPECT_THAT(viewer.NextStatus(), HasSubstr("no such channel"));
    }
    viewer.SendReplay({{"replay", state["replay"]}, {"tag", 1}, {"wish", "pause"}});
    EXPECT_THAT(viewer.NextStatus(), of.why);
    EXPECT_EQ(viewer.closed(), 1008);
  }
}

TEST_F(Mouse, IsLetGoOfAndItsViewerToldWhenTheGatewayEndsOnASignal) {
  WebClient viewer(gateway_.port());
  const Json held = Taken(viewer);
  gateway_.program().Signal(SIGTERM);
  EXPECT_EQ(viewer.closed(), 1001);
  EXPECT_EQ(gateway_.program().Exit(), 0) << gateway_.program().Output();
  EXPECT_TRUE(server_->Says(Left(held)));
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
