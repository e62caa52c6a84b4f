#include "client/replayer/steps/record_steps.h"

#include <fstream>

#include <gmock/gmock.h>

#include "client/replayer/verify/verify.h"
#include "tests/support/complaint.h"
#include "tests/support/folder.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;

void WriteFile(const std::string& file, const std::string& text) {
  std::ofstream(file) << text;
}

TEST(RecordSteps, ReadsRowsWithTitlesBlanksAndQuaternions) {
  const Folder folder;
  const std::string file = folder / "poses.csv";
  WriteFile(file, "x, y, z\r\n1,2,3\r\n\n 0.5 , 0, -1 \n0,0,0,0,1,0,0\n");
  const std::vector<Pose> poses = ReadPoses(file);
  ASSERT_EQ(poses.size(), 3u);
  EXPECT_EQ(poses[0].p, Vec3(1.0, 2.0, 3.0));
  EXPECT_EQ(poses[1].p, Vec3(0.5, 0.0, -1.0));
  EXPECT_EQ(poses[2].q.coeffs(), Quat(0.0, 1.0, 0.0, 0.0).coeffs());
}

TEST(RecordSteps, NamesTheLineThatIsNoPose) {
  const Folder folder;
  const std::string file = folder / "poses.csv";
  for (const char* row : {"1,2", "1,2,x", "1,2,3,4", "nan,0,0", "0,inf,0", "0,0,0,1,1,0,0"}) {
    WriteFile(file, std::string("0,0,0\n") + row + "\n");
    EXPECT_THAT(ComplaintOf([&] { ReadPoses(file); }), HasSubstr(file + ":2:")) << row;
  }
  for (const char* none : {"", "x,y,z\n"}) {
    WriteFile(file, none);
    EXPECT_THAT(ComplaintOf([&] { ReadPoses(file); }), HasSubstr(file)) << none;
  }
}

TEST(RecordSteps, WritesASessionThatVerifies) {
  const Folder folder;
  std::string rows;
  for (int i = 0; i < 300; ++i) rows += std::to_string(1e-5 * i) + ",0.0295,0\n";
  WriteFile(folder / "poses.csv", rows);
  const StepsOptions options{.poses = folder / "poses.csv",
                             .scene = "cube",
                             .tool = "",
                             .file = folder / "mine.mcap",
                             .models_dir = ""};
  RecordSteps(options);
  const Verification verification = Verify({options.file}, {});
  EXPECT_TRUE(verification.good()) << ToText(verification);
  ASSERT_EQ(verification.sessions.size(), 1u);
  EXPECT_EQ(verification.sessions[0].verified, 300u);
  EXPECT_THAT(ComplaintOf([&] { RecordSteps(options); }), HasSubstr("mine.mcap")) << "kept";
  StepsOptions other = options;
  other.tool = "chisel";
  EXPECT_THAT(ComplaintOf([&] { RecordSteps(other); }), HasSubstr("ball"));
}

}  // namespace
}  // namespace palpate::test
