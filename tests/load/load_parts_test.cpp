#include <filesystem>
#include <fstream>
#include <future>
#include <string>

#include <gmock/gmock.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "client/load/options.h"
#include "client/load/process_use.h"
#include "client/load/scene_copies.h"
#include "client/load/web_viewers.h"
#include "common/dds/server_lock.h"
#include "common/error.h"
#include "common/json/pose_script.h"
#include "scenes/catalogue.h"
#include "tests/support/command_line.h"
#include "tests/support/complaint.h"
#include "tests/support/folder.h"
#include "tests/support/test_domain.h"

namespace palpate {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::optional<LoadRunOptions> Parse(const std::vector<const char*>& words) {
  return test::ParseWith(ParseLoadOptions, words);
}

std::string Complaint(const std::vector<const char*>& words) {
  return test::ComplaintOf(ParseLoadOptions, words);
}

TEST(LoadOptions, AreOneStationAndNoViewerUnlessTold) {
  const auto options = Parse({});
  ASSERT_TRUE(options);
  EXPECT_THAT(options->stations, ElementsAre(1));
  EXPECT_THAT(options->viewers, ElementsAre(0));
  EXPECT_THAT(Parse({"--stations", "1,4,16"})->stations, ElementsAre(1, 4, 16));
  EXPECT_EQ(options->viewer_url.text(), "ws://127.0.0.1:8765");
  EXPECT_EQ(options->scene, "");
  EXPECT_EQ(options->copies, 0u);
}

TEST(LoadOptions, TakeTheGatewaysAddressWithAndWithoutASlash) {
  for (const std::string url : {"ws://10.0.0.7:9000", "ws://10.0.0.7:9000/"}) {
    EXPECT_EQ(ParseViewerUrl(url).host, "10.0.0.7");
    EXPECT_EQ(ParseViewerUrl(url).port, 9000);
  }
  for (const std::string url :
       {"", "http://127.0.0.1:8765", "ws://127.0.0.1", "ws://:8765",
        "ws://127.0.0.1:", "ws://127.0.0.1:0", "ws://127.0.0.1:70000", "ws://127.0.0.1:87a5"}) {
    EXPECT_THROW(ParseViewerUrl(url), UsageError) << url;
  }
}

TEST(LoadOptions, TakeANumberOfToolsAndAFileForAScene) {
  const auto options = Parse({"--make-scene", "32", "many.json"});
  ASSERT_TRUE(options);
  EXPECT_EQ(options->copies, 32u);
  EXPECT_EQ(options->copies_file, "many.json");
  EXPECT_THAT(Complaint({"--make-scene", "many", "many.json"}), HasSubstr("1 to 256"));
  EXPECT_THAT(Complaint({"--make-scene", "0", "many.json"}), HasSubstr("1 to 256"));
  EXPECT_THAT(Complaint({"--make-scene", "32", "many"}), HasSubstr(".json"));
}

class SceneCopies : public testing::Test {
 protected:
  static Scene Load(const std::string& scene) {
    LoadOptions no_cache;
    no_cache.use_cache = false;
    return LoadScene(scene, no_cache);
  }
  std::string In(const std::string& file) const { return folder_ / file; }

  const test::Folder folder_;
};

TEST_F(SceneCopies, HaveTheSameToolAndObjectsAndEachANameOfItsOwn) {
  WriteSceneWithCopies("cube", 5, In("many.json"));
  const Scene many = Load(In("many.json"));
  const Scene one = Load("cube");
  EXPECT_EQ(many.name, "many");
  ASSERT_EQ(many.tools.size(), 5u);
  for (std::size_t i = 0; i < many.tools.size(); ++i) {
    EXPECT_EQ(many.tools[i].name, "ball_" + std::to_string(i + 1));
    EXPECT_EQ(many.tools[i].X_WB.p, one.tools[0].X_WB.p);
    EXPECT_EQ(many.tools[i].mesh.vertices, one.tools[0].mesh.vertices);
  }
  EXPECT_EQ(many.objects.size(), one.objects.size());
}

TEST_F(SceneCopies, BringTheHandsScriptAlong) {
  WriteSceneWithCopies("cube", 2, In("many.json"));
  const PoseScript script = PoseScript::Load(ScriptFileBeside(In("many.json")));
  const PoseScript original = PoseScript::Load(ScriptFileBeside("cube"));
  EXPECT_EQ(script.duration(), original.duration());
  EXPECT_EQ(script.At(2.0).p, original.At(2.0).p);
}

TEST_F(SceneCopies, FindTheMeshesThatStandBesideTheScene) {
  std::filesystem::create_directory(In("own"));
  std::ofstream(In("own/part.obj")) << "v 0 0 0\nv 10 0 0\nv 0 10 0\nv 0 0 10\n"
                                       "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
  std::ofstream(In("own/mine.json")) << R"({// a comment
             "tools": [{"name": "t", "mesh": {"shape": "sphere", "radius_m": 0.005}, "leaves": 1,
                        "start": {"position_mm": [0, 80, 0]}}],
             "objects": [{"name": "part", "mesh": {"file": "part.obj", "unit": "mm"},
                          "leaves": 8}]})";
  WriteSceneWithCopies(In("own/mine.json"), 2, In("many.json"));
  EXPECT_EQ(Load(In("many.json")).objects[0].mesh.triangles.size(), 4u);
}

