#include "common/mcap/mcap_writer.h"

#include <csignal>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <unistd.h>

#include "common/error.h"
#include "common/mcap/mcap_reader.h"
#include "tests/common/recording/samples.h"
#include "tests/support/complaint.h"
#include "tests/support/random.h"

// tests/recorder shows with others' readers that the files are MCAP.
namespace palpate::mcap {
namespace {

using testing::HasSubstr;

std::size_t MessagesIn(const std::string& file, bool& complete) {
  const MappedFile mapped(file);
  Reader reader(mapped.bytes(), file);
  Message message;
  std::size_t count = 0;
  while (reader.Next(message)) ++count;
  complete = reader.complete();
  return count;
}

/// Lets no file of this process grow beyond `bytes`, like a full disk.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) {
    std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &former_);
    rlimit limit = former_;
    limit.rlim_cur = bytes;
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FullDisk() { setrlimit(RLIMIT_FSIZE, &former_); }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

 private:
  rlimit former_{};
};

TEST(McapWriter, LeavesWholeWhatWasFlushedThoughItNeverCloses) {
  const test::Folder folder;
  Writer writer(folder / "a.mcap", "test");
  const std::uint16_t channel = writer.AddChannel(writer.AddSchema("X", "omgidl", ""), "t", "cdr");
  const std::vector<std::uint8_t> data(100, 1);
  bool complete = true;
  for (std::uint32_t i = 0; i < 10; ++i) {
    writer.Write(channel, i, i, i, data);
    EXPECT_EQ(MessagesIn(folder / "a.mcap", complete), i);
    EXPECT_FALSE(complete);
    writer.Flush();
    EXPECT_EQ(MessagesIn(folder / "a.mcap", complete), i + 1);
  }
}

TEST(McapWriter, LocksItsFileUntilItIsClosed) {
  const test::Folder folder;
  Writer writer(folder / "a.mcap", "test");
  const int fd = open((folder / "a.mcap").c_str(), O_RDONLY | O_CLOEXEC);
  EXPECT_NE(flock(fd, LOCK_SH | LOCK_NB), 0) << "it still grows";
  writer.Close();
  EXPECT_EQ(flock(fd, LOCK_SH | LOCK_NB), 0);
  close(fd);
}

TEST(McapWriter, TakesAFailedWriteBackWhereverTheDiskIsFull) {
  const test::Folder folder;
  test::Random random(1);
  for (rlim_t limit = 200; limit < 9000; limit += 97) {
    const std::string file = folder / std::to_string(limit);
    std::uint32_t flushed = 0;
    std::string said;
    try {
      const FullDisk disk(limit);
      Writer writer(file, "test");
      const std::uint16_t channel =
          writer.AddChannel(writer.AddSchema("X", "omgidl", ""), "t", "cdr");
      for (std::uint32_t i = 0; i < 100; ++i) {
        std::vector<std::uint8_t> noise(100);
        for (std::uint8_t& byte : noise) byte = static_cast<std::uint8_t>(random.Bits());
        writer.Write(channel, i, i, i, noise);
        writer.Flush();
        flushed = i + 1;
      }
      writer.Close();
    } catch (const Error& error) {
      said = error.what();
    }
    EXPECT_THAT(said, HasSubstr(file));
    EXPECT_THAT(said, HasSubstr("File too large")) << "the system's reason";
    bool complete = false;
    EXPECT_EQ(MessagesIn(file, complete), flushed);
  }
}

TEST(McapWriter, ClosesWithWhatFitsWhereTheDiskIsFull) {
  const test::Folder folder;
  const std::string file = folder / "a.mcap";
  test::Random random(1);
  std::uint32_t flushed = 0;
  {
    const FullDisk disk(100'000);
    Writer writer(file, "test");
    const std::uint16_t channel =
        writer.AddChannel(writer.AddSchema("X", "omgidl", ""), "t", "cdr");
    try {
      for (std::uint32_t i = 0;; ++i) {
        std::vector<std::uint8_t> noise(20'000);
        for (std::uint8_t& byte : noise) byte = static_cast<std::uint8_t>(random.Bits());
        writer.Write(channel, i, i, i, noise);
        writer.Flush();
        flushed = i + 1;
      }
    } catch (const Error&) {
      writer.Close();  // the index is small
    }
  }
  bool complete = false;
  EXPECT_EQ(MessagesIn(file, complete), flushed);
  EXPECT_TRUE(complete);
  EXPECT_GT(flushed, 2u);
}

TEST(McapWriter, SaysWhyADeviceTakesNothing) {
  EXPECT_THAT(test::ComplaintOf([] { Writer writer("/dev/full", "test", true); }),
              HasSubstr("/dev/full: No space left on device"));
}

TEST(McapWriter, LeavesAFileThatIsThereUnlessToldOtherwise) {
  const test::Folder folder;
  const std::string file = folder / "a.mcap";
  test::WriteBytes(file, {1, 2, 3});
  EXPECT_THROW(Writer(file, "test"), Error);
  EXPECT_EQ(test::BytesOf(file).size(), 3u);
  Writer(file, "test", true).Close();
  EXPECT_GT(test::BytesOf(file).size(), 3u);
}

}  // namespace
}  // namespace palpate::mcap
