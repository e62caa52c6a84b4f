#include "client/viewer/options.h"

#include <gmock/gmock.h>

#include "common/error.h"
#include "tests/support/command_line.h"

namespace palpate {
namespace {

std::optional<ViewerOptions> Parse(const std::vector<const char*>& words) {
  return test::ParseWith(ParseViewerOptions, words);
}

TEST(ViewerOptions, AreForThisHostAloneUnlessTold) {
  const auto options = Parse({"--http", "8765"});
  ASSERT_TRUE(options);
  EXPECT_EQ(options->port, 8765);
  EXPECT_EQ(options->address, "127.0.0.1");
  EXPECT_EQ(options->rate_hz, 30.0);
  EXPECT_EQ(options->max_viewers, 300u);
  EXPECT_EQ(options->max_mice, 4);
  EXPECT_FALSE(options->no_steering);
  EXPECT_THAT(options->page, testing::HasSubstr("/page"));
}

TEST(ViewerOptions, AreForAHostsNamesInSmallLettersAndForANewTokenInPlaceOfAPort) {
  const auto named = Parse({"--http", "1", "--host-name", "Lab.Example", "--host-name", "lab"});
  ASSERT_TRUE(named);
  EXPECT_EQ(named->host_names, (std::vector<std::string>{"lab.example", "lab"}));
  EXPECT_FALSE(named->make_token);
  const auto make = Parse({"--make-token", "operate", "teacher", "--tokens", "f"});
  ASSERT_TRUE(make && make->make_token);
  EXPECT_EQ(make->make_token->role, Access::kOperate);
  EXPECT_EQ(make->make_token->name, "teacher");
}

}  // namespace
}  // namespace palpate
