#include <cstdio>
#include <optional>

#include <unistd.h>

#include "client/replayer/certificate/certificate.h"
#include "client/replayer/export/export.h"
#include "client/replayer/export/solid_export.h"
#include "client/replayer/guide/guide.h"
#include "client/replayer/options.h"
#include "client/replayer/play/player.h"
#include "client/replayer/score/score_report.h"
#include "client/replayer/verify/verify.h"
#include "common/files/private_file.h"
#include "common/program/command_line.h"
#include "common/program/stop_signal.h"
#include "common/text/quoted.h"

namespace palpate {
namespace {

constexpr int kPolite = 10;

int Run(const ReplayOptions& options) {
  KeepFilesPrivate();
  switch (options.what) {
    case ReplayOptions::What::kVerify: {
      const Verification verification = Verify(options.playback.files, options.verify);
      if (options.json != "-") std::fputs(ToText(verification).c_str(), stdout);
      if (!options.json.empty()) WriteJson(verification, options.json);
      return verification.good() ? 0 : 1;
    }
    case ReplayOptions::What::kVerifySealed: {
      const Certificate certificate = VerifySealed(options.sealed);
      if (options.json != "-") std::fputs(ToText(certificate).c_str(), stdout);
      if (!options.json.empty()) WriteJson(certificate, options.json);
      if (!options.out.empty()) {
        WriteCertificate(certificate, options.out);
        std::fprintf(stderr, "open %s\n", ShellWord(options.out + "/certificate.html").c_str());
      }
      return certificate.good() ? 0 : 1;
    }
    case ReplayOptions::What::kPlay: {
      StopSignal stop;
      Play(options.playback, options.play, stop);
      return 0;
    }
    case ReplayOptions::What::kGuide: {
      StopSignal stop;
      Guide(options.playback, options.guide, stop);
      return 0;
    }
    case ReplayOptions::What::kRehearse:
    case ReplayOptions::What::kScore: {
      const bool scores = options.what == ReplayOptions::What::kScore;
      std::optional<StopSignal> stop;
      if (options.score.follow) {
        stop.emplace();
        std::fprintf(stderr, "following %s\n", Printable(options.score.trials.front()).c_str());
        // While it waits, the class's servo loops must not be disturbed.
        (void)!nice(kPolite);
      }
      const Report report = scores ? MakeReport(options.score, stop ? &*stop : nullptr)
                                   : Rehearse(LoadExercise(options.exercise));
      if (options.json != "-") std::fputs(ToText(report).c_str(), stdout);
      if (!options.json.empty()) WriteJson(report, options.json);
      if (!options.out.empty()) {
        WriteReport(report, options.out);
        std::fprintf(stderr, "open %s\n", ShellWord(options.out + "/score.html").c_str());
      }
      return scores || Passed(report) ? 0 : 1;
    }
    case ReplayOptions::What::kExport: {
      StopSignal stop;
      if (options.exports_solids) {
        ExportSolids(options.solids, stop);
      } else {
        Export(options.columns, stop);
      }
      return 0;
    }
    case ReplayOptions::What::kSteps:
      RecordSteps(options.steps);
      std::printf("%s: verify it with palpate-replay --verify %s\n",
                  Printable(options.steps.file).c_str(), ShellWord(options.steps.file).c_str());
      return 0;
    case ReplayOptions::What::kCriteria:
      WriteNewCriteria(options.new_criteria, options.criteria_of);
      std::printf(
          "%s: edit it, then score with: palpate-replay score EXPERT TRIALS --criteria %s\n",
          Printable(options.new_criteria).c_str(), ShellWord(options.new_criteria).c_str());
      return 0;
  }
  return 1;
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  return palpate::RunProgram("palpate-replay", argc, argv, palpate::ParseReplayOptions,
                             palpate::Run);
}
