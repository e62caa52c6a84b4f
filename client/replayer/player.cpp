#include "client/replayer/player.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <map>
#include <random>
#include <string>
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
         type == RecordedType::kSceneWhole || type == RecordedType::kSceneBundle ||
         type == RecordedType::kToolState || type == RecordedType::kLoopStatistics ||
         type == RecordedType::kStationStatistics;
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

Span Measure(RecordingReader& reader, const StopSignal& stop) {
  Span span;
  RecordedSample sample{};
  bool any = false;
  while (!stop.stopped() && reader.Next(sample)) {
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
  Voice(int domain, const dds::Network& network)
      : service_(dds::Participant::Service(domain, network)),
        states_(service_, dds::kSessionStateTopic, dds::Qos::kSession),
        changes_(service_, dds::kSceneChangeTopic, dds::Qos::kSession),
        wholes_(service_, dds::kSceneWholeTopic, dds::Qos::kSession),
        bundles_(service_, dds::kSceneBundleTopic, dds::Qos::kSession),
        tools_(service_, dds::kToolStateTopic, dds::Qos::kStream),
        statistics_(service_, dds::kLoopStatisticsTopic, dds::Qos::kStream),
        stations_(service_, dds::kStationStatisticsTopic, dds::Qos::kStream) {}

  void Say(const RecordedSample& sample) {
    switch (sample.type) {
      case RecordedType::kSessionState:
        return Say(sample, states_);
      case RecordedType::kSceneChange:
        return Say(sample, changes_);
      case RecordedType::kSceneWhole:
        return Say(sample, wholes_);
      case RecordedType::kSceneBundle:
        return Say(sample, bundles_);
      case RecordedType::kToolState:
        return Say(sample, tools_);
      case RecordedType::kLoopStatistics:
        return Say(sample, statistics_);
      case RecordedType::kStationStatistics:
        return Say(sample, stations_);
      default:
        return;
    }
  }
  /// What comes from here on is another server's, which viewers take for a new one: its scenes are
  /// whole again.
  void BeginRound() { run_ = std::uint64_t{random_()} << 32 | random_(); }
  /// Ends every session that still stands.
  void End() {
    for (auto& [station, state] : standing_) {
      state.phase = palpate_SESSION_ENDED;
      wire::FromText("the replay has ended", state.reason);
      states_.Write(state);
    }
    standing_.clear();
  }

 private:
  template <class T>
  void Say(const RecordedSample& sample, dds::Writer<T>& writer) {
    T value{};
    if (sample.To(value)) {
      // Of one recording: its servers' runs stay apart.  Viewers ignore runs that they know as
      // over.
      if constexpr (requires { value.server_run; }) value.server_run += run_;
      writer.Write(value);
      if constexpr (std::is_same_v<T, wire::SessionState>) Keep(value);
    }
    dds::FreeContents(value);
  }
  void Keep(const wire::SessionState& state) {
    if (state.phase == palpate_SESSION_ENDED || state.phase == palpate_SESSION_REFUSED) {
      standing_.erase(state.station);
    } else {
      standing_[state.station] = state;
    }
  }

  std::random_device random_;
  std::uint64_t run_ = 0;
  std::map<std::string, wire::SessionState> standing_;
  dds::Participant service_;
  dds::Writer<wire::SessionState> states_;
  dds::Writer<wire::SceneChange> changes_;
  dds::Writer<wire::SceneWhole> wholes_;
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
        span_(Measure(reader_, stop)),
        clock_(options.rate, options.stepping) {
    if (stop.stopped()) return;
    if (span_.for_viewers == 0) {
      throw Error(options.files.front() + ": holds nothing that viewers see; record it anew");
    }
    for (const std::string& problem : reader_.problems()) spdlog::warn("{}", problem);
    const double length_s = 1e-9 * static_cast<double>(span_.last_ns - span_.first_ns);
    if (options.from_s > length_s) {
      throw UsageError("--from is behind the recording's end, at " + std::to_string(length_s) +
                       " s");
    }
    from_ns_ = span_.first_ns + static_cast<std::int64_t>(1e9 * options.from_s);
    to_ns_ = span_.first_ns + static_cast<std::int64_t>(1e9 * std::min(options.to_s, length_s));
  }

  void Play(Voice& voice) {
    while (!stop_.stopped() && PlayOnce(voice) && options_.loop) {
    }
    voice.End();
    // Who listens is to have it all.
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  double length_s() const { return 1e-9 * static_cast<double>(to_ns_ - from_ns_); }
  std::uint64_t said() const { return said_; }

 private:
  /// False where it was ended before the recording did.
  bool PlayOnce(Voice& voice) {
    reader_.Restart();
    voice.BeginRound();
    bool begun = false;  // the clock: what came before takes its time to read
    RecordedSample sample{};
    while (reader_.Next(sample)) {
      if (sample.log_time_ns < from_ns_) {
        if (stop_.stopped()) return false;
        if (IsForViewers(sample.type) && Stays(sample.type)) Say(voice, sample);
        continue;
      }
      if (!begun) clock_.Begin(from_ns_, SteadyNanoseconds());
      begun = true;
      if (sample.log_time_ns > to_ns_) break;
      if (!IsForViewers(sample.type)) continue;
      if (!Await(sample.log_time_ns, sample.type)) return false;
      Say(voice, sample);
    }
    return Await(to_ns_, RecordedType::kToolState);
  }

  void Say(Voice& voice, const RecordedSample& sample) {
    voice.Say(sample);
    ++said_;
  }

  /// Until the time of a sample of that type has come; false where the replay is ended.
  bool Await(std::int64_t time_ns, RecordedType type) {
    for (;;) {
      const std::int64_t now_ns = SteadyNanoseconds();
      Show(time_ns, now_ns);
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
        if (type == RecordedType::kToolState) {
          step_ = false;
          clock_.Begin(time_ns, now_ns);
        }
        return true;
      }
      if (clock_.At(now_ns) >= time_ns) return !stop_.stopped();
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
  if (stop.stopped()) return;
  const ServerLock lock(options.domain);
  Voice voice(options.domain, options.network);
  std::printf("replaying %s: %.1f s at %g x, domain %d\n", options.files.front().c_str(),
              player.length_s(), options.rate, options.domain);
  std::fflush(stdout);
  player.Play(voice);
  std::printf("\nended after %llu samples\n", static_cast<unsigned long long>(player.said()));
}

}  // namespace palpate
