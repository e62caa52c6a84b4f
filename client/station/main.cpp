#include "client/station/options.h"
#include "client/station/station.h"
#include "common/files/private_file.h"
#include "common/program/command_line.h"
#include "common/program/log.h"
#include "common/program/stop_signal.h"

int main(int argc, char** argv) {
  return palpate::RunProgram("palpate-station", [&] {
    const auto options = palpate::ParseOptions(argc, argv);
    if (!options) return 0;
    palpate::KeepFilesPrivate();
    palpate::SetUpLog("palpate-station", options->log_level);
    palpate::StopSignal stop;
    palpate::RunStation(*options, stop);
    return 0;
  });
}
