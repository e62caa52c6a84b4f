#include <csignal>
#include <cstdio>
#include <exception>

#include "client/recorder/file_summary.h"
#include "client/recorder/options.h"
#include "client/recorder/recorder.h"
#include "common/error.h"
#include "common/log.h"
#include "common/stop_signal.h"

int main(int argc, char** argv) {
  const auto fail = [](const std::exception& error, int status) {
    std::fprintf(stderr, "palpate-record: %s\n", error.what());
    return status;
  };
  try {
    const auto options = palpate::ParseOptions(argc, argv);
    if (!options) return 0;
    palpate::SetUpLog("palpate-record", options->log_level);
    if (!options->info_files.empty()) {
      const palpate::FileSummary summary = palpate::Summarise(options->info_files);
      if (options->json != "-") std::fputs(palpate::ToText(summary).c_str(), stdout);
      if (!options->json.empty()) palpate::WriteJson(summary, options->json);
      return 0;
    }
    // A file that has grown to its limit (ulimit -f) is then an error of the write, as a full disk.
    std::signal(SIGXFSZ, SIG_IGN);
    palpate::StopSignal stop;
    palpate::Record(*options, stop);
    return 0;
  } catch (const palpate::UsageError& error) {
    return fail(error, 2);
  } catch (const std::exception& error) {
    return fail(error, 1);
  }
}
