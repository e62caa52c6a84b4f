// Access to the real palpate-viewer over real sockets: by which Host, from which address, how
// often, with which token, over TLS or not.  Needs no server: a stand-in says what one would.
#include <array>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <memory>
#include <set>
#include <thread>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl.hpp>
#include <boost/asio/ssl/impl/src.hpp>
#include <boost/asio/write.hpp>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <sys/stat.h>

#include "client/viewer/topic_feed.h"
#include "tests/support/folder.h"
#include "tests/support/random.h"
#include "tests/viewer/gateway.h"

namespace palpate::test {
namespace {

namespace net = boost::asio;
using net::ip::tcp;
using Json = nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using Headers = Gateway::Headers;

Headers From(const std::string& address) {
  return {{"X-Forwarded-For", address}};
}
Headers Bearing(const std::string& token) {
  return {{"Authorization", "Bearer " + token}};
}

// --- Host ---

TEST(Host, IsCheckedOfEveryRequestWhateverTheGatewayIsBoundTo) {
  for (const char* bound : {"127.0.0.1", "0.0.0.0"}) {
    Gateway gateway({"--bind", bound, "--host-name", "lab.example"});
    EXPECT_THAT(gateway.program().Output(), HasSubstr("ready: page http://lab.example:"));
    const auto socket_at = [&](const std::string& host) {
      return Handshake(gateway.port(), kV1, "http://" + host, {{"Host", host}}).status;
    };
    for (const char* host : {"evil.example", "localhost.evil.example:80", "lab", ""}) {
      for (const char* target : {"/healthz", "/", "/scene/cube.bundle", "/assets/x.js"}) {
        const HttpAnswer answer = Get(gateway.port(), target, {{"Host", host}});
        EXPECT_EQ(answer.status, 421) << bound << ' ' << host << ' ' << target;
        EXPECT_THAT(answer.body, AllOf(HasSubstr("--host-name"), Not(HasSubstr("scenes"))));
      }
      EXPECT_EQ(Handshake(gateway.port(), kV1, "", {{"Host", host}}).status, 421) << host;
      EXPECT_EQ(socket_at(host), 421) << host;
    }
    for (const char* host : {"localhost:8765", "[::1]", "10.1.2.3:80", "LAB.example"}) {
      EXPECT_EQ(Get(gateway.port(), "/healthz", {{"Host", host}}).status, 200) << host;
      EXPECT_EQ(socket_at(host), 101) << host;
    }
    EXPECT_TRUE(gateway.Logs("refused (host) 127.0.0.1:"));
  }
}

TEST(Host, IsNamedOnceByARequestAndNotByItsTarget) {
  Gateway gateway;
  EXPECT_EQ(Get(gateway.port(), "/healthz", {{"Host", "127.0.0.1\r\nHost: evil.example"}}).status,
            400);
  EXPECT_EQ(Get(gateway.port(), "http://evil.example/healthz").status, 400);
}

TEST(Refusals, DoNotForgeLinesOfTheLog) {
  Gateway gateway;
  Handshake(gateway.port(), kV1, "http://x\x1b[2J");
  Get(gateway.port(), "/healthz", {{"Host", "x\x1b[2J\x7f"}});
  EXPECT_TRUE(gateway.Logs("refused ("));
  EXPECT_THAT(gateway.program().Output(), Not(HasSubstr("\x1b[2J")));
}

// --- places and takes ---

TEST(Places, AreNotAllOneClientsHoweverManyItOpens) {
  Gateway gateway({"--max-viewers", "30", "--proxy", "127.0.0.1"});
  std::vector<std::unique_ptr<WebClient>> flood;
  for (int i = 0; i < 60; ++i) {
    flood.push_back(std::make_unique<WebClient>(gateway.port(), kV1, "", 0, From("192.168.0.66")));
    if (flood.back()->open()) flood.back()->Subscribe(1, 1);
  }
  ASSERT_TRUE(gateway.HasViewers(30));
  std::vector<std::unique_ptr<WebClient>> pupils;
  for (int i = 0; i < 15; ++i) {
    pupils.push_back(std::make_unique<WebClient>(gateway.port(), kV1, "", 0, From("192.168.0.7")));
    EXPECT_TRUE(pupils.back()->open()) << i;
    pupils.back()->Subscribe(1, 1);
  }
  EXPECT_EQ(gateway.Health()["viewers"], 30);
  EXPECT_EQ(Handshake(gateway.port(), kV1, "", From("192.168.0.66")).status, 503);
  EXPECT_EQ(Handshake(gateway.port(), kV1, "", From("192.168.0.7")).status, 503);
  EXPECT_TRUE(WebClient(gateway.port(), kV1, "", 0, From("192.168.0.8")).open());
  for (const auto& pupil : pupils) EXPECT_TRUE(pupil->open());
  EXPECT_TRUE(gateway.Logs("refused (full)"));
}

TEST(Takes, AreLimitedHoweverQuicklyAViewerTakesAndLetsGo) {
  StandIn server;
  Gateway gateway({"--max-mice", "16"});
  ASSERT_TRUE(gateway.KnowsScenes(1));
  WebClient viewer(gateway.port());
  viewer.Subscribe(9, TopicFeed::kMouseState);
  for (int i = 0; i < 100; ++i) {
    viewer.SendMouse({{"op", "take"}, {"scene", "cube"}, {"tool", fmt::format("t{}", i % 2)}});
    viewer.SendMouse({{"op", "release"}});
  }
  // Those in between are refused for mice that are still leaving.
  std::string said_to_it;
  for (int i = 0; i < 100 && said_to_it.find("taken too often") == std::string::npos; ++i) {
    said_to_it = viewer.NextStatus();
  }
  EXPECT_THAT(said_to_it, HasSubstr("taken too often"));
  EXPECT_TRUE(gateway.Logs("refused (takes)"));
  EXPECT_TRUE(gateway.Until([](const Json& health) { return health["refusals"] > 50; }));
}

// --- tokens ---

/// A key and a self-signed certificate for 127.0.0.1.
class TestCertificate {
 public:
  TestCertificate() {
    Program openssl("/usr/bin/openssl", {"req", "-x509", "-newkey", "ec", "-pkeyopt",
                                         "ec_paramgen_curve:P-256", "-nodes", "-days", "1", "-subj",
                                         "/CN=127.0.0.1", "-keyout", key(), "-out", file()});
    EXPECT_EQ(openssl.Exit(), 0) << openssl.Output();
  }
  std::string file() const { return folder_ / "cert.pem"; }
  std::string key() const { return folder_ / "key.pem"; }

