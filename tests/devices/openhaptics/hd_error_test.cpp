#include "devices/openhaptics/hd_error.h"

#include <set>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace palpate::hd {
namespace {

using testing::HasSubstr;

TEST(HdError, NamesEveryCodeOnceAndHasARemedyForIt) {
  std::set<Code> codes;
  std::set<std::string> names;
  for (const ErrorText& text : ErrorTexts()) {
    EXPECT_TRUE(codes.insert(text.code).second) << text.name;
    EXPECT_TRUE(names.insert(text.name).second) << text.name;
    EXPECT_GT(std::string(text.remedy).size(), 10u) << text.name;
    EXPECT_THAT(Describe({text.code, 7, 0}), HasSubstr(text.name));
    EXPECT_THAT(Describe({text.code, 7, 0}), HasSubstr(text.remedy));
  }
  EXPECT_EQ(codes.size(), 22u);
}

TEST(HdError, DropsContactForTooMuchForceAndLatchesForWhatIsBroken) {
  // The vendor's own helper leaves the impulse out of the force errors.
  for (const Code code :
       {kExceededMaxForce, kExceededMaxForceImpulse, kExceededMaxVelocity, kForceError}) {
    EXPECT_EQ(ClassOf(code), ErrorClass::kForce) << code;
  }
  EXPECT_EQ(ClassOf(kWarmMotors), ErrorClass::kWarm);
  for (const Code code : {kDeviceFault, kCommError, kCommConfigError, kTimerError}) {
    EXPECT_EQ(ClassOf(code), ErrorClass::kFatal) << code;
  }
  EXPECT_EQ(ClassOf(kSuccess), ErrorClass::kNone);
}

TEST(HdError, TakesAnUnknownCodeForTheWorst) {
  EXPECT_EQ(ClassOf(0x999), ErrorClass::kUse);
  EXPECT_THAT(Describe({0x999, 3, 0}), HasSubstr("an unknown error (0x999, internal 3)"));
}

}  // namespace
}  // namespace palpate::hd
