#include "common/files/output.h"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <gmock/gmock.h>

#include "tests/support/complaint.h"
#include "tests/support/folder.h"
#include "tests/support/read_file.h"

namespace palpate {
namespace {

using test::ComplaintOf;
using testing::HasSubstr;
namespace fs = std::filesystem;

class Output : public testing::Test {
 protected:
  const test::Folder folder_;
  const std::string file_ = folder_ / "output";
};

TEST_F(Output, GoesToTheFileInPlaceOfWhatWasThere) {
  WriteOutput("--json", file_, "something long\n");
  WriteOutput("--json", file_, "{}\n");
  EXPECT_EQ(ReadWholeFile(file_), "{}\n");
}

TEST_F(Output, IsWholeForWhoReadsItMeanwhile) {
  WriteOutput("--json", file_, "the former\n");
  std::ifstream reader(file_);
  WriteOutput("--json", file_, "{}\n");
  std::string read;
  std::getline(reader, read);
  EXPECT_EQ(read, "the former");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_.path()), fs::directory_iterator()), 1);
}

TEST_F(Output, GoesToWhereALinkLeads) {
  fs::create_symlink(file_, folder_ / "link");
  WriteOutput("--json", folder_ / "link", "{}\n");
  EXPECT_EQ(ReadWholeFile(file_), "{}\n");
  EXPECT_TRUE(fs::is_symlink(folder_ / "link"));
}

TEST_F(Output, ReplacesALinkInAFolderThatAProgramKeeps) {
  std::ofstream(file_) << "another's";
  fs::create_symlink(file_, folder_ / "link");
  WriteOutput("--out", folder_ / "link", "{}\n", Links::kReplace);
  EXPECT_EQ(ReadWholeFile(file_), "another's");
  EXPECT_FALSE(fs::is_symlink(folder_ / "link"));
  EXPECT_EQ(ReadWholeFile(folder_ / "link"), "{}\n");
}

TEST_F(Output, GoesToStandardOutputForADash) {
  testing::internal::CaptureStdout();
  WriteOutput("--json", "-", "{}\n");
  CheckOutput("--json", "-");
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "{}\n");
  EXPECT_FALSE(fs::exists("-"));
}

TEST_F(Output, NamesTheOptionTheFileAndTheReasonBothBeforeAndAfterTheWork) {
  for (const auto& complaint :
       {ComplaintOf([] { CheckOutput("--report", "/nowhere/a.md"); }),
        ComplaintOf([] { WriteOutput("--report", "/nowhere/a.md", "text"); })}) {
    EXPECT_THAT(complaint, HasSubstr("--report /nowhere/a.md: cannot be written (No such file"));
    EXPECT_THAT(complaint, HasSubstr("folder"));
  }
}

TEST_F(Output, SaysWhereTheDiskIsFull) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full";
  EXPECT_THAT(ComplaintOf([] { WriteOutput("--json", "/dev/full", "text"); }),
              HasSubstr("No space left"));
}

TEST_F(Output, KeepsWhatAFileHoldsUntilThereIsMore) {
  WriteOutput("--json", file_, "of the last run\n");
  CheckOutput("--json", file_);
  EXPECT_EQ(ReadWholeFile(file_), "of the last run\n");
}

}  // namespace
}  // namespace palpate
