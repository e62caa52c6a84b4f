#include "client/viewer/access.h"

#include <gtest/gtest.h>

namespace palpate {
namespace {

Access Of(const char* origin, const char* host, bool loopback_only = true,
          const std::vector<std::string>& allowed = {}) {
  return AccessOf(origin, host, loopback_only, allowed);
}

TEST(Access, IsForTheGatewaysOwnPagesAndForPrograms) {
  EXPECT_EQ(Of("", "anything"), Access::kAll);
  EXPECT_EQ(Of("http://127.0.0.1:8765", "127.0.0.1:8765"), Access::kAll);
  EXPECT_EQ(Of("http://LocalHost:8765", "localhost:8765"), Access::kAll);
  EXPECT_EQ(Of("http://[::1]:8765", "[::1]:8765"), Access::kAll);
  EXPECT_EQ(Of("https://lab.example:8765", "lab.example:8765", false), Access::kAll);
}

TEST(Access, IsNotForPagesFromElsewhere) {
  for (const bool loopback : {true, false}) {
    for (const char* origin :
         {"http://evil.example", "http://127.0.0.1:9999", "http://127.0.0.1:8765.evil.example",
          "null", "127.0.0.1:8765", "file://evil.example", "file:///"}) {
      EXPECT_EQ(Of(origin, "127.0.0.1:8765", loopback), Access::kNone) << origin;
    }
    EXPECT_EQ(Of("null", "null", loopback), Access::kNone);
    EXPECT_EQ(Of("http://", "", loopback, {"http://app.example"}), Access::kNone);
  }
}

TEST(Access, IsNotForANameThatSomebodysDnsLeadsHere) {
  EXPECT_EQ(Of("http://evil.example:8765", "evil.example:8765"), Access::kNone);
}

TEST(Access, IsToLookForDesktopApplications) {
  EXPECT_EQ(Of("file://", "127.0.0.1:8765"), Access::kLook);
  EXPECT_EQ(Of("FILE://", "lab.example", false), Access::kLook);
  EXPECT_EQ(Of("file://", "127.0.0.1:8765", true, {"file://"}), Access::kAll);
}

TEST(Access, IsForPagesThatAreNamed) {
  EXPECT_EQ(Of("https://app.example.org", "127.0.0.1:8765", true,
               {"https://other", "https://app.example.org"}),
            Access::kAll);
  EXPECT_EQ(Of("https://app.example.org.evil", "127.0.0.1:8765", true, {"https://app.example.org"}),
            Access::kNone);
  EXPECT_EQ(Of("https://anything", "127.0.0.1:8765", true, {"*"}), Access::kAll);
}

}  // namespace
}  // namespace palpate
