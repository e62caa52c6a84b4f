#pragma once

#include <cstdint>
#include <string>

namespace palpate {

/// Names of the bits of StepFault, for people: "target-far jammed"; "-" where there are none.
std::string FaultText(std::uint32_t faults);

}  // namespace palpate
