#include "client/viewer/visitor.h"

#include <algorithm>

#include <gtest/gtest.h>

namespace palpate {
namespace {

namespace ip = boost::asio::ip;

Visitor At(const char* address, const char* forwarded = "",
           const std::vector<ip::address>& proxies = {}) {
  return VisitorAt({ip::make_address(address), 50312}, forwarded, proxies);
}
const ip::address kProxy = ip::make_address("127.0.0.1");

TEST(Visitor, IsNamedByItsAddressAndPortAndIsOneWithItsNetworkOfIpv6) {
  EXPECT_EQ(At("192.168.0.7").name, "192.168.0.7:50312");
  EXPECT_EQ(At("192.168.0.7").address, "192.168.0.7");
  EXPECT_EQ(At("::1").name, "[::1]:50312");
  EXPECT_EQ(At("::ffff:192.168.0.7").address, "192.168.0.7");
  EXPECT_EQ(At("2001:db8:1:2:3::4").address, At("2001:db8:1:2:ffff::").address);
  EXPECT_NE(At("2001:db8:1:2:3::4").address, At("2001:db8:1:3:3::4").address);
}

TEST(Visitor, IsLocalWhereItComesFromThisHostAndThroughNoProxy) {
  EXPECT_TRUE(At("127.0.0.1").is_local);
  EXPECT_TRUE(At("::1").is_local);
  EXPECT_FALSE(At("192.168.0.7").is_local);
  EXPECT_FALSE(At("127.0.0.1", "10.0.0.1").is_local);
  EXPECT_FALSE(At("127.0.0.1", "for=10.0.0.1").is_local);
  EXPECT_FALSE(At("127.0.0.1", "127.0.0.1", {kProxy}).is_local);
  EXPECT_FALSE(At("127.0.0.1", "", {kProxy}).is_local) << "a proxy that does not say for whom";
}

TEST(Visitor, IsWhomAProxySpeaksForAndNobodyElse) {
  const Visitor visitor = At("127.0.0.1", "9.9.9.9, 10.0.0.1", {kProxy});
  EXPECT_EQ(visitor.address, "10.0.0.1") << "the last is what the proxy has seen";
  EXPECT_EQ(visitor.name, "10.0.0.1 (by the proxy 127.0.0.1)");
  EXPECT_EQ(At("192.168.0.7", "10.0.0.1", {kProxy}).address, "192.168.0.7");
  EXPECT_EQ(At("127.0.0.1", "unknown", {kProxy}).address, "127.0.0.1");
}

TEST(HostAddresses, NameThoseThatOthersReachBeforeThisHostsOwn) {
  for (const bool v6 : {false, true}) {
    const auto addresses = HostAddresses(v6);
    EXPECT_EQ(std::ranges::count(addresses, ip::make_address("127.0.0.1")), 1);
    EXPECT_TRUE(std::ranges::is_partitioned(
        addresses, [](const ip::address& address) { return !address.is_loopback(); }));
    for (const ip::address& address : addresses) EXPECT_TRUE(v6 || address.is_v4()) << address;
  }
}

}  // namespace
}  // namespace palpate
