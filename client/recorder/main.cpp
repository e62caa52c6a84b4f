#include <chrono>
#include <cstdio>
#include <string>

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>
#include <sys/utsname.h>
#include <unistd.h>

#include "client/recorder/file_summary.h"
#include "client/recorder/options.h"
#include "client/recorder/sample_queue.h"
#include "client/recorder/taps.h"
#include "client/recorder/writer_thread.h"
#include "common/dds/server_lock.h"
#include "common/dds/topics.h"
#include "common/files/private_file.h"
#include "common/program/machine.h"
#include "common/program/stop_signal.h"
#include "common/realtime/steady_clock.h"
#include "common/text/joined.h"
#include "common/text/quoted.h"

namespace palpate {
namespace {

constexpr std::chrono::milliseconds kPoll{5};
/// Buffer for a stalled disk: more than a minute of one station, four seconds of sixteen.
constexpr std::size_t kQueue = std::size_t{64} << 20;

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

/// Returns the message for when no server is heard, with hints where one may be.
std::string Silence(const RecorderOptions& options, double seconds) {
  const bool here = options.network.this_host();
  std::string text = fmt::format("no server found in domain {} of {} for {:.0f} s", options.domain,
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

/// Records until its time is over or a signal comes.  Throws Error; what was recorded by then is
/// intact in the file.
void Record(const RecorderOptions& options) {
  StopSignal stop;
  const dds::TransportChoice transport = dds::ChooseTransport(options.transport, options.network);
  RecordingOptions recording_options = options.recording;
  recording_options.about["domain"] = std::to_string(options.domain);
  // For palpate-replay export, which writes the methods text.
  const HostMachine host = ThisHost();
  recording_options.about["cpu"] = host.cpu;
  recording_options.about["cores"] = std::to_string(host.cores);
  if (utsname system{}; uname(&system) == 0) recording_options.about["kernel"] = system.release;
  if (!options.stations.empty()) recording_options.about["stations"] = Joined(options.stations);
  recording_options.about["loop"] = options.loop ? transport.reason : "not recorded";

  SampleQueue queue(kQueue);
  TappedTopics topics;
  Taps taps(options.domain, options.network, transport, options.loop, options.stations, queue,
            topics);
  // Made last: an existing file is overwritten only once everything else is ready.
  RecordingWriter recording(recording_options);
  WriterThread writer(recording, queue, topics);
  const auto say_ready = [&] {
    std::printf("recording to %s; domain %d; poses and wrenches: %s\n",
                Printable(recording.files().front()).c_str(), options.domain,
                recording_options.about["loop"].c_str());
    std::fflush(stdout);
  };
  bool is_ready = options.scene.empty();
  if (is_ready) say_ready();

  ProgressLine progress;
  const std::int64_t began_ns = SteadyNanoseconds();
  const auto seconds = [&] { return 1e-9 * static_cast<double>(SteadyNanoseconds() - began_ns); };
  const char* reason = "ended by the user";
  bool silence_said = false;
  while (!stop.WaitFor(kPoll) && !writer.failed()) {
    taps.Poll(SteadyNanoseconds());
    if (!is_ready && taps.has_scene(options.scene)) {
      is_ready = true;
      say_ready();
    }
    progress.Show(seconds(), taps.sessions(), writer.totals());
    if (!silence_said && !taps.heard() && seconds() > 5.0) {
      silence_said = true;
      progress.End();
      spdlog::warn("{}; recording whatever arrives", Silence(options, 5.0));
    }
    if (options.seconds && seconds() >= *options.seconds) {
      reason = "its time was over";
      break;
    }
  }
  taps.Poll(SteadyNanoseconds());
  progress.End();
  writer.Finish(reason);
  if (!taps.heard() && !silence_said) spdlog::warn("{}", Silence(options, seconds()));
  const auto& totals = writer.totals();
  std::printf("%s%s: %.1f s, %llu messages, %.1f MB, missing %llu, dropped %llu\n",
              Printable(recording.files().front()).c_str(),
              recording.files().size() > 1 ? " and on" : "", seconds(),
              static_cast<unsigned long long>(totals.messages.load()),
              1e-6 * static_cast<double>(recording.bytes()),
              static_cast<unsigned long long>(totals.missing.load()),
              static_cast<unsigned long long>(totals.dropped.load()));
}

int Run(const RecorderOptions& options) {
  KeepFilesPrivate();
  if (options.info_files.empty()) {
    Record(options);
    return 0;
  }
  const FileSummary summary = Summarise(options.info_files);
  if (options.json != "-") std::fputs(ToText(summary).c_str(), stdout);
  if (!options.json.empty()) WriteJson(summary, options.json);
  return summary.intact() ? 0 : 1;
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  return palpate::RunProgram("palpate-record", argc, argv, palpate::ParseRecorderOptions,
                             palpate::Run);
}
