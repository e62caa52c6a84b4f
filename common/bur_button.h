#pragma once

#include <cstdint>

namespace palpate {

/// Bit of HapticPose.buttons while which a bur stands still: the second button.  (The first may
/// enable forces.)
inline constexpr std::uint32_t kStillBurButton = 1u << 1;

}  // namespace palpate
