#include "common/dds/cdr.h"

#include <cstring>

#include <gtest/gtest.h>

#include "common/dds/cdr_reader.h"
#include "tests/common/recording/samples.h"

namespace palpate::dds {
namespace {

template <class T>
std::vector<std::uint8_t> BytesOf(const T& sample) {
  std::vector<std::uint8_t> bytes;
  ToCdr(sample, bytes);
  return bytes;
}

TEST(Cdr, GivesALoopSampleAsItIsBehindFourBytes) {
  const wire::Wrench wrench = test::SampleWrench(3);
  const std::vector<std::uint8_t> bytes = BytesOf(wrench);
  ASSERT_EQ(bytes.size(), 4 + sizeof wrench);
  EXPECT_EQ(std::memcmp(&bytes[4], &wrench, sizeof wrench), 0);
  wire::Wrench again;
  ASSERT_TRUE(FromCdr<wire::Wrench>(bytes, again));
  EXPECT_EQ(std::memcmp(&again, &wrench, sizeof wrench), 0);
}

TEST(Cdr, GivesTextAndNumbersBack) {
  const wire::SessionState state = test::SampleState("hand", 5);
  wire::SessionState again{};
  ASSERT_TRUE(FromCdr<wire::SessionState>(BytesOf(state), again));
  EXPECT_EQ(std::memcmp(&again, &state, sizeof state), 0);
}

TEST(Cdr, GivesAScenesBytesBack) {
  std::vector<std::uint8_t> bytes(1001);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(i);
  wire::SceneBundle bundle{};
  bundle.hash = 9;
  bundle.bundle._buffer = bytes.data();
  bundle.bundle._length = bundle.bundle._maximum = 1001;
  wire::SceneBundle again{};
  ASSERT_TRUE(FromCdr<wire::SceneBundle>(BytesOf(bundle), again));
  EXPECT_EQ(again.hash, 9u);
  EXPECT_EQ(std::vector<std::uint8_t>(again.bundle._buffer, again.bundle._buffer + 1001), bytes);
  FreeContents(again);
}

TEST(Cdr, RefusesBytesThatEndEarlyAndOtherEncodings) {
  std::vector<std::uint8_t> bytes = BytesOf(test::SampleState("hand", 5));
  wire::SessionState state{};
  for (std::size_t n = 0; n < bytes.size(); ++n) {
    EXPECT_FALSE(FromCdr<wire::SessionState>({bytes.data(), n}, state)) << n;
  }
  bytes[1] = 0;  // big-endian
  EXPECT_FALSE(FromCdr<wire::SessionState>(bytes, state));
  wire::HapticPose pose;
  EXPECT_FALSE(FromCdr<wire::HapticPose>(BytesOf(test::SampleWrench(1)), pose));
}

}  // namespace
}  // namespace palpate::dds
