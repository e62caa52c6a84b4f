#include "client/replayer/player.h"

#include <chrono>
#include <cstdio>
#include <optional>
#include <thread>

#include <spdlog/spdlog.h>
#include <unistd.h>

#include "client/replayer/keyboard.h"
#include "client/replayer/playback_clock.h"
#include "common/dds/cdr_reader.h"
#include "common/dds/endpoint.h"
#include "common/dds/topics.h"
#include "common/error.h"
#include "common/recording/recording_reader.h"
#include "common/server_lock.h"
#include "common/time/steady_clock.h"

namespace palpate {
namespace {

constexpr std::chrono::milliseconds kPoll{2};

bool IsForViewers(RecordedType type) {
  return type == RecordedType::kSessionState || type == RecordedType::kSceneChange ||
         type == RecordedType::kSceneBundle || type == RecordedType::kToolState ||
         type == RecordedType::kLoopStatistics || type == RecordedType::kStationStatistics;
}

/// What holds on once it is said, and is said even of the time before the replay begins.
bool Stays(RecordedType type) {
  return type != RecordedType::kToolState && type != RecordedType::kLoopStatistics &&
         type != RecordedType::kStationStatistics;
}

struct Span {
  std::int64_t first_ns = 0, last_ns = 0;
  std::uint64_t for_viewers = 0;
};

Span Measure(RecordingReader& reader) {
  Span span;
  RecordedSample sample{};
  bool any = false;
  while (reader.Next(sample)) {
    if (!any) span.first_ns = span.last_ns = sample.log_time_ns;
    any = true;
    span.last_ns = std::max(span.last_ns, sample.log_time_ns);
    span.for_viewers += IsForViewers(sample.type);
  }
  return span;
}

/// Speaks as a server: the writers that viewers listen to.
class Voice {
 public:
  explicit Voice(int domain)
      : service_(dds::Participant::Service(domain)),
        states_(service_, dds::kSessionStateTopic, dds::Qos::kSession),
        changes_(service_, dds::kSceneChangeTopic, dds::Qos::kSession),
        bundles_(service_, dds::kSceneBundleTopic, dds::Qos::kSession),
        tools_(service_, dds::kToolStateTopic, dds::Qos::kStream),
        statistics_(service_, dds::kLoopStatisticsTopic, dds::Qos::kStream),
        stations_(service_, dds::kStationStatisticsTopic, dds::Qos::kStream) {}

  /// @param round  added to the server's run, so that each round finds its scenes whole again.
  void Say(const RecordedSample& sample, std::uint64_t round) {
    switch (sample.type) {
      case RecordedType::kSessionState:
        return Say(sample, round, states_);
      case RecordedType::kSceneChange:
        return Say(sample, round, changes_);
      case RecordedType::kSceneBundle:
        return Say(sample, round, bundles_);
      case RecordedType::kToolState:
        return Say(sample, round, tools_);
      case RecordedType::kLoopStatistics:
        return Say(sample, round, statistics_);
      case RecordedType::kStationStatistics:
        return Say(sample, round, stations_);
      default:
        return;
    }
  }

 private:
  template <class T>
  static void Say(const RecordedSample& sample, [[maybe_unused]] std::uint64_t round,
                  dds::Writer<T>& writer) {
    T value{};
    if (sample.To(value)) {
      if constexpr (requires { value.server_run; }) value.server_run += round;
      writer.Write(value);
    }
    dds::FreeContents(value);
  }

  dds::Participant service_;
  dds::Writer<wire::SessionState> states_;
  dds::Writer<wire::SceneChange> changes_;
  dds::Writer<wire::SceneBundle> bundles_;
  dds::Writer<wire::ToolState> tools_;
  dds::Writer<wire::LoopStatistics> statistics_;
  dds::Writer<wire::StationStatistics> stations_;
};

class Player {
 public:
  Player(const ReplayOptions& options, StopSignal& stop)
      : options_(options),
        stop_(stop),
        reader_(options.files),
        span_(Measure(reader_)),
        clock_(options.rate, options.stepping) {
    if (span_.for_viewers == 0) {
      throw Error(options.files.front() + ": holds nothing that viewers see; record it anew");
    }
    for (const std::string& problem : reader_.problems()) spdlog::warn("{}", problem);
    from_ns_ = span_.first_ns + static_cast<std::int64_t>(1e9 * options.from_s);
    to_ns_ = span_.last_ns;
    if (options.to_s < 1e-9 * static_cast<double>(to_ns_ - span_.first_ns)) {
      to_ns_ = span_.first_ns + static_cast<std::int64_t>(1e9 * options.to_s);
    }
    if (from_ns_ > span_.last_ns) {
      throw UsageError("--from is behind the recording's end, at " +
                       std::to_string(1e-9 * static_cast<double>(span_.last_ns - span_.first_ns)) +
                       " s");
    }
  }

