#include <cstdlib>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

#include "tests/support/program.h"
#include "tests/support/test_domain.h"

namespace palpate {
namespace {

using testing::HasSubstr;
using testing::Not;

/// The exit status of palpate-station, and what it printed.
struct Outcome {
  int status;
  std::string text;
};
Outcome RunStation(const std::vector<std::string>& arguments) {
  test::Program program(test::OwnFolder() + "/palpate-station", arguments);
  const int status = program.Exit();
  return {status, program.Output()};
}

/// Runs a station whose words are right except for `more`.
Outcome RunSimulated(std::vector<std::string> more) {
  more.insert(more.begin(), {"--device", "simulated", "--scene", "cube", "--id", "a"});
  return RunStation(more);
}

TEST(PalpateStation, ExitsWithOneForAFileThatIsNotThere) {
  for (const auto& [option, file] : {std::pair{"--script", "/nowhere/path.json"},
                                     std::pair{"--workspace", "/nowhere/desk.json"}}) {
    const Outcome outcome = RunSimulated({option, file});
    EXPECT_EQ(outcome.status, 1) << option;
    EXPECT_THAT(outcome.text, HasSubstr(file));
  }
}

TEST(PalpateStation, NamesWhatADriverMissesThoughNoServerAnswers) {
  const std::string domain = std::to_string(test::OwnDomain());
  const std::string nothing = "/nowhere/it";
  for (const auto& [device, variable, value] :
       {std::tuple{"openhaptics", "PALPATE_OPENHAPTICS_LIBRARY", nothing},
        std::tuple{"forcedimension", "PALPATE_FORCEDIMENSION_LIBRARY", nothing},
        std::tuple{"haply", "PALPATE_HAPLY_SERVICE", std::string("ws://127.0.0.1:1")}}) {
    setenv(variable, value.c_str(), 1);
    const Outcome outcome = RunStation(
        {"--device", device, "--scene", "cube", "--id", "a", "--domain", domain, "--wait", "0.2"});
    unsetenv(variable);
    EXPECT_EQ(outcome.status, 1) << device;
    EXPECT_THAT(outcome.text, HasSubstr(std::string("palpate-station: ") + device + ": "));
    EXPECT_THAT(outcome.text, HasSubstr(value));
    EXPECT_THAT(outcome.text, Not(HasSubstr("no server"))) << device;
  }
}

}  // namespace
}  // namespace palpate
