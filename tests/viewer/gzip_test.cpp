#include "client/viewer/gzip.h"

#include <gtest/gtest.h>
#include <zlib.h>

namespace palpate {
namespace {

std::vector<std::uint8_t> Unpacked(const std::vector<std::uint8_t>& packed, std::size_t most) {
  std::vector<std::uint8_t> bytes(most);
  z_stream stream{};
  EXPECT_EQ(inflateInit2(&stream, MAX_WBITS + 16), Z_OK);  // gzip alone
  stream.next_in = const_cast<Bytef*>(packed.data());
  stream.avail_in = static_cast<uInt>(packed.size());
  stream.next_out = bytes.data();
  stream.avail_out = static_cast<uInt>(bytes.size());
  EXPECT_EQ(inflate(&stream, Z_FINISH), Z_STREAM_END);
  bytes.resize(stream.total_out);
  inflateEnd(&stream);
  return bytes;
}

TEST(Gzip, GivesBackWhatWentIn) {
  for (const std::size_t size : {0u, 1u, 1'000'000u}) {
    std::vector<std::uint8_t> bytes(size);
    for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::uint8_t>(i / 100 % 7);
    const auto packed = Gzip(bytes);
    EXPECT_TRUE(Unpacked(packed, size + 1) == bytes);
    if (size > 1000) {
      EXPECT_LT(packed.size(), size / 20);
    }
  }
}

}  // namespace
}  // namespace palpate
