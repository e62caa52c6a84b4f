#include "common/dds/cdr.h"

#include <cstring>

#include <gtest/gtest.h>

#include "common/dds/cdr_reader.h"
#include "tests/common/recording/samples.h"
#include "tests/support/random.h"

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

/// Bytes of a sample, each beginning of them, and the same with bytes changed: what is taken is a
/// sample that gives its own bytes, which mean the same again; the rest is refused.
template <class T>
void ExpectStandsAnyBytes(const T& sample, std::uint64_t seed) {
  test::Random random(seed);
  const std::vector<std::uint8_t> good = BytesOf(sample);
  for (std::size_t n = 0; n < good.size(); ++n) {
    // A copy of its own, so that a sanitizer sees a read beyond it.
    const std::vector<std::uint8_t> part(good.begin(), good.begin() + static_cast<long>(n));
    T read{};
    EXPECT_FALSE(FromCdr<T>(part, read)) << n << " of " << good.size();
  }
  int taken = 0;
  for (int i = 0; i < 5000; ++i) {
    std::vector<std::uint8_t> bytes = good;
    for (int change = 1 + random.Below(3); change > 0; --change) {
      bytes[random.Bits() % bytes.size()] = static_cast<std::uint8_t>(random.Below(256));
    }
    T read{};
    if (!FromCdr<T>(bytes, read)) continue;
    ++taken;
    const std::vector<std::uint8_t> own = BytesOf(read);
    ASSERT_LE(own.size(), bytes.size()) << "no more than there was";
    T again{};
    ASSERT_TRUE(FromCdr<T>(own, again)) << i;
    ASSERT_EQ(BytesOf(again), own) << i;
    FreeContents(read);
    FreeContents(again);
  }
  EXPECT_GT(taken, 0);
}

TEST(Cdr, OfEveryTypeStandsAnyBytes) {
  ExpectStandsAnyBytes(test::SamplePose(3), 11);
  ExpectStandsAnyBytes(test::SampleWrench(3), 12);
  ExpectStandsAnyBytes(test::SampleState("hand", 5), 13);
  ExpectStandsAnyBytes(test::SampleChange(4), 14);
  wire::SessionRequest request{};
  wire::FromText("hand", request.station);
  wire::FromText("cube", request.scene);
  ExpectStandsAnyBytes(request, 15);
  wire::ToolState tool{};
  wire::FromText("hand", tool.station);
  tool.points = 3;
  ExpectStandsAnyBytes(tool, 16);
  wire::LoopStatistics loop{};
  wire::FromText("hand", loop.station);
  ExpectStandsAnyBytes(loop, 17);
  wire::StationStatistics station{};
  wire::FromText("hand", station.station);
  ExpectStandsAnyBytes(station, 18);
  wire::GuideTarget guide{};
  wire::FromText("hand", guide.station);
  ExpectStandsAnyBytes(guide, 19);
  wire::LeafTaken leaf{};
  wire::FromText("hand", leaf.station);
  ExpectStandsAnyBytes(leaf, 20);
  std::vector<std::uint8_t> bytes(101, 7);
  wire::SceneBundle bundle{};
  wire::FromText("cube", bundle.scene);
  bundle.bundle._buffer = bytes.data();
  bundle.bundle._length = bundle.bundle._maximum = 101;
  ExpectStandsAnyBytes(bundle, 21);
}

}  // namespace
}  // namespace palpate::dds