TEST_F(SceneCopies, AreRefusedWithTheFileThatCannotBeReadOrWritten) {
  EXPECT_THROW(WriteSceneWithCopies("cub", 2, In("many.json")), Error);
  EXPECT_THAT(test::ComplaintOf([&] { WriteSceneWithCopies("cube", 2, In("none/many.json")); }),
              testing::HasSubstr("none/many.json"));
}

TEST(ProcessUse, ReadsTimesWhateverTheNameIs) {
  EXPECT_EQ(TicksOf("7 (a ) (b) S 1 7 7 0 -1 4194560 1 2 3 4 250 50 9 9 20 0 3 0 100 1 1"), 300u);
  EXPECT_FALSE(TicksOf(""));
  EXPECT_FALSE(TicksOf("7 (a) S 1"));
}

TEST(ProcessUse, IsTheTimeUsedByTheTimePassed) {
  const ProcessTimes begin{1'000'000'000, 10.0}, end{3'000'000'000, 13.0};
  EXPECT_DOUBLE_EQ(UseBetween(begin, end), 1.5);
  EXPECT_EQ(UseBetween(begin, begin), 0.0);
}

TEST(ProcessUse, SharesTheMachinesTimeIntoBusyAndIdle) {
  const MachineTimes begin = ParseMachineTimes("cpu  100 0 50 800 50 0 0 0 40 0\ncpu0 1 2 3\n");
  EXPECT_EQ(begin.busy, 150u);
  EXPECT_EQ(begin.all, 1000u);
  const MachineTimes end = ParseMachineTimes("cpu  150 10 60 860 60 5 5 0 40 0\n");
  EXPECT_DOUBLE_EQ(BusyBetween(begin, end), 80.0 / 150.0);
  EXPECT_EQ(BusyBetween(begin, begin), 0.0);
  EXPECT_GT(MachineTimesNow().all, 0u);
}

TEST(ProcessUse, FindsNoServerInWhatHoldsItsPlaceAndIsNone) {
  const int domain = test::OwnDomain();
  EXPECT_FALSE(ServerProcess(domain));
  const ServerLock lock(domain);
  EXPECT_EQ(ServerProcess(domain), getpid());
  EXPECT_FALSE(ServerOf(domain)) << "by its name";
}

/// A port of this host that nobody uses.
struct Port {
  Port() {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    socklen_t size = sizeof address;
    getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size);
    number = ntohs(address.sin_port);
  }
  ~Port() { close(socket); }
  const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
  int number = 0;
};

TEST(ProcessUse, FindsWhoListensAtAPort) {
  const Port port;
  EXPECT_FALSE(ListenerAt(port.number));
  ASSERT_EQ(listen(port.socket, 1), 0);
  EXPECT_EQ(ListenerAt(port.number), getpid());
}

using testing::AllOf;

/// Listens at a port of this host without being a gateway: takes one connection and answers
/// `answer`.
class Stranger {
 public:
  explicit Stranger(const std::string& answer) {
    listen(port_.socket, 1);
    served_ = std::async(std::launch::async, [this, answer] {
      const int client = accept(port_.socket, nullptr, nullptr);
      char request[4096];
      if (recv(client, request, sizeof request, 0) > 0) {
        send(client, answer.data(), answer.size(), MSG_NOSIGNAL);
      }
      close(client);
    });
  }
  ~Stranger() { served_.wait(); }
  int port() const { return port_.number; }

 private:
  const Port port_;
  std::future<void> served_;
};

std::string ComplaintAbout(const std::string& answer) {
  const Stranger stranger(answer);
  FrameTally tally({1, 0, "load", 30.0, {}, {}});
  StopSignal stop;
  return test::ComplaintOf([&] {
    const WebViewers viewers({"127.0.0.1", stranger.port()}, 1, 20.0, tally, stop);
  });
}

TEST(WebViewers, TellAnotherServerAndAFullGatewayFromNone) {
  EXPECT_THAT(ComplaintAbout("HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n\r\n"),
              AllOf(HasSubstr("the program at ws://127.0.0.1:"),
                    HasSubstr("is not a palpate-viewer"), HasSubstr("HTTP status 404")));
  EXPECT_THAT(ComplaintAbout("SSH-2.0-OpenSSH\r\n"), HasSubstr("is not a palpate-viewer"));
  EXPECT_THAT(ComplaintAbout("HTTP/1.1 503 Service Unavailable\r\nContent-Length: 0\r\n\r\n"),
              AllOf(HasSubstr("refuses viewers (HTTP status 503)"), HasSubstr("--max-viewers")));
}

}  // namespace
}  // namespace palpate
