#pragma once

#include "devices/limiter/limiter_chain.h"

namespace palpate::test {

/// Replaces the energy stage: it observes the energy but does not reduce the wrench.
class ObservedEnergy {
 public:
  explicit ObservedEnergy(const WrenchLimits&) {}
  Wrench Pass(const Wrench& wanted, double, const Pose& X_WH, double, bool, bool) noexcept {
    observer_.Move(X_WH);
    return wanted;
  }
  void Hold(const Wrench& applied) noexcept { observer_.Hold(applied); }
  std::uint64_t count() const noexcept { return 0; }
  const PassivityObserver& observer() const noexcept { return observer_; }

 private:
  PassivityObserver observer_;
};

/// The limiter without its passivity controller, to measure the controller's effect.  It returns a
/// Wrench and not a LimitedWrench, so it cannot drive a device.
using UncontrolledLimiter = LimiterChain<ObservedEnergy>;

}  // namespace palpate::test
