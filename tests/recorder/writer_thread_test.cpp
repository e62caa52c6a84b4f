#include "client/recorder/writer_thread.h"

#include <csignal>
#include <cstdio>
#include <fstream>

#include <gmock/gmock.h>
#include <sys/resource.h>
#include <unistd.h>

#include "client/recorder/file_summary.h"
#include "common/error.h"
#include "tests/common/recording/samples.h"
#include "tests/support/complaint.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;

void Put(SampleQueue& queue, TappedTopics& topics, std::uint64_t sequence) {
  std::vector<std::uint8_t> cdr;
  dds::ToCdr(SamplePose(sequence), cdr);
  const std::uint32_t number =
      topics.NumberOf(dds::PoseTopic("hand", 1), RecordedType::kHapticPose);
  EXPECT_TRUE(queue.Put(
      number, [&] { return static_cast<std::int64_t>(sequence); }, cdr));
}

TEST(WriterThread, WritesWhatComesAndWhatIsLeftAtTheEnd) {
  const Folder folder;
  SampleQueue queue(1 << 20);
  TappedTopics topics;
  RecordingWriter recording({.file = folder / "a.mcap"});
  WriterThread writer(recording, queue, topics);
  for (std::uint64_t i = 1; i <= 100; ++i) Put(queue, topics, i);
  writer.Finish("the test is over");
  EXPECT_FALSE(writer.failed());
  EXPECT_EQ(writer.totals().messages, 100u);
  EXPECT_TRUE(Summarise({folder / "a.mcap"}).whole());
}

TEST(WriterThread, TellsThatAWriteFailedAndClosesTheFile) {
  const Folder folder;
  std::signal(SIGXFSZ, SIG_IGN);
  SampleQueue queue(1 << 20);
  TappedTopics topics;
  RecordingWriter recording({.file = folder / "a.mcap"});
  for (std::uint64_t i = 1; i <= 100; ++i) {
    Add(recording, dds::PoseTopic("hand", 1), SamplePose(i), static_cast<std::int64_t>(i));
  }
  recording.Flush();
  rlimit former{}, limit{};
  getrlimit(RLIMIT_FSIZE, &former);
  limit = {recording.bytes() + 10, former.rlim_max};
  setrlimit(RLIMIT_FSIZE, &limit);
  WriterThread writer(recording, queue, topics);
  Put(queue, topics, 101);
  const std::string complaint = ComplaintOf([&] { writer.Finish("the test is over"); });
  EXPECT_THAT(complaint, HasSubstr("a.mcap: File too large"));
  EXPECT_THAT(complaint, HasSubstr("complete, without an index"));
  setrlimit(RLIMIT_FSIZE, &former);
  EXPECT_EQ(Summarise({folder / "a.mcap"}).messages, 100u);
}

std::size_t MemoryOfThisProcess() {
  std::size_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * static_cast<std::size_t>(getpagesize());
}

/// In a process of its own with limited memory, so that the queue's second buffer cannot be had.
void RunOutOfMemory(const std::string& file) {
  constexpr std::size_t kQueue = std::size_t{1} << 30;
  SampleQueue queue(kQueue);
  TappedTopics topics;
  RecordingWriter recording({.file = file});
  Add(recording, dds::PoseTopic("hand", 1), SamplePose(1), 1);
  const rlimit limit{MemoryOfThisProcess() + kQueue / 2, RLIM_INFINITY};
  setrlimit(RLIMIT_AS, &limit);
  WriterThread writer(recording, queue, topics);
  Put(queue, topics, 2);
  try {
    writer.Finish("the test is over");
  } catch (const Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    _exit(writer.failed() ? 1 : 3);
  }
  _exit(0);
}

TEST(WriterThreadDeathTest, TellsThatMemoryRanOutAndClosesTheFile) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "a sanitizer's shadow takes more than the limit";
#endif
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const std::string file = testing::TempDir() + "/palpate_out_of_memory.mcap";
  std::remove(file.c_str());
  EXPECT_EXIT(RunOutOfMemory(file), testing::ExitedWithCode(1),
              "no memory left to record with.*is complete, with its index");
  const FileSummary summary = Summarise({file});
  EXPECT_TRUE(summary.complete);
  EXPECT_EQ(summary.messages, 1u);
  EXPECT_EQ(summary.end_reason, "a write failed");
  std::remove(file.c_str());
}

using Bytes = std::vector<std::uint8_t>;

TEST(SampleQueue, GivesSamplesBackInTheirOrder) {
  SampleQueue queue(1000);
  std::int64_t time_ns = 5;
  const auto clock = [&] { return time_ns++; };
  EXPECT_TRUE(queue.Put(7, clock, Bytes{1, 2}, Bytes{3}));
  EXPECT_TRUE(queue.Put(8, clock, Bytes{}));
  Bytes drained;
  queue.Swap(drained);
  int count = 0;
  SampleQueue::ForEach(drained, [&](const SampleQueue::Head& head, auto bytes) {
    EXPECT_EQ(head.time_ns, 5 + count);
    EXPECT_EQ(head.channel, 7u + static_cast<unsigned>(count));
    EXPECT_EQ(Bytes(bytes.begin(), bytes.end()), count == 0 ? (Bytes{1, 2, 3}) : Bytes{});
    ++count;
  });
  EXPECT_EQ(count, 2);
  queue.Swap(drained);
  EXPECT_TRUE(drained.empty());
}

TEST(SampleQueue, RefusesWhatHasNoRoomAndTakesMoreOnceItIsEmptied) {
  SampleQueue queue(3 * (sizeof(SampleQueue::Head) + 10));
  const auto clock = [] { return std::int64_t{0}; };
  const Bytes sample(10);
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(queue.Put(0, clock, sample));
  EXPECT_FALSE(queue.Put(0, clock, sample));
  Bytes drained;
  queue.Swap(drained);
  EXPECT_TRUE(queue.Put(0, clock, sample));
}

TEST(SampleQueue, LosesNothingBetweenThreads) {
  SampleQueue queue(std::size_t{1} << 24);
  constexpr int kEach = 20000;
  std::int64_t ticks = 0;
  const auto produce = [&](std::uint32_t channel) {
    for (std::uint32_t i = 0; i < kEach; ++i) {
      const auto* bytes = reinterpret_cast<const std::uint8_t*>(&i);
      ASSERT_TRUE(queue.Put(channel, [&] { return ++ticks; }, {bytes, sizeof i}));
    }
  };
  std::thread a(produce, 0u), b(produce, 1u);
  std::uint32_t next[2] = {0, 0};
  std::int64_t time_ns = 0;
  Bytes drained;
  while (next[0] + next[1] < 2 * kEach) {
    queue.Swap(drained);
    SampleQueue::ForEach(drained, [&](const SampleQueue::Head& head, auto bytes) {
      std::uint32_t value;
      ASSERT_EQ(bytes.size(), sizeof value);
      std::memcpy(&value, bytes.data(), sizeof value);
      EXPECT_EQ(value, next[head.channel]++);
      EXPECT_EQ(head.time_ns, ++time_ns);
    });
  }
  a.join();
  b.join();
}

}  // namespace
}  // namespace palpate::test
