#include "client/crtk/bridge.h"
#include "common/program/command_line.h"
#include "common/program/log.h"

int main(int argc, char** argv) {
  return palpate::RunProgram("palpate-crtk", [&] {
    const auto options = palpate::ParseOptions(argc, argv);
    if (!options) return 0;
    palpate::SetUpLog("palpate-crtk", options->log_level);
    palpate::StopSignal stop;
    palpate::Bridge(*options, stop);
    return 0;
  });
}
