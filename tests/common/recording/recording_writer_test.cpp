#include "common/recording/recording_writer.h"

#include <cinttypes>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>

#include <gmock/gmock.h>

#include "common/error.h"
#include "common/recording/recording_reader.h"
#include "common/recording/split_name.h"
#include "common/revision.h"
#include "tests/common/recording/samples.h"
#include "tests/support/complaint.h"
#include "tests/support/milliseconds.h"

namespace palpate::test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

mcap::StringMap MetadataOf(const RecordingReader& reader, const std::string& name,
                           const std::string& topic = "") {
  for (const mcap::Metadata& metadata : reader.metadata()) {
    if (metadata.name != name) continue;
    if (topic.empty() || metadata.values.at("topic") == topic) return metadata.values;
  }
  ADD_FAILURE() << "no metadata " << name << " " << topic;
  return {};
}

TEST(RecordingWriter, ProvesWhatIsMissing) {
  const Folder folder;
  RecordingWriter writer({.file = folder / "a.mcap"});
  for (const std::uint64_t sequence : {5u, 6u, 9u, 10u, 20u}) {
    Add(writer, dds::PoseTopic("hand", 1), SamplePose(sequence), kMs);
    Add(writer, dds::WrenchTopic("hand", 1), SampleWrench(sequence), kMs);
  }
  writer.SetDropped(dds::PoseTopic("hand", 1), RecordedType::kHapticPose, 3);
  writer.SetDropped(dds::kSceneBundleTopic, RecordedType::kSceneBundle, 1);
  EXPECT_EQ(writer.missing(), 22u);
  writer.Close("the test is over");

  RecordingReader reader({folder / "a.mcap"});
  RecordedSample sample{};
  int count = 0;
  while (reader.Next(sample)) ++count;
  EXPECT_EQ(count, 10);
  EXPECT_TRUE(reader.complete());
  const mcap::StringMap pose = MetadataOf(reader, "palpate.topic", dds::PoseTopic("hand", 1));
  EXPECT_EQ(pose.at("messages"), "5");
  EXPECT_EQ(pose.at("first"), "5");
  EXPECT_EQ(pose.at("last"), "20");
  EXPECT_EQ(pose.at("holes"), "2");
  EXPECT_EQ(pose.at("missing"), "11");
  EXPECT_EQ(pose.at("dropped"), "3");
  EXPECT_EQ(MetadataOf(reader, "palpate.topic", dds::kSceneBundleTopic).at("dropped"), "1")
      << "though none was written";
  EXPECT_EQ(MetadataOf(reader, "palpate.end").at("reason"), "the test is over");
  EXPECT_EQ(MetadataOf(reader, "palpate.recording").at("build"), PALPATE_VERSION);
  EXPECT_EQ(MetadataOf(reader, "palpate.recording").at("physics"), kPhysicsRevision);
}

