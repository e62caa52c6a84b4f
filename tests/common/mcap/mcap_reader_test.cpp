#include "common/mcap/mcap_reader.h"

#include <gmock/gmock.h>
#include <sys/stat.h>

#include "common/error.h"
#include "common/mcap/mcap_writer.h"
#include "tests/common/recording/samples.h"
#include "tests/support/random.h"

namespace palpate::mcap {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

constexpr int kChunks = 3;
constexpr int kPerChunk = 20;

std::vector<std::uint8_t> DataOf(int i) {
  std::vector<std::uint8_t> data(static_cast<std::size_t>(40 + i % 7));
  for (std::size_t k = 0; k < data.size(); ++k) {
    data[k] = static_cast<std::uint8_t>(i * 31 + static_cast<int>(k * k));
  }
  return data;
}

/// A file of three chunks, each of twenty numbered messages.
class McapReaderTest : public testing::Test {
 protected:
  McapReaderTest() {
    Writer writer(file_, "test");
    const std::uint16_t schema = writer.AddSchema("palpate::X", "omgidl", "struct X {};");
    const std::uint16_t channel = writer.AddChannel(schema, "topic", "cdr", {{"a", "b"}});
    for (int i = 0; i < kChunks * kPerChunk; ++i) {
      writer.Write(channel, static_cast<std::uint32_t>(i), 1000 + i, 2000 + i, DataOf(i));
      if (i % kPerChunk == kPerChunk - 1) {
        writer.Flush();
        ends_.push_back(writer.size());
      }
    }
    writer.WriteMetadata({"notes", {{"key", "value"}}});
    writer.Close();
    bytes_ = test::BytesOf(file_);
  }

  /// The numbers of all messages that can be read; checks that each is as it was written.
  static std::vector<int> Read(Reader& reader) {
    std::vector<int> numbers;
    Message message;
    while (reader.Next(message)) {
      const auto i = static_cast<int>(message.sequence);
      EXPECT_EQ(message.log_time_ns, 1000 + i);
      EXPECT_EQ(message.publish_time_ns, 2000 + i);
      EXPECT_EQ(message.channel->topic, "topic");
      EXPECT_EQ(std::vector<std::uint8_t>(message.data.begin(), message.data.end()), DataOf(i));
      numbers.push_back(i);
    }
    return numbers;
  }

