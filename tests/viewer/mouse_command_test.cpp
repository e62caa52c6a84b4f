#include "client/viewer/mouse_command.h"

#include <gtest/gtest.h>

#include "common/error.h"
#include "devices/mouse/mouse_device.h"
#include "tests/support/random.h"

namespace palpate {
namespace {

using Op = MouseCommand::Op;
using test::Random;

TEST(MouseCommand, TakesDragsReleasesAndMakesWhole) {
  const MouseCommand take = ParseMouseCommand(R"({"op":"take","scene":"cube","tool":"ball"})");
  EXPECT_EQ(take.op, Op::kTake);
  EXPECT_EQ(take.scene, "cube");
  EXPECT_EQ(take.tool, "ball");
  EXPECT_EQ(ParseMouseCommand(R"({"op":"take","scene":"cube"})").tool, "");
  const MouseCommand pose = ParseMouseCommand(R"({"op":"pose","p":[0.1,-2,3e-3],"q":[1,0,0.5,0]})");
  EXPECT_EQ(pose.op, Op::kPose);
  EXPECT_EQ(pose.X_WT.p, Vec3(0.1, -2, 0.003));
  EXPECT_EQ(pose.X_WT.q.y(), 0.5);
  EXPECT_EQ(ParseMouseCommand(R"({"op":"release"})").op, Op::kRelease);
  const MouseCommand whole = ParseMouseCommand(R"({"op":"whole","scene":"calculus"})");
  EXPECT_EQ(whole.op, Op::kWhole);
  EXPECT_EQ(whole.scene, "calculus");
}

TEST(MouseCommand, IsRefusedWhereItIsNone) {
  for (const char* text :
       {"", "{", "[]", "{}", R"({"op":"jump"})", R"({"op":"take"})", R"({"op":"whole"})",
        R"({"op":"take","scene":3})", R"({"op":"take","scene":""})", R"({"op":"pose"})",
        R"({"op":"pose","p":[1,2],"q":[1,0,0,0]})", R"({"op":"pose","p":[1,2,"3"],"q":[1,0,0,0]})",
        R"({"op":"pose","p":[1,2,null],"q":[1,0,0,0]})",
        R"({"op":"pose","p":[1,2,1e999],"q":[1,0,0,0]})",
        R"({"op":"pose","p":[1,2,3],"q":[1,0,0]})"}) {
    EXPECT_THROW(ParseMouseCommand(text), Error) << text;
  }
  const std::string most(64, 'x');
  EXPECT_EQ(ParseMouseCommand(R"({"op":"take","scene":")" + most + R"("})").scene, most);
  EXPECT_THROW(ParseMouseCommand(R"({"op":"take","scene":")" + most + R"(x"})"), Error);
  EXPECT_THROW(ParseMouseCommand(R"({"op":"take","scene":"cube","tool":")" + most + R"(x"})"),
               Error);
}

TEST(MouseCommand, ReachesTheDeviceToTheBit) {
  Random random(8);
  for (int i = 0; i < 10'000; ++i) {
    const Vec3 p = random.InCube(1.0) * (i % 2 == 0 ? 1.0 : 1e-9);
    const Vec3 a = random.InCube(1.0);
    const Pose X{p, Quat(1.0, a.x(), a.y(), a.z())};
    std::string line = ToMouseLine(X);
    ASSERT_EQ(line.back(), '\n');
    line.pop_back();
    std::string complaint;
    const auto read = ParseMouseLine(line, complaint);
    ASSERT_TRUE(read && read->X_WT) << line << complaint;
    ASSERT_EQ(read->X_WT->p, p);
    ASSERT_LT((read->X_WT->q.coeffs() - X.q.normalized().coeffs()).norm(), 1e-15);
  }
}

}  // namespace
}  // namespace palpate
