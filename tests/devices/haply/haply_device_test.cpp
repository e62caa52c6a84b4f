#include "devices/haply/haply_device.h"

#include <cmath>
#include <cstdlib>
#include <set>

#include <gmock/gmock.h>

#include "devices/haply/inverse_message.h"
#include "tests/devices/haply/haply_bench.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/complaint.h"
#include "tests/support/eventually.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;
using namespace haply;  // NOLINT: a test of its messages and lies

class Haply : public testing::Test {
 protected:
  std::string OpeningError(const std::string& id = "") {
    return ComplaintOf([&] { HaplyDevice device(OptionsOf(service, id)); });
  }
  FakeInverseService service;
};

class HaplyWithForce : public Haply {
 protected:
  void SetUp() override { ASSERT_TRUE(bench.UntilForce()); }
  /// The force that is sent goes to zero, and once `mend` has run comes back by a ramp.
  void ExpectGoneAndBack(const std::function<void()>& mend) {
    EXPECT_TRUE(bench.Until([&] { return bench.arm.sent_force().isZero(0.0); }));
    EXPECT_NE(bench.sample.status & kDeviceFault, 0u);
    mend();
    double last = 0.0;
    bool steps = false;
    EXPECT_TRUE(bench.Until([&] {
      const double now = bench.arm.sent_force().norm();
      steps = steps || now > last + 0.2;
      last = now;
      return now > 0.9;
    }));
    // The limiter's ramp takes 200 ms, of which a late tick counts for at most 2 ms.
    EXPECT_FALSE(steps);
  }
  HaplyBench bench{service};
};

TEST_F(Haply, IsBoundedWithoutTorqueByTheTypeThatTheServiceNames) {
  const HaplyDevice arm(OptionsOf(service));
  EXPECT_EQ(arm.info().model, "Haply inverse3 (049D)");
  EXPECT_EQ(arm.info().torque_axes, 0);
  EXPECT_LE(arm.info().continuous_force_N, arm.info().max_force_N);
}

TEST_F(Haply, GivesPoseAndButtonsInWAboutTheMiddleOfItsReach) {
  service.SetPosition({0.01, -0.12 - 0.02, 0.15 + 0.03});
  service.SetOrientation({0.6, 0.0, 0.0, 0.8});
  service.buttons = 5;
  HaplyBench bench(service);
  ASSERT_TRUE(bench.Until([&] { return bench.sample.buttons == 5u; }));
  EXPECT_TRUE(bench.sample.X_WH.p.isApprox(Vec3(0.01, 0.03, 0.02), 1e-9));
  EXPECT_NEAR(std::abs(bench.sample.X_WH.q.dot(Quat(0.6, 0.0, 0.8, 0.0))), 1.0, 1e-9);
}

TEST_F(HaplyWithForce, SendsTheForceAsTheServiceHasItAndSaysWhoItIs) {
  EXPECT_TRUE(bench.Until([&] { return service.force()[2] > 0.9; })) << "up is the service's z";
  EXPECT_EQ(service.force()[0], 0.0);
  EXPECT_THAT(service.first_command(), HasSubstr(R"("profile":{"name":"palpate"})"));
  EXPECT_THAT(bench.news, HasSubstr("the device is ready"));
}

TEST_F(HaplyWithForce, KeepsNoForceWhereTheStationNoLongerTicks) {
  EXPECT_TRUE(Eventually([&] { return service.force() == std::array<double, 3>{}; }));
}

TEST_F(HaplyWithForce, LosesItsForceWithItsServiceAndFindsBothAgain) {
  service.Die();
  ExpectGoneAndBack([&] {
    EXPECT_TRUE(bench.UntilNews("the Inverse Service has gone"));
    EXPECT_TRUE(bench.Until([&] { return std::string(bench.arm.activity()) == "service gone"; }));
    EXPECT_THAT(bench.news, HasSubstr("journalctl -u haply-inverse-service"));
    service.ComeBack();
  });
  EXPECT_TRUE(bench.UntilNews("the Inverse Service is back"));
}

TEST_F(HaplyWithForce, LosesItsForceWhereTheServiceStallsAndSendsNoOldOneAfterwards) {
  service.stalls = true;
  ExpectGoneAndBack([&] {
    EXPECT_TRUE(bench.UntilNews("does not answer in time"));
    const std::uint64_t before = service.commands;
    service.stalls = false;
    // One force may have been on its way.  The next is zero, which is what is asked for now.
    EXPECT_TRUE(bench.Until([&] { return service.commands >= before + 2; }));
    EXPECT_EQ(service.force(), (std::array<double, 3>{}));
  });
}

TEST_F(HaplyWithForce, LosesItsForceWhereRepliesComeTooLate) {
  service.delay_ms = 60;
  ExpectGoneAndBack([&] { service.delay_ms = 0; });
}

