// What libFuzzer runs for long, here for seconds: whole inputs, and these spoilt.
#include "tests/fuzz/targets/targets.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include "tests/fuzz/spoilt_bytes.h"
#include "tests/support/optimised.h"

namespace palpate::test {
namespace {

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
