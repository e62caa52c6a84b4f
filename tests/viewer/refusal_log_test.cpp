#include "client/viewer/refusal_log.h"

#include <sstream>

#include <gmock/gmock.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

namespace palpate {
namespace {

using testing::HasSubstr;

constexpr std::int64_t kS = RateLimit::kSecond_ns;

class RefusalLogTest : public testing::Test {
 protected:
  RefusalLogTest() {
    spdlog::set_default_logger(std::make_shared<spdlog::logger>(
        "test", std::make_shared<spdlog::sinks::ostream_sink_mt>(text_)));
    spdlog::set_pattern("%v");
  }
  ~RefusalLogTest() override { spdlog::set_default_logger(before_); }

  std::string Said() {
    const std::string said = text_.str();
    text_.str("");
    return said;
  }

  std::shared_ptr<spdlog::logger> before_ = spdlog::default_logger();
  std::ostringstream text_;
  RefusalLog log_;
};

TEST_F(RefusalLogTest, HasNoKindTwiceASecondAndLosesNone) {
  for (int i = 0; i < 500; ++i) log_.Say(Refusal::kHost, "10.0.0.1", "its Host is", i);
  EXPECT_EQ(Said(), "refused (host) 10.0.0.1: its Host is\n");
  log_.Poll(kS / 2);
  EXPECT_EQ(Said(), "");
  log_.Poll(kS);
  EXPECT_EQ(Said(), "refused (host): 499 more\n");
  log_.Poll(3 * kS);
  EXPECT_EQ(Said(), "");
  EXPECT_EQ(log_.count(), 500u);
}

TEST_F(RefusalLogTest, TellsOfEachKindApart) {
  log_.Say(Refusal::kHost, "a", "x", 0);
  log_.Say(Refusal::kToken, "b", "y", 1);
  log_.Say(Refusal::kToken, "b", "y", 2);
  EXPECT_THAT(Said(), testing::AllOf(HasSubstr("(host) a"), HasSubstr("(token) b")));
  log_.Say(Refusal::kToken, "c", "z", 2 * kS);
  EXPECT_EQ(Said(), "refused (token) c: z (1 more before it)\n");
}

}  // namespace
}  // namespace palpate
