#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "client/replayer/export.h"
#include "client/replayer/score_report.h"
#include "client/replayer/verify.h"
#include "common/dds/network.h"

namespace palpate {

struct ReplayOptions {
  enum class What { kPlay, kVerify, kGuide, kScore, kCriteria, kExport };
  What what = What::kPlay;
  std::vector<std::string> files;
  VerifyOptions verify;
  std::string json;  ///< of verify and score: file or "-"; empty: none

  // kPlay and kGuide
  double rate = 1.0;
  bool loop = false;
  bool stepping = false;  ///< begins paused
  bool locked = false;    ///< viewers may not steer
  bool stays = false;     ///< waits at the end
  double from_s = 0.0;
  double to_s = std::numeric_limits<double>::infinity();
  int domain = 0;
  dds::Network network;
  std::string guide;    ///< station to be guided
  std::string station;  ///< whose path guides it, as SessionChoice
  bool waits = true;    ///< the guide, for a hand that stays behind

  // kScore
  ScoreOptions score;
  std::string out;  ///< folder for the report; empty: none

  // kCriteria
  std::string new_criteria;  ///< file to write

  // kExport
  ExportOptions columns;

  std::string log_level = "info";
};

/// Reads the command line.  For --help and --version prints them and returns nothing.
/// Throws UsageError.
std::optional<ReplayOptions> ParseOptions(int argc, const char* const* argv);

}  // namespace palpate
