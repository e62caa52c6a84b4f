#include "client/viewer/host_addresses.h"

#include <algorithm>

#include <gtest/gtest.h>

namespace palpate {
namespace {

namespace ip = boost::asio::ip;

TEST(HostAddresses, ArePutIntoAUrlAsItSpellsThem) {
  EXPECT_EQ(InUrl(ip::make_address("192.168.0.7")), "192.168.0.7");
  EXPECT_EQ(InUrl(ip::make_address("2001:db8::7")), "[2001:db8::7]");
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
