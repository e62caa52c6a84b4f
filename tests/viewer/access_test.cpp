#include "client/viewer/access.h"

#include <gtest/gtest.h>

namespace palpate {
namespace {

Access Of(const char* origin, const char* host, bool secure = false,
          const std::vector<std::string>& allowed = {}) {
  return AccessOfOrigin(origin, host, secure, allowed);
}

TEST(Access, IsAllForTheGatewaysOwnPagesAndForPrograms) {
  EXPECT_EQ(Of("", "127.0.0.1:8765"), Access::kOperate);
  EXPECT_EQ(Of("http://127.0.0.1:8765", "127.0.0.1:8765"), Access::kOperate);
  EXPECT_EQ(Of("http://LocalHost:8765", "localhost:8765"), Access::kOperate);
  EXPECT_EQ(Of("http://[::1]:8765", "[::1]:8765"), Access::kOperate);
  EXPECT_EQ(Of("https://lab.example", "lab.example"), Access::kOperate) << "a proxy speaks TLS";
}

TEST(Access, IsNotForThisGatewaysAddressInTheClearWhereItSpeaksTls) {
  EXPECT_EQ(Of("https://127.0.0.1:8765", "127.0.0.1:8765", true), Access::kOperate);
  EXPECT_EQ(Of("http://127.0.0.1:8765", "127.0.0.1:8765", true), Access::kNone)
      << "whoever is on the way could have written that page";
}

TEST(Access, IsNotForPagesFromElsewhere) {
  for (const bool secure : {true, false}) {
    for (const char* origin :
         {"http://evil.example", "http://127.0.0.1:9999", "http://127.0.0.1:8765.evil.example",
          "null", "127.0.0.1:8765", "file://evil.example", "file:///", "ftp://127.0.0.1:8765",
          "http://127.0.0.1:8765/", "http://a@127.0.0.1:8765", "http://127.0.0.1"}) {
      EXPECT_EQ(Of(origin, "127.0.0.1:8765", secure), Access::kNone) << origin;
    }
    EXPECT_EQ(Of("null", "null", secure), Access::kNone);
    EXPECT_EQ(Of("http://", "", secure, {"http://app.example"}), Access::kNone);
  }
}

TEST(Access, IsToWatchForDesktopApplications) {
  EXPECT_EQ(Of("file://", "127.0.0.1:8765"), Access::kWatch);
  EXPECT_EQ(Of("FILE://", "lab.example"), Access::kWatch);
  EXPECT_EQ(Of("file://", "127.0.0.1:8765", false, {"file://"}), Access::kDrive);
}

TEST(Access, IsToDriveForPagesThatAreNamed) {
  EXPECT_EQ(Of("https://app.example.org", "127.0.0.1:8765", false,
               {"https://other", "https://app.example.org"}),
            Access::kDrive);
  EXPECT_EQ(
      Of("https://app.example.org.evil", "127.0.0.1:8765", false, {"https://app.example.org"}),
      Access::kNone);
  EXPECT_EQ(Of("https://anything", "127.0.0.1:8765", false, {"*"}), Access::kDrive);
}

TEST(Access, HasTheNamesOfItsRoles) {
  for (const Access role : {Access::kWatch, Access::kDrive, Access::kOperate}) {
    EXPECT_EQ(ParseRole(RoleName(role)), role);
  }
  for (const char* word : {"", "none", "Watch", "operate ", "admin"}) {
    EXPECT_FALSE(ParseRole(word)) << word;
  }
}

}  // namespace
}  // namespace palpate
