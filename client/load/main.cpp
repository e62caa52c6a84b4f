#include <cstdio>
#include <exception>

#include "client/load/load.h"
#include "client/load/options.h"
#include "common/error.h"
#include "common/log.h"
#include "common/stop_signal.h"

int main(int argc, char** argv) {
  const auto fail = [](const std::exception& error, int status) {
    std::fprintf(stderr, "palpate-load: %s\n", error.what());
    return status;
  };
  try {
    const auto options = palpate::ParseLoadOptions(argc, argv);
    if (!options) return 0;
    palpate::SetUpLog("palpate-load", options->log_level);
    palpate::StopSignal stop;
    palpate::RunLoad(*options, stop);
    return 0;
  } catch (const palpate::UsageError& error) {
    return fail(error, 2);
  } catch (const std::exception& error) {
    return fail(error, 1);
  }
}
