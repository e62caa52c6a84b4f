#include "common/dds/cdr_reader.h"

#include <chrono>
#include <cstring>
#include <thread>

#include <gtest/gtest.h>

#include "tests/common/dds/own_topic.h"
#include "tests/common/dds/peer.h"
#include "tests/support/eventually.h"

namespace palpate::dds {
namespace {

template <class T>
bool Takes(CdrReader<T>& reader, CdrSample& raw, T& sample) {
  return test::Eventually([&] { return reader.Take(raw, sample); });
}

TEST(CdrReader, GivesTheBytesAsTheyTravelledAndTheStructThatTheyMean) {
  const Participant participant = Participant::Service(kDomain);
  const std::string topic = OwnTopic("tool_state");
  Writer<wire::ToolState> writer(participant, topic, Qos::kSession);
  wire::ToolState state{};
  wire::FromText("abc", state.station);
  state.pose_sequence = 0x1122334455667788;
  ASSERT_TRUE(writer.Write(state));
  CdrReader<wire::ToolState> reader(participant, topic, Qos::kSession);
  CdrSample raw;
  wire::ToolState taken{};
  ASSERT_TRUE(Takes(reader, raw, taken));
  EXPECT_STREQ(taken.station, "abc");
  EXPECT_EQ(taken.pose_sequence, state.pose_sequence);
  EXPECT_GT(raw.source_time_ns, 0);
  // Little-endian CDR; a string has its length with the zero, then its characters.
  const std::uint8_t begin[] = {0, 1, 0, 0, 4, 0, 0, 0, 'a', 'b', 'c', 0};
  ASSERT_GT(raw.cdr.size(), sizeof begin);
  EXPECT_EQ(std::memcmp(raw.cdr.data(), begin, sizeof begin), 0);
  EXPECT_FALSE(reader.Take(raw, taken));
}

TEST(CdrReader, TellsThatAnInstanceIsOverToWhoWantsToKnow) {
  const Participant participant = Participant::Service(kDomain);
  const std::string topic = OwnTopic("over");
  Writer<wire::ToolState> writer(participant, topic, Qos::kSession);
  CdrReader<wire::ToolState> told(participant, topic, Qos::kSession);
  CdrReader<wire::ToolState> untold(participant, topic, Qos::kSession);
  wire::ToolState state{};
  CdrSample raw;
  wire::ToolState taken{};
  for (const char* station : {"a", "b"}) {
    wire::FromText(station, state.station);
    ASSERT_TRUE(writer.Write(state));
  }
  while (!Takes(told, raw, taken) || taken.station[0] != 'b') {
  }
  wire::FromText("a", state.station);
  writer.Dispose(state);
  ASSERT_TRUE(test::Eventually([&] { return told.Take(raw, taken, true); }));
  EXPECT_TRUE(raw.over);
  EXPECT_STREQ(taken.station, "a");
  EXPECT_TRUE(raw.cdr.empty());
  while (untold.Take(raw, taken)) EXPECT_FALSE(raw.over);
  // Who comes later hears of b alone.
  CdrReader<wire::ToolState> late(participant, topic, Qos::kSession);
  ASSERT_TRUE(Takes(late, raw, taken));
  EXPECT_STREQ(taken.station, "b");
  EXPECT_FALSE(late.Take(raw, taken, true));
}

TEST(CdrReader, TellsParticipantsApartAndWhetherTheyAreThere) {
  const std::string topic = OwnTopic("origin");
  const Participant here = Participant::Service(kDomain);
  CdrReader<wire::ToolState> reader(here, topic, Qos::kSession);
  CdrSample raw;
  wire::ToolState state{}, taken{};
  std::vector<std::uint64_t> origins;
  Participant lasting = Participant::Service(kDomain);
  Writer<wire::ToolState> lasting_writer(lasting, topic, Qos::kSession);
  {
    Participant passing = Participant::Service(kDomain);
    Writer<wire::ToolState> first(passing, topic, Qos::kSession);
    Writer<wire::ToolState> second(passing, topic, Qos::kSession);
    for (Writer<wire::ToolState>* writer : {&first, &second, &lasting_writer}) {
      ASSERT_TRUE(writer->Write(state));
      ASSERT_TRUE(Takes(reader, raw, taken));
      origins.push_back(raw.origin);
    }
    EXPECT_NE(origins[0], 0u);
    EXPECT_EQ(origins[0], origins[1]);
    EXPECT_NE(origins[0], origins[2]);
    EXPECT_TRUE(reader.Hears(origins[0]));
  }
  for (int i = 0; i < 10'000 && reader.Hears(origins[0]); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  EXPECT_FALSE(reader.Hears(origins[0]));
  EXPECT_TRUE(reader.Hears(origins[2]));
}

TEST(CdrReader, TellsInstancesApartByTheirKeys) {
  const Participant participant = Participant::Service(kDomain);
  const std::string topic = OwnTopic("instances");
  Writer<wire::LoopStatistics> writer(participant, topic, Qos::kSession);
  CdrReader<wire::LoopStatistics> reader(participant, topic, Qos::kSession);
  CdrSample raw;
  wire::LoopStatistics sample{};
  std::vector<std::uint64_t> instances;
  for (const char* station : {"a", "b", "a"}) {
    wire::LoopStatistics s{};
    wire::FromText(station, s.station);
    ASSERT_TRUE(writer.Write(s));
    ASSERT_TRUE(Takes(reader, raw, sample));
    instances.push_back(raw.instance);
  }
  EXPECT_EQ(instances[0], instances[2]);
  EXPECT_NE(instances[0], instances[1]);
}

TEST(CdrReader, GetsABundleOfTensOfMegabytesThatWasWrittenBeforeItCame) {
  const std::string topic = OwnTopic("bundle");
  constexpr std::size_t kBytes = 32'000'003;
  Peer peer("bundle", kDomain, topic, kBytes, "at-once");
  const Participant participant = Participant::Service(kDomain);
  for (int late = 0; late < 2; ++late) {  // the second comes once all is written and sent
    CdrReader<wire::SceneBundle> reader(participant, topic, Qos::kSession);
    CdrSample raw;
    wire::SceneBundle sample{};
    ASSERT_TRUE(Takes(reader, raw, sample));
    ASSERT_EQ(sample.bundle._length, kBytes);
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < kBytes; ++i) {
      wrong += sample.bundle._buffer[i] != static_cast<std::uint8_t>(i);
    }
    EXPECT_EQ(wrong, 0u);
    FreeContents(sample);
    EXPECT_EQ(sample.bundle._buffer, nullptr);
  }
  peer.Kill();
}

}  // namespace
}  // namespace palpate::dds