  void Play(Voice& voice) {
    std::uint64_t round = 0;
    do {
      if (!PlayOnce(voice, round++)) return;
    } while (options_.loop);
    // Who listens is to have it all.
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  double length_s() const { return 1e-9 * static_cast<double>(to_ns_ - from_ns_); }
  std::uint64_t said() const { return said_; }

 private:
  /// False where it was ended before the recording did.
  bool PlayOnce(Voice& voice, std::uint64_t round) {
    reader_.Restart();
    clock_.Begin(from_ns_, SteadyNanoseconds());
    RecordedSample sample{};
    while (reader_.Next(sample)) {
      if (!IsForViewers(sample.type)) continue;
      if (sample.log_time_ns < from_ns_) {
        if (Stays(sample.type)) Say(voice, sample, round);
        continue;
      }
      if (sample.log_time_ns > to_ns_) break;
      if (!Await(sample)) return false;
      Say(voice, sample, round);
    }
    return true;
  }

  void Say(Voice& voice, const RecordedSample& sample, std::uint64_t round) {
    voice.Say(sample, round);
    ++said_;
  }

  /// Until the sample's time has come; false where the replay is ended.
  bool Await(const RecordedSample& sample) {
    for (;;) {
      const std::int64_t now_ns = SteadyNanoseconds();
      Show(sample.log_time_ns, now_ns);
      switch (keyboard_.Read()) {
        case Keyboard::Key::kQuit:
          return false;
        case Keyboard::Key::kSpace:
          clock_.SetPaused(!clock_.paused(), now_ns);
          break;
        case Keyboard::Key::kRight:
          // To the next that moves: what comes before it goes along.
          if (!clock_.paused()) clock_.SetPaused(true, now_ns);
          step_ = true;
          break;
        case Keyboard::Key::kNone:
          break;
      }
      if (step_) {
        if (sample.type == RecordedType::kToolState) {
          step_ = false;
          clock_.Begin(sample.log_time_ns, now_ns);
        }
        return true;
      }
      if (clock_.At(now_ns) >= sample.log_time_ns) return !stop_.stopped();
      if (stop_.WaitFor(kPoll)) return false;
    }
  }

  void Show(std::int64_t at_ns, std::int64_t now_ns) {
    if (!terminal_ || now_ns - shown_ns_ < 100'000'000) return;
    shown_ns_ = now_ns;
    std::fprintf(stderr, "\r%8.2f / %.2f s%s  (space %s, -> step, q end)\x1b[K",
                 1e-9 * static_cast<double>(at_ns - span_.first_ns),
                 1e-9 * static_cast<double>(span_.last_ns - span_.first_ns),
                 clock_.paused() ? "  paused" : "", clock_.paused() ? "goes on" : "pauses");
    std::fflush(stderr);
  }

  const ReplayOptions& options_;
  StopSignal& stop_;
  RecordingReader reader_;
  const Span span_;
  PlaybackClock clock_;
  Keyboard keyboard_;
  std::int64_t from_ns_ = 0, to_ns_ = 0, shown_ns_ = 0;
  bool step_ = false;
  const bool terminal_ = isatty(STDERR_FILENO) == 1;
  std::uint64_t said_ = 0;
};

}  // namespace

void Play(const ReplayOptions& options, StopSignal& stop) {
  Player player(options, stop);
  const ServerLock lock(options.domain);
  Voice voice(options.domain);
  std::printf("replaying %s: %.1f s at %g x, domain %d\n", options.files.front().c_str(),
              player.length_s(), options.rate, options.domain);
  std::fflush(stdout);
  player.Play(voice);
  std::printf("\nended after %llu samples\n", static_cast<unsigned long long>(player.said()));
}

}  // namespace palpate
