// The programs without RouDi, which manages shared memory.  tests/faults kills it under them.
#include "tests/support/roudi.h"

#include <gmock/gmock.h>

#include "tests/integration/rig.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;

constexpr const char* kRemedy = "deploy/cyclonedds/roudi.toml' (same user";
constexpr const char* kFallback = "UDP (no RouDi listens at /tmp/roudi; start 'iox-roudi -c";

TEST(WithoutRouDi, SharedMemoryIsRefusedWithTheRemedyAndAutoTakesUdpAndSaysSo) {
  RouDi roudi;
  roudi.Kill();  // so that no other RouDi runs meanwhile

  ServerProgram insisting_server("shm");
  EXPECT_EQ(insisting_server.Exit(), 1);
  EXPECT_THAT(insisting_server.Output(), HasSubstr(kRemedy));
  StationProgram insisting_station("hand", "shm");
  EXPECT_EQ(insisting_station.Exit(), 1);
  EXPECT_THAT(insisting_station.Output(), HasSubstr(kRemedy));

  ServerProgram server("auto");
  ASSERT_TRUE(server.Ready()) << server.Output();
  EXPECT_THAT(server.Output(), HasSubstr(kFallback));
  StationProgram station("hand", "auto", {"--for", "1"});
  EXPECT_EQ(station.Exit(), 0);
  EXPECT_THAT(station.Output(), HasSubstr(kFallback));
  EXPECT_TRUE(server.Says("station hand: active")) << server.Output();
}

}  // namespace
}  // namespace palpate::test
