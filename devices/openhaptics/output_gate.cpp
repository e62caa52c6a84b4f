#include "devices/openhaptics/output_gate.h"

namespace palpate {

void OutputGate::Enter(State state) noexcept {
  state_ = state;
  quiet_ticks_ = 0;
}

void OutputGate::Open() noexcept {
  if (state_ == State::kCalibrating) Enter(State::kPaused);
}

void OutputGate::Report(hd::ErrorClass error) noexcept {
  if (state_ == State::kLatched) return;
  switch (error) {
    case hd::ErrorClass::kNone:
      return;
    case hd::ErrorClass::kForce:
      quiet_ticks_ = 0;
      if (state_ == State::kOn) Enter(State::kPaused);
      return;
    case hd::ErrorClass::kWarm:
      quiet_ticks_ = 0;
      if (state_ != State::kCalibrating) Enter(State::kCooling);
      return;
    case hd::ErrorClass::kFatal:
    case hd::ErrorClass::kUse:
      return Enter(State::kLatched);
  }
}

void OutputGate::SetTemperature(double hottest) noexcept {
  hottest_ = hottest;
  knows_temperature_ = true;
}

bool OutputGate::Passes(const Wrench& limited) noexcept {
  ++quiet_ticks_;
  if (state_ == State::kCooling) {
    // NaN does not count as cool.
    if (knows_temperature_ ? hottest_ < kCool && Rested(kLeastRest_s) : Rested(kBlindRest_s)) {
      Enter(State::kPaused);
    }
  } else if (state_ == State::kPaused) {
    const bool nothing = limited.force.isZero(0.0) && limited.torque.isZero(0.0);
    if (nothing && Rested(kQuiet_s)) Enter(State::kOn);
  }
  return state_ == State::kOn;
}

}  // namespace palpate
