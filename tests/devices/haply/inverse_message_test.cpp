#include "devices/haply/inverse_message.h"

#include <cmath>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/complaint.h"

namespace palpate::haply {
namespace {

using testing::HasSubstr;

const std::string kFirst =
    R"({"inverse3":[{"device_id":"A1","config":{"type":"inverse3x","preset":"arm_front_centered"}},)"
    R"({"device_id":"B2","config":{"type":"minverse"}}],"verse_grip":[{"device_id":"G"}]})";

std::string Reply(const std::string& p, const std::string& v, const std::string& q) {
  return R"({"inverse3":[{"device_id":"A1","state":{"cursor_position":)" + p +
         R"(,"cursor_velocity":)" + v + R"(},"status":{"calibrated":true}}],)" +
         R"("verse_grip":[{"device_id":"G","state":{"orientation":)" + q + R"(,"button":true}}]})";
}
const std::string kP = R"({"x":0.1,"y":0.2,"z":0.3})";
const std::string kV = R"({"x":1,"y":2,"z":3})";
const std::string kQ = R"({"w":1,"x":0,"y":0,"z":0})";

Lie LieOf(const std::string& text) {
  Reading reading;
  reading.p = Vec3(9.0, 9.0, 9.0);
  const Lie lie = ParseReply(text, ParseInventory(kFirst, ""), reading);
  if (lie != Lie::kNone) {
    EXPECT_EQ(reading.p, Vec3(9.0, 9.0, 9.0)) << "it is left alone";
  }
  return lie;
}

TEST(InverseMessage, FindsTheFirstDeviceOrTheOneThatIsNamedAndItsGrip) {
  const Inventory first = ParseInventory(kFirst, "");
  EXPECT_EQ(first.device_id, "A1");
  EXPECT_EQ(first.type, "inverse3x");
  EXPECT_TRUE(first.centred);
  EXPECT_EQ(first.grip_array, "verse_grip");
  EXPECT_EQ(first.grip_id, "G");
  const Inventory named = ParseInventory(kFirst, "B2");
  EXPECT_EQ(named.type, "minverse");
  EXPECT_FALSE(named.centred);
}

TEST(InverseMessage, RefusesAFirstMessageWithoutTheDeviceInWords) {
  const auto complaint = [](const std::string& text, const std::string& wanted) {
    return test::ComplaintOf([&] { ParseInventory(text, wanted); });
  };
  EXPECT_THAT(complaint("", ""), HasSubstr("does not speak as the Inverse Service"));
  EXPECT_THAT(complaint("[1]", ""), HasSubstr("does not speak as the Inverse Service"));
  for (const char* none : {"{}", R"({"inverse3":[]})", R"({"inverse3":7})", R"({"inverse3":[7]})",
                           R"({"inverse3":[{"device_id":7}]})"}) {
    EXPECT_THAT(complaint(none, ""), HasSubstr("has no device; plug it in")) << none;
  }
  EXPECT_THAT(complaint(kFirst, "C3"), HasSubstr("has no device 'C3'"));
}

TEST(InverseMessage, TurnsTheServicesFrameIntoTheProjects) {
  Reading reading;
  // By a quarter about the service's z, up.
  const std::string q = R"({"w":0.7071068,"x":0,"y":0,"z":0.7071068})";
  ASSERT_EQ(ParseReply(Reply(kP, kV, q), ParseInventory(kFirst, ""), reading), Lie::kNone);
  EXPECT_TRUE(reading.p.isApprox(Vec3(0.1, 0.3, -0.2))) << "right, up, to the user";
  EXPECT_TRUE(reading.v.isApprox(Vec3(1.0, 3.0, -2.0)));
  const Quat about_up(Eigen::AngleAxisd(0.5 * M_PI, Vec3::UnitY()));
  EXPECT_NEAR(std::abs(reading.q.dot(about_up)), 1.0, 1e-6);
  EXPECT_EQ(reading.buttons, 1u);
  // And back: a force in W, as the service has it.
  const std::string message = ForceMessage(ParseInventory(kFirst, ""), Vec3(1.0, 2.0, 3.0));
  EXPECT_THAT(message, HasSubstr(R"("set_cursor_force":{"vector":{"x":1.0,"y":-3.0,"z":2.0}})"));
  EXPECT_THAT(message, HasSubstr(R"("device_id":"A1")"));
}

TEST(InverseMessage, FindsEachLie) {
  EXPECT_EQ(LieOf(Reply(kP, kV, kQ)), Lie::kNone);
  for (const char* text : {"", "{", "NaN", R"({"x":NaN})", "\xff\xfe", R"({"x":1e999})"}) {
    EXPECT_EQ(LieOf(text), Lie::kNotJson) << text;
  }
  for (const char* text :
       {"{}", "7", "[]", "null", R"({"inverse3":[]})", R"({"inverse3":[{"device_id":"A1"}]})",
        R"({"inverse3":[{"device_id":"other","state":{}}]})"}) {
    EXPECT_EQ(LieOf(text), Lie::kNoDevice) << text;
  }
  for (const std::string bad : {"null", "7", "{}", R"({"x":0,"y":0})", R"({"x":"0","y":0,"z":0})",
                                R"({"x":1e300,"y":0,"z":0})", R"({"x":0,"y":2,"z":0})",
                                R"({"x":0,"y":null,"z":0})", R"([0,0,0])"}) {
    EXPECT_EQ(LieOf(Reply(bad, kV, kQ)), Lie::kPosition) << bad;
  }
  EXPECT_EQ(LieOf(Reply(kP, R"({"x":0,"y":0,"z":99})", kQ)), Lie::kVelocity);
  EXPECT_EQ(LieOf(Reply(kP, "null", kQ)), Lie::kVelocity);
  for (const std::string bad : {"null", R"({"w":0,"x":0,"y":0,"z":0})",
                                R"({"w":2,"x":0,"y":0,"z":0})", R"({"w":1,"x":0,"y":0})"}) {
    EXPECT_EQ(LieOf(Reply(kP, kV, bad)), Lie::kOrientation) << bad;
  }
  const std::string without_grip = R"({"inverse3":[{"device_id":"A1","state":{"cursor_position":)" +
                                   kP + R"(,"cursor_velocity":)" + kV + "}}]}";
  EXPECT_EQ(LieOf(without_grip), Lie::kGrip);
}

TEST(InverseMessage, HasWordsForEachLie) {
  std::set<std::string> texts;
  for (const Lie lie : {Lie::kNotJson, Lie::kNoDevice, Lie::kPosition, Lie::kVelocity,
                        Lie::kOrientation, Lie::kGrip}) {
    EXPECT_TRUE(texts.insert(TextOf(lie)).second);
    EXPECT_THAT(TextOf(lie), HasSubstr(": ")) << "what, and what to do";
  }
}

}  // namespace
}  // namespace palpate::haply
