#include "common/files/bundle_hash.h"

#include <vector>

#include <gmock/gmock.h>

#include "tests/support/complaint.h"

namespace palpate {
namespace {

TEST(BundleHash, IsXxh3OfTheBytesAndNamesOneContentAlone) {
  EXPECT_EQ(BundleHash({}), 0x2d06800538d394c2u) << "as its specification has it of nothing";
  const std::vector<std::uint8_t> bytes = {1, 2, 3};
  EXPECT_NO_THROW(CheckBundleHash(bytes, BundleHash(bytes), "scene 'cube'"));
  const std::string complaint =
      test::ComplaintOf([&] { CheckBundleHash(bytes, 0x123456789abcdef0, "scene 'cube'"); });
  EXPECT_THAT(complaint, testing::HasSubstr("scene 'cube'"));
  EXPECT_THAT(complaint, testing::HasSubstr("not 123456789abcdef0"));
  EXPECT_THAT(complaint, testing::HasSubstr("damaged or forged"));
}

}  // namespace
}  // namespace palpate