 private:
  const Folder folder_;
};

class Guarded : public testing::Test {
 protected:
  Guarded() {
    watch_ = Make("watch", "class");
    drive_ = Make("drive", "hand");
    operate_ = Make("operate", "teacher");
  }

  std::string Make(const std::string& role, const std::string& name) {
    Program program(PALPATE_BIN_DIR "/palpate-viewer",
                    {"--make-token", role, name, "--tokens", path_, "--log-level", "error"});
    EXPECT_EQ(program.Exit(), 0) << program.Output();
    std::string token = program.Output();
    while (token.ends_with('\n')) token.pop_back();
    return token;
  }
  WebClient Viewer(int port, const std::string& token, const std::string& origin = "") {
    return WebClient(port, std::string(kV1) + ", palpate.token." + token, origin);
  }

  /// Options with which the gateway speaks TLS and wants tokens.
  std::vector<std::string> Tls() const {
    return {"--tls-cert", certificate_.file(), "--tls-key", certificate_.key(), "--tokens", path_};
  }

  const TestCertificate certificate_;
  const Folder folder_;
  const std::string path_ = folder_ / "tokens";
  std::string watch_, drive_, operate_;
  StandIn server_;
};

TEST_F(Guarded, GivesScenesHealthAndSocketsToTokensAloneAndThePagesFilesToAll) {
  Gateway gateway({"--tokens", path_});
  const std::vector<Headers> unauthorised = {
      {},
      {{"Authorization", "Bearer " + operate_ + "0"}},
      {{"Authorization", "Bearer " + std::string(4000, 'a')}},
      {{"Authorization", "Bearer \x01\xff"}},
      {{"Cookie", "token=" + operate_}},
      {{"X-Token", operate_}}};
  int tries = 0;
  for (const Headers& headers : unauthorised) {
    for (const char* target :
         {"/healthz", "/scene/cube.bundle", "/scene/", "/%68ealthz", "/healthz?token=x",
          "/scene/%63ube.bundle", "/metrics", "/%6detrics"}) {
      const HttpAnswer answer = Get(gateway.port(), target, headers);
      // A malformed header makes it no request.
      EXPECT_THAT(answer.status, testing::AnyOf(401, 400)) << target;
      EXPECT_THAT(answer.body, Not(HasSubstr("viewers")));
      if (answer.status == 401) {
        EXPECT_EQ(answer.headers.at("www-authenticate"), "Bearer realm=\"palpate\"");
      }
      ++tries;
    }
    EXPECT_THAT(Handshake(gateway.port(), kV1, "", headers).status, testing::AnyOf(401, 400));
    ++tries;
  }
  for (const std::string& offered :
       {operate_, "palpate.token." + operate_ + ", palpate.token." + operate_}) {
    EXPECT_GE(Handshake(gateway.port(), std::string(kV1) + ", " + offered).status, 400) << offered;
    ++tries;
  }
  const Json health = gateway.Health(Bearing(watch_));
  EXPECT_EQ(health["refusals"], tries) << "each is counted";
  EXPECT_EQ(health["viewers"], 0);
  EXPECT_TRUE(gateway.Logs("refused (token)"));
  EXPECT_THAT(gateway.program().Output(), Not(HasSubstr(operate_.substr(8, 16))));
  for (const std::string& token : {watch_, drive_, operate_}) {
    EXPECT_EQ(Get(gateway.port(), "/healthz", Bearing(token)).status, 200);
    EXPECT_EQ(Get(gateway.port(), "/scene/none.bundle", Bearing(token)).status, 404);
    EXPECT_EQ(Handshake(gateway.port(), kV1, "", Bearing(token)).status, 101);
  }
  EXPECT_EQ(Get(gateway.port(), "/").status, 200);
}

TEST_F(Guarded, GivesAPageWhatItsTokensRoleAllowsAndNeverEchoesTheToken) {
  Gateway gateway({"--tokens", path_});
  const std::string own = "http://127.0.0.1:" + std::to_string(gateway.port());
  WebClient watcher = Viewer(gateway.port(), watch_, own);
  ASSERT_TRUE(watcher.open());
  EXPECT_EQ(watcher.subprotocol(), kV1);
  EXPECT_EQ(watcher.NextJson("serverInfo")["metadata"]["role"], "watch");
  watcher.SendMouse({{"op", "take"}, {"scene", "cube"}});
  EXPECT_THAT(watcher.NextStatus(), HasSubstr("role is watch"));
  EXPECT_EQ(watcher.closed(), 1008);

  WebClient driver = Viewer(gateway.port(), drive_, own);
  EXPECT_EQ(driver.NextJson("serverInfo")["metadata"]["role"], "drive");
  driver.SendOperate({{"op", "mute"}, {"station", "left"}});
  EXPECT_THAT(driver.NextStatus(), HasSubstr("role operate"));
  EXPECT_EQ(driver.closed(), 1008);
  EXPECT_EQ(server_.CountAsked(), 0);

  EXPECT_TRUE(gateway.Logs("refused (role) class at 127.0.0.1:"));
  EXPECT_EQ(gateway.Health(Bearing(watch_))["refusals"], 2);
  EXPECT_EQ(Handshake(gateway.port(), std::string(kV1) + ", palpate.token." + operate_,
                      "http://evil.example")
                .status,
            403)
      << "a token is no way around the Origin";
}

TEST_F(Guarded, PassesOnWhatATeacherDecidesWithHisName) {
  Gateway gateway({"--tokens", path_});
  WebClient teacher = Viewer(gateway.port(), operate_);
  EXPECT_EQ(teacher.NextJson("serverInfo")["metadata"]["role"], "operate");
  ASSERT_TRUE(gateway.KnowsScenes(1, Bearing(watch_)));
  const std::vector<std::pair<const char*, wire::OperateWish>> wishes = {
      {"admit", palpate_OPERATE_ADMIT},
      {"take_back", palpate_OPERATE_TAKE_BACK},
      {"mute", palpate_OPERATE_MUTE},
      {"unmute", palpate_OPERATE_UNMUTE}};
  std::set<std::uint64_t> numbers;
  for (const auto& [op, wish] : wishes) {
    teacher.SendOperate({{"op", op}, {"station", "left"}});
    const auto asked = server_.Asked();
    ASSERT_TRUE(asked) << op;
    EXPECT_EQ(asked->wish, wish);
    EXPECT_STREQ(asked->station, "left");
    EXPECT_EQ(asked->server_run, StandIn::kRun);
    EXPECT_THAT(asked->by, HasSubstr("teacher at 127.0.0.1:"));
    numbers.insert(asked->request);
  }
  EXPECT_EQ(numbers.size(), wishes.size());
  for (const Json& wrong : {Json{{"op", "mute"}, {"station", "left\nready: fake"}},
                            Json{{"op", "dance"}, {"station", "left"}},
                            Json{{"op", "mute"}, {"station", "left"}, {"by", "me"}}}) {
    teacher.SendOperate(wrong);
    EXPECT_THAT(teacher.NextStatus(), HasSubstr("/palpate/operate:1: "));
  }
  EXPECT_EQ(server_.CountAsked(), 0);
  EXPECT_TRUE(teacher.open());
}

TEST_F(Guarded, AreTheNamesOfTheirHoldersMiceAndOfNobodyElses) {
  const std::string anna = Make("drive", "anna");
  Make("drive", "anna_2");
  Gateway gateway({"--tokens", path_, "--max-mice", "4"});
  ASSERT_TRUE(gateway.KnowsScenes(1, Bearing(watch_)));
  std::vector<std::string> names;
  for (const char* tool : {"a", "b"}) {
    WebClient viewer = Viewer(gateway.port(), anna);
    viewer.Subscribe(9, TopicFeed::kMouseState);
    viewer.SendMouse({{"op", "take"}, {"scene", "cube"}, {"tool", tool}});
    const auto told = viewer.Next(9);
    ASSERT_TRUE(told);
    names.push_back(Json::parse(told->payload)["station"]);
  }
  EXPECT_THAT(names, testing::ElementsAre("anna", "anna_3"));
}

TEST_F(Guarded, SetAGoalThatAllAreToldWhereTheyMayOperate) {
  Gateway gateway({"--tokens", path_});
  ASSERT_TRUE(gateway.KnowsScenes(1, Bearing(watch_)));
  const Json goal = {{"scene", "cube"}, {"text", "Press gently"}, {"limit_N", 0.5}};
  const auto with_op = [](Json of) {
    of["op"] = "goal";
    return of;
  };
  WebClient student = Viewer(gateway.port(), watch_);
  student.Subscribe(9, TopicFeed::kGoal);
  WebClient teacher = Viewer(gateway.port(), operate_);
  teacher.SendOperate(with_op(goal));
  const auto told = student.Next(9);
  ASSERT_TRUE(told);
  EXPECT_EQ(Json::parse(told->payload), goal);
  WebClient late = Viewer(gateway.port(), drive_);
  late.Subscribe(9, TopicFeed::kGoal);
  const auto kept = late.Next(9);
  ASSERT_TRUE(kept);
  EXPECT_EQ(Json::parse(kept->payload), goal);
  teacher.SendOperate(with_op({{"scene", "nowhere"}, {"text", ""}, {"limit_N", 0}}));
  EXPECT_THAT(teacher.NextStatus(), HasSubstr("is not served here"));
  late.SendOperate(with_op(goal));
  EXPECT_EQ(late.closed(), 1008) << "it may drive, and set no goal";
}

TEST_F(Guarded, HoldAsTheFileHasThemWhenItIsReadAnew) {
  Gateway gateway({"--tokens", path_});
  WebClient watcher = Viewer(gateway.port(), watch_), driver = Viewer(gateway.port(), drive_),
            teacher = Viewer(gateway.port(), operate_);
  for (WebClient* viewer : {&watcher, &driver, &teacher}) {
    ASSERT_TRUE(viewer->open());
    EXPECT_FALSE(viewer->NextJson("serverInfo").is_null());
  }
  const std::string later = Make("watch", "later");
  EXPECT_EQ(Get(gateway.port(), "/healthz", Bearing(later)).status, 401) << "not yet read";

  // The class's token is taken back, the hand's gets another role, the teacher's stays.
  std::string text;
  {
    std::ifstream file(path_);
    for (std::string line; std::getline(file, line);) {
      if (line.starts_with("watch class ")) continue;
      if (line.starts_with("drive hand ")) line.replace(0, 5, "watch");
      text += line + "\n";
    }
  }
  std::ofstream(path_) << text;
  gateway.program().Signal(SIGHUP);
  ASSERT_TRUE(gateway.Logs("read again: 3 tokens are valid; connections closed: 2"));
  for (WebClient* viewer : {&watcher, &driver}) {
    EXPECT_THAT(viewer->NextStatus(), HasSubstr("was taken back"));
    EXPECT_EQ(viewer->closed(), 1008);
  }
  EXPECT_EQ(Get(gateway.port(), "/healthz", Bearing(watch_)).status, 401);
  EXPECT_EQ(Get(gateway.port(), "/healthz", Bearing(later)).status, 200);
  EXPECT_EQ(Handshake(gateway.port(), kV1, "", Bearing(watch_)).status, 401);
  WebClient again = Viewer(gateway.port(), drive_);
  EXPECT_EQ(again.NextJson("serverInfo")["metadata"]["role"], "watch");
  ASSERT_TRUE(gateway.KnowsScenes(1, Bearing(later)));
  teacher.SendOperate({{"op", "mute"}, {"station", "left"}});
  EXPECT_TRUE(server_.Asked()) << "whose token stays is not disturbed";
}

TEST_F(Guarded, HoldAsBeforeWhereTheFileIsBrokenWhenItIsReadAnew) {
  Gateway gateway({"--tokens", path_});
  WebClient watcher = Viewer(gateway.port(), watch_);
  ASSERT_TRUE(watcher.open());
  std::ofstream(path_, std::ios::app) << "dance x y\n";
  gateway.program().Signal(SIGHUP);
  EXPECT_TRUE(gateway.Logs("role 'dance' is not known; give watch, drive or operate"));
  EXPECT_TRUE(gateway.Logs("the tokens read before remain valid"));
  std::filesystem::remove(path_);
  gateway.program().Signal(SIGHUP);
  EXPECT_TRUE(gateway.Logs("No such file"));
  EXPECT_EQ(Get(gateway.port(), "/healthz", Bearing(watch_)).status, 200);
  EXPECT_EQ(gateway.Health(Bearing(watch_))["viewers"], 1);
  EXPECT_TRUE(watcher.open());
}

TEST_F(Guarded, DropsWhoseTokenIsTakenBackThoughItReadsNothing) {
  Gateway gateway({"--tokens", path_});
  // It never runs, so it answers no closing handshake.
  WebClient stalled = Viewer(gateway.port(), watch_);
  ASSERT_TRUE(stalled.open());
  std::ofstream(path_) << "";
  const std::string only = Make("watch", "only");
  gateway.program().Signal(SIGHUP);
  ASSERT_TRUE(gateway.Logs("1 tokens are valid; connections closed: 1"));
  EXPECT_TRUE(gateway.HasViewers(0, Bearing(only)));
}

TEST(Reload, WithoutTokensEndsNothing) {
  Gateway gateway;
  gateway.program().Signal(SIGHUP);
  EXPECT_TRUE(gateway.Logs("there are no --tokens and no --course to read again"));
  EXPECT_EQ(gateway.Health()["viewers"], 0);
}

// --- TLS ---

tcp::endpoint At(int port) {
  return {net::ip::make_address("127.0.0.1"), static_cast<unsigned short>(port)};
}

/// A plain port that leads to a TLS port, whose certificate it does not check.
class Tunnel {
 public:
  explicit Tunnel(int port, int most_tls = 0) : to_(At(port)) {
    if (most_tls != 0) {
      SSL_CTX_set_security_level(context_.native_handle(),
                                 0);  // the gateway is to refuse
      SSL_CTX_set_min_proto_version(context_.native_handle(), 0);
      SSL_CTX_set_max_proto_version(context_.native_handle(), most_tls);
    }
    Accept();
    thread_ = std::thread([this] { io_.run(); });
  }
  ~Tunnel() {
    io_.stop();
    thread_.join();
  }
  int port() const { return acceptor_.local_endpoint().port(); }

