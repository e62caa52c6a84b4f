// Every error code and every cause of lost force ends in a remedy.
#include "devices/forcedimension/dhd_library.h"

#include <cstdlib>
#include <set>

#include <gmock/gmock.h>

#include "devices/forcedimension/dhd_texts.h"
#include "tests/support/complaint.h"

namespace palpate::dhd {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

std::string LoadError(const std::vector<std::string>& candidates) {
  return test::ComplaintOf([&] { LoadLibrary(candidates); });
}

TEST(DhdLibrary, BindsEveryFunction) {
  const Library library = LoadLibrary({"libno-such-dhd.so", PALPATE_FAKE_DHD});
  EXPECT_EQ(library.file, PALPATE_FAKE_DHD);
#define PALPATE_DHD_LOOK(result, name, arguments) \
  EXPECT_NE(library.functions.name, nullptr) << #name;
  PALPATE_DHD_FUNCTIONS(PALPATE_DHD_LOOK)
#undef PALPATE_DHD_LOOK
}

TEST(DhdLibrary, SaysWhatToInstallWhereThereIsNoneOrItIsAnother) {
  EXPECT_THAT(LoadError({"libno-such-dhd.so"}),
              AllOf(HasSubstr("forcedimension: no DHD library could be loaded"),
                    HasSubstr("install Force Dimension's SDK"), HasSubstr(kLibraryVariable)));
  EXPECT_THAT(LoadError({"libm.so.6"}),
              AllOf(HasSubstr("libm.so.6 has no dhdErrorGetLast, "),
                    HasSubstr("it is not Force Dimension's DHD library")));
}

TEST(DhdLibrary, TriesTheFileThatTheVariableNamesAlone) {
  setenv(kLibraryVariable, "/opt/sdk/libdhd.so.3", 1);
  EXPECT_THAT(kLibraryWords.Candidates(), ElementsAre("/opt/sdk/libdhd.so.3"));
  unsetenv(kLibraryVariable);
  EXPECT_THAT(kLibraryWords.Candidates(), ElementsAre("libdhd.so.3", "libdhd.so"));
}

using testing::StartsWith;

TEST(DhdError, KnowsEveryCodeThatIsDocumentedInItsPlace) {
  // Release 3.7 has 21 errors after DHD_NO_ERROR; later releases added one.
  ASSERT_EQ(ErrorTexts().size(), 1u + 21u + 1u);
  std::set<std::string> names;
  for (std::size_t i = 0; i < ErrorTexts().size(); ++i) {
    const ErrorText& text = ErrorTexts()[i];
    EXPECT_EQ(text.code, static_cast<int>(i));
    EXPECT_THAT(text.name, StartsWith("DHD_"));
    EXPECT_TRUE(names.insert(text.name).second) << text.name << " stands there twice";
    EXPECT_GE(std::string(text.remedy).size(), 10u) << text.name;
    EXPECT_THAT(DescribeError(text.code), HasSubstr(text.remedy));
    EXPECT_EQ(text.error_class == ErrorClass::kNone, i == 0) << text.name;
  }
}

TEST(DhdError, TakesACodeThatNobodyKnowsForTheWorst) {
  for (const int code : {-1, 23, 9999}) {
    EXPECT_EQ(ClassOf(code), ErrorClass::kLatch);
    EXPECT_THAT(DescribeError(code), HasSubstr("please report it"));
  }
}

TEST(ArmCondition, HasARemedyForEachOfThem) {
  std::set<std::string> remedies;
  for (std::size_t i = 0; i < ConditionTexts().size(); ++i) {
    const ConditionText& text = ConditionTexts()[i];
    EXPECT_EQ(text.condition, static_cast<Condition>(i));
    EXPECT_EQ(&TextOf(text.condition), &text);
    EXPECT_TRUE(remedies.insert(text.remedy).second) << text.name;
    if (text.condition == Condition::kReady) continue;
    EXPECT_THAT(DescribeCondition(text.condition), HasSubstr(text.remedy));
  }
  EXPECT_EQ(ConditionTexts().size(), static_cast<std::size_t>(Condition::kForceOff) + 1);
}

class Status : public testing::Test {
 protected:
  Status() {
    for (const int on : {kStatusPower, kStatusConnected, kStatusStarted, kStatusWristDetected,
                         kStatusWristInit, kStatusForce}) {
      status[on] = 1;
    }
  }
  int status[kStatusRoom] = {};
};

TEST_F(Status, IsReadyWithForceWhateverTheLastCauseWas) {
  EXPECT_EQ(ConditionOf(status), Condition::kReady);
  status[kStatusForceOffCause] = 2;
  EXPECT_EQ(ConditionOf(status), Condition::kReady);
}

TEST_F(Status, NamesEachCauseForWhichTheForceGoesOff) {
  status[kStatusForce] = 0;
  EXPECT_EQ(ConditionOf(status), Condition::kForceOff);
  const std::pair<int, Condition> causes[] = {
      {1, Condition::kOffByButton},   {2, Condition::kOffByVelocity},
      {3, Condition::kOffByWatchdog}, {4, Condition::kOffBySoftware},
      {5, Condition::kOffByUsb},      {6, Condition::kOffByDeadMan},
      {7, Condition::kOffUnknown},    {-1, Condition::kOffUnknown}};
  for (const auto& [cause, condition] : causes) {
    status[kStatusForceOffCause] = cause;
    EXPECT_EQ(ConditionOf(status), condition) << cause;
  }
}

TEST_F(Status, NamesTheFirstThingThatIsAmiss) {
  status[kStatusForce] = 0;
  status[kStatusBrake] = 1;
  EXPECT_EQ(ConditionOf(status), Condition::kBrake);
  status[kStatusBrake] = 0;
  status[kStatusIdle] = 1;
  EXPECT_EQ(ConditionOf(status), Condition::kIdle);
  status[kStatusWristInit] = 0;
  EXPECT_EQ(ConditionOf(status), Condition::kWristNotCalibrated);
  status[kStatusReset] = 1;
  EXPECT_EQ(ConditionOf(status), Condition::kNotCalibrated);
  status[kStatusError] = 1;
  EXPECT_EQ(ConditionOf(status), Condition::kError);
  status[kStatusStarted] = 0;
  EXPECT_EQ(ConditionOf(status), Condition::kNotStarted);
  status[kStatusConnected] = 0;
  EXPECT_EQ(ConditionOf(status), Condition::kNotConnected);
  status[kStatusPower] = 0;
  EXPECT_EQ(ConditionOf(status), Condition::kNoPower);
}

}  // namespace
}  // namespace palpate::dhd
