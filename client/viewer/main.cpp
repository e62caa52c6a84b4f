#include "client/viewer/gateway.h"
#include "client/viewer/options.h"
#include "common/command_line.h"
#include "common/log.h"
#include "common/stop_signal.h"

int main(int argc, char** argv) {
  return palpate::RunProgram("palpate-viewer", [&] {
    const auto options = palpate::ParseViewerOptions(argc, argv);
    if (!options) return 0;
    palpate::SetUpLog("palpate-viewer", options->log_level);
    palpate::StopSignal stop;
    palpate::RunGateway(*options, stop);
    return 0;
  });
}
