#include "client/recorder/recorder.h"

#include <atomic>
#include <chrono>
#include <cstdio>
#include <exception>
#include <thread>

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include "client/recorder/sample_queue.h"
#include "client/recorder/taps.h"
#include "common/dds/topics.h"
#include "common/error.h"
#include "common/server_lock.h"
#include "common/time/steady_clock.h"

namespace palpate {
namespace {

constexpr std::chrono::milliseconds kPoll{5};
constexpr std::chrono::milliseconds kDrain{20};
/// Twice in the second that may be lost at most.
constexpr std::int64_t kFlush_ns = 500'000'000;
/// How long the disk may stand still: more than a minute of one station, four seconds of sixteen.
constexpr std::size_t kQueue = std::size_t{64} << 20;

/// Writes what comes out of the queue, in a thread of its own: a disk may stand still for seconds.
class WriterThread {
 public:
  struct Totals {
    std::atomic<std::uint64_t> messages{0}, bytes{0}, missing{0}, dropped{0};
  };

  WriterThread(RecordingWriter& recording, SampleQueue& queue, Taps& taps)
      : recording_(recording), queue_(queue), taps_(taps), thread_([this] { Run(); }) {}
  ~WriterThread() { Stop(); }
  WriterThread(const WriterThread&) = delete;
  WriterThread& operator=(const WriterThread&) = delete;

  /// Writes what is left.
  void Stop() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
  }
  bool failed() const { return failed_; }
  /// Once stopped: what went wrong, if anything did.
  std::exception_ptr error() const { return error_; }
  const Totals& totals() const { return totals_; }

 private:
  void Run() {
    try {
      std::int64_t flushed_ns = SteadyNanoseconds();
      bool last = false;
      while (!last) {
        last = stop_;
        if (!last) std::this_thread::sleep_for(kDrain);
        queue_.Swap(drained_);
        SampleQueue::ForEach(drained_, [&](const SampleQueue::Head& head, auto bytes) {
          const TappedTopic& topic = taps_.topic(head.channel);
          recording_.Add(topic.name, topic.type, head.time_ns, bytes);
        });
        Count();
        const std::int64_t now_ns = SteadyNanoseconds();
        if (now_ns - flushed_ns >= kFlush_ns || last) {
          recording_.Flush();
          flushed_ns = now_ns;
        }
      }
    } catch (const Error&) {
      error_ = std::current_exception();
      failed_ = true;
    }
  }

  void Count() {
    std::uint64_t dropped = 0;
    for (std::uint32_t i = 0; i < taps_.topics(); ++i) {
      const TappedTopic& topic = taps_.topic(i);
      const std::uint64_t of_topic = topic.dropped.load(std::memory_order_relaxed);
      if (of_topic > 0) recording_.SetDropped(topic.name, topic.type, of_topic);
      dropped += of_topic;
    }
    totals_.messages = recording_.messages();
    totals_.bytes = recording_.bytes();
    totals_.missing = recording_.missing();
    totals_.dropped = dropped;
  }

  RecordingWriter& recording_;
  SampleQueue& queue_;
  Taps& taps_;
  std::vector<std::uint8_t> drained_;
  Totals totals_;
  std::atomic<bool> stop_{false}, failed_{false};
  std::exception_ptr error_;
  std::thread thread_;
};

class ProgressLine {
 public:
  ProgressLine() : terminal_(isatty(STDERR_FILENO) == 1) {}

  void Show(double seconds, int sessions, const WriterThread::Totals& totals) {
    if (seconds - shown_s_ < (terminal_ ? 0.5 : 10.0)) return;
    shown_s_ = seconds;
    const std::string line =
        fmt::format("{:8.1f} s  {} session{}  {} messages  {:.1f} MB  missing {}  dropped {}",
                    seconds, sessions, sessions == 1 ? "" : "s", totals.messages.load(),
                    1e-6 * static_cast<double>(totals.bytes.load()), totals.missing.load(),
                    totals.dropped.load());
    std::fprintf(stderr, terminal_ ? "\r%s\x1b[K" : "%s\n", line.c_str());
    std::fflush(stderr);
    drawn_ = terminal_;
  }
  void End() {
    if (drawn_) std::fputc('\n', stderr);
    drawn_ = false;
  }

