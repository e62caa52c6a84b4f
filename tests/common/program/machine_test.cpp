#include "common/program/machine.h"

#include <gtest/gtest.h>
#include <sched.h>

namespace palpate {
namespace {

TEST(Machine, HasTheCoresThatThisProcessMayRunOn) {
  cpu_set_t all;
  sched_getaffinity(0, sizeof all, &all);
  EXPECT_EQ(ThisHost().cores, CPU_COUNT(&all));
  cpu_set_t one;
  CPU_ZERO(&one);
  CPU_SET(sched_getcpu(), &one);
  ASSERT_EQ(sched_setaffinity(0, sizeof one, &one), 0);
  EXPECT_EQ(ThisHost().cores, 1);
  sched_setaffinity(0, sizeof all, &all);
}

TEST(Machine, NamesItsProcessorAndCompiler) {
  EXPECT_NE(ThisHost().cpu, "");
  EXPECT_NE(ThisHost().compiler.find("GCC "), std::string::npos);
}

}  // namespace
}  // namespace palpate
