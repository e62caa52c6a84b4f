#pragma once

#include <cstdint>

#include "common/math/pose.h"

namespace palpate {

/// A wrench with NaN or infinity in it counts as zero.
class FiniteStage {
 public:
  Wrench Pass(const Wrench& wrench) noexcept {
    if (wrench.force.allFinite() && wrench.torque.allFinite()) return wrench;
    ++count_;
    return {};
  }
  std::uint64_t count() const noexcept { return count_; }

 private:
  std::uint64_t count_ = 0;
};

}  // namespace palpate
