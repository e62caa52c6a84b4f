#include "client/replayer/commands/commands.h"
#include "common/dds/topics.h"
#include "common/error.h"
#include "common/program/stop_signal.h"

namespace palpate {
namespace {

/// At a higher rate, successive targets of a quick hand would lie so far apart that a station would
/// take them for jumps.
constexpr double kMostGuideRate = 2.0;

}  // namespace

void GuideCommand::AddTo(const CommandLine& app) {
  const Option guides =
      app.Add("--guide", guide.led, "guide the hand at this station along the recorded path")
          .Excludes(app.Find("--verify"));
  app.AddFlag("--no-wait", no_wait,
              "with --guide: keep the recorded speed even if the hand falls behind")
      .Needs(guides);
  app.Add("--station", guide.station,
          "with --guide: station whose path to follow, if the recording has several sessions; "
          "NAME/RUN if the station has several")
      .TypeName("NAME")
      .Needs(guides);
}

void GuideCommand::Check() const {
  if (!dds::IsStationName(guide.led)) {
    throw UsageError("--guide '" + guide.led + "': give the name of a station, as in its --id");
  }
  if (playback.rate > kMostGuideRate) {
    throw UsageError(
        "--rate: a hand is guided at most at twice the recorded speed; give 2 or less");
  }
}

int GuideCommand::Run() const {
  StopSignal stop;
  GuideOptions options = guide;
  options.waits = !no_wait;
  Guide(playback, options, stop);
  return 0;
}

}  // namespace palpate