TEST(RecordingWriter, KeepsASceneOrItsHashAlone) {
  const Folder folder;
  for (const bool bundles : {true, false}) {
    const std::string file = folder / (bundles ? "with.mcap" : "without.mcap");
    RecordingWriter writer({.file = file, .bundles = bundles});
    AddBundle(writer, std::vector<std::uint8_t>(100'000, 3), kMs);
    writer.Close("");
    RecordingReader reader({file});
    RecordedSample sample{};
    EXPECT_EQ(reader.Next(sample), bundles);
    while (reader.Next(sample)) {
    }
    char hash[17];
    std::snprintf(hash, sizeof hash, "%016" PRIx64,
                  BundleHash(std::vector<std::uint8_t>(100'000, 3)));
    EXPECT_EQ(MetadataOf(reader, "palpate.scene").at("hash"), hash);
  }
}

TEST(RecordingWriter, BeginsEachSplitWithWhatHoldsThen) {
  const Folder folder;
  RecordingWriter writer({.file = folder / "day.mcap", .split_s = 1.0});
  AddBundle(writer, {1, 2, 3}, 0);
  for (int i = 0; i < 30; ++i) {
    const std::int64_t now_ns = (1 + 100 * i) * kMs;
    if (i == 2) Add(writer, dds::kSessionStateTopic, SampleState("hand", 1), now_ns);
    if (i == 4) Add(writer, dds::kSessionStateTopic, SampleState("hand", 2), now_ns);
    if (i == 5) Add(writer, dds::kSolidBlockTopic, SampleBlock(1), now_ns);
    if (i == 6) Add(writer, dds::kSolidBlockTopic, SampleBlock(2), now_ns);
    Add(writer, dds::PoseTopic("hand", 2), SamplePose(static_cast<std::uint64_t>(i)), now_ns);
  }
  writer.Close("");
  EXPECT_THAT(writer.files(), ElementsAre(folder / "day_000.mcap", folder / "day_001.mcap",
                                          folder / "day_002.mcap"));
  for (std::size_t split = 1; split < 3; ++split) {
    RecordingReader reader({writer.files()[split]});
    RecordedSample sample{};
    std::map<RecordedType, int> count;
    while (reader.Next(sample)) {
      ++count[sample.type];
      wire::SessionState state{};
      if (sample.To(state)) {
        EXPECT_EQ(state.run, 2u) << "the latest";
      }
    }
    EXPECT_TRUE(reader.complete());
    EXPECT_EQ(count[RecordedType::kSceneBundle], 1);
    EXPECT_EQ(count[RecordedType::kSessionState], 1);
    EXPECT_EQ(count[RecordedType::kSolidBlock], 2);
    EXPECT_EQ(count[RecordedType::kHapticPose], 10);
    EXPECT_EQ(MetadataOf(reader, "palpate.recording").at("split"), std::to_string(split));
    EXPECT_EQ(MetadataOf(reader, "palpate.scene").at("scene"), "cube");
  }
  RecordingReader all(writer.files());
  RecordedSample sample{};
  int poses = 0;
  while (all.Next(sample)) poses += sample.type == RecordedType::kHapticPose;
  EXPECT_EQ(poses, 30);
}

TEST(RecordingWriter, SplitsBySize) {
  const Folder folder;
  RecordingWriter writer({.file = folder / "day.mcap", .split_bytes = 20'000});
  for (std::uint64_t i = 1; i < 1000; ++i) {
    Add(writer, dds::PoseTopic("hand", 2), SamplePose(i * i), static_cast<std::int64_t>(i) * kMs);
    if (i % 50 == 0) writer.Flush();
  }
  writer.Close("");
  EXPECT_GT(writer.files().size(), 1u);
  for (const std::string& file : writer.files()) EXPECT_LT(BytesOf(file).size(), 60'000u);
}

TEST(SequenceCount, TakesRepetitionsForNoHoles) {
  SequenceCount count;
  for (const std::uint64_t i : {3u, 4u, 4u, 3u, 5u, 8u}) count.Add(i);
  EXPECT_EQ(count.first(), 3u);
  EXPECT_EQ(count.last(), 8u);
  EXPECT_EQ(count.holes(), 1u);
  EXPECT_EQ(count.missing(), 2u);
}

TEST(SequenceCount, PassesOverNumbersThatNoCountLeadsTo) {
  constexpr std::uint64_t kLast = ~std::uint64_t{0};
  SequenceCount count;
  for (const std::uint64_t i :
       {std::uint64_t{1}, kLast, std::uint64_t{2}, kLast - 1, std::uint64_t{4}}) {
    count.Add(i);
  }
  EXPECT_EQ(count.last(), 4u);
  EXPECT_EQ(count.missing(), 1u);
  EXPECT_EQ(count.astray(), 2u);
  SequenceCount from_the_end;
  for (const std::uint64_t i : {kLast, std::uint64_t{1}, std::uint64_t{2}}) from_the_end.Add(i);
  EXPECT_EQ(from_the_end.missing(), 0u);
  EXPECT_EQ(from_the_end.astray(), 2u);
}

TEST(RecordingWriter, DoesNotCountWhatASplitRepeats) {
  const Folder folder;
  RecordingWriter writer({.file = folder / "a.mcap", .split_bytes = 20'000});
  std::vector<std::uint8_t> noise(100'000);
  std::uint32_t state = 1;
  for (std::uint8_t& byte : noise)
    byte = static_cast<std::uint8_t>((state = state * 1664525 + 1013904223) >> 24);
  wire::SceneBundle bundle{};
  wire::FromText("noise", bundle.scene);
  bundle.bundle._buffer = noise.data();
  bundle.bundle._length = bundle.bundle._maximum = static_cast<std::uint32_t>(noise.size());
  Add(writer, dds::kSceneBundleTopic, bundle, kMs);
  for (std::uint64_t i = 1; i <= 2000; ++i) {
    Add(writer, dds::PoseTopic("hand", 1), SamplePose(i), static_cast<std::int64_t>(i) * kMs);
    if (i % 50 == 0) writer.Flush();
  }
  writer.Close("");
  EXPECT_GT(writer.files().size(), 3u);
  EXPECT_LT(writer.files().size(), 30u) << "a file for a sample or two";
}

TEST(RecordingWriter, LeavesTheSplitsOfAFormerRecording) {
  const Folder folder;
  for (const char* name : {"a_b.mcap", "a_20261122.mcap", "a_7.mcap", "b_001.mcap"}) {
    std::ofstream(folder / name) << "no split";
  }
  const RecordingOptions options{.file = folder / "a.mcap", .split_s = 10.0, .overwrite = true};
  RecordingWriter(options).Close("");
  std::filesystem::rename(folder / "a_000.mcap", folder / "a_017.mcap");
  EXPECT_THAT(ComplaintOf([&] { RecordingWriter writer(options); }),
              testing::AllOf(testing::HasSubstr(folder / "a_017.mcap"),
                             testing::HasSubstr("move such files away")));
  EXPECT_FALSE(std::filesystem::exists(folder / "a_000.mcap"));
}

TEST(RecordingWriter, OverwritesNothingThatComesToHaveASplitsName) {
  const Folder folder;
  RecordingWriter writer({.file = folder / "a.mcap", .split_s = 1.0, .overwrite = true});
  Add(writer, dds::PoseTopic("hand", 1), SamplePose(1), kMs);
  WriteBytes(folder / "a_001.mcap", {1, 2, 3});
  EXPECT_THROW(Add(writer, dds::PoseTopic("hand", 1), SamplePose(2), 2000 * kMs), Error);
  EXPECT_EQ(BytesOf(folder / "a_001.mcap").size(), 3u);
}

TEST(RecordingWriter, OverwritesNoFileButARecording) {
  const Folder folder;
  WriteBytes(folder / "thesis.pdf", {1, 2, 3});
  EXPECT_THROW(RecordingWriter({.file = folder / "thesis.pdf", .overwrite = true}), Error);
  EXPECT_EQ(BytesOf(folder / "thesis.pdf").size(), 3u);
}

TEST(RecordingWriter, FilesNoTopicUnderAnothersWhereThereAreTooMany) {
  const Folder folder;
  constexpr std::uint64_t kTopics = 70'000;
  {
    RecordingWriter writer({.file = folder / "a.mcap"});
    for (std::uint64_t i = 1; i <= kTopics; ++i) {
      Add(writer, dds::PoseTopic("hand", i), SamplePose(i), kMs);
    }
    writer.Close("the test is over");
  }
  RecordingReader reader({folder / "a.mcap"});
  RecordedSample sample{};
  std::uint64_t count = 0;
  while (reader.Next(sample)) {
    wire::HapticPose pose;
    ASSERT_TRUE(sample.To(pose));
    ASSERT_EQ(*sample.topic, dds::PoseTopic("hand", pose.pose_sequence));
    ++count;
  }
  EXPECT_EQ(count, 65'535u);
  EXPECT_THAT(reader.problems(), IsEmpty());
  EXPECT_EQ(MetadataOf(reader, "palpate.topic", dds::PoseTopic("hand", 1)).at("no_channel"), "0");
  EXPECT_EQ(MetadataOf(reader, "palpate.topic", dds::PoseTopic("hand", kTopics)).at("no_channel"),
            "1")
      << "the recording says what it lacks";
}

TEST(RecordingWriter, ReplacesAFileThatIsBeingReadWithoutHarmToItsReader) {
  const Folder folder;
  const auto record = [&](std::uint64_t poses) {
    RecordingWriter writer({.file = folder / "a.mcap", .overwrite = true});
    for (std::uint64_t i = 1; i <= poses; ++i) {
      Add(writer, dds::PoseTopic("hand", 1), SamplePose(i), static_cast<std::int64_t>(i) * kMs);
    }
    writer.Close("");
  };
  record(2000);
  RecordingReader reader({folder / "a.mcap"});
  record(1);
  RecordedSample sample{};
  int count = 0;
  while (reader.Next(sample)) ++count;
  EXPECT_EQ(count, 2000);
}

}  // namespace
}  // namespace palpate::test
