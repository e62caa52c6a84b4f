#include "common/metrics/metrics_port.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/error.h"
#include "tests/viewer/web_client.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;

int PortOf(const MetricsPort& port) {
  const std::string& url = port.url();
  return std::stoi(url.substr(url.rfind(':') + 1));
}

TEST(MetricsPort, GivesThePageAsItIsWhenItIsAskedFor) {
  std::uint64_t asked = 0;
  const MetricsPort port({.address = "127.0.0.1", .port = 0},
                         [&](MetricsPage& page) { page.Add(metric::kServerRefusals, ++asked); });
  const HttpAnswer first = Get(PortOf(port), "/metrics");
  EXPECT_EQ(first.status, 200);
  EXPECT_THAT(first.body, HasSubstr("palpate_server_refusals_total 1\n"));
  EXPECT_THAT(Get(PortOf(port), "/metrics").body, HasSubstr("palpate_server_refusals_total 2\n"));
  EXPECT_EQ(Get(PortOf(port), "/elsewhere").status, 404);
}

TEST(MetricsPort, NamesAPortThatCannotBeHad) {
  const MetricsPort first({}, [](MetricsPage&) {});
  const MetricsEndpoint taken{.address = "127.0.0.1", .port = PortOf(first)};
  EXPECT_THAT([&] { MetricsPort(taken, [](MetricsPage&) {}); },
              testing::ThrowsMessage<Error>(
                  HasSubstr("--metrics 127.0.0.1:" + std::to_string(taken.port))));
}

TEST(MetricsEndpoint, IsThisHostsAloneUnlessItSaysMore) {
  EXPECT_EQ(ParseMetricsEndpoint("9464").address, "127.0.0.1");
  EXPECT_EQ(ParseMetricsEndpoint("9464").port, 9464);
  EXPECT_EQ(ParseMetricsEndpoint("10.0.0.1:80").address, "10.0.0.1");
  EXPECT_EQ(ParseMetricsEndpoint("[::1]:80").address, "[::1]");
  for (const char* text : {"", "x", "80x", ":80", "70000", "-1", "10.0.0.1:"}) {
    EXPECT_THROW(ParseMetricsEndpoint(text), UsageError) << text;
  }
}

}  // namespace
}  // namespace palpate::test
