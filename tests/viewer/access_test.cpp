#include "client/viewer/access.h"

#include <gtest/gtest.h>

namespace palpate {
namespace {

TEST(Access, IsForTheGatewaysOwnPagesAndForPrograms) {
  EXPECT_TRUE(MayAttach("", "anything", true, {}));
  EXPECT_TRUE(MayAttach("http://127.0.0.1:8765", "127.0.0.1:8765", true, {}));
  EXPECT_TRUE(MayAttach("http://LocalHost:8765", "localhost:8765", true, {}));
  EXPECT_TRUE(MayAttach("http://[::1]:8765", "[::1]:8765", true, {}));
  EXPECT_TRUE(MayAttach("https://lab.example:8765", "lab.example:8765", false, {}));
}

TEST(Access, IsNotForPagesFromElsewhere) {
  for (const bool loopback : {true, false}) {
    EXPECT_FALSE(MayAttach("http://evil.example", "127.0.0.1:8765", loopback, {}));
    EXPECT_FALSE(MayAttach("http://127.0.0.1:9999", "127.0.0.1:8765", loopback, {}));
    EXPECT_FALSE(MayAttach("http://127.0.0.1:8765.evil.example", "127.0.0.1:8765", loopback, {}));
    EXPECT_FALSE(MayAttach("null", "null", loopback, {}));
    EXPECT_FALSE(MayAttach("127.0.0.1:8765", "127.0.0.1:8765", loopback, {}));
    EXPECT_FALSE(MayAttach("http://", "", loopback, {"http://app.example"}));
  }
}

TEST(Access, IsNotForANameThatSomebodysDnsLeadsHere) {
  EXPECT_FALSE(MayAttach("http://evil.example:8765", "evil.example:8765", true, {}));
}

TEST(Access, IsForPagesThatAreNamed) {
  EXPECT_TRUE(MayAttach("https://app.example.org", "127.0.0.1:8765", true,
                        {"https://other", "https://app.example.org"}));
  EXPECT_FALSE(MayAttach("https://app.example.org.evil", "127.0.0.1:8765", true,
                         {"https://app.example.org"}));
  EXPECT_TRUE(MayAttach("file://", "127.0.0.1:8765", true, {"*"}));
}

}  // namespace
}  // namespace palpate