  test::Folder folder_;
  std::string file_ = folder_ / "a.mcap";
  std::vector<std::uint64_t> ends_;  // size of the file after each chunk
  std::vector<std::uint8_t> bytes_;
};

TEST_F(McapReaderTest, GivesBackWhatWasWritten) {
  Reader reader(bytes_, "a");
  EXPECT_THAT(Read(reader), SizeIs(kChunks * kPerChunk));
  EXPECT_TRUE(reader.complete());
  EXPECT_THAT(reader.problems(), IsEmpty());
  ASSERT_THAT(reader.metadata(), SizeIs(1));
  EXPECT_EQ(reader.metadata()[0].values.at("key"), "value");
  EXPECT_EQ(reader.schemas().at(1).data, "struct X {};");
  EXPECT_EQ(reader.channels().at(1).metadata.at("a"), "b");
}

TEST_F(McapReaderTest, GivesEveryWholeChunkWhereverTheFileIsCutOff) {
  for (std::size_t n = kMagicSize; n < bytes_.size(); ++n) {
    Reader reader({bytes_.data(), n}, "a");
    const std::size_t read = Read(reader).size();
    std::size_t whole = 0;
    while (whole < ends_.size() && ends_[whole] <= n) ++whole;
    // A chunk's record ends before the index that follows it.
    EXPECT_GE(read, whole * kPerChunk) << n;
    EXPECT_EQ(read % kPerChunk, 0u) << n;
    EXPECT_FALSE(reader.complete()) << n;
    EXPECT_THAT(reader.problems(), SizeIs(1)) << n;
  }
}

TEST_F(McapReaderTest, NeverGivesAChangedMessageWhateverBitIsFlipped) {
  test::Random random(7);
  int damaged = 0;
  for (int i = 0; i < 20000; ++i) {
    std::vector<std::uint8_t> bytes = bytes_;
    const std::size_t at = kMagicSize + random.Bits() % (bytes.size() - kMagicSize);
    bytes[at] ^= static_cast<std::uint8_t>(1 << random.Below(8));
    Reader reader(bytes, "a");
    Message message;
    std::size_t read = 0;
    for (; reader.Next(message); ++read) {
      const auto number = static_cast<int>(message.sequence);
      ASSERT_EQ(message.log_time_ns, 1000 + number);
      ASSERT_EQ(std::vector<std::uint8_t>(message.data.begin(), message.data.end()),
                DataOf(number));
    }
    ASSERT_TRUE(reader.damaged() || !reader.complete()) << "whole, with another bit at " << at;
    if (read < kChunks * kPerChunk) {
      ++damaged;
      EXPECT_THAT(reader.problems(), testing::Not(IsEmpty())) << at;
    }
  }
  EXPECT_GT(damaged, 1000);
}

TEST_F(McapReaderTest, GoesOnBehindABrokenChunkAndNamesIt) {
  bytes_[ends_[0] + 100] ^= 1;  // within the second chunk
  Reader reader(bytes_, "a");
  EXPECT_THAT(Read(reader), SizeIs((kChunks - 1) * kPerChunk));
  ASSERT_THAT(reader.problems(), SizeIs(2)) << "the chunk, and the file as a whole";
  EXPECT_THAT(reader.problems()[0], HasSubstr(std::to_string(ends_[0])));
  EXPECT_TRUE(reader.complete());
}

TEST_F(McapReaderTest, GoesOnFromAnyChunkAndTellsNothingTwice) {
  // The second of three chunks is broken.
  std::vector<std::uint8_t> bytes = bytes_;
  bytes[(ends_[0] + ends_[1]) / 2] ^= 1;
  Reader reader(bytes, "a");
  std::vector<std::pair<std::size_t, int>> places;  // and the number of the first message there
  Message message;
  while (reader.Next(message)) {
    if (places.empty() || places.back().first != reader.offset()) {
      places.emplace_back(reader.offset(), static_cast<int>(message.sequence));
    }
  }
  ASSERT_THAT(places, SizeIs(2));
  const std::vector<std::string> problems = reader.problems();
  EXPECT_THAT(problems, SizeIs(2)) << "the chunk, and the file as a whole";
  places.emplace_back(kMagicSize, 0);
  for (const auto& [offset, first] : {places[1], places[0], places[2], places[1]}) {
    reader.GoTo(offset);
    const std::vector<int> numbers = Read(reader);
    ASSERT_THAT(numbers, testing::Not(IsEmpty()));
    EXPECT_EQ(numbers.front(), first);
    EXPECT_EQ(numbers.back(), kChunks * kPerChunk - 1);
    EXPECT_TRUE(reader.complete());
    EXPECT_EQ(reader.problems(), problems);
    EXPECT_THAT(reader.metadata(), SizeIs(1));
  }
  // Also from within a chunk, before its end was reached.
  reader.GoTo(places[0].first);
  ASSERT_TRUE(reader.Next(message));
  reader.GoTo(places[1].first);
  EXPECT_THAT(Read(reader), SizeIs(kPerChunk));
}

TEST_F(McapReaderTest, ReadsNoFurtherWhereAnIdStandsForSomethingElse) {
  // A channel record of id 1 for another topic, between the second chunk and the third.
  std::vector<std::uint8_t> record = {kChannel, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 1, 0};
  for (const std::string text : {"other", "cdr"}) {
    record.insert(record.end(), {static_cast<std::uint8_t>(text.size()), 0, 0, 0});
    record.insert(record.end(), text.begin(), text.end());
  }
  record.insert(record.end(), {0, 0, 0, 0});
  record[1] = static_cast<std::uint8_t>(record.size() - kRecordHead);
  // Inserted after the second chunk's index, where the third begins, so that records stay whole.
  Reader places(bytes_, "a");
  Message message;
  std::vector<std::size_t> chunks;
  while (places.Next(message)) {
    if (chunks.empty() || chunks.back() != places.offset()) chunks.push_back(places.offset());
  }
  ASSERT_THAT(chunks, SizeIs(kChunks));
  bytes_.insert(bytes_.begin() + static_cast<std::ptrdiff_t>(chunks[2]), record.begin(),
                record.end());
  Reader reader(bytes_, "a");
  EXPECT_THAT(Read(reader), SizeIs(2 * kPerChunk));
  EXPECT_FALSE(reader.complete());
  EXPECT_TRUE(reader.damaged());
  ASSERT_THAT(reader.problems(), SizeIs(1));
  EXPECT_THAT(reader.problems()[0], HasSubstr("channel 1 is declared twice, as 'topic'"));
  EXPECT_THAT(reader.problems()[0], HasSubstr("'other'"));
}

TEST_F(McapReaderTest, LeavesOutNamesThatAreTooLongToBeAny) {
  const std::string name(kMostText + 1, 'x');
  {
    Writer writer(file_, "test", true);
    writer.AddSchema("palpate::X", "omgidl", "struct X {};");
    writer.Write(writer.AddChannel(1, name, "cdr"), 0, 0, 0, DataOf(0));
    writer.WriteMetadata({name, {}});
    writer.WriteMetadata({"notes", {{"key", name}}});  // our own writer cuts it
    writer.Close();
  }
  bytes_ = test::BytesOf(file_);
  Reader reader(bytes_, "a");
  Message message;
  EXPECT_FALSE(reader.Next(message));
  EXPECT_TRUE(reader.damaged());
  ASSERT_THAT(reader.problems(), SizeIs(3));
  EXPECT_THAT(reader.problems()[1], HasSubstr("has a name of more than 4096 bytes: left out"));
  ASSERT_THAT(reader.metadata(), SizeIs(1));
  EXPECT_THAT(reader.metadata()[0].values.at("key"), SizeIs(kMostText));
  for (const std::string& problem : reader.problems()) EXPECT_LT(problem.size(), 200u);
}

TEST_F(McapReaderTest, GivesNoTimeThatASumCouldOverflow) {
  Writer writer(file_, "test", true);
  writer.AddSchema("palpate::X", "omgidl", "struct X {};");
  writer.AddChannel(1, "topic", "cdr");
  const std::int64_t times[] = {-1, std::numeric_limits<std::int64_t>::min(), 7};
  for (const std::int64_t time_ns : times) writer.Write(1, 0, time_ns, time_ns, DataOf(0));
  writer.Close();
  bytes_ = test::BytesOf(file_);
  Reader reader(bytes_, "a");
  Message message;
  for (const std::int64_t time_ns : times) {
    ASSERT_TRUE(reader.Next(message));
    const std::int64_t latest = std::numeric_limits<std::int64_t>::max() / 2;
    EXPECT_EQ(message.log_time_ns, time_ns < 0 ? latest : time_ns);
    EXPECT_EQ(message.publish_time_ns, message.log_time_ns);
  }
}

TEST_F(McapReaderTest, RefusesWhatIsNoSuchFile) {
  const std::vector<std::uint8_t> text = {'h', 'e', 'l', 'l', 'o', '!', '!', '!', '!'};
  EXPECT_THROW(Reader(text, "a"), Error);
  EXPECT_THROW(MappedFile(folder_ / "none.mcap"), Error);
  ASSERT_EQ(mkfifo((folder_ / "pipe.mcap").c_str(), 0600), 0);
  EXPECT_THROW(MappedFile(folder_ / "pipe.mcap"), Error) << "nobody writes to it";
}

}  // namespace
}  // namespace palpate::mcap
