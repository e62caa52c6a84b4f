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

/// A topic of tool states with a writer, and what its readers take.
class CdrReaderTest : public testing::Test {
 protected:
  CdrReader<wire::ToolState> Reader() const { return {participant, topic, Qos::kSession}; }

  const Participant participant = Participant::Service(kDomain);
  const std::string topic = OwnTopic(testing::UnitTest::GetInstance()->current_test_info()->name());
  Writer<wire::ToolState> writer{participant, topic, Qos::kSession};
  wire::ToolState state{}, taken{};
  CdrSample raw;
};

TEST_F(CdrReaderTest, GivesTheBytesAsTheyTravelledAndTheStructThatTheyMean) {
  wire::FromText("abc", state.station);
  state.pose_sequence = 0x1122334455667788;
  ASSERT_TRUE(writer.Write(state));
  CdrReader<wire::ToolState> reader = Reader();
  ASSERT_TRUE(Takes(reader, raw, taken));
  EXPECT_STREQ(taken.station, "abc");
  EXPECT_EQ(taken.pose_sequence, state.pose_sequence);
  EXPECT_GT(raw.source_time_ns, 0);
  // Little-endian CDR: a string is its length, with the zero, then its characters.
  const std::uint8_t begin[] = {0, 1, 0, 0, 4, 0, 0, 0, 'a', 'b', 'c', 0};
  ASSERT_GT(raw.cdr.size(), sizeof begin);
  EXPECT_EQ(std::memcmp(raw.cdr.data(), begin, sizeof begin), 0);
  EXPECT_FALSE(reader.Take(raw, taken));
}

TEST_F(CdrReaderTest, TellsThatAnInstanceIsOverToWhoWantsToKnow) {
  CdrReader<wire::ToolState> told = Reader(), untold = Reader();
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
  // A late reader hears only of b.
  CdrReader<wire::ToolState> late = Reader();
  ASSERT_TRUE(Takes(late, raw, taken));
  EXPECT_STREQ(taken.station, "b");
  EXPECT_FALSE(late.Take(raw, taken, true));
}

TEST_F(CdrReaderTest, TellsParticipantsApartAndWhetherTheyAreThere) {
  CdrReader<wire::ToolState> reader = Reader();
  std::vector<std::uint64_t> origins;
  {
    Participant passing = Participant::Service(kDomain);
    Writer<wire::ToolState> first(passing, topic, Qos::kSession);
    Writer<wire::ToolState> second(passing, topic, Qos::kSession);
    for (Writer<wire::ToolState>* each : {&first, &second, &writer}) {
      ASSERT_TRUE(each->Write(state));
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
  for (int late = 0; late < 2; ++late) {  // the second reader comes once all is written and sent
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
