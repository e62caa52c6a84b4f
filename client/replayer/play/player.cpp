#include "client/replayer/play/player.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include <fmt/format.h>
#include <poll.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include "client/replayer/play/playhead.h"
#include "client/replayer/play/steering.h"
#include "client/replayer/play/timeline.h"
#include "client/replayer/play/voice.h"
#include "common/dds/server_lock.h"
#include "common/error.h"
#include "common/realtime/steady_clock.h"
#include "common/recording/recording_reader.h"
#include "common/text/quoted.h"

namespace palpate {
namespace {

/// Returns the next byte; -1 if none has come.
int NextByte() {
  pollfd input{STDIN_FILENO, POLLIN, 0};
  unsigned char byte = 0;
  return poll(&input, 1, 0) == 1 && read(STDIN_FILENO, &byte, 1) == 1 ? byte : -1;
}

constexpr std::chrono::milliseconds kPoll{2};
/// Period of the replay's state for viewers and terminal.
constexpr std::int64_t kTell_ns = 200'000'000;
constexpr std::int64_t kShow_ns = 100'000'000;
/// While paused, tools are repeated at this period, for viewers that come then.
constexpr std::int64_t kRepeat_ns = 1'000'000'000;
/// Distance that an arrow key moves.
constexpr std::int64_t kArrow_ns = 5'000'000'000;
/// `p` skips a mark that was passed less than kJustPassed_s ago, and `n` a mark at the present
/// position (within kHere_s).  [s], as on the page.
constexpr double kJustPassed_s = 0.8, kHere_s = 0.05;
constexpr std::array<double, 7> kRates = {0.1, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0};

Timeline Look(RecordingReader& reader, const StopSignal& stop) {
  Timeline timeline;
  RecordedSample sample{};
  while (!stop.stopped() && reader.Next(sample)) timeline.Add(sample, reader.place());
  timeline.Finish();
  return timeline;
}

/// An indexed recording, and the part of it to play.
struct RecordedLesson {
  RecordedLesson(const Playback& playback, const StopSignal& stop)
      : reader(playback.files), timeline(Look(reader, stop)) {
    if (stop.stopped()) return;
    const std::string& file = playback.files.front();
    if (timeline.for_viewers() == 0) {
      throw Error(file + ": has nothing to show; record it again");
    }
    for (const std::string& problem : reader.problems()) spdlog::warn("{}", problem);
    if (timeline.left_out() > 0) {
      spdlog::info("{}: {} further marks and gaps are not shown to viewers", file,
                   timeline.left_out());
    }
    const double length_s = Seconds(timeline.last_ns());
    if (playback.from_s > length_s) {
      throw UsageError("--from is after the end of the recording, at " + std::to_string(length_s) +
                       " s");
    }
    from_ns = Time(playback.from_s);
    to_ns = Time(std::min(playback.to_s, length_s));
  }
  double Seconds(std::int64_t time_ns) const {
    return 1e-9 * static_cast<double>(time_ns - timeline.first_ns());
  }
  std::int64_t Time(double seconds) const {
    return timeline.first_ns() + std::llround(1e9 * seconds);
  }

  RecordingReader reader;
  const Timeline timeline;
  std::int64_t from_ns = 0, to_ns = 0;
};

/// The part of a replay's state that its clock does not hold.
struct Now {
  double sought = 1.0;
  bool ended = false;
};

class Player {
 public:
  Player(const Playback& playback, const PlayOptions& options, RecordedLesson& material,
         const dds::Participant& service, StopSignal& stop)
      : playback_(playback),
        options_(options),
        material_(material),
        timeline_(material.timeline),
        playhead_(material.reader, timeline_),
        stop_(stop),
        voice_(service, stop),
        steering_(service, playback.files.front(), timeline_, options.locked),
        clock_(playback.rate, options.stepping) {}