 private:
  const bool terminal_;
  bool drawn_ = false;
  double shown_s_ = 0.0;
};

/// What to say where no server is heard, and where there would be one.
std::string Silence(const RecorderOptions& options, double seconds) {
  const bool here = options.network.this_host();
  std::string text =
      fmt::format("nothing heard of a server in domain {} of {} for {:.0f} s", options.domain,
                  here ? "this host" : options.network.interface, seconds);
  if (!here) return text;
  std::string others;
  for (const auto& [domain, holder] : ServersOnThisHost(dds::kMaxDomain)) {
    if (domain == options.domain) {
      text += fmt::format("; {} has it: was one of them given --network?", holder);
    } else {
      others += fmt::format("{}--domain {} is {}'s", others.empty() ? "; " : ", ", domain, holder);
    }
  }
  return text + others;
}

}  // namespace

void Record(const RecorderOptions& options, StopSignal& stop) {
  const dds::TransportChoice transport = dds::ChooseTransport(options.transport, options.network);
  RecordingOptions recording_options = options.recording;
  recording_options.about["domain"] = std::to_string(options.domain);
  recording_options.about["loop"] = options.loop ? transport.reason : "not recorded";

  SampleQueue queue(kQueue);
  Taps taps(options.domain, options.network, transport, options.loop, queue);
  // Last: what it overwrites is lost only when there is something to record with.
  RecordingWriter recording(recording_options);
  WriterThread writer(recording, queue, taps);
  std::printf("recording to %s; domain %d; poses and wrenches: %s\n",
              recording.files().front().c_str(), options.domain,
              recording_options.about["loop"].c_str());
  std::fflush(stdout);

  ProgressLine progress;
  const std::int64_t began_ns = SteadyNanoseconds();
  const auto seconds = [&] { return 1e-9 * static_cast<double>(SteadyNanoseconds() - began_ns); };
  const char* reason = "ended by the user";
  bool silence_said = false;
  while (!stop.WaitFor(kPoll) && !writer.failed()) {
    taps.Poll(SteadyNanoseconds());
    progress.Show(seconds(), taps.sessions(), writer.totals());
    if (!silence_said && !taps.heard() && seconds() > 5.0) {
      silence_said = true;
      progress.End();
      spdlog::warn("{}: recording what comes", Silence(options, 5.0));
    }
    if (options.seconds && seconds() >= *options.seconds) {
      reason = "its time was over";
      break;
    }
  }
  taps.Poll(SteadyNanoseconds());
  writer.Stop();
  progress.End();
  if (writer.failed()) {
    std::string what;
    try {
      std::rethrow_exception(writer.error());
    } catch (const Error& error) {
      what = error.what();
    }
    try {
      recording.Close("a write failed");
      what += " (what was recorded until then is whole, and has its index)";
    } catch (const Error&) {
      what += " (what was recorded until then is whole, without an index)";
    }
    throw Error(what);
  }
  recording.Close(reason);
  if (!taps.heard() && !silence_said) spdlog::warn("{}", Silence(options, seconds()));
  const auto& totals = writer.totals();
  std::printf("%s%s: %.1f s, %llu messages, %.1f MB, missing %llu, dropped %llu\n",
              recording.files().front().c_str(), recording.files().size() > 1 ? " and on" : "",
              seconds(), static_cast<unsigned long long>(totals.messages.load()),
              1e-6 * static_cast<double>(recording.bytes()),
              static_cast<unsigned long long>(totals.missing.load()),
              static_cast<unsigned long long>(totals.dropped.load()));
}

}  // namespace palpate
