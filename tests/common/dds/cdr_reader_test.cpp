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

/// Returns of how many stations a reader's DDS remembers anything.
std::size_t InstancesOf(const CdrReader<wire::ToolState>& reader,
                        const Writer<wire::ToolState>& writer, std::size_t most) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < most; ++i) {
    wire::ToolState key{};
    wire::FromText("s" + std::to_string(i), key.station);
    const auto instance = dds_lookup_instance(writer.handle(), &key);
    dds_sample_info_t info;
    void* samples[1] = {&key};
    kept += instance != DDS_HANDLE_NIL &&
            dds_read_instance(reader.handle(), samples, &info, 1, 1, instance) >= 0;
  }
  return kept;
}

/// What reaches readers of several sources from a writer that writes of many stations.
class Flooded : public CdrReaderTest {
 protected:
  static constexpr std::size_t kMany = 400;

  void Flood(const CdrReader<wire::ToolState>& control, Writer<wire::ToolState>& by) {
    for (std::size_t i = 1; i < kMany; ++i) {
      wire::FromText("s" + std::to_string(i), state.station);
      ASSERT_TRUE(by.Write(state));
    }
    ASSERT_TRUE(test::Eventually([&] { return InstancesOf(control, by, kMany) >= kMany - 1; }));
  }

  const Participant stranger_ = Participant::Service(kDomain);
  Writer<wire::ToolState> strange_{stranger_, topic, Qos::kSession};
};

TEST_F(Flooded, ReaderOfOneParticipantKeepsNothingOfWhatOthersWrite) {
  const auto source = std::make_shared<Source>();
  CdrReader<wire::ToolState> reader(participant, topic, Qos::kSession, source);
  const CdrReader<wire::ToolState> control = Reader();
  wire::FromText("server", state.station);
  ASSERT_TRUE(writer.Write(state));
  ASSERT_TRUE(Takes(reader, raw, taken));
  source->Only(raw.origin);
  wire::FromText("s0", state.station);
  ASSERT_TRUE(strange_.Write(state));
  ASSERT_TRUE(Takes(reader, raw, taken)) << "whose writer it is becomes known by its first sample";
  EXPECT_FALSE(source->Allows(raw.origin));
  EXPECT_TRUE(source->TakeRefused());
  Flood(control, strange_);
  EXPECT_LE(InstancesOf(reader, strange_, kMany), 1u);
  EXPECT_FALSE(reader.Take(raw, taken));
  EXPECT_TRUE(source->TakeRefused());
  EXPECT_FALSE(source->TakeRefused()) << "once";
  wire::FromText("server", state.station);
  ASSERT_TRUE(writer.Write(state));
  ASSERT_TRUE(Takes(reader, raw, taken));
  EXPECT_STREQ(taken.station, "server");
  source->Only(0);
  CdrReader<wire::ToolState> later(participant, topic, Qos::kSession, source);
  EXPECT_TRUE(test::Eventually([&] { return InstancesOf(later, strange_, kMany) == kMany; }));
}

TEST_F(Flooded, ReaderOfFewInstancesTakesThoseThatCameFirst) {
  CdrReader<wire::ToolState> reader(participant, topic, Qos::kSession,
                                    std::make_shared<Source>(Source::kFew));
  const CdrReader<wire::ToolState> control = Reader();
  Flood(control, strange_);
  EXPECT_EQ(InstancesOf(reader, strange_, kMany), Source::kFew);
  wire::FromText("other", state.station);
  ASSERT_TRUE(writer.Write(state));
  while (Takes(reader, raw, taken) && std::string(taken.station) != "other") {
  }
  EXPECT_STREQ(taken.station, "other") << "each writer has its own share";
  wire::FromText("s1", state.station);
  state.pose_sequence = 5;
  ASSERT_TRUE(strange_.Write(state));
  ASSERT_TRUE(Takes(reader, raw, taken));
  EXPECT_EQ(taken.pose_sequence, 5u) << "of those that it has, it takes all";
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
