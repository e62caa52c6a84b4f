#include "devices/return_gate.h"

#include <gtest/gtest.h>

namespace palpate {
namespace {

const Wrench kSome{Vec3(0.0, 1e-9, 0.0), Vec3::Zero()};

bool PassesAfter(ReturnGate& gate, int ticks, const Wrench& wrench) {
  for (int i = 1; i < ticks; ++i) gate.Passes(wrench);
  return gate.Passes(wrench);
}

TEST(ReturnGate, OpensOnlyAfterQuietAndOnceNothingIsAskedFor) {
  ReturnGate gate(1000.0);
  EXPECT_FALSE(PassesAfter(gate, 5000, kSome)) << "a step would come of it";
  EXPECT_TRUE(gate.Passes(Wrench{}));
  EXPECT_TRUE(gate.Passes(kSome));
}

TEST(ReturnGate, ShutsWithAFaultAndCountsItsQuietAnew) {
  ReturnGate gate(1000.0);
  ASSERT_TRUE(PassesAfter(gate, 101, Wrench{}));
  gate.Fault();
  EXPECT_FALSE(gate.Passes(kSome));
  EXPECT_FALSE(PassesAfter(gate, 98, Wrench{}));
  gate.Fault();
  EXPECT_FALSE(PassesAfter(gate, 100, Wrench{}));
  EXPECT_TRUE(gate.Passes(Wrench{}));
}

}  // namespace
}  // namespace palpate
