#include "common/log.h"

#include <gtest/gtest.h>
#include <spdlog/spdlog.h>

#include "common/error.h"

namespace palpate {
namespace {

TEST(Log, WritesToStandardErrorFromItsLevelOn) {
  testing::internal::CaptureStderr();
  testing::internal::CaptureStdout();
  SetUpLog("a-program", "warn");
  spdlog::info("too quiet");
  spdlog::warn("loud enough");
  const std::string err = testing::internal::GetCapturedStderr();
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(err.find("too quiet"), std::string::npos);
  EXPECT_NE(err.find("a-program warning: loud enough"), std::string::npos) << err;
}

TEST(Log, RefusesALevelThatDoesNotExist) {
  EXPECT_THROW(SetUpLog("a-program", "loud"), UsageError);
  EXPECT_NO_THROW(SetUpLog("a-program", "off"));
}

}  // namespace
}  // namespace palpate
