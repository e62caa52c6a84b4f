#include <csignal>
#include <cstdio>

#include "client/recorder/file_summary.h"
#include "client/recorder/options.h"
#include "client/recorder/recorder.h"
#include "common/files/private_file.h"
#include "common/program/command_line.h"
#include "common/program/log.h"
#include "common/program/stop_signal.h"

int main(int argc, char** argv) {
  return palpate::RunProgram("palpate-record", [&] {
    const auto options = palpate::ParseOptions(argc, argv);
    if (!options) return 0;
    palpate::KeepFilesPrivate();
    palpate::SetUpLog("palpate-record", options->log_level);
    if (!options->info_files.empty()) {
      const palpate::FileSummary summary = palpate::Summarise(options->info_files);
      if (options->json != "-") std::fputs(palpate::ToText(summary).c_str(), stdout);
      if (!options->json.empty()) palpate::WriteJson(summary, options->json);
      return summary.intact() ? 0 : 1;
    }
    // A file that has grown to its limit (ulimit -f) is then an error of the write, as a full disk.
    std::signal(SIGXFSZ, SIG_IGN);
    palpate::StopSignal stop;
    palpate::Record(*options, stop);
    return 0;
  });
}