TEST_F(HaplyWithForce, LosesItsForceWithEachLieAndHoldsItsPose) {
  const Vec3 held = bench.sample.X_WH.p;
  for (const char* lie :
       {"no JSON", "{}", R"({"inverse3":"no array"})",
        R"({"inverse3":[{"device_id":"other","state":{}}]})",
        R"({"inverse3":[{"device_id":"049D","state":{"cursor_position":{"x":1e300}}}]})"}) {
    SCOPED_TRACE(lie);
    service.Lie(lie);
    ExpectGoneAndBack([&] {
      EXPECT_EQ(bench.sample.X_WH.p, held);
      service.Lie("");
    });
  }
  EXPECT_THAT(bench.news, HasSubstr("has lost the device: check its USB cable"));
}

TEST_F(HaplyWithForce, LosesItsForceWithItsGripItsCalibrationAndByAJump) {
  service.grip_there = false;
  ExpectGoneAndBack([&] {
    EXPECT_TRUE(bench.UntilNews("the VerseGrip has gone"));
    service.grip_there = true;
  });
  service.calibrated = false;
  ExpectGoneAndBack([&] {
    EXPECT_TRUE(bench.UntilNews("put the grip on its inkwell"));
    service.calibrated = true;
  });
  service.SetPosition({0.1, -0.12, 0.15});
  ExpectGoneAndBack([] {});
}

TEST_F(Haply, SaysWhatToDoWhereThereIsNoServiceOrNoDevice) {
  EXPECT_THAT(OpeningError("1234"), HasSubstr("has no device '1234'"));
  service.LieFirst("hello");
  EXPECT_THAT(OpeningError(), HasSubstr("the answer is not from an Inverse Service"));
  service.Die();
  EXPECT_THAT(OpeningError(), HasSubstr("no Inverse Service at ws://127.0.0.1:"));
  EXPECT_THAT(OpeningError(), HasSubstr("PALPATE_HAPLY_SERVICE"));
}

TEST_F(Haply, TakesItsServicesAddressFromTheEnvironment) {
  unsetenv(haply::kServiceVariable);
  EXPECT_EQ(haply::ServiceAddress().port, "10001");
  setenv(haply::kServiceVariable, "ws://arm.lab:8500/", 1);
  EXPECT_EQ(haply::ServiceAddress().host, "arm.lab");
  EXPECT_EQ(haply::ServiceAddress().port, "8500");
  for (const char* bad : {"arm.lab", "ws://:1", "ws://arm:", "ws://arm:x"}) {
    setenv(haply::kServiceVariable, bad, 1);
    EXPECT_THROW(haply::ServiceAddress(), UsageError) << bad;
  }
  unsetenv(haply::kServiceVariable);
}

TEST_F(Haply, AsksForNoMemoryInATick) {
  if (!kCountsAllocations) GTEST_SKIP();
  HaplyDevice arm(OptionsOf(service));
  StationCore core(arm);
  core.Act(SteadyNanoseconds());
  const std::uint64_t before = AllocationsOfThisThread();
  for (int i = 0; i < 100; ++i) {
    core.Sense(SteadyNanoseconds(), true);
    core.Act(SteadyNanoseconds());
  }
  EXPECT_EQ(AllocationsOfThisThread(), before);
}

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
  EXPECT_EQ(reading.p == Vec3(9.0, 9.0, 9.0), lie != Lie::kNone) << "a lie changes nothing";
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
    return ComplaintOf([&] { ParseInventory(text, wanted); });
  };
  EXPECT_THAT(complaint("", ""), HasSubstr("the answer is not from an Inverse Service"));
  EXPECT_THAT(complaint("[1]", ""), HasSubstr("the answer is not from an Inverse Service"));
  for (const char* none : {"{}", R"({"inverse3":[]})", R"({"inverse3":7})", R"({"inverse3":[7]})",
                           R"({"inverse3":[{"device_id":7}]})"}) {
    EXPECT_THAT(complaint(none, ""), HasSubstr("has no device; plug it in")) << none;
  }
  EXPECT_THAT(complaint(kFirst, "C3"), HasSubstr("has no device 'C3'"));
}

TEST(InverseMessage, TurnsTheServicesFrameIntoTheProjects) {
  Reading reading;
  // A quarter turn about the service's z, which points up.
  const std::string q = R"({"w":0.7071068,"x":0,"y":0,"z":0.7071068})";
  ASSERT_EQ(ParseReply(Reply(kP, kV, q), ParseInventory(kFirst, ""), reading), Lie::kNone);
  EXPECT_TRUE(reading.p.isApprox(Vec3(0.1, 0.3, -0.2))) << "right, up, to the user";
  EXPECT_TRUE(reading.v.isApprox(Vec3(1.0, 3.0, -2.0)));
  const Quat about_up(Eigen::AngleAxisd(0.5 * M_PI, Vec3::UnitY()));
  EXPECT_NEAR(std::abs(reading.q.dot(about_up)), 1.0, 1e-6);
  EXPECT_EQ(reading.buttons, 1u);
  // A force in W goes back into the service's frame.
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
}  // namespace palpate::test