  void Play() {
    if (terminal_) std::fprintf(stderr, "%s\n", Keyboard::kHelp);
    while (!stop_.stopped() && PlayOnce() && playback_.loop) {
    }
    voice_.EndSessions("the replay has ended");
    Tell(SteadyNanoseconds(), {.ended = true});
    // Lets the last samples reach the viewers.
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  std::uint64_t said() const { return said_; }

 private:
  /// How a wait for a time ended: the time has come, the replay has moved elsewhere, or it is over.
  enum class Wait { kCome, kElsewhere, kOver };

  /// Returns false if it ended before the recording's end.
  bool PlayOnce() {
    if (!Go(material_.from_ns, true)) return false;
    for (;;) {
      RecordedSample sample{};
      const bool more = Next(sample);
      const Wait wait =
          more ? Await(playhead_.passed_ns(), sample.type == RecordedType::kToolState) : AwaitEnd();
      if (wait == Wait::kOver) return false;
      if (wait == Wait::kElsewhere) continue;
      if (!more) return true;
      published_up_to_ns_ = playhead_.passed_ns() - 1;
      published_some_of_ns_ = playhead_.passed_ns();
      if (!Stays(sample.type)) {
        latest_[Timeline::SourceOf(sample)].assign(sample.cdr.begin(), sample.cdr.end());
      }
      if (!Say(sample.type, sample.cdr)) return false;
    }
  }

  /// Returns the next sample for viewers; false if there is none before the end.
  bool Next(RecordedSample& sample) {
    return playhead_.Next(sample) && playhead_.passed_ns() <= material_.to_ns;
  }

  bool Say(RecordedType type, std::span<const std::uint8_t> cdr) {
    ++said_;
    return voice_.Say(type, cdr);
  }

  /// Moves to a moment: publishes the state that holds then, and the last streamed samples.
  /// @param anew  viewers are to forget their state; they also are if it cannot lead to
  ///              that moment.
  /// Returns false if the replay is stopped meanwhile.
  bool Go(std::int64_t time_ns, bool anew) {
    const Timeline::Moment wanted = timeline_.At(time_ns);
    Timeline::Moment published;
    if (anew || voice_.lacks() || !LeadsTo(timeline_.At(published_some_of_ns_), wanted)) {
      voice_.BeginRound();
    } else {
      published = timeline_.At(published_up_to_ns_);
    }
    clock_.Begin(time_ns, SteadyNanoseconds());
    const std::vector<const Timeline::State*> rest = RestOf(wanted, published);
    for (std::size_t i = 0; i < rest.size(); ++i) {
      TellIfDue({.sought = static_cast<double>(i) / static_cast<double>(rest.size())});
      if (!Say(rest[i]->type, rest[i]->cdr)) return false;
    }
    published_up_to_ns_ = published_some_of_ns_ = time_ns;
    latest_ = playhead_.GoTo(time_ns);
    std::erase_if(latest_, [&](const auto& entry) {
      const std::string& station = entry.first.second;
      return wanted.holds.contains({RecordedType::kSessionState, station, 0}) &&
             !voice_.has_session(station);
    });
    for (const auto& [source, cdr] : latest_) Say(source.first, cdr);
    // Publishing the state takes time: the clock starts after it.
    const std::int64_t now_ns = SteadyNanoseconds();
    clock_.Begin(time_ns, now_ns);
    repeated_ns_ = now_ns;
    Tell(now_ns);
    return !stop_.stopped();
  }

  /// Waits until a time.
  /// @param moves  a tool moves at that time, which ends a step.
  Wait Await(std::int64_t time_ns, bool moves) {
    for (;;) {
      const std::int64_t now_ns = SteadyNanoseconds();
      if (const Wait wait = Attend(now_ns); wait != Wait::kCome) return wait;
      if (step_) {
        if (moves) {
          step_ = false;
          clock_.Begin(time_ns, now_ns);
          Tell(now_ns);
        }
        return Wait::kCome;
      }
      if (clock_.At(now_ns) >= time_ns) return stop_.stopped() ? Wait::kOver : Wait::kCome;
      if (stop_.WaitFor(kPoll)) return Wait::kOver;
    }
  }

  /// Waits at the end, paused, if a viewer who steers may want to go back.
  Wait AwaitEnd() {
    Wait wait = Await(material_.to_ns, true);
    const bool is_left = playback_.loop || !(options_.stays || steering_.steered());
    if (wait != Wait::kCome || (is_left && !clock_.paused())) return wait;
    const std::int64_t end_ns = SteadyNanoseconds();
    clock_.SetPaused(true, end_ns);
    clock_.Begin(material_.to_ns, end_ns);
    Tell(end_ns);
    while (wait == Wait::kCome) {
      if (stop_.WaitFor(kPoll)) return Wait::kOver;
      wait = Attend(SteadyNanoseconds());
      step_ = false;
    }
    return wait;
  }

  /// Handles requests of terminal and viewers, and publishes the position.
  Wait Attend(std::int64_t now_ns) {
    sought_ns_.reset();
    const int key = keyboard_.Read();
    if (key == 'q') return Wait::kOver;
    Press(key, now_ns);
    bool changed = key != Keyboard::kNone;
    wire::ReplayRequest request{};
    while (steering_.Take(StateAt(now_ns), request)) {
      Follow(request, now_ns);
      changed = true;
    }
    if (sought_ns_) {
      // Only the last of several seeks counts, as when a viewer drags the bar.
      const std::int64_t first_ns = std::min(timeline_.opening_ns(), material_.to_ns);
      const bool gone = Go(std::clamp(*sought_ns_, first_ns, material_.to_ns), false);
      return gone ? Wait::kElsewhere : Wait::kOver;
    }
    if (changed) Tell(now_ns);
    TellIfDue();
    if (clock_.paused() && now_ns - repeated_ns_ >= kRepeat_ns) Repeat(now_ns);
    return Wait::kCome;
  }

  void Repeat(std::int64_t now_ns) {
    repeated_ns_ = now_ns;
    for (const auto& [source, cdr] : latest_) {
      if (voice_.has_session(source.second)) voice_.Say(source.first, cdr);
    }
  }

  void Press(int key, std::int64_t now_ns) {
    switch (key) {
      case ' ':
        return SetPaused(!clock_.paused(), now_ns);
      case Keyboard::kLeft:
        sought_ns_ = clock_.At(now_ns) - kArrow_ns;
        return;
      case Keyboard::kRight:
        // While paused, advances to the next sample that moves a tool, including those before it.
        step_ = clock_.paused();
        if (!step_) sought_ns_ = clock_.At(now_ns) + kArrow_ns;
        return;
      case 'p':
        return Seek(steering_.MarkBefore(At_s(now_ns) - kJustPassed_s * clock_.rate()));
      case 'n':
        return Seek(steering_.MarkAfter(At_s(now_ns) + kHere_s));
      case '-': {
        const auto rate = std::ranges::lower_bound(kRates, clock_.rate());
        if (rate != kRates.begin()) clock_.SetRate(*std::prev(rate), now_ns);
        return;
      }
      case '+': {
        const auto rate = std::ranges::upper_bound(kRates, clock_.rate());
        if (rate != kRates.end()) clock_.SetRate(*rate, now_ns);
        return;
      }
      case 'b':
        return AddBookmark(At_s(now_ns));
      default:
        return;
    }
  }

  void AddBookmark(double at_s) {
    try {
      steering_.AddBookmark(at_s, fmt::format("at {:.1f} s, from the terminal", at_s));
    } catch (const Error& error) {
      spdlog::error("{}", error.what());
    }
  }

  void Follow(const wire::ReplayRequest& request, std::int64_t now_ns) {
    switch (request.wish) {
      case palpate_REPLAY_PLAY:
        return SetPaused(false, now_ns);
      case palpate_REPLAY_PAUSE:
        return SetPaused(true, now_ns);
      case palpate_REPLAY_RATE:
        return clock_.SetRate(request.value, now_ns);
      case palpate_REPLAY_SEEK:
        return Seek(request.value);
      default:
        return;
    }
  }

  void Seek(std::optional<double> at_s) {
    if (at_s)
      sought_ns_ = material_.Time(std::clamp(*at_s, 0.0, material_.Seconds(material_.to_ns)));
  }

  /// Play at the end starts again from the beginning.
  void SetPaused(bool paused, std::int64_t now_ns) {
    const bool at_end = clock_.At(now_ns) >= material_.to_ns;
    if (clock_.paused() && !paused && at_end && !sought_ns_) sought_ns_ = material_.from_ns;
    clock_.SetPaused(paused, now_ns);
    if (!paused) step_ = false;
  }

  void TellIfDue(const Now& now = {}) {
    const std::int64_t now_ns = SteadyNanoseconds();
    if (now_ns - shared_ns_ >= kTell_ns) Tell(now_ns, now);
    if (terminal_ && now_ns - shown_ns_ >= kShow_ns) Show(now_ns);
  }

  double At_s(std::int64_t now_ns) const {
    return material_.Seconds(std::clamp(clock_.At(now_ns), timeline_.first_ns(), material_.to_ns));
  }

  Steering::State StateAt(std::int64_t now_ns, const Now& now = {}) const {
    return {.at_s = At_s(now_ns),
            .rate = clock_.rate(),
            .sought = now.sought,
            .playing = !clock_.paused() && !now.ended,
            .ended = now.ended};
  }

  void Tell(std::int64_t now_ns, const Now& now = {}) {
    shared_ns_ = now_ns;
    steering_.Tell(StateAt(now_ns, now));
  }

  void Show(std::int64_t now_ns) {
    shown_ns_ = now_ns;
    std::fprintf(stderr, "\r%8.2f / %.2f s  %g x%s\x1b[K", At_s(now_ns),
                 material_.Seconds(timeline_.last_ns()), clock_.rate(),
                 clock_.paused() ? "  paused" : "");
    std::fflush(stderr);
  }

  const Playback& playback_;
  const PlayOptions& options_;
  RecordedLesson& material_;
  const Timeline& timeline_;
  Playhead playhead_;
  StopSignal& stop_;
  Voice voice_;
  Steering steering_;
  PlaybackClock clock_;
  Keyboard keyboard_;
  std::optional<std::int64_t> sought_ns_;  // target of the present seek
  // Viewers have received everything up to the first, and perhaps part of the second.
  std::int64_t published_up_to_ns_ = 0, published_some_of_ns_ = 0;
  std::int64_t shared_ns_ = 0, shown_ns_ = 0, repeated_ns_ = 0;
  Playhead::Streams latest_;  // the last samples of streams shown to viewers
  bool step_ = false;
  const bool terminal_ = isatty(STDERR_FILENO) == 1;
  std::uint64_t said_ = 0;
};

}  // namespace

Keyboard::Keyboard() {
  // A background process that changes the terminal would be stopped.
  terminal_ = isatty(STDIN_FILENO) == 1 && tcgetpgrp(STDIN_FILENO) == getpgrp() &&
              tcgetattr(STDIN_FILENO, &former_) == 0;
  if (!terminal_) return;
  termios raw = former_;
  raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
  terminal_ = tcsetattr(STDIN_FILENO, TCSANOW, &raw) == 0;
}

Keyboard::~Keyboard() {
  if (terminal_) tcsetattr(STDIN_FILENO, TCSANOW, &former_);
}

int Keyboard::Read() {
  const int key = terminal_ ? NextByte() : kNone;
  if (key != 0x1b) return key;
  // ESC [ C, ESC [ D
  if (NextByte() != '[') return kNone;
  const int arrow = NextByte();
  return arrow == 'C' ? kRight : arrow == 'D' ? kLeft : kNone;
}

void Play(const Playback& playback, const PlayOptions& options, StopSignal& stop) {
  RecordedLesson material(playback, stop);
  if (stop.stopped()) return;
  const ServerLock lock(playback.domain);
  const dds::Participant service = dds::Participant::Service(playback.domain, playback.network);
  Player player(playback, options, material, service, stop);
  std::printf("replaying %s: %.1f s at %g x, domain %d\n",
              Printable(playback.files.front()).c_str(),
              1e-9 * static_cast<double>(material.to_ns - material.from_ns), playback.rate,
              playback.domain);
  std::fflush(stdout);
  player.Play();
  std::printf("\nended after %llu samples\n", static_cast<unsigned long long>(player.said()));
}

}  // namespace palpate
