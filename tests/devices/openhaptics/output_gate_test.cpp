#include "devices/openhaptics/output_gate.h"

#include <limits>

#include <gtest/gtest.h>

namespace palpate {
namespace {

using hd::ErrorClass;
using State = OutputGate::State;

const Wrench kNothing{};
const Wrench kForce{Vec3(0, 1, 0), Vec3::Zero()};

OutputGate OpenGate() {
  OutputGate gate(1000.0);
  gate.Open();
  for (int i = 0; i < 200; ++i) gate.Passes(kNothing);
  EXPECT_EQ(gate.state(), State::kOn);
  return gate;
}

TEST(OutputGate, IsClosedUntilTheArmIsCalibratedAndNothingIsAskedFor) {
  OutputGate gate(1000.0);
  for (int i = 0; i < 1000; ++i) EXPECT_FALSE(gate.Passes(kNothing));
  gate.Open();
  for (int i = 0; i < 1000; ++i) EXPECT_FALSE(gate.Passes(kForce)) << "that would be a step";
  EXPECT_TRUE(gate.Passes(kNothing));
  EXPECT_TRUE(gate.Passes(kForce));
}

TEST(OutputGate, PausesForATooGreatForceUntilTenthOfASecondIsQuiet) {
  OutputGate gate = OpenGate();
  gate.Report(ErrorClass::kForce);
  EXPECT_TRUE(gate.motors_on());
  for (int i = 1; i < 100; ++i) EXPECT_FALSE(gate.Passes(kNothing)) << i;
  gate.Report(ErrorClass::kForce);
  for (int i = 1; i < 100; ++i) EXPECT_FALSE(gate.Passes(kNothing)) << i;
  EXPECT_TRUE(gate.Passes(kNothing));
}

TEST(OutputGate, TurnsTheMotorsOffUntilTheyAreCool) {
  OutputGate gate = OpenGate();
  gate.SetTemperature(0.95);
  gate.Report(ErrorClass::kWarm);
  EXPECT_FALSE(gate.motors_on());
  for (int i = 0; i < 5000; ++i) EXPECT_FALSE(gate.Passes(kNothing));
  gate.SetTemperature(std::numeric_limits<double>::quiet_NaN());
  for (int i = 0; i < 5000; ++i) EXPECT_FALSE(gate.Passes(kNothing));
  gate.SetTemperature(0.69);
  EXPECT_FALSE(gate.Passes(kNothing));
  EXPECT_EQ(gate.state(), State::kPaused);
  for (int i = 0; i < 99; ++i) EXPECT_FALSE(gate.Passes(kNothing));
  EXPECT_TRUE(gate.Passes(kNothing));
}

TEST(OutputGate, RestsTwoSecondsEvenWhereTheMotorsSeemCoolAndAMinuteWhereNobodyKnows) {
  OutputGate gate = OpenGate();
  gate.SetTemperature(0.1);
  gate.Report(ErrorClass::kWarm);
  for (int i = 1; i < 2000; ++i) gate.Passes(kNothing);
  EXPECT_EQ(gate.state(), State::kCooling);
  gate.Passes(kNothing);
  EXPECT_EQ(gate.state(), State::kPaused);

  OutputGate blind = OpenGate();
  blind.Report(ErrorClass::kWarm);
  for (int i = 1; i < 60000; ++i) blind.Passes(kNothing);
  EXPECT_EQ(blind.state(), State::kCooling);
  blind.Passes(kNothing);
  EXPECT_EQ(blind.state(), State::kPaused);
}

TEST(OutputGate, LatchesWhateverComesAfterwards) {
  for (const ErrorClass worst : {ErrorClass::kFatal, ErrorClass::kUse}) {
    OutputGate gate = OpenGate();
    gate.Report(worst);
    gate.Report(ErrorClass::kWarm);
    gate.Report(ErrorClass::kForce);
    gate.Open();
    for (int i = 0; i < 100'000; ++i) EXPECT_FALSE(gate.Passes(kNothing));
    EXPECT_FALSE(gate.motors_on());
    EXPECT_EQ(gate.state(), State::kLatched);
  }
}

TEST(OutputGate, IsNotOpenedByAnErrorWhileTheArmIsCalibrated) {
  for (const ErrorClass error : {ErrorClass::kNone, ErrorClass::kForce, ErrorClass::kWarm}) {
    OutputGate gate(1000.0);
    gate.Report(error);
    for (int i = 0; i < 100'000; ++i) EXPECT_FALSE(gate.Passes(kNothing));
    EXPECT_FALSE(gate.motors_on());
  }
}

}  // namespace
}  // namespace palpate
