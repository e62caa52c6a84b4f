#include "common/dds/leave_seal.h"

#include <algorithm>
#include <set>

#include <gtest/gtest.h>

namespace palpate::dds {
namespace {

TEST(LeaveSeal, IsTheHashThatStandardsName) {
  // SHA-256 (FIPS 180-4) of 32 zero bytes.
  const std::uint8_t zeros[32] = {};
  const LeaveKey seal = SealOf(zeros);
  EXPECT_EQ(seal[0], 0x66);
  EXPECT_EQ(seal[1], 0x68);
  EXPECT_EQ(seal[31], 0x25);
}

TEST(LeaveSeal, IsOpenedByItsKeyAloneAndThatOfZerosByAll) {
  const LeaveKey key = NewLeaveKey();
  std::uint8_t bytes[32];
  std::ranges::copy(key, bytes);
  const LeaveKey seal = SealOf(bytes);
  EXPECT_TRUE(Opens(bytes, seal));
  for (int i = 0; i < 32 * 8; ++i) {
    bytes[i / 8] ^= static_cast<std::uint8_t>(1 << i % 8);
    EXPECT_FALSE(Opens(bytes, seal)) << i;
    bytes[i / 8] ^= static_cast<std::uint8_t>(1 << i % 8);
  }
  std::ranges::copy(seal, bytes);  // which everybody can read
  EXPECT_FALSE(Opens(bytes, seal));
  const std::uint8_t none[32] = {};
  EXPECT_TRUE(Opens(none, LeaveKey{}));
}

TEST(LeaveSeal, DrawsAnotherKeyEachTime) {
  std::set<LeaveKey> keys;
  for (int i = 0; i < 100; ++i) keys.insert(NewLeaveKey());
  EXPECT_EQ(keys.size(), 100u);
}

}  // namespace
}  // namespace palpate::dds
