#include "client/load/load_run.h"

#include <algorithm>
#include <chrono>
#include <memory>

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include "client/load/frame_tally.h"
#include "client/load/process_use.h"
#include "client/load/web_viewers.h"
#include "client/station/reply.h"
#include "client/station/servo_thread.h"
#include "client/station/session_link.h"
#include "client/station/station_core.h"
#include "common/error.h"
#include "common/realtime/steady_clock.h"
#include "devices/device.h"
#include "devices/device_factory.h"

namespace palpate {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kPoll{10};
constexpr double kWarmUp_s = 1.0;
constexpr std::int64_t kSecond_ns = 1'000'000'000;
/// Longest wait until every station has its session: a slower machine is far over its capacity.
constexpr double kMatchPatience_s = 30.0;

/// Period of new figures in the progress line.
constexpr double kSnapshot_s = 0.5;

LinkOptions LinkOf(const std::string& name, const OfferedTool& tool,
                   const LoadRunOptions& options) {
  LinkOptions link;
  link.station = name;
  link.scene = tool.scene;
  link.tool = tool.tool;
  link.device = "scripted (palpate-load)";
  link.domain = options.domain;
  link.transport = options.transport;
  link.network = options.network;
  link.realtime.mode = ParseRealtimeMode(options.realtime);
  link.patience_s = options.patience_s;
  return link;
}

/// A palpate-station without command line and table: the same core, loop and session, with a hand
/// that repeats a script.  All stations are threads of one process, so DDS has one set of threads
/// for all of them (README.md has figures).  Thread contract: one thread, that of all stations.
class LoadStation {
 public:
  // Scripted, not simulated: a real station does not compute an arm's dynamics.
  LoadStation(const std::string& name, const OfferedTool& tool, const PoseScript& script,
              const LoadRunOptions& options)
      : device_(MakeDevice({"scripted", script, true})), core_(*device_) {
    core_.EnableForces(true);
    link_ = std::make_unique<SessionLink>(
        LinkOf(name, tool, options), replies_,
        [this]() -> ServoThread& {
          servo_ = std::make_unique<ServoThread>(core_, replies_, kSnapshot_s);
          return *servo_;
        },
        [name](const std::string& event) { spdlog::debug("{}: {}", name, event); });
  }

  /// Call it a hundred times per second.  Throws Error (SessionLink::Poll).
  void Poll(std::int64_t now_ns) { link_->Poll(now_ns); }
  bool linked() const { return link_->phase() == SessionLink::Phase::kLinked; }
  ServoThread& servo() { return *servo_; }
  const SessionLink& link() const { return *link_; }
  /// Valid after servo().Stop().
  const StationTotals& totals() const { return core_.totals(); }

 private:
  std::unique_ptr<Device> device_;
  StationCore core_;
  ReplyRing replies_;
  std::unique_ptr<ServoThread> servo_;
  std::unique_ptr<SessionLink> link_;  // destroyed first, so that the loop stops using the path
};

using Stations = std::vector<std::unique_ptr<LoadStation>>;

void Poll(Stations& stations) {
  for (const auto& station : stations) station->Poll(SteadyNanoseconds());
}

/// Returns false if a signal came before the condition held.
template <class Condition>
bool PollUntil(Stations& stations, StopSignal& stop, Condition condition) {
  while (!condition()) {
    if (stop.WaitFor(kPoll)) return false;
    Poll(stations);
  }
  return true;
}

bool PollFor(Stations& stations, StopSignal& stop, double seconds) {
  const std::int64_t end_ns = SteadyNanoseconds() + static_cast<std::int64_t>(1e9 * seconds);
  return PollUntil(stations, stop, [end_ns] { return SteadyNanoseconds() >= end_ns; });
}

bool Link(const LoadSetting& setting, std::size_t count, Stations& stations, StopSignal& stop) {
  const LoadRunOptions& options = setting.options;
  for (std::size_t i = 0; i < count; ++i) {
    stations.push_back(std::make_unique<LoadStation>(
        options.name + "_" + std::to_string(i + 1), setting.tools[i], setting.scripts[i], options));
    Poll(stations);
    if (stop.stopped()) return false;
  }
  const std::int64_t end_ns =
      SteadyNanoseconds() + static_cast<std::int64_t>(1e9 * kMatchPatience_s);
  return PollUntil(stations, stop, [&] {
    const auto linked = std::ranges::count_if(stations, [](const auto& s) { return s->linked(); });
    if (static_cast<std::size_t>(linked) == count) return true;
    if (SteadyNanoseconds() > end_ns) {
      throw Error(fmt::format("only {} of {} stations have a session after {} s; give fewer",
                              linked, count, kMatchPatience_s));
    }
    setting.progress(fmt::format("{} of {} stations linked", linked, count));
    return false;
  });
}

/// The processor times of the processes at one moment.
struct Times {
  std::optional<ProcessTimes> server, gateway, self;
  MachineTimes machine;
};

Times TimesNow(std::optional<int> server, std::optional<int> gateway) {
  Times times;
  if (server) times.server = TimesOf(*server);
  if (gateway) times.gateway = TimesOf(*gateway);
  times.self = TimesOf(getpid());
  times.machine = MachineTimesNow();
  return times;
}

std::optional<double> Use(const std::optional<ProcessTimes>& begin,
                          const std::optional<ProcessTimes>& end) {
  if (!begin || !end) return std::nullopt;
  return UseBetween(*begin, *end);
}

/// The stations' figures of the last half second, for the progress line.
class Glance {
 public:
  explicit Glance(std::size_t stations) : latest_(stations) {}

