#include "common/files/whole_file.h"

#include <cstring>
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "common/error.h"
#include "tests/support/complaint.h"
#include "tests/support/folder.h"

namespace palpate {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

class WholeFile : public testing::Test {
 protected:
  std::string Write(const std::string& text) {
    std::ofstream(file_, std::ios::binary) << text;
    return file_;
  }
  static std::string Complaint(const std::string& file, std::uint64_t most = 1 << 20) {
    return test::ComplaintOf([&] { ReadWholeFile(file, most, "--file"); });
  }

  const test::Folder place_;
  const std::string folder_ = place_.path(), file_ = folder_ + "/file";
};

TEST_F(WholeFile, IsReadToItsLastByte) {
  std::string text;
  for (int i = 0; i < 300'000; ++i) text += static_cast<char>(i * 7);
  EXPECT_EQ(ReadWholeFile(Write(text), 1 << 20), text);
  EXPECT_EQ(ReadWholeFile(Write(""), 0), "");
}

TEST_F(WholeFile, MayHoldAsMuchAsItsLimitAndNotAByteMore) {
  EXPECT_EQ(Complaint(Write(std::string(1024, 'x')), 1024), "no complaint");
  EXPECT_EQ(Complaint(Write(std::string(1025, 'x')), 1024),
            "--file " + file_ +
                ": holds more than 1 KiB, the limit for such a file; check that it is the right "
                "one, or make it smaller");
  EXPECT_THAT(Complaint(file_, 1000), HasSubstr("more than 1000 bytes"));
}

TEST_F(WholeFile, TakesNoMemoryForASparseFileBeyondTheLimit) {
  Write("x");
  std::filesystem::resize_file(file_, std::uintmax_t{1} << 40);
  EXPECT_THAT(Complaint(file_, std::uint64_t{1} << 30), HasSubstr("holds more than 1 GiB"));
}

TEST_F(WholeFile, OfTheKernelIsReadThoughItTellsNoSize) {
  EXPECT_THAT(ReadWholeFile("/proc/self/status", 1 << 20), HasSubstr("VmRSS"));
  EXPECT_THAT(Complaint("/proc/self/status", 16), HasSubstr("holds more than 16 bytes"))
      << "the limit holds where the size is not known before";
}

TEST_F(WholeFile, IsNoFolderNoPipeNoSocketAndNoDeviceAndIsNotWaitedFor) {
  EXPECT_EQ(Complaint(folder_),
            "--file " + folder_ + ": is a folder; give the name of a regular file");
  ASSERT_EQ(mkfifo(file_.c_str(), 0600), 0);
  EXPECT_THAT(Complaint(file_), HasSubstr(": is a pipe; give"));
  std::filesystem::remove(file_);

  const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  ASSERT_LT(file_.size(), sizeof address.sun_path);
  std::memcpy(address.sun_path, file_.c_str(), file_.size());
  ASSERT_EQ(bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  EXPECT_THAT(Complaint(file_), HasSubstr(": is a socket; give"));
  close(fd);
  EXPECT_THAT(Complaint("/dev/zero"), HasSubstr(": is a device; give"));
}

TEST_F(WholeFile, SaysWhyItCannotBeRead) {
  EXPECT_THAT(Complaint("/nowhere/file"), AllOf(StartsWith("--file /nowhere/file: No such file"),
                                                HasSubstr("check the name and the rights")));
  // Opens, but cannot be read: nothing is mapped at address 0 of this process.
  EXPECT_THAT(Complaint("/proc/self/mem"), HasSubstr("Input/output error"));
  EXPECT_EQ(TryReadWholeFile("/nowhere/file", 10), std::nullopt);
  EXPECT_EQ(TryReadWholeFile(Write("text"), 10), "text");
}

TEST_F(WholeFile, BelowAFolderIsReachedByNoLink) {
  namespace fs = std::filesystem;
  fs::create_directories(folder_ + "/kept/a/b");
  const std::string kept = folder_ + "/kept", within = kept + "/a/b/file";
  std::ofstream(within) << "text";
  const auto complaint = [&](const std::string& file) {
    return test::ComplaintOf([&] { ReadFileBelow(kept, file, 10); });
  };
  EXPECT_EQ(ReadFileBelow(kept, within, 10), "text");
  EXPECT_EQ(ReadFileBelow(kept + "/", within, 10), "text");
  EXPECT_THAT(complaint(kept + "/a/b/none"), HasSubstr("No such file"));
  EXPECT_THAT(complaint(kept + "/a/b"), HasSubstr("is a folder"));
  EXPECT_THAT(complaint(Write("outside")), HasSubstr("is not below"));
  EXPECT_THAT(complaint(kept + "/a/../../file"), HasSubstr("is not below"));
  fs::create_symlink(file_, kept + "/a/b/link");
  fs::create_directory_symlink(kept + "/a", kept + "/c");
  for (const char* link : {"/a/b/link", "/c/b/file"}) {
    EXPECT_EQ(ReadWholeFile(kept + link, 10).size() > 0, true);
    EXPECT_THAT(complaint(kept + link), HasSubstr("is a link")) << link;
  }
  EXPECT_THROW(RefuseLinks(kept, kept + "/c/b"), Error);
  EXPECT_NO_THROW(RefuseLinks(kept, kept + "/a/b"));
  mkfifo((kept + "/pipe").c_str(), 0600);
  EXPECT_THAT(complaint(kept + "/pipe"), HasSubstr("is a pipe"));
  // The folder itself may be a link: its name is the user's.
  fs::create_directory_symlink(kept, folder_ + "/named");
  EXPECT_EQ(ReadFileBelow(folder_ + "/named", folder_ + "/named/a/b/file", 10), "text");
}

TEST_F(WholeFile, IsLookedAtBeforeItIsRead) {
  Write("text");
  chmod(file_.c_str(), 0640);
  const auto owner_alone = [](const struct stat& status) {
    if ((status.st_mode & 077) != 0) throw Error("others may read it");
  };
  EXPECT_THROW(ReadWholeFile(file_, 10, "", owner_alone), Error);
  chmod(file_.c_str(), 0600);
  EXPECT_EQ(ReadWholeFile(file_, 10, "", owner_alone), "text");
}

}  // namespace
}  // namespace palpate
