#include "common/metrics/metrics_port.h"

#include <chrono>
#include <list>
#include <thread>

#include <boost/asio.hpp>
#include <gmock/gmock.h>

#include "common/error.h"
#include "tests/support/web_client.h"

namespace palpate::test {
namespace {

namespace net = boost::asio;
using net::ip::tcp;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

int PortOf(const MetricsPort& port) {
  const std::string& url = port.url();
  return std::stoi(url.substr(url.rfind(':') + 1));
}

/// A client that sends what a test likes, at the test's pace.
class RawClient {
 public:
  explicit RawClient(int port, const char* address = "127.0.0.1") {
    socket_.connect({net::ip::make_address(address), static_cast<unsigned short>(port)});
  }
  void Send(const std::string& text) {
    boost::system::error_code gone;
    net::write(socket_, net::buffer(text), gone);
  }
  /// All that comes until the other side closes the connection.
  std::string Answer() {
    std::string text;
    boost::system::error_code end;
    net::read(socket_, net::dynamic_buffer(text), end);
    return text;
  }
  /// Whether the other side has closed the connection.
  bool Closed() {
    boost::system::error_code error;
    char byte;
    socket_.non_blocking(true);
    socket_.read_some(net::buffer(&byte, 1), error);
    return error && error != net::error::would_block;
  }