  std::string Text(Stations& stations, std::uint64_t frames) {
    double hz = 0.0;
    double p99_us = 0.0;
    for (std::size_t i = 0; i < stations.size(); ++i) {
      stations[i]->servo().ReadSnapshot(latest_[i]);
      hz += latest_[i].rate_hz / static_cast<double>(stations.size());
      p99_us = std::max(p99_us, latest_[i].round_trip_us_p99);
    }
    std::string text;
    if (!stations.empty()) text += fmt::format(", {:.0f} Hz, p99 {:.0f} us", hz, p99_us);
    if (frames > 0) text += fmt::format(", {} frames", frames);
    return text;
  }

 private:
  std::vector<StationSnapshot> latest_;
};

}  // namespace

std::optional<LoadFigures> RunOnce(const LoadSetting& setting, const LoadSize& size,
                                   StopSignal& stop) {
  const LoadRunOptions& options = setting.options;
  LoadFigures figures;
  figures.stations = size.stations;
  figures.viewers = size.viewers;
  figures.load_averages = LoadAverages();

  // Declared first, so that viewers end before the stations, which they ask for the poses' ages.
  Stations stations;
  FrameTally::Setup setup;
  setup.viewers = size.viewers;
  setup.stations = size.stations;
  setup.name = options.name;
  setup.rate_hz = options.rate_hz;
  setup.newest_sequence = [&](std::size_t station) {
    return stations[station]->servo().newest_sequence();
  };
  setup.sample_time_ns = [&](std::size_t station, std::uint64_t sequence) {
    return stations[station]->servo().sample_time_ns(sequence);
  };
  FrameTally web_tally(setup);
  if (!Link(setting, size.stations, stations, stop)) return std::nullopt;
  std::optional<WebViewers> web_viewers;
  // The stations are not polled while viewers connect; they keep running by themselves.
  web_viewers.emplace(options.viewer_url, size.viewers, options.patience_s, web_tally, stop);
  setting.progress("warming up");
  if (!PollFor(stations, stop, kWarmUp_s)) return std::nullopt;

  const std::optional<int> server = ServerOf(options.domain);
  std::optional<int> gateway;
  if (size.viewers > 0) gateway = ListenerAt(options.viewer_url.port);
  const Times begin = TimesNow(server, gateway);
  const std::int64_t begin_ns = SteadyNanoseconds();
  for (const auto& station : stations) station->servo().RestartTotals();
  web_tally.Begin(begin_ns);

  Glance glance(size.stations);
  const auto seconds = [&] { return 1e-9 * static_cast<double>(SteadyNanoseconds() - begin_ns); };
  std::int64_t said_ns = 0;
  PollUntil(stations, stop, [&] {
    if (SteadyNanoseconds() - said_ns >= kSecond_ns) {
      said_ns = SteadyNanoseconds();
      setting.progress(fmt::format("{} stations, {} viewers: {:.0f} of {:.0f} s{}", size.stations,
                                   size.viewers, seconds(), size.seconds,
                                   glance.Text(stations, web_tally.frames())));
    }
    return seconds() >= size.seconds;
  });

  web_tally.End(SteadyNanoseconds());
  const Times end = TimesNow(server, gateway);
  figures.seconds = seconds();
  for (const auto& station : stations) station->servo().BeginToStop();
  figures.viewers_gone = web_viewers->gone();
  web_viewers.reset();
  for (const auto& station : stations) {
    station->servo().Stop();
    figures.sum.Add(station->totals(), station->servo().missed_ticks(),
                    station->link().reconnects());
    figures.transport = dds::ToString(station->link().transport().transport);
  }
  figures.server = Use(begin.server, end.server);
  figures.gateway = Use(begin.gateway, end.gateway);
  figures.self = Use(begin.self, end.self).value_or(0.0);
  figures.machine_busy = BusyBetween(begin.machine, end.machine);
  figures.viewer_frames = web_tally.frames();
  figures.frames_due = web_tally.due();
  figures.lost = web_tally.lost();
  figures.frame_age = web_tally.age();
  setting.progress("");
  if (size.stations > 0 && size.viewers > 0 && figures.viewer_frames == 0 && !stop.stopped()) {
    throw Error("the gateway at " + options.viewer_url.text() +
                " sent its viewers nothing; check that it runs in domain " +
                std::to_string(options.domain) + ", or start 'palpate-viewer --http " +
                std::to_string(options.viewer_url.port) + " --domain " +
                std::to_string(options.domain) + "'");
  }
  return figures;
}

}  // namespace palpate
