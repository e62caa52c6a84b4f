#include "client/replayer/commands/commands.h"
#include "common/program/stop_signal.h"

namespace palpate {

void PlayCommand::AddTo(const CommandLine& app) {
  const Option verify = app.Find("--verify"), guide = app.Find("--guide");
  app.Add("--rate", playback.rate, "speed relative to the recording; at most 2 with --guide")
      .Range(0.01, 100.0)
      .Excludes(verify)
      .ShowDefault();
  const Option loop = app.AddFlag("--loop", playback.loop, "repeat until Ctrl-C").Excludes(verify);
  app.AddFlag(
         "--stay", play.stays,
         "wait at the end until Ctrl-C, so that viewers can go back; otherwise the replay ends "
         "there unless a viewer has steered it")
      .Excludes(verify)
      .Excludes(guide)
      .Excludes(loop);
  app.AddFlag("--locked", play.locked,
              "viewers may watch but not steer: no pause, seek or bookmarks")
      .Excludes(verify)
      .Excludes(guide);
  app.AddFlag("--step", play.stepping, "begin paused: space resumes, the right arrow steps")
      .Excludes(verify)
      .Excludes(guide);
  app.Add("--from", playback.from_s,
          "begin at this time of the recording, in seconds (with --guide: of the hand's path)")
      .NotNegative()
      .Excludes(verify);
  app.Add("--to", playback.to_s, "end at this time, in seconds").Positive().Excludes(verify);
}

int PlayCommand::Run() const {
  StopSignal stop;
  Play(playback, play, stop);
  return 0;
}

}  // namespace palpate
