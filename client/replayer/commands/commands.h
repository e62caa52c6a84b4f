#pragma once

#include <optional>
#include <string>
#include <vector>

#include "client/replayer/export/export.h"
#include "client/replayer/export/solid_export.h"
#include "client/replayer/guide/guide.h"
#include "client/replayer/play/player.h"
#include "client/replayer/playback.h"
#include "client/replayer/score/score_report.h"
#include "client/replayer/steps/record_steps.h"
#include "client/replayer/verify/sealed.h"
#include "client/replayer/verify/verify.h"
#include "common/program/command_line.h"

// The commands of palpate-replay, each with its own options, in a file of its name.
//   AddTo  adds its options, or itself, to the command line; the object must outlive that.
//   Check  takes what was parsed.  Throws UsageError.
//   Run    carries it out.  Returns the exit status.  Throws Error.
namespace palpate {

/// Shows recordings to viewers; the command line names no command.
struct PlayCommand {
  Playback playback;
  PlayOptions play;

  /// @pre VerifyCommand and GuideCommand are added.
  void AddTo(const CommandLine& app);
  int Run() const;
};

/// --verify
struct VerifyCommand {
  bool given = false;
  std::vector<std::string> files;
  VerifyOptions verify;
  std::optional<std::string> key;  ///< file, if the seal is checked, too
  std::string json;                ///< file or "-"; empty: none

  void AddTo(const CommandLine& app);
  void Check() const;
  int Run() const;
};

/// --guide
struct GuideCommand {
  Playback playback;
  GuideOptions guide;
  bool no_wait = false;

  /// @pre VerifyCommand is added.
  void AddTo(const CommandLine& app);
  void Check() const;
  int Run() const;
};

struct ScoreCommand {
  ScoreOptions score;
  std::string out;   ///< folder; empty: none
  std::string json;  ///< file or "-"; empty: none

  CommandLine AddTo(const CommandLine& app);
  void Check() const;
  int Run() const;
};

struct VerifyExamCommand {
  SealedOptions sealed;
  std::string out, json;  ///< as ScoreCommand's

  CommandLine AddTo(const CommandLine& app);
  void Check() const {}
  int Run() const;
};

struct RehearseCommand {
  std::string exercise;   ///< file
  std::string out, json;  ///< as ScoreCommand's

  CommandLine AddTo(const CommandLine& app);
  void Check() const {}
  int Run() const;
};

struct CriteriaCommand {
  std::string file;   ///< to write
  std::string scene;  ///< empty: for periodontal probing

  CommandLine AddTo(const CommandLine& app);
  void Check() const {}
  int Run() const;
};

struct ExportCommand {
  ExportOptions columns;
  bool exports_solids = false;
  SolidExportOptions solids;

  CommandLine AddTo(const CommandLine& app);
  void Check();
  int Run() const;
};

struct StepsCommand {
  StepsOptions steps;

  CommandLine AddTo(const CommandLine& app);
  void Check() const {}
  int Run() const;
};

}  // namespace palpate
