// Malicious clients at the real palpate-viewer over real sockets: whatever they send, what the
// gateway stores and does for them is bounded, and others are served.
#include <chrono>
#include <thread>
#include <utility>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/write.hpp>
#include <gmock/gmock.h>

#include "client/viewer/topic_feed.h"
#include "client/viewer/viewer_limits.h"
#include "tests/viewer/gateway.h"

namespace palpate::test {
namespace {

namespace net = boost::asio;
using net::ip::tcp;
using Clock = std::chrono::steady_clock;
using Json = nlohmann::json;
using testing::HasSubstr;
using testing::StartsWith;

double SecondsSince(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// How many a limit lets pass in that time.
double Passed(const ViewerLimits::Rate& rate, double seconds) {
  return rate.at_once + seconds * 1e9 / static_cast<double>(rate.period_ns) + 1.0;
}

/// Those of the client's next `most` statuses that contain `part`; stops at "the last one" and once
/// the client hears nothing.
std::vector<std::string> Statuses(WebClient& client, const std::string& part, int most) {
  std::vector<std::string> found;
  for (int i = 0; i < most; ++i) {
    const Json status = client.NextJson("status");
    if (status.is_null()) break;
    const std::string text = status.value("message", "");
    if (text.find(part) != std::string::npos) found.push_back(text);
    if (text.find("the last one") != std::string::npos) break;
  }
  return found;
}

TEST(Wishes, AboutStationsAreAFewASecondOfAViewerAndOfItsAddressAndRefusedOnceInWords) {
  StandIn server;
  Gateway gateway;
  ASSERT_TRUE(gateway.KnowsScenes(1));
  WebClient teacher(gateway.port());
  ASSERT_TRUE(teacher.open());
  const auto begin = Clock::now();
  constexpr int kWished = 400;
  for (int i = 0; i < kWished; ++i) teacher.SendOperate({{"op", "mute"}, {"station", "left"}});
  teacher.SendText(R"({"op": "the last one"})");
  EXPECT_THAT(Statuses(teacher, "decided about too often", 100), testing::SizeIs(1));
  const double allowed = Passed(ViewerLimits::kOperate.of_viewer, SecondsSince(begin));
  const int asked = server.CountAsked();
  EXPECT_GE(asked, 1);
  EXPECT_LE(asked, allowed);
  EXPECT_TRUE(gateway.Logs("refused (wishes) the page at 127.0.0.1:"));
  EXPECT_GE(gateway.Health()["refusals"], kWished - allowed) << "each is counted";
  EXPECT_TRUE(teacher.open());
  // Now as another viewer each time.
  for (int i = 0; i < 10; ++i) {
    WebClient again(gateway.port());
    for (int k = 0; k < ViewerLimits::kOperate.of_viewer.at_once; ++k) {
      again.SendOperate({{"op", "mute"}, {"station", "left"}});
    }
    again.SendText(R"({"op": "the last one"})");
    Statuses(again, "", 100);
  }
  EXPECT_LE(asked + server.CountAsked(),
            Passed(ViewerLimits::kOperate.of_address, SecondsSince(begin)));
}

TEST(Wishes, OfAReplayAreAnsweredEachThoughNobodyIsAsked) {
  Gateway gateway;
  WebClient viewer(gateway.port());
  viewer.Subscribe(5, TopicFeed::kReplayAnswer);
  int tag = 0;
  for (; tag < 200; ++tag) {
    viewer.SendReplay({{"replay", "1"}, {"tag", tag}, {"wish", "seek"}, {"value", 0.5}});
  }
  std::string refusal;
  for (int i = 0; i < 200; ++i) {
    const auto message = viewer.Next(5);
    if (!message) break;
    const Json answer = Json::parse(message->payload);
    refusal = answer["refusal"];
    if (answer["tag"] == tag - 1) break;
  }
  EXPECT_THAT(refusal, HasSubstr("steered too often"));
}

TEST(Wishes, ToSubscribeAreBoundedAndStateIsSentNoMoreOften) {
  StandIn server;
  Gateway gateway;
  ASSERT_TRUE(gateway.KnowsScenes(1));
  WebClient viewer(gateway.port());
  for (int i = 0; i < 150; ++i) {
    viewer.Subscribe(1, TopicFeed::kSceneBundle);
    viewer.SendText(R"({"op": "unsubscribe", "subscriptionIds": [1]})");
  }
  viewer.SendText(R"({"op": "the last one"})");
  EXPECT_THAT(Statuses(viewer, "subscribed to too often", 100), testing::SizeIs(1));
  EXPECT_TRUE(gateway.Logs("refused (wishes)"));
  EXPECT_TRUE(viewer.open());
}

TEST(Complaints, AreToldAFewASecondWithHowManyWereLeftOut) {
  Gateway gateway;
  WebClient viewer(gateway.port());
  // One message brings more complaints than may wait for a viewer that does not read.
  Json list = Json::array();
  for (std::size_t i = 0; i < ViewerLimits::kMostItems; ++i) {
    list.push_back({{"id", i}, {"channelId", 1000 + i}});
  }
  viewer.SendText(Json{{"op", "subscribe"}, {"subscriptions", list}}.dump());
  const int told = ViewerLimits::kComplaints.at_once;
  for (int i = 0; i < told; ++i) EXPECT_THAT(viewer.NextStatus(), HasSubstr("no such channel"));
  std::this_thread::sleep_for(std::chrono::nanoseconds(ViewerLimits::kComplaints.period_ns));
  viewer.SendText(R"({"op": "dance"})");
  EXPECT_THAT(viewer.NextStatus(), HasSubstr("more were left out"));
  EXPECT_TRUE(viewer.open());
}

/// A WebSocket that sends exact bytes and reads nothing.
class RawViewer {
 public:
  explicit RawViewer(int port) {
    socket_.connect({net::ip::make_address("127.0.0.1"), static_cast<unsigned short>(port)});
    net::write(socket_, net::buffer("GET / HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port) +
                                    "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                                    "Sec-WebSocket-Version: 13\r\n"
                                    "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n"
                                    "Sec-WebSocket-Protocol: foxglove.websocket.v1\r\n\r\n"));
    std::string answer;
    net::read_until(socket_, net::dynamic_buffer(answer), "\r\n\r\n");
    EXPECT_THAT(answer, StartsWith("HTTP/1.1 101"));
    socket_.non_blocking(true);
  }
  /// Sends the frame again and again; returns the number of bytes taken.
  std::size_t Flood(const std::string& frame, double seconds, std::size_t most) {
    std::string block;
    while (block.size() < 64 * 1024) block += frame;
    std::size_t taken = 0, at = 0;
    for (const auto begin = Clock::now(); SecondsSince(begin) < seconds && taken < most;) {
      boost::system::error_code error;
      const std::size_t n = socket_.write_some(net::buffer(block) + at, error);
      taken += n;
      at = (at + n) % block.size();
      if (error == net::error::would_block) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      } else if (error) {
        break;  // the gateway has closed it
      }
    }
    return taken;
  }
  void Send(const std::string& bytes) {
    boost::system::error_code error;
    net::write(socket_, net::buffer(bytes), error);
  }

 private:
  net::io_context io_;
  tcp::socket socket_{io_};
};

/// Masked with zeros, so that the bytes are as given.
std::string Frame(int first, const std::string& payload) {
  return std::string{
             static_cast<char>(first), static_cast<char>(0x80 | payload.size()), 0, 0, 0, 0} +
         payload;
}

double ResidentMegabytes(Gateway& gateway) {
  const std::string page = Get(gateway.port(), "/metrics").body;
  const std::string name = "\npalpate_gateway_resident_memory_bytes ";
  return 1e-6 * std::stod(page.substr(page.find(name) + name.size()));
}

TEST(Flood, IsLeftInTheNetworkWhateverItConsistsOf) {
  StandIn server;
  Gateway gateway;
  ASSERT_TRUE(gateway.KnowsScenes(1));
  [[maybe_unused]] const double before = ResidentMegabytes(gateway);
  // More than the kernel buffers and the gateway may read in these seconds, far less than it could
  // read.
  constexpr std::size_t kMost = std::size_t{48} << 20;
  constexpr double kSeconds = 3.0;
  const std::string pose = R"({"op":"unsubscribe","subscriptionIds":[1]})";
  const std::vector<std::pair<const char*, std::string>> floods = {
      {"fragments that are empty", Frame(0x00, "")},
      {"pings", Frame(0x89, std::string(100, 'p'))},
      {"messages", Frame(0x81, pose)},
      {"what nobody knows", Frame(0x81, R"({"op":"dance"})")},
      {"subscriptions", Frame(0x81, R"({"op":"subscribe","subscriptions":[{"id":1,"channelId":)" +
                                        std::to_string(TopicFeed::kSceneBundle) + "}]}") +
                            Frame(0x81, pose)}};
  for (const auto& [what, frame] : floods) {
    RawViewer viewer(gateway.port());
    if (frame[0] == 0x00) viewer.Send(Frame(0x01, "{"));
    EXPECT_LT(viewer.Flood(frame, kSeconds, kMost), kMost) << what;
    // Only this flood is there, with all that it has sent: those before it are gone.
    EXPECT_TRUE(gateway.HasViewers(1)) << what;
    WebClient other(gateway.port());
    other.Subscribe(3, TopicFeed::kSceneBundle);
    EXPECT_TRUE(other.Next(3)) << "the scene did not come, beside " << what;
  }
  EXPECT_TRUE(gateway.Logs("refused (flood)"));
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // they keep freed memory
  EXPECT_LT(ResidentMegabytes(gateway) - before, 64.0);
#endif
}

}  // namespace
}  // namespace palpate::test
