#include "client/doctor/report.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

namespace palpate::doctor {
namespace {

using testing::HasSubstr;
using testing::Not;

const Finding kGood{.check = "kernel", .found = "Linux 6.1, PREEMPT_RT"};
const Finding kPoor{.check = "idle states",
                    .status = Status::kWarning,
                    .found = "the deepest is C6",
                    .remedy = "sudo cpupower idle-set -D 10"};
const Finding kBad{.check = "loop", .status = Status::kFault, .found = "lost", .remedy = "mend it"};

TEST(Report, IsFitUntilAFault) {
  EXPECT_STREQ(Verdict({.findings = {kGood}}), "fit");
  EXPECT_STREQ(Verdict({.findings = {kGood, kPoor}}), "fit, with warnings");
  EXPECT_STREQ(Verdict({.findings = {kBad, kPoor, kGood}}), "not fit");
  const std::string text = Summary({.findings = {kGood, kPoor, kBad}}, {});
  EXPECT_THAT(text, HasSubstr("verdict: not fit for 1 kHz (1 fault, 1 warning)"));
  EXPECT_THAT(text, HasSubstr("was not measured"));
}

TEST(Report, ShowsTheRemedyBelowWhatItIsForAndColoursOnATerminalAlone) {
  const std::string text = ToText(kPoor, {});
  EXPECT_THAT(text, HasSubstr("  warning  idle states"));
  EXPECT_LT(text.find("the deepest is C6"), text.find("-> sudo cpupower"));
  EXPECT_THAT(ToText(kGood, {}), Not(HasSubstr("->")));
  EXPECT_THAT(ToText(kBad, {.colours = true}), HasSubstr("\x1b[1;31m"));
  EXPECT_THAT(ToText(kBad, {}), Not(HasSubstr("\x1b")));
}

TEST(Report, KeepsToTheTerminalsWidthAndPathsWhole) {
  Finding finding = kPoor;
  finding.remedy = std::string(40, 'p') + " " + std::string(40, 'q');
  const std::string text = ToText(finding, {.columns = 80});
  EXPECT_THAT(text, HasSubstr(std::string(40, 'p') + "\n"));
  finding.remedy = "one two three four five six seven eight nine ten eleven twelve thirteen";
  std::istringstream lines(ToText(finding, {.columns = 80}));
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 80u) << line;
}

TEST(Report, IsOneObjectForScripts) {
  Report report{.host = "lab: \xff, 4 cores", .findings = {kGood, kPoor}, .jitter = Jitter{}};
  for (int i = 1; i <= 1000; ++i) report.jitter->lateness.Add(10 * i);
  const auto json = nlohmann::json::parse(ToJson(report));
  ASSERT_EQ(json["findings"].size(), 2u);
  EXPECT_EQ(json["findings"][1]["check"], "idle states");
  EXPECT_EQ(json["findings"][1]["status"], "warning");
  EXPECT_EQ(json["findings"][1]["found"], "the deepest is C6");
  EXPECT_EQ(json["findings"][1]["remedy"], "sudo cpupower idle-set -D 10");
  EXPECT_NEAR(json["jitter"]["p50_us"], 5.0, 0.2);
  EXPECT_EQ(json["jitter"]["max_us"], 10.0);
  EXPECT_EQ(json["verdict"], "fit, with warnings");
}

}  // namespace
}  // namespace palpate::doctor
