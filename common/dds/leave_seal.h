#pragma once

#include <array>
#include <cstdint>

namespace palpate::dds {

/// The key with which only the station itself can end its session, although anybody may write
/// requests (a hash commitment).  With its request the station publishes a seal, the key's hash,
/// which reveals nothing of the key; when it leaves it publishes the key, which is then of no
/// more use to others.  This does not replace the secured profile, which decides who may write
/// poses at all.
using LeaveKey = std::array<std::uint8_t, 32>;

/// Returns a new key that nobody can guess.  Throws Error if the system supplies no random numbers.
LeaveKey NewLeaveKey();

/// Returns the key's SHA-256.
LeaveKey SealOf(const std::uint8_t (&key)[32]);

/// Returns true if the key belongs to the seal; any key opens a seal of zeros.
bool Opens(const std::uint8_t (&key)[32], const LeaveKey& seal);

}  // namespace palpate::dds
