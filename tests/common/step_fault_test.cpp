#include "common/step_fault.h"

#include <gtest/gtest.h>

namespace palpate {
namespace {

TEST(StepFault, IsNamedAndExplained) {
  EXPECT_EQ(FaultWords(kFaultNone), "none");
  EXPECT_EQ(FaultMeanings(kFaultNone), "none");
  EXPECT_EQ(FaultWords(kFaultTargetFar | kFaultJammed), "target far, jammed");
  EXPECT_EQ(FaultMeanings(kFaultTargetFar | kFaultJammed),
            "target far (the hand moved faster than the tool, which follows), jammed (the tool was "
            "wedged between surfaces)");
  EXPECT_EQ(FaultMeanings(1u << 30), "unknown");
}

}  // namespace
}  // namespace palpate
