#include "client/viewer/options.h"

#include <gmock/gmock.h>

#include "common/error.h"
#include "tests/support/command_line.h"

namespace palpate {
namespace {

using testing::HasSubstr;

std::optional<ViewerOptions> Parse(const std::vector<const char*>& words) {
  return test::ParseWith(ParseViewerOptions, words);
}

std::string Complaint(const std::vector<const char*>& words) {
  return test::ComplaintOf(ParseViewerOptions, words);
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
  EXPECT_THAT(options->page, HasSubstr("/page"));
}

TEST(ViewerOptions, NameTheArgumentThatIsWrong) {
  EXPECT_THAT(Complaint({}), HasSubstr("--http"));
  EXPECT_THAT(Complaint({"--http", "70000"}), HasSubstr("--http"));
  EXPECT_THAT(Complaint({"--http", "1", "--bind", "here"}), HasSubstr("--bind 'here'"));
  EXPECT_THAT(Complaint({"--http", "1", "--rate", "9"}), HasSubstr("--rate"));
  EXPECT_THAT(Complaint({"--http", "1", "--max-mice", "99"}), HasSubstr("--max-mice"));
  EXPECT_THAT(Complaint({"--http", "1", "--transport", "pigeon"}), HasSubstr("--transport"));
  EXPECT_THAT(Complaint({"--http", "1", "--page", "/proc/none"}),
              HasSubstr("--page /proc/none: is not a folder; give the one"));
}

TEST(ViewerOptions, NameWhatIsWrongWithWhoMay) {
  EXPECT_THAT(Complaint({"--http", "1", "--host-name", "http://lab"}), HasSubstr("--host-name"));
  EXPECT_THAT(Complaint({"--http", "1", "--proxy", "lab"}), HasSubstr("--proxy 'lab'"));
  EXPECT_THAT(Complaint({"--http", "1", "--tls-cert", "a.pem"}), HasSubstr("--tls-key"));
  EXPECT_THAT(Complaint({"--http", "1", "--tls-key", "a.pem"}), HasSubstr("--tls-cert"));
  EXPECT_THAT(Complaint({"--make-token", "admin", "x", "--tokens", "f"}),
              HasSubstr("watch, drive or operate"));
  EXPECT_THAT(Complaint({"--make-token", "watch", "x"}), HasSubstr("--tokens FILE"));
  EXPECT_THAT(Complaint({"--export-csv", "-"}), HasSubstr("--course FOLDER"));
  EXPECT_EQ(Parse({"--export-csv", "-", "--course", "anatomy"})->export_csv, "-");
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
