#include "common/step_tuning.h"

#include <gmock/gmock.h>

namespace palpate {
namespace {

using ::testing::HasSubstr;

TEST(StepTuning, TellsOfAFieldThatIsOutOfItsRange) {
  EXPECT_EQ(TuningFault({}), "");
  EXPECT_THAT(TuningFault({.separation = 1.0}), HasSubstr("separation_um is 1e+06"));
  EXPECT_THAT(TuningFault({.queries = 2'000'000'000}), HasSubstr("queries"));
  EXPECT_THAT(TuningFault({.widest_step = -1.0}), HasSubstr("widest_step_mm"));
}

}  // namespace
}  // namespace palpate
