#include "client/replayer/guide/guide.h"

#include <chrono>
#include <cstdio>
#include <limits>
#include <utility>

#include "client/replayer/hand_path.h"
#include "common/dds/endpoint.h"
#include "common/dds/random_run.h"
#include "common/dds/topics.h"
#include "common/error.h"
#include "common/realtime/steady_clock.h"
#include "common/text/quoted.h"

namespace palpate {
namespace {

constexpr std::chrono::milliseconds kPeriod{10};
/// A hand's pose older than this counts as unknown.
constexpr double kKnown_s = 0.5;
/// Longest wait for a station that accepts the guide.
constexpr double kPatience_s = 5.0;
/// Longest step of the pace, so that a guide that was itself suspended does not jump.
constexpr double kLongestStep_s = 0.1;

/// The led hand, as its server publishes it.
class LedHand {
 public:
  LedHand(const dds::Participant& service, std::string station)
      : states_(service, dds::kToolStateTopic, dds::Qos::kRecord), station_(std::move(station)) {}

  /// Returns the distance from the hand to `aim` [m]; none without a recent pose of the hand.
  std::optional<double> Behind(const Vec3& aim, double now_s) {
    wire::ToolState state;
    while (states_.Take(state)) {
      if (station_ != state.station) continue;
      position_ = wire::ToVec3(state.haptic_position_m);
      heard_s_ = now_s;
    }
    if (!(now_s - heard_s_ < kKnown_s)) return std::nullopt;
    return (aim - position_).norm();
  }

 private:
  dds::Reader<wire::ToolState> states_;
  std::string station_;
  Vec3 position_ = Vec3::Zero();
  double heard_s_ = -std::numeric_limits<double>::infinity();
};

/// Returns the path's pose at a time: that of the last sample up to it.
const Pose& AimAt(const HandPath& path, double time_s) {
  const auto next = std::ranges::upper_bound(path.time_s, time_s);
  return path
      .X_WH[static_cast<std::size_t>(std::max<std::ptrdiff_t>(next - path.time_s.begin() - 1, 0))];
}

double Now_s() {
  return 1e-9 * static_cast<double>(SteadyNanoseconds());
}

}  // namespace

void Guide(const Playback& playback, const GuideOptions& options, StopSignal& stop) {
  const HandPath path = ReadHandPath(playback.files, {options.station});
  const double end_s = std::min(playback.to_s, path.duration_s());
  if (playback.from_s >= end_s) throw UsageError("--from is after the end of the path; give less");
  const dds::Participant service = dds::Participant::Service(playback.domain, playback.network);
  dds::Writer<wire::GuideTarget> writer(service, dds::kGuideTopic, dds::Qos::kStream);
  std::printf("guiding station %s along %.1f s of %s's path at %g x, domain %d\n",
              options.led.c_str(), end_s - playback.from_s, Printable(path.station).c_str(),
              playback.rate, playback.domain);
  std::fflush(stdout);

  LedHand hand(service, options.led);
  wire::GuideTarget target{};
  wire::FromText(options.led, target.station);
  // Discovery takes a while, and a path whose beginning no hand followed has not been led.
  for (const double begun_s = Now_s(); writer.matched_readers() == 0;) {
    if (stop.WaitFor(kPeriod)) return;
    if (Now_s() - begun_s < kPatience_s) continue;
    throw Error("no station accepts the guide; start it with --accept-guide, in the same --domain");
  }
  do {
    target.run = RandomRun();
    GuidePace pace(playback.rate, playback.from_s, options.waits);
    double last_s = Now_s();
    bool said = false;
    while (pace.time_s() <= end_s) {
      const Pose& aim = AimAt(path, pace.time_s());
      wire::FromPose(aim, target.position_m, target.orientation_wxyz);
      ++target.number;
      writer.Write(target);
      if (stop.WaitFor(kPeriod)) return;

      const bool listens = writer.matched_readers() > 0;
      const double now_s = Now_s();
      const std::optional<double> behind = hand.Behind(aim.p, now_s);
      // The guide does not wait for a station that does not receive its aims.
      pace.Advance(std::min(now_s - last_s, kLongestStep_s), listens ? behind : std::nullopt);
      last_s = now_s;
      if (pace.waiting() == said) continue;
      said = pace.waiting();
      if (said) {
        std::printf("at %.1f s: waiting for the hand, %.0f mm behind\n", pace.time_s(),
                    1e3 * *behind);
      } else {
        std::puts("the hand has caught up: continuing");
      }
      std::fflush(stdout);
    }
  } while (playback.loop);
  std::puts("ended");
}

}  // namespace palpate
