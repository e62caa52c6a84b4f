#include "common/step_tuning.h"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/complaint.h"

namespace palpate {
namespace {

using test::ComplaintOf;
using ::testing::AllOf;
using ::testing::HasSubstr;

std::string Refusal(const char* name, double value) {
  StepTuning tuning;
  const std::string complaint = ComplaintOf([&] { SetField(tuning, name, value); });
  EXPECT_EQ(tuning, StepTuning{}) << "a refusal changes nothing";
  return complaint;
}

TEST(StepTuning, TakesEachFieldInItsUnitAtBothEndsOfItsRange) {
  StepTuning tuning;
  ForEachField(tuning, [&](const char* name, auto& field, double scale, double least, double most) {
    for (const double value : {least, most}) {
      SetField(tuning, name, value);
      EXPECT_DOUBLE_EQ(field, scale * value) << name;
      EXPECT_EQ(TuningFault(tuning), "");
    }
    EXPECT_THAT(Refusal(name, least - 0.5), HasSubstr(name));
    EXPECT_THAT(Refusal(name, 2.0 * most), HasSubstr("from"));
  });
}

TEST(StepTuning, NamesTheRangeOrTheFieldsThatThereAre) {
  EXPECT_THAT(Refusal("separation_um", 1e4), HasSubstr("is 10000; give a number from 0.01 to 100"));
  EXPECT_THAT(Refusal("sub_steps", 2.5), HasSubstr("a whole number from 1 to 64"));
  EXPECT_THAT(Refusal("looks", std::numeric_limits<double>::quiet_NaN()),
              HasSubstr("looks is nan"));
  EXPECT_THAT(Refusal("seperation_um", 2.0),
              AllOf(HasSubstr("seperation_um is no field"), HasSubstr("separation_um, widest")));
}

TEST(StepTuning, TellsOfAFieldThatIsOutOfItsRange) {
  EXPECT_EQ(TuningFault({}), "");
  EXPECT_THAT(TuningFault({.separation = 1.0}), HasSubstr("separation_um is 1e+06"));
  EXPECT_THAT(TuningFault({.looks = 2'000'000'000}), HasSubstr("looks"));
  EXPECT_THAT(TuningFault({.widest_step = -1.0}), HasSubstr("widest_step_mm"));
}

}  // namespace
}  // namespace palpate
