#include "client/load/load.h"
#include "client/load/options.h"
#include "common/program/command_line.h"
#include "common/program/log.h"
#include "common/program/stop_signal.h"

int main(int argc, char** argv) {
  return palpate::RunProgram("palpate-load", [&] {
    const auto options = palpate::ParseLoadOptions(argc, argv);
    if (!options) return 0;
    palpate::SetUpLog("palpate-load", options->log_level);
    palpate::StopSignal stop;
    palpate::RunLoad(*options, stop);
    return 0;
  });
}