 private:
  struct Way {
    tcp::socket near;
    net::ssl::stream<tcp::socket> far;
    std::array<char, 65536> out, back;
  };
  void Accept() {
    acceptor_.async_accept([this](boost::system::error_code error, tcp::socket near) {
      const auto way = std::make_shared<Way>(Way{std::move(near), {io_, context_}, {}, {}});
      way->far.next_layer().connect(to_, error);
      way->far.handshake(net::ssl::stream_base::client, error);
      if (!error) {
        Pump(way, way->near, way->far, way->out);
        Pump(way, way->far, way->near, way->back);
      }
      Accept();
    });
  }
  template <class From, class To>
  static void Pump(const std::shared_ptr<Way>& way, From& from, To& to,
                   std::array<char, 65536>& bytes) {
    from.async_read_some(net::buffer(bytes), [=, &from, &to, &bytes](auto error, std::size_t n) {
      if (error) return way->near.close(error), way->far.next_layer().close(error), void();
      net::async_write(to, net::buffer(bytes, n), [=, &from, &to, &bytes](auto failed, auto) {
        if (!failed) Pump(way, from, to, bytes);
      });
    });
  }

  const tcp::endpoint to_;
  net::io_context io_;
  net::ssl::context context_{net::ssl::context::tls_client};
  tcp::acceptor acceptor_{io_, At(0)};
  std::thread thread_;
};

HttpAnswer GetSecure(int port, const std::string& target, const Headers& headers = {},
                     int most_tls = 0) {
  return Get(Tunnel(port, most_tls).port(), target, headers);
}

TEST_F(Guarded, SpeaksTlsWithSafeHeadersAndNoOlderThanOneTwo) {
  Gateway gateway(Tls());
  EXPECT_THAT(gateway.program().Output(), HasSubstr("ready: page https://127.0.0.1:"));
  const HttpAnswer answer = GetSecure(gateway.port(), "/healthz", Bearing(watch_));
  EXPECT_EQ(answer.status, 200);
  EXPECT_THAT(answer.body, HasSubstr("\"scenes\""));
  for (const auto& [name, value] : Headers{{"strict-transport-security", "max-age="},
                                           {"referrer-policy", "no-referrer"},
                                           {"x-frame-options", "DENY"},
                                           {"x-content-type-options", "nosniff"},
                                           {"cross-origin-opener-policy", "same-origin"},
                                           {"cross-origin-resource-policy", "same-origin"},
                                           {"permissions-policy", "camera=()"},
                                           {"content-security-policy", "frame-ancestors 'none'"}}) {
    ASSERT_TRUE(answer.headers.contains(name)) << name;
    EXPECT_THAT(answer.headers.at(name), HasSubstr(value));
  }
  EXPECT_EQ(GetSecure(gateway.port(), "/healthz").status, 401);
  EXPECT_EQ(GetSecure(gateway.port(), "/", {}, TLS1_2_VERSION).status, 200);
  EXPECT_EQ(GetSecure(gateway.port(), "/", {}, TLS1_1_VERSION).status, 0);
}

TEST_F(Guarded, TellsWhoSpeaksInTheClearWhereTlsIsSpoken) {
  Gateway gateway(Tls());
  const std::string at = "127.0.0.1:" + std::to_string(gateway.port());
  const HttpAnswer answer = Get(gateway.port(), "/?scene=cube");
  EXPECT_EQ(answer.status, 307);
  EXPECT_EQ(answer.headers.at("location"), "https://" + at + "/?scene=cube");
  EXPECT_FALSE(answer.headers.contains("strict-transport-security"));
  EXPECT_EQ(Get(gateway.port(), "/", {{"Host", "evil.example"}}).status, 421);
  EXPECT_EQ(Get(gateway.port(), "/healthz", Bearing(operate_)).status, 400);
  const HttpAnswer socket = Handshake(gateway.port(), kV1, "", Bearing(operate_));
  EXPECT_EQ(socket.status, 400);
  EXPECT_THAT(socket.body, HasSubstr("wss://"));
  EXPECT_TRUE(gateway.Logs("refused (tls)"));
}

TEST_F(Guarded, OutlivesAnyBytesAtItsTlsPortAndThoseWhoNeverShakeHands) {
  Gateway gateway(Tls());
  net::io_context io;
  std::vector<tcp::socket> silent;
  Random random(5);
  for (int i = 0; i < 250; ++i) {
    tcp::socket& socket = silent.emplace_back(io);
    boost::system::error_code error;
    socket.connect(At(gateway.port()), error);
    // Begins like a handshake, and goes on with random bytes.
    std::string bytes = i % 2 == 0 ? std::string("\x16\x03\x01\x01\x00\x01", 6) : "";
    for (std::size_t k = random.Below(i % 3 == 0 ? 1 : 300); k > 0; --k) {
      bytes += static_cast<char>(random.Below(256));
    }
    net::write(socket, net::buffer(bytes), error);
  }
  EXPECT_EQ(GetSecure(gateway.port(), "/").status, 200);
  EXPECT_EQ(GetSecure(gateway.port(), "/healthz", Bearing(watch_)).status, 200);
  EXPECT_TRUE(gateway.program().Runs());
}

TEST_F(Guarded, GivesAWebSocketOverTlsWhatItGivesInTheClear) {
  Gateway gateway(Tls());
  const Tunnel tunnel(gateway.port());
  const std::string own = "https://127.0.0.1:" + std::to_string(tunnel.port());
  WebClient viewer = Viewer(tunnel.port(), operate_, own);
  EXPECT_EQ(viewer.NextJson("serverInfo")["metadata"]["role"], "operate");
  viewer.Subscribe(7, TopicFeed::kSceneBundle);
  EXPECT_TRUE(viewer.Next(7));
  // An orderly farewell.
  gateway.program().Signal(SIGTERM);
  EXPECT_EQ(viewer.closed(), 1001);
  EXPECT_EQ(gateway.program().Exit(), 0);
}

TEST(Tls, NamesTheFileThatItCannotUse) {
  const TestCertificate certificate;
  const auto complaint = [&](const std::string& cert, const std::string& key) {
    Program program(
        PALPATE_BIN_DIR "/palpate-viewer",
        {"--http", "0", "--domain", std::to_string(kDomain), "--tls-cert", cert, "--tls-key", key});
    EXPECT_EQ(program.Exit(), 1);
    return program.Output();
  };
  EXPECT_THAT(complaint("/proc/none", certificate.key()), HasSubstr("--tls-cert /proc/none"));
  EXPECT_THAT(complaint(certificate.file(), "/proc/none"), HasSubstr("--tls-key /proc/none"));
  EXPECT_THAT(complaint(certificate.key(), certificate.key()), HasSubstr("--tls-cert"));
  chmod(certificate.key().c_str(), 0644);
  EXPECT_THAT(complaint(certificate.file(), certificate.key()), HasSubstr("chmod 0600"));
}

TEST(Tls, OffersOfTls12OnlyWhatEncryptsAndAuthenticatesInOne) {
  const TestCertificate certificate;
  const Gateway gateway({"--tls-cert", certificate.file(), "--tls-key", certificate.key()});
  const auto agrees = [&](const char* suite) {
    net::io_context io;
    net::ssl::context context(net::ssl::context::tls_client);
    SSL_CTX_set_max_proto_version(context.native_handle(), TLS1_2_VERSION);
    EXPECT_EQ(SSL_CTX_set_cipher_list(context.native_handle(), suite), 1) << suite;
    net::ssl::stream<tcp::socket> stream(io, context);
    stream.next_layer().connect(At(gateway.port()));
    boost::system::error_code error;
    stream.handshake(net::ssl::stream_base::client, error);
    return !error;
  };
  for (const char* suite : {"ECDHE-ECDSA-AES128-GCM-SHA256", "ECDHE-ECDSA-CHACHA20-POLY1305"}) {
    EXPECT_TRUE(agrees(suite)) << suite;
  }
  for (const char* suite :
       {"ECDHE-ECDSA-AES128-SHA256", "ECDHE-ECDSA-AES256-SHA384", "ECDHE-ECDSA-AES128-SHA"}) {
    EXPECT_FALSE(agrees(suite)) << suite;
  }
}

// --- palpate-identities certificate ---

/// The error of a browser that trusts this authority and opens the gateway under `name`; empty:
/// none.
std::string Distrust(int port, const std::string& authority, const std::string& name) {
  net::io_context io;
  net::ssl::context context(net::ssl::context::tls_client);
  context.load_verify_file(authority);
  context.set_verify_mode(net::ssl::verify_peer);
  net::ssl::stream<tcp::socket> stream(io, context);
  stream.set_verify_callback(net::ssl::host_name_verification(name));
  stream.next_layer().connect(At(port));
  boost::system::error_code error;
  stream.handshake(net::ssl::stream_base::client, error);
  return error ? error.message() : "";
}

/// Runs the script that makes a certificate in the folder; returns its output.
std::string Certify(const std::string& folder, std::vector<std::string> names, int exit = 0) {
  names.insert(names.begin(), {"certificate", folder});
  Program script(PALPATE_SOURCE_DIR "/deploy/security/identities", std::move(names));
  EXPECT_EQ(script.Exit(60.0), exit) << script.Output();
  return script.Output();
}

TEST(PageCertificate, OfOneCommandIsTrustedUnderItsNamesByWhoKnowsItsAuthority) {
  const Folder kept;
  const std::string& folder = kept.path();
  const std::string page = folder + "/page";
  EXPECT_THAT(Certify(folder, {"page.lab.example", "127.0.0.1"}),
              AllOf(HasSubstr("--host-name page.lab.example"), HasSubstr(page + "/key.pem")));
  for (const std::string& key : {page + "/key.pem", folder + "/authority/page_ca_key.pem"}) {
    struct stat status {};
    EXPECT_EQ(stat(key.c_str(), &status), 0) << key;
    EXPECT_EQ(status.st_mode & 0777, 0600u) << key;
  }
  const std::string authority = folder + "/first_ca.pem";
  std::filesystem::copy_file(page + "/ca.pem", authority);
  for (const bool anew : {false, true}) {
    if (anew) Certify(folder, {"page.lab.example", "127.0.0.1"});
    Gateway gateway({"--tls-cert", page + "/cert.pem", "--tls-key", page + "/key.pem"});
    EXPECT_EQ(Distrust(gateway.port(), authority, "page.lab.example"), "");
    EXPECT_EQ(Distrust(gateway.port(), authority, "127.0.0.1"), "");
    EXPECT_NE(Distrust(gateway.port(), authority, "other.example"), "");
  }
}

TEST(PageCertificate, IsRefusedForNamesThatItsAuthorityDoesNotVouchForOrNobodyCanType) {
  const Folder kept;
  const std::string& folder = kept.path();
  Certify(folder, {"page.lab.example"});
  // Names of a kind that the authority has none of are refused, too.
  EXPECT_THAT(Certify(folder, {"other.example"}, 1), HasSubstr("cannot certify other.example"));
  EXPECT_THAT(Certify(folder, {"10.0.0.5"}, 1), HasSubstr("cannot certify 10.0.0.5"));
  EXPECT_THAT(Certify(folder, {"Page.example"}, 2), HasSubstr("in lower case"));
  EXPECT_THAT(Certify(folder, {"10.0.0.256"}, 2), HasSubstr("10.0.0.256"));
  EXPECT_THAT(Certify(folder, {}, 2), HasSubstr("NAME"));
  EXPECT_TRUE(std::filesystem::exists(folder + "/page/cert.pem"));
  // A secured domain may put its authority there afterwards.
  Program script(PALPATE_SOURCE_DIR "/deploy/security/identities", {"new", folder});
  EXPECT_EQ(script.Exit(60.0), 0) << script.Output();
}

// --- what one is told at the start ---

TEST_F(Guarded, SaysWhatABoundGatewayMeansWithoutTokensAndWithoutTls) {
  Gateway open({"--bind", "0.0.0.0"});
  EXPECT_TRUE(open.Logs("every host that can reach 0.0.0.0 can watch"));
  EXPECT_THAT(open.program().Output(),
              AllOf(HasSubstr("--tokens"), HasSubstr("--tls-cert"), HasSubstr("is not encrypted")));
  Gateway local;
  EXPECT_THAT(local.program().Output(), Not(HasSubstr("warning")));
  Gateway guarded({"--bind", "0.0.0.0", "--tokens", path_});
  EXPECT_TRUE(guarded.Logs("use the tokens"));
  EXPECT_THAT(guarded.program().Output(), Not(HasSubstr("can look")));
}

}  // namespace
}  // namespace palpate::test
