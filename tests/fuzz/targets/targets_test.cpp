// What libFuzzer runs for long, here for seconds: valid inputs, intact and damaged.
#include "tests/fuzz/targets/targets.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <string>

#include <gtest/gtest.h>
#include <sys/resource.h>

#include "tests/support/optimised.h"
#include "tests/support/random.h"

namespace palpate::test {
namespace {

/// One to four changes as by a disk, a transfer or an attacker: another bit, byte or number (of
/// four bytes or in digits), a piece that is missing or doubled, or a missing end.
std::string Spoilt(std::string bytes, Random& random) {
  static constexpr std::uint32_t kNumbers[] = {0,          1,          3,          0xff,
                                               0x7fff,     0xffff,     0x10000,    0x7fffffff,
                                               0x80000000, 0xffffffff, 0x7f800000, 0x7fc00000};
  static constexpr const char* kWords[] = {"-1",    "0",     "4294967295", "99999999999999999999",
                                           "1e300", "1e999", "-1e-320",    "nan",
                                           "\n",    " ",     "null",       "true",
                                           "\"\"",  "[]",    "{}",         "[[[[[["};
  const auto below = [&](std::size_t n) {
    return static_cast<std::size_t>(random.Below(static_cast<int>(n)));
  };
  for (std::size_t changes = 1 + below(4); changes > 0 && !bytes.empty(); --changes) {
    const std::size_t i = below(bytes.size());
    const std::size_t n = std::min(bytes.size() - i, 1 + below(64));
    switch (below(9)) {
      case 0:
        bytes[i] = static_cast<char>(bytes[i] ^ (1 << below(8)));
        break;
      case 1:
        bytes[i] = static_cast<char>(below(256));
        break;
      case 2:
      case 3: {
        const std::uint32_t number = kNumbers[below(std::size(kNumbers))];
        std::memcpy(bytes.data() + i, &number, std::min(sizeof number, bytes.size() - i));
        break;
      }
      case 4:
        bytes.erase(i, n);
        break;
      case 5:
        bytes.insert(below(bytes.size()), bytes.substr(i, n));
        break;
      case 6:
        if (below(4) == 0) bytes.resize(i);
        break;
      default: {
        const std::size_t digit = bytes.find_first_of("0123456789", i);
        if (digit == std::string::npos) break;
        const std::size_t end = bytes.find_first_not_of("0123456789.-", digit);
        const std::string word = below(2) == 0 ? std::to_string(below(300))
                                               : std::string(kWords[below(std::size(kWords))]);
        bytes.replace(digit, std::min(end, bytes.size()) - digit, word);
      }
    }
  }
  return bytes;
}

class FuzzTarget : public testing::TestWithParam<fuzz::Target> {
 protected:
  static void SetUpTestSuite() {
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
    const rlimit gigabyte{std::size_t{1} << 30, std::size_t{1} << 30};
    setrlimit(RLIMIT_AS, &gigabyte);
#endif
  }
};

TEST_P(FuzzTarget, ComesBackFromAnything) {
  const std::vector<std::string> seeds = GetParam().seeds();
  ASSERT_FALSE(seeds.empty());
  const auto run = [](const std::string& input) {
    return GetParam().run(reinterpret_cast<const std::uint8_t*>(input.data()), input.size());
  };
  Random random(1);
  const int tries = kOptimised ? 3000 : 200;
  run("");
  for (const std::string& seed : seeds) {
    ASSERT_GT(seed.size(), 4u);
    EXPECT_TRUE(run(seed)) << "what is whole is taken:\n" << seed;
    for (int i = 0; i < tries; ++i) run(Spoilt(seed, random));
  }
}

INSTANTIATE_TEST_SUITE_P(Each, FuzzTarget, testing::ValuesIn(fuzz::AllTargets()),
                         [](const auto& each) { return each.param.name; });

}  // namespace
}  // namespace palpate::test
