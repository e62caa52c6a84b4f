#pragma once

#include <optional>
#include <string>

#include "client/replayer/export/export.h"
#include "client/replayer/export/solid_export.h"
#include "client/replayer/guide/guide.h"
#include "client/replayer/play/player.h"
#include "client/replayer/playback.h"
#include "client/replayer/score/score_report.h"
#include "client/replayer/steps/record_steps.h"
#include "client/replayer/verify/sealed.h"
#include "client/replayer/verify/verify.h"

namespace palpate {

struct ReplayOptions {
  enum class What {
    kPlay,
    kVerify,
    kVerifySealed,
    kGuide,
    kScore,
    kRehearse,
    kCriteria,
    kExport,
    kSteps
  };
  What what = What::kPlay;
  Playback playback;  ///< of kPlay and kGuide; kVerify takes its files
  PlayOptions play;
  VerifyOptions verify;
  SealedOptions sealed;
  GuideOptions guide;
  ScoreOptions score;
  std::string out;           ///< folder of kScore and kVerifySealed; empty: none
  std::string json;          ///< file or "-" of these and kVerify; empty: none
  std::string exercise;      ///< file of kRehearse
  std::string new_criteria;  ///< file that kCriteria writes
  std::string criteria_of;   ///< scene of kCriteria; empty: periodontal probing
  ExportOptions columns;     ///< of kExport, unless it exports solids
  bool exports_solids = false;
  SolidExportOptions solids;
  StepsOptions steps;

  std::string log_level = "info";
};

/// Reads the command line.  For --help and --version prints them and returns nothing.
/// Throws UsageError.
std::optional<ReplayOptions> ParseReplayOptions(int argc, const char* const* argv);

}  // namespace palpate
