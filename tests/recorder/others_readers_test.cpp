// The readers by MCAP's and Foxglove's makers find every sample in a recording as it was: so it is
// an MCAP file with omgidl schemas.
#include "tests/recorder/others_readers.h"

#include "tests/common/recording/samples.h"
#include "tests/session/session_request.h"

namespace palpate::test {
namespace {

/// A sample's numbers in the order of its fields, as read_back.mjs prints them.
void PutDoubles(nlohmann::json& out, const double* values, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) out.push_back(values[i]);
}
nlohmann::json ValuesOf(const wire::HapticPose& pose) {
  nlohmann::json out{std::to_string(pose.pose_sequence), std::to_string(pose.sample_time_ns)};
  PutDoubles(out, pose.position_m, 13);
  out.push_back(pose.buttons);
  out.push_back(pose.device_status);
  return out;
}
nlohmann::json ValuesOf(const wire::Wrench& wrench) {
  nlohmann::json out{std::to_string(wrench.pose_sequence), std::to_string(wrench.pose_time_ns)};
  PutDoubles(out, wrench.force_N, 13 + 36 + 12 + 12 + 4);
  out.push_back(std::to_string(wrench.step));
  for (const std::uint32_t value :
       {wrench.hands, wrench.rows, wrench.contacts, wrench.faults, wrench.answer, wrench.pad}) {
    out.push_back(value);
  }
  return out;
}
nlohmann::json ValuesOf(const wire::SessionState& state) {
  nlohmann::json out{state.station,
                     std::to_string(state.run),
                     std::to_string(state.server_run),
                     static_cast<int>(state.phase),
                     state.scene,
                     state.tool,
                     state.reason,
                     state.start_depth_m};
  PutDoubles(out, state.tool_reference_m, 3 + 2);
  out.push_back(std::to_string(state.start_sequence));
  PutDoubles(out, state.start_position_m, 7);
  out.push_back(static_cast<bool>(state.muted));
  out.push_back(state.listeners);
  return out;
}
class OthersReadersTest : public testing::Test {
 protected:
  template <class T>
  void Put(const std::string& topic, const T& sample, nlohmann::json values) {
    Add(writer_, topic, sample, ++time_ns_);
    expected_.push_back({topic, std::move(values)});
  }

