#pragma once

#include <array>
#include <cstdint>

namespace palpate::dds {

/// What lets a station alone end its session, where everybody may write requests: with its request
/// it gives a seal, which tells nothing of the key, and when it leaves the key, which is of no use
/// to others any more (a hash commitment).  Not the secured profile's place: who may write poses at
/// all is that one's matter.
using LeaveKey = std::array<std::uint8_t, 32>;

/// A new one, which nobody can guess.  Throws Error where the system has no randomness.
LeaveKey NewLeaveKey();

/// The key's SHA-256.
LeaveKey SealOf(const std::uint8_t (&key)[32]);

/// True where the key is the seal's; a seal of zeros is open to any.
bool Opens(const std::uint8_t (&key)[32], const LeaveKey& seal);

}  // namespace palpate::dds
