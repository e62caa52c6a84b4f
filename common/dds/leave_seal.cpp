#include "common/dds/leave_seal.h"

#include <openssl/rand.h>
#include <openssl/sha.h>

#include "common/error.h"

namespace palpate::dds {

LeaveKey NewLeaveKey() {
  LeaveKey key;
  if (RAND_bytes(key.data(), static_cast<int>(key.size())) != 1) {
    throw Error("the system gives no random numbers (OpenSSL's RAND_bytes)");
  }
  return key;
}

LeaveKey SealOf(const std::uint8_t (&key)[32]) {
  LeaveKey seal;
  SHA256(key, sizeof key, seal.data());
  return seal;
}

bool Opens(const std::uint8_t (&key)[32], const LeaveKey& seal) {
  return seal == LeaveKey{} || SealOf(key) == seal;
}

}  // namespace palpate::dds