  Folder folder_;
  std::string file_ = folder_ / "a.mcap";
  RecordingWriter writer_{{.file = file_}};
  std::int64_t time_ns_ = 1'700'000'000'000'000'000;
  std::vector<std::pair<std::string, nlohmann::json>> expected_;
};

TEST_F(OthersReadersTest, FindEverySampleOfEveryTopicAsItWas) {
  for (std::uint64_t i = 1; i <= 50; ++i) {
    Put(dds::PoseTopic("hand", 5), SamplePose(i), ValuesOf(SamplePose(i)));
    Put(dds::WrenchTopic("hand", 5), SampleWrench(i), ValuesOf(SampleWrench(i)));
    if (i % 10 == 0) writer_.Flush();
  }
  Put(dds::kSessionStateTopic, SampleState("hand", 5), ValuesOf(SampleState("hand", 5)));

  wire::SessionRequest request = MakeRequest("hand", 5, "cube", "", true);
  wire::FromText("simulated", request.device);
  request.leave_seal[0] = 9;  // bytes are given as their sum
  Put(dds::kSessionRequestTopic, request,
      {"hand", "5", "cube", "", "simulated", true, 32, 9, 32, 0, false});

  wire::LoopWhole made_whole{};
  wire::FromText("hand", made_whole.station);
  made_whole.run = 5;
  made_whole.number = 6;
  made_whole.pose_sequence = 7;
  Put(dds::kLoopWholeTopic, made_whole, {"hand", "5", "6", "7"});

  wire::ToolState tool{};
  wire::FromText("hand", tool.station);
  tool.pose_sequence = 3;
  tool.step_us = 2.5;
  tool.points = 1;
  tool.buttons = 2;
  tool.point[0].force_N[2] = -1.5;
  nlohmann::json values{"hand", "", "", "3"};
  for (int i = 0; i < 20; ++i) values.push_back(0.0);
  values.push_back(2.5);
  for (const int value : {0, 0, 1, 2}) values.push_back(value);
  for (int i = 0; i < 16 * 6; ++i) values.push_back(i == 5 ? -1.5 : 0.0);
  Put(dds::kToolStateTopic, tool, values);

  wire::LoopStatistics statistics{};
  wire::FromText("hand", statistics.station);
  wire::FromText("cube", statistics.scene);
  statistics.period_s = 1.5;
  statistics.steps = 1000;
  statistics.faults = 3;
  Put(dds::kLoopStatisticsTopic, statistics,
      {"hand", "cube", 1.5, "1000", 0.0, 0.0, 0.0, 0.0, 0.0, "0", "0", "0", "0", "0", "0", "0", 0,
       3});

  wire::GuideTarget guide{};
  wire::FromText("hand", guide.station);
  guide.run = 5;
  guide.number = 6;
  Number(guide.position_m, 1.5);
  Number(guide.orientation_wxyz, 4.5);
  Put(dds::kGuideTopic, guide, {"hand", "5", "6", 1.5, 2.5, 3.5, 4.5, 5.5, 6.5, 7.5});

  wire::StationStatistics station{};
  wire::FromText("hand", station.station);
  station.run = 7;
  wire::FromText("an arm", station.device);
  station.period_s = 1.5;
  station.braked = 4;
  station.energy_J = 0.25;
  station.device_status = 9;
  nlohmann::json figures{"hand", "7", "an arm", 1.5};
  for (int i = 0; i < 6; ++i) figures.push_back("0");
  figures.push_back(0.0);
  for (int i = 0; i < 8; ++i) figures.push_back(i == 3 ? "4" : "0");
  for (const double value : {0.0, 0.0, 0.0, 0.0, 0.25, 0.0, 0.0}) figures.push_back(value);
  figures.push_back(9);
  figures.push_back(0);
  Put(dds::kStationStatisticsTopic, station, figures);

  AddBundle(writer_, std::vector<std::uint8_t>(70'001, 2), ++time_ns_);
  expected_.push_back(
      {dds::kSceneBundleTopic,
       {"cube", "77", std::to_string(BundleHash(std::vector<std::uint8_t>(70'001, 2))), 70'001,
        140'002}});
  writer_.Close("the test is over");

  const auto found = ReadByOthers(file_);
  if (!found) GTEST_SKIP() << "deploy/setup --for tests fetches MCAP's readers";
  EXPECT_EQ((*found)["different"], 0) << "their writer makes other bytes";
  EXPECT_GT((*found)["reencoded"], 50);
  EXPECT_TRUE((*found)["done"]);
  EXPECT_EQ((*found)["topics"].size(), 10u);
  for (const auto& [topic, what] : (*found)["topics"].items()) {
    EXPECT_EQ(what["schema"], "omgidl") << topic;
    EXPECT_EQ(what["encoding"], "cdr") << topic;
  }
  const auto& messages = (*found)["messages"];
  ASSERT_EQ(messages.size(), expected_.size());
  for (std::size_t i = 0; i < expected_.size(); ++i) {
    EXPECT_EQ(messages[i]["topic"], expected_[i].first);
    EXPECT_EQ(messages[i]["values"], expected_[i].second) << expected_[i].first;
    EXPECT_EQ(messages[i]["log_time"],
              std::to_string(1'700'000'000'000'000'001 + static_cast<std::int64_t>(i)));
  }
  EXPECT_EQ((*found)["statistics"]["messages"], expected_.size());
  EXPECT_EQ((*found)["statistics"]["channels"], 10);
  EXPECT_EQ((*found)["indexed"], expected_.size());
  EXPECT_EQ((*found)["index_same"], expected_.size());
  EXPECT_EQ((*found)["indexed_metadata"], (*found)["metadata"].size());
  EXPECT_EQ((*found)["statistics"]["metadata"], (*found)["metadata"].size());
}

TEST_F(OthersReadersTest, ReadInOrderWhatWasNeverClosed) {
  for (std::uint64_t i = 1; i <= 50; ++i) {
    Put(dds::PoseTopic("hand", 5), SamplePose(i), ValuesOf(SamplePose(i)));
  }
  writer_.Flush();
  const auto found = ReadByOthers(file_);
  if (!found) GTEST_SKIP() << "deploy/setup --for tests fetches MCAP's readers";
  EXPECT_EQ((*found)["messages"].size(), 50u);
  EXPECT_FALSE((*found)["done"]);
}

}  // namespace
}  // namespace palpate::test
