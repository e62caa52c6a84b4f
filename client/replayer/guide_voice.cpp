#include "client/replayer/guide_voice.h"

#include <algorithm>
#include <chrono>
#include <cstdio>

#include "client/replayer/hand_path.h"
#include "client/replayer/playback_clock.h"
#include "common/dds/endpoint.h"
#include "common/dds/topics.h"
#include "common/error.h"
#include "common/random_run.h"
#include "common/time/steady_clock.h"

namespace palpate {
namespace {

constexpr std::chrono::milliseconds kPeriod{10};

}  // namespace

void Guide(const ReplayOptions& options, StopSignal& stop) {
  const HandPath path = ReadHandPath(options.files);
  const double end_s = std::min(options.to_s, path.duration_s());
  if (options.from_s >= end_s) throw UsageError("--from is behind the path's end");
  const dds::Participant service = dds::Participant::Service(options.domain, options.network);
  dds::Writer<wire::GuideTarget> writer(service, dds::kGuideTopic, dds::Qos::kStream);
  std::printf("leading station %s along %.1f s of %s's path at %g x, domain %d\n",
              options.guide.c_str(), end_s - options.from_s, path.station.c_str(), options.rate,
              options.domain);
  std::fflush(stdout);

  wire::GuideTarget target{};
  wire::FromText(options.guide, target.station);
  const auto from_ns = static_cast<std::int64_t>(1e9 * options.from_s);
  bool heard = false;
  do {
    target.run = RandomRun();
    PlaybackClock clock(options.rate, false);
    clock.Begin(from_ns, SteadyNanoseconds());
    for (;;) {
      const double now_s = 1e-9 * static_cast<double>(clock.At(SteadyNanoseconds()));
      if (now_s > end_s) break;
      const auto next = std::ranges::upper_bound(path.time_s, now_s);
      const auto i =
          static_cast<std::size_t>(std::max<std::ptrdiff_t>(next - path.time_s.begin() - 1, 0));
      wire::FromPose(path.X_WH[i], target.position_m, target.orientation_wxyz);
      ++target.number;
      writer.Write(target);
      heard = heard || writer.matched_readers() > 0;
      if (stop.WaitFor(kPeriod)) return;
    }
  } while (options.loop);
  if (!heard) {
    throw Error("nobody listened: start the station with --accept-guide, in the same --domain");
  }
  std::puts("ended");
}

}  // namespace palpate
