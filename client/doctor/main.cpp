#include <cstdio>
#include <cstdlib>

#include <sys/ioctl.h>
#include <unistd.h>

#include "client/doctor/doctor.h"
#include "client/doctor/options.h"
#include "client/doctor/report.h"
#include "common/program/command_line.h"
#include "common/program/log.h"
#include "common/program/stop_signal.h"

namespace palpate::doctor {
namespace {

Style StyleOfOutput() {
  Style style;
  if (isatty(STDOUT_FILENO) != 1) return style;
  style.colours = std::getenv("NO_COLOR") == nullptr;
  winsize window{};
  if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &window) == 0 && window.ws_col > 0) {
    style.columns = window.ws_col;
  }
  return style;
}

/// A line that gives way to the next thing said.
void SayForNow(const std::string& what) {
  if (isatty(STDERR_FILENO) == 1) std::fprintf(stderr, "  measuring %s ...\r", what.c_str());
}
void WipeForNow() {
  if (isatty(STDERR_FILENO) == 1) std::fputs("\x1b[2K", stderr);
}

int Run(const Options& options) {
  SetUpLog("palpate-doctor", options.log_level);
  const Style style = StyleOfOutput();
  StopSignal stop;
  if (!options.json) {
    std::printf("palpate-doctor %s on %s\n\n", PALPATE_VERSION, HostLine().c_str());
    std::fflush(stdout);
  }
  const auto report = Examine(
      options, stop,
      [&](const Finding& finding) {
        WipeForNow();
        if (options.json) return;
        std::fputs(ToText(finding, style).c_str(), stdout);
        std::fflush(stdout);
      },
      SayForNow);
  if (!report) {
    std::fputs("palpate-doctor: stopped before a verdict\n", stderr);
    return 1;
  }
  const std::string end = options.json ? ToJson(*report) : Summary(*report, style);
  std::fputs(end.c_str(), stdout);
  return Worst(report->findings) == Status::kFault ? 1 : 0;
}

}  // namespace
}  // namespace palpate::doctor

int main(int argc, char** argv) {
  return palpate::RunProgram("palpate-doctor", [&] {
    const auto options = palpate::doctor::ParseOptions(argc, argv);
    return options ? palpate::doctor::Run(*options) : 0;
  });
}
