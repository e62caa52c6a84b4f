#include "common/program/log.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "common/error.h"

namespace palpate {
namespace {

using testing::EndsWith;
using testing::HasSubstr;
using testing::MatchesRegex;

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

/// What is on standard error after a message.
std::string Logged(LogFormat format, const std::string& message) {
  testing::internal::CaptureStderr();
  SetLogFormat(format);
  SetUpLog("a-program", "info");
  spdlog::info("station {}", message);
  SetLogFormat(LogFormat::kText);
  return testing::internal::GetCapturedStderr();
}

constexpr char kForged[] =
    "a\n12:00:00.000 palpate-server info: ready: fake\r\x1b[2K\xc2\x9b\xff\x07";

TEST(Log, LetsNoMessageMakeALineOfItsOwn) {
  for (const LogFormat format : {LogFormat::kText, LogFormat::kJson}) {
    const std::string line = Logged(format, kForged);
    ASSERT_THAT(line, EndsWith("\n"));
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
      EXPECT_TRUE(line[i] >= ' ' && line[i] < 0x7f) << "byte " << i << " of " << line;
    }
    EXPECT_THAT(line, HasSubstr("ready: fake"));
  }
  EXPECT_THAT(Logged(LogFormat::kText, kForged),
              HasSubstr(R"(ready: fake\r\x1b[2K\u009b\xff\x07)"));
}

TEST(Log, WritesAnObjectALineWhereAsked) {
  const std::string line = Logged(LogFormat::kJson, "\"quoted\" Zähne \\ \n");
  const auto json = nlohmann::json::parse(line);
  EXPECT_EQ(json.size(), 4u);
  EXPECT_EQ(json["level"], "info");
  EXPECT_EQ(json["program"], "a-program");
  EXPECT_EQ(json["message"], R"(station "quoted" Zähne \ \n)");
  EXPECT_THAT(json["time"], MatchesRegex("[0-9-]{10}T[0-9:]{8}\\.[0-9]{3}Z"));
  EXPECT_LE(json["time"], UtcTime()) << "in UTC";
}

TEST(Log, GivesAProgramsLastWordsTheSameForm) {
  EXPECT_EQ(LogLine("a-program", "no\nway"), "a-program: no\\nway\n");
  SetLogFormat(LogFormat::kJson);
  const std::string line = LogLine("a-program", "no\nway");
  SetLogFormat(LogFormat::kText);
  const auto json = nlohmann::json::parse(line);
  EXPECT_EQ(json["level"], "error");
  EXPECT_EQ(json["message"], "no\\nway");
}

TEST(Log, RefusesAFormatOrALevelThatDoesNotExist) {
  EXPECT_EQ(ParseLogFormat("json"), LogFormat::kJson);
  EXPECT_EQ(ParseLogFormat("text"), LogFormat::kText);
  EXPECT_THROW(ParseLogFormat("xml"), UsageError);
  EXPECT_THROW(SetUpLog("a-program", "loud"), UsageError);
  EXPECT_NO_THROW(SetUpLog("a-program", "off"));
}

}  // namespace
}  // namespace palpate
