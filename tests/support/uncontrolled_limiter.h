#pragma once

#include "devices/limiter/limiter_chain.h"

namespace palpate::test {

/// In the energy stage's place: it observes, and holds nothing back.
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

/// The limiter without its passivity controller, to measure what that does.  It gives a Wrench and
/// no LimitedWrench: no device can be driven by it.
using UncontrolledLimiter = LimiterChain<ObservedEnergy>;

}  // namespace palpate::test
