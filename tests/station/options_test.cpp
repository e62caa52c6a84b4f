#include "client/station/options.h"

#include <iterator>
#include <sstream>
#include <vector>

#include <gmock/gmock.h>

#include "tests/support/command_line.h"

namespace palpate {
namespace {

std::optional<StationOptions> Parse(const std::vector<const char*>& words) {
  return test::ParseWith(ParseStationOptions, words);
}

TEST(StationOptions, ReadsWhatItIsGiven) {
  std::istringstream text(
      "--device simulated --model touch --rate 2000 --scene cube --tool sphere --id probe_1 "
      "--for 2.5 --transport udp --domain 7 --loop --no-table --realtime off --json - "
      "--calibrate --device-name left --max-force 1.5 --scale 2.5 --workspace desk.json "
      "--clutch-button 1 --network eth0 --peer 10.0.0.1 --peer 10.0.0.2 --trace ticks.csv");
  const std::vector<std::string> words{std::istream_iterator<std::string>(text), {}};
  std::vector<const char*> arguments;
  for (const std::string& word : words) arguments.push_back(word.c_str());
  const auto options = Parse(arguments);
  ASSERT_TRUE(options);
  EXPECT_EQ(options->link.device, "simulated");
  EXPECT_EQ(options->device.model, "touch");
  EXPECT_EQ(options->device.rate_Hz, 2000.0);
  EXPECT_EQ(options->link.scene, "cube");
  EXPECT_EQ(options->link.tool, "sphere");
  EXPECT_EQ(options->link.station, "probe_1");
  EXPECT_EQ(options->seconds, 2.5);
  EXPECT_EQ(options->link.transport, dds::Transport::kUdp);
  EXPECT_EQ(options->link.domain, 7);
  EXPECT_TRUE(options->device.loop);
  EXPECT_FALSE(options->enable_forces);
  EXPECT_EQ(options->table, false);
  EXPECT_EQ(options->link.realtime.mode, RealtimeMode::kOff);
  EXPECT_EQ(options->json, "-");
  EXPECT_TRUE(options->device.calibrate);
  EXPECT_EQ(options->device.arm, "left");
  EXPECT_EQ(options->max_force_N, 1.5);
  EXPECT_EQ(options->scale, 2.5);
  EXPECT_EQ(options->workspace, "desk.json");
  EXPECT_EQ(options->clutch_button, 1);
  EXPECT_EQ(options->link.network.interface, "eth0");
  EXPECT_THAT(options->link.network.peers, testing::ElementsAre("10.0.0.1", "10.0.0.2"));
  EXPECT_EQ(options->trace, "ticks.csv");
}

TEST(StationOptions, TakesADriversFileAndTellsTheServerItsName) {
  const auto options = Parse({"--device", "made/by/me.so", "--scene", "cube", "--id", "a"});
  ASSERT_TRUE(options);
  EXPECT_EQ(options->device.name, "made/by/me.so");
  EXPECT_EQ(options->link.device, "me.so");
}

TEST(StationOptions, RefusesALimitThatIsNone) {
  for (const char* limit : {"--max-force", "--scale"}) {
    for (const char* value : {"0", "nan", "-1"}) {
      EXPECT_THAT(test::ComplaintOf(ParseStationOptions, {"--device", "simulated", "--scene",
                                                          "cube", "--id", "a", limit, value}),
                  testing::HasSubstr(limit));
    }
  }
}

}  // namespace
}  // namespace palpate
