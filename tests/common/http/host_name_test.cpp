#include "common/http/host_name.h"

#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace palpate {
namespace {

TEST(OwnHost, IsAnAddressInNumbersOrLocalhost) {
  for (const char* host : {"127.0.0.1", "127.0.0.1:8765", "192.168.0.7:1", "localhost",
                           "LocalHost:65535", "[::1]", "[::1]:8765", "[2001:db8::7]:80"}) {
    EXPECT_TRUE(IsOwnHost(host, {})) << host;
  }
}

TEST(OwnHost, IsANameThatIsConfiguredAndNoOther) {
  const std::vector<std::string> names = {"lab.example", "lab"};
  for (const char* host : {"lab.example", "LAB.example:8765", "lab:80"}) {
    EXPECT_TRUE(IsOwnHost(host, names)) << host;
  }
  for (const char* host :
       {"evil.example", "evil.example:8765", "lab.example.evil.example", "xlab.example", "lab.",
        "lab.example.", "127.0.0.1.evil.example", "localhost.evil.example", "evil.localhost"}) {
    EXPECT_FALSE(IsOwnHost(host, names)) << host;
  }
}

TEST(OwnHost, IsNothingThatIsSpelledInAnotherWay) {
  std::istringstream words(
      ": :8765 127.1 0x7f.0.0.1 2130706433 127.0.0.01 localhost: localhost:123456 localhost:80x "
      "localhost:80:80 ::1 [::1 [::1]x [::1]: [lab] [127.0.0.1] [] localhost/ a@localhost "
      "localhost# localhost,evil local%68ost");
  std::vector<std::string> hosts{"", "localhost evil", "127.0.0.1\t"};
  for (std::string word; words >> word;) hosts.push_back(word);
  for (const std::string& host : hosts) {
    EXPECT_FALSE(IsOwnHost(host, {"lab"})) << host;
  }
  EXPECT_FALSE(IsOwnHost(std::string_view("localhost\0evil", 14), {}));
  EXPECT_FALSE(IsOwnHost(std::string_view("[::1\0evil]", 10), {}));
  EXPECT_FALSE(IsOwnHost("[fe80::1%eth0]", {}));
}

TEST(OwnHost, RefusesWithWhatLetsANameIn) {
  EXPECT_FALSE(RefuseHost(1, "lab:80", {"lab"}, "palpate-viewer"));
  const auto other = RefuseHost(1, "evil.example", {"lab"}, "palpate-viewer");
  ASSERT_TRUE(other);
  EXPECT_EQ(other->status, 421);
  EXPECT_EQ(other->reason,
            "its Host is 'evil.example', which is no address in numbers, nor localhost; "
            "palpate-viewer --host-name lets it in, where that name is this host's");
  for (const int hosts : {0, 2}) {
    const auto refusal = RefuseHost(hosts, "lab", {"lab"}, "palpate-viewer");
    ASSERT_TRUE(refusal);
    EXPECT_EQ(refusal->status, 400);
  }
}

TEST(HostName, HasTheLettersOfOne) {
  EXPECT_TRUE(IsHostName("lab-7.example.org"));
  for (const char* name : {"", "lab:80", "http://lab", "lab example", "läb", "*"}) {
    EXPECT_FALSE(IsHostName(name)) << name;
  }
  EXPECT_FALSE(IsHostName(std::string(254, 'a')));
}

}  // namespace
}  // namespace palpate