 private:
  net::io_context io_;
  tcp::socket socket_{io_};
};

TEST(MetricsPort, GivesThePageAsItIsWhenItIsAskedFor) {
  std::uint64_t asked = 0;
  const MetricsPort port({},
                         [&](MetricsPage& page) { page.Add(metric::kServerRefusals, ++asked); });
  const HttpAnswer first = Get(PortOf(port), "/metrics");
  EXPECT_EQ(first.status, 200);
  EXPECT_EQ(first.headers.at("content-type"), kMetricsContentType);
  EXPECT_THAT(first.body, HasSubstr("palpate_server_refusals_total 1\n"));
  EXPECT_THAT(Get(PortOf(port), "/metrics?x=y").body,
              HasSubstr("palpate_server_refusals_total 2\n"));
  EXPECT_EQ(Get(PortOf(port), "/metrics", {}, "HEAD").status, 200);
  EXPECT_EQ(asked, 3u);
  EXPECT_EQ(Get(PortOf(port), "/elsewhere").status, 404);
  EXPECT_EQ(Get(PortOf(port), "/metrics/..").status, 404);
  EXPECT_EQ(Get(PortOf(port), "/metrics", {}, "POST").status, 405);
  EXPECT_EQ(asked, 3u) << "for nothing else the page is made";
}

TEST(MetricsPort, SaysSoWhereThePageCannotBeMade) {
  const MetricsPort port({}, [](MetricsPage&) { throw Error("no counters"); });
  EXPECT_EQ(Get(PortOf(port), "/metrics").status, 500);
  EXPECT_THAT(Get(PortOf(port), "/metrics").body, HasSubstr("no counters"));
}

TEST(MetricsPort, GivesNothingToAPageWhoseNameLeadsHere) {
  const MetricsPort port({.host_names = {"lab.example"}},
                         [](MetricsPage& page) { page.Add(metric::kServerRefusals, 1.0); });
  for (const char* host : {"evil.example", "evil.example:9464", "lab", "localhost.evil.example",
                           "127.0.0.1.evil.example", "2130706433", ""}) {
    const HttpAnswer answer = Get(PortOf(port), "/metrics", {{"Host", host}});
    EXPECT_EQ(answer.status, 421) << host;
    EXPECT_THAT(answer.body,
                AllOf(HasSubstr("palpate-server --host-name"), Not(HasSubstr("refusals"))));
  }
  for (const char* host : {"127.0.0.1", "localhost:9464", "[::1]", "10.1.2.3:80", "LAB.example"}) {
    EXPECT_EQ(Get(PortOf(port), "/metrics", {{"Host", host}}).status, 200) << host;
  }
  EXPECT_EQ(Get(PortOf(port), "/metrics", {{"Host", "127.0.0.1\r\nHost: evil.example"}}).status,
            400);
  RawClient nameless(PortOf(port));
  nameless.Send("GET /metrics HTTP/1.0\r\n\r\n");
  EXPECT_THAT(nameless.Answer(), StartsWith("HTTP/1.1 400"));
}

TEST(MetricsPort, AnswersAtAnAddressOfIPv6) {
  std::optional<MetricsPort> port;
  try {
    port.emplace(MetricsPort::Options{.endpoint = ParseMetricsEndpoint("[::1]:0")},
                 [](MetricsPage& page) { page.Add(metric::kServerRefusals, 7.0); });
  } catch (const Error& error) {
    GTEST_SKIP() << error.what() << " (this host has no IPv6)";
  }
  EXPECT_THAT(port->url(), AllOf(StartsWith("http://[::1]:"), testing::EndsWith("/metrics")));
  RawClient client(PortOf(*port), "::1");
  client.Send("GET /metrics HTTP/1.1\r\nHost: [::1]:" + std::to_string(PortOf(*port)) + "\r\n\r\n");
  EXPECT_THAT(client.Answer(),
              AllOf(StartsWith("HTTP/1.1 200"), HasSubstr("palpate_server_refusals_total 7\n")));
}

TEST(MetricsPort, GivesUpWhoIsSlowHoweverItsBytesCome) {
  const MetricsPort port({}, [](MetricsPage&) {});
  RawClient silent(PortOf(port)), drips(PortOf(port));
  // All of it takes more than 20 s; a connection has only the time of one request.
  const std::string request = "GET /metrics HTTP/1.1\r\nX: " + std::string(200, 'a');
  std::size_t sent = 0;
  for (; sent < request.size() && !drips.Closed(); ++sent) {
    drips.Send(request.substr(sent, 1));
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  EXPECT_LT(sent, request.size()) << "each byte won it time";
  EXPECT_EQ(silent.Answer(), "");
  EXPECT_EQ(Get(PortOf(port), "/metrics").status, 200);
}

TEST(MetricsPort, IsThereWhileOthersHoldAllItsConnections) {
  const MetricsPort port({}, [](MetricsPage&) {});
  std::list<RawClient> idle;
  for (int i = 0; i < 200; ++i) {
    idle.emplace_back(PortOf(port));
    if (i % 50 != 0) continue;
    EXPECT_EQ(Get(PortOf(port), "/metrics").status, 200) << i;
  }
  EXPECT_EQ(Get(PortOf(port), "/metrics").status, 200);
  int open = 0;
  for (RawClient& client : idle) open += !client.Closed();
  EXPECT_LE(open, 32);
}

TEST(MetricsPort, TakesNoRequestThatIsTooLargeOrNone) {
  const MetricsPort port({}, [](MetricsPage&) {});
  const std::string head = "GET /metrics HTTP/1.1\r\nHost: 127.0.0.1\r\n";
  const std::vector<std::string> requests = {
      "nonsense\r\n\r\n", head + "X: " + std::string(9000, 'a') + "\r\n\r\n",
      head + "Content-Length: 5\r\n\r\nhello",
      std::string("\x16\x03\x01\x02\x00\x01", 6) + "\r\n\r\n"};
  for (const std::string& request : requests) {
    RawClient client(PortOf(port));
    client.Send(request);
    // Closing with unread bytes may lose the answer.
    EXPECT_THAT(client.Answer(), testing::AnyOf("", StartsWith("HTTP/1.1 4")));
  }
  EXPECT_EQ(Get(PortOf(port), "/metrics").status, 200);
}

TEST(MetricsPort, EndsWithConnectionsThatAreOpen) {
  std::list<RawClient> idle;
  {
    const MetricsPort port({}, [](MetricsPage&) {});
    for (int i = 0; i < 10; ++i) idle.emplace_back(PortOf(port)).Send("GET /metr");
    EXPECT_EQ(Get(PortOf(port), "/metrics").status, 200);
  }
  for (RawClient& client : idle) EXPECT_EQ(client.Answer(), "");
}

TEST(MetricsPort, NamesAPortThatCannotBeHad) {
  const MetricsPort first({}, [](MetricsPage&) {});
  const MetricsEndpoint taken{.address = "127.0.0.1", .port = PortOf(first)};
  EXPECT_THAT(
      [&] { MetricsPort({.endpoint = taken}, [](MetricsPage&) {}); },
      testing::ThrowsMessage<Error>(AllOf(
          HasSubstr("--metrics 127.0.0.1:" + std::to_string(taken.port)), HasSubstr("in use"))));
}

TEST(MetricsEndpoint, IsThisHostsAloneUnlessItSaysMore) {
  EXPECT_EQ(ParseMetricsEndpoint("9464").address, "127.0.0.1");
  EXPECT_EQ(ParseMetricsEndpoint("9464").port, 9464);
  EXPECT_EQ(ParseMetricsEndpoint("10.0.0.1:80").address, "10.0.0.1");
  EXPECT_EQ(ParseMetricsEndpoint("[::1]:80").address, "::1");
  EXPECT_EQ(ParseMetricsEndpoint("[::]:80").port, 80);
  for (const char* text : {"", "x", "80x", ":80", "70000", "-1", "10.0.0.1:", "::1:80", "[::1]",
                           "[10.0.0.1]:80", "[]:80", "[::1:80", "lab.example:80", "10.0.0:80"}) {
    EXPECT_THROW(ParseMetricsEndpoint(text), UsageError) << text;
  }
  EXPECT_THAT([] { ParseMetricsEndpoint("x"); },
              testing::ThrowsMessage<UsageError>(HasSubstr("--metrics 'x': is no [ADDRESS:]PORT")));
}

}  // namespace
}  // namespace palpate::test
