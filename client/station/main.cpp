#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <spdlog/spdlog.h>
#include <unistd.h>

#include "client/station/display.h"
#include "client/station/guide_link.h"
#include "client/station/options.h"
#include "client/station/served_tools.h"
#include "client/station/servo_thread.h"
#include "client/station/station_core.h"
#include "client/station/statistics_period.h"
#include "client/station/trace.h"
#include "common/dds/topics.h"
#include "common/error.h"
#include "common/files/private_file.h"
#include "common/program/command_line.h"
#include "common/program/stop_signal.h"
#include "common/realtime/steady_clock.h"
#include "devices/device_factory.h"

namespace palpate {
namespace {

constexpr std::chrono::milliseconds kPoll{10};

PoseScript HandOf(const OfferedTool& tool) {
  if (!tool.hand) throw Error(tool.remark + "; give one with --script");
  if (!tool.remark.empty()) spdlog::info("{}", tool.remark);
  return *tool.hand;
}

std::optional<Workspace> WorkspaceOf(const StationOptions& options) {
  if (options.workspace.empty() && !options.scale && !options.clutch_button) return std::nullopt;
  Workspace workspace =
      options.workspace.empty() ? Workspace{} : Workspace::Load(options.workspace);
  if (options.scale) workspace.scale = *options.scale;
  if (options.clutch_button) workspace.clutch_button = options.clutch_button;
  return workspace;
}

/// Returns the device options of the command line, with the files that it names.
DeviceOptions DeviceOf(const StationOptions& options) {
  DeviceOptions device = options.device;
  device.workspace = WorkspaceOf(options);
  if (!options.script.empty()) device.script = PoseScript::Load(options.script);
  return device;
}

/// Opens the device; the server determines what the command line leaves open.
std::unique_ptr<Device> OpenDevice(DeviceOptions device, const OfferedTool& tool) {
  if (!device.script && DeviceNeedsScript(device.name)) device.script = HandOf(tool);
  device.start = device.script ? device.script->At(0.0) : tool.Start();
  return MakeDevice(device);
}

LiveTable::Style StyleOf(const StationOptions& options) {
  if (options.json == "-") return LiveTable::Style::kSilent;  // a program reads stdout then
  const bool table = options.table.value_or(isatty(STDOUT_FILENO) == 1);
  return table ? LiveTable::Style::kInPlace : LiveTable::Style::kLines;
}

WrenchLimits::Bounds LimitsOf(const Device& device, const StationCore& core) {
  WrenchLimits::Bounds limits = core.limiter().limits().bounds();
  if (device.info().torque_axes == 0) limits.torque_Nm = limits.continuous_torque_Nm = 0.0;
  return limits;
}

StationSummary Summarise(const StationOptions& options, const Device& device,
                         const StationCore& core, const SessionLink& link, const ServoThread& servo,
                         const StationSnapshot& end, double seconds) {
  StationSummary summary;
  summary.station = options.link.station;
  summary.device = device.info().model;
  summary.scene = options.link.scene;
  summary.tool = link.tool();
  summary.transport = dds::ToString(link.transport().transport);
  summary.seconds = seconds;
  summary.totals = core.totals();
  summary.missed_ticks = servo.missed_ticks();
  summary.linked_ticks_s =
      static_cast<double>(summary.totals.ticks + summary.missed_ticks) / device.info().rate_Hz;
  summary.reconnects = link.reconnects();
  summary.limits = LimitsOf(device, core);
  summary.end = end;
  return summary;
}

/// A station with its device, from the request for a session to the summary.
class StationRun {
 public:
  /// @param options, device, service, stop  must outlive this.
  StationRun(const StationOptions& options, Device& device, const dds::Participant& service,
             StopSignal& stop)
      : options_(options),
        device_(device),
        stop_(stop),
        core_(device, options.max_force_N),
        forces_(options.enable_forces || device.info().simulated),
        table_(stdout, StyleOf(options), std::getenv("NO_COLOR") == nullptr),
        trace_(options.trace.empty() ? nullptr : std::make_unique<Trace>(options.trace)),
        link_(
            options.link, replies_, [this]() -> ServoThread& { return MakeServo(); },
            [this](const std::string& event) {
              table_.Erase();
              spdlog::info(event);
            }),
        statistics_(service, dds::kStationStatisticsTopic, dds::Qos::kStream),
        period_(options.link.station, device.info().model) {
    if (options.accept_guide) guide_.emplace(service, options.link.station);
  }

  /// Says what the device, the transport and this host give.
  void Introduce() const {
    spdlog::info("device: {}", device_.info().model);
    if (device_.info().torque_axes == 0) {
      spdlog::warn("this device renders no torque: the scene's torques are not felt");
    }
    const WrenchLimits::Bounds limits = LimitsOf(device_, core_);
    spdlog::info(
        "limits: {:.2f} N and {:.3f} N m, once the motors are warm {:.2f} N and {:.3f} N m",
        limits.force_N, limits.torque_Nm, limits.continuous_force_N, limits.continuous_torque_Nm);
    spdlog::info("transport: {}", link_.transport().reason);
    spdlog::info("real-time: {}", link_.realtime().summary);
    if (!forces_) {
      spdlog::info(
          "forces are off; they are on while the first button is held, or with --enable-forces");
    }
  }

  /// Runs until the time is over, the device ends or a signal comes.  Throws Error.
  void Run() {
    while (!stop_.WaitFor(kPoll)) {
      link_.Poll(SteadyNanoseconds());
      if (const DeviceNews news = device_.Attend(); !news.empty()) {
        table_.Erase();
        if (!news.faults.empty()) spdlog::warn("device: {}", news.faults);
        if (!news.notes.empty()) spdlog::info("device: {}", news.notes);
      }
      if (guide_) guide_->Poll([&](const GuideAim& aim) { servo_->SetAim(aim); });
      if (!has_begun() && servo_->started()) began_ns_ = SteadyNanoseconds();
      if (device_.ended()) {
        spdlog::info("the device has ended: ending the session");
        return;
      }
      if (options_.seconds && seconds() >= *options_.seconds) return;
      if (std::string now = link_.PhaseText(); now != view_.phase) {
        view_.phase = std::move(now);
        spdlog::debug("session: {}", view_.phase);
      }
      if (!servo_->ReadSnapshot(view_.snapshot)) continue;
      view_.seconds = seconds();
      TellOfMotors(view_.snapshot.limiter);
      table_.Show(view_);
      TellStatistics(view_.snapshot, false);
    }
  }
  /// Whether the loop has run: there is something to summarise.
  bool has_begun() const { return began_ns_ != 0; }

  /// Stops the loop, and prints the summary.
  void Finish() {
    const double ran_s = seconds();
    servo_->Stop();
    if (servo_->ReadSnapshot(view_.snapshot)) TellStatistics(view_.snapshot, false);
    const StationSnapshot end = core_.TakeSnapshot(SteadyNanoseconds());
    if (has_begun()) TellStatistics(end, true);
    const StationSummary summary = Summarise(options_, device_, core_, link_, *servo_, end, ran_s);
    if (options_.json != "-") std::fputs(("\n" + ToText(summary)).c_str(), stdout);
    if (!options_.json.empty()) WriteJson(summary, options_.json);
    std::fflush(stdout);
    if (!trace_) return;
    trace_->Close();
    if (trace_->dropped() > 0) {
      spdlog::warn("--trace {}: {} ticks are missing, because the disk was too slow",
                   options_.trace, trace_->dropped());
    }
  }

 private:
  ServoThread& MakeServo() {
    // The core is the thread's from then on.
    core_.EnableForces(forces_);
    core_.EnableLocalModel(options_.local_model);
    if (options_.accept_guide) core_.AcceptGuide(GuideLimits::OfForce(options_.guide_force_N));
    servo_ = std::make_unique<ServoThread>(core_, replies_, table_.period_s(), trace_.get());
    servo_->LoseForceBy(stop_);
    if (!forces_) servo_->EnableForcesByButton();
    return *servo_;
  }
  /// --seconds counts the loop's time, which begins with the first pose.
  double seconds() const {
    return has_begun() ? 1e-9 * static_cast<double>(SteadyNanoseconds() - began_ns_) : 0.0;
  }
  void TellStatistics(const StationSnapshot& snapshot, bool last) {
    const auto figures = period_.Add(snapshot, servo_->missed_ticks(), link_.run(), last);
    if (figures) statistics_.Write(*figures);
  }
  void TellOfMotors(const LimiterCounts& counts) {
    const std::string remark = TemperatureRemark(counts);
    if (remark == told_of_motors_ || device_.info().simulated) return;
    table_.Erase();
    const bool odd = counts.too_hot + counts.too_cold > 0;
    spdlog::log(odd ? spdlog::level::warn : spdlog::level::info, "device: {}", remark);
    told_of_motors_ = remark;
  }

  const StationOptions& options_;
  Device& device_;
  StopSignal& stop_;
  StationCore core_;
  const bool forces_;  // not by the device's button
  LiveTable table_;
  ReplyRing replies_;
  // Before the servo thread: its own must not inherit the loop's scheduling.
  std::unique_ptr<Trace> trace_;
  std::unique_ptr<ServoThread> servo_;  // link_ makes it
  SessionLink link_;
  std::optional<GuideLink> guide_;
  dds::Writer<wire::StationStatistics> statistics_;
  StatisticsPeriod period_;
  std::int64_t began_ns_ = 0;
  StationView view_;
  std::string told_of_motors_;
};

/// Runs a station until its time is over or a signal comes, and prints its summary.  Throws Error;
/// if the loop has run, only after printing the summary.
int RunStation(const StationOptions& given) {
  KeepFilesPrivate();
  StopSignal stop;
  StayAwake();
  // Fails at once for what needs no server.
  DeviceOptions device_options = DeviceOf(given);
  CheckDriver(given.device.name);
  dds::ChooseTransport(given.link.transport, given.link.network);
  // Kept open, so that the domain is not created anew for the session.
  const dds::Participant service = dds::Participant::Service(given.link.domain, given.link.network);
  const std::vector<OfferedTool> tools =
      AskForTools(service, {given.link.domain, given.link.network, given.link.patience_s},
                  given.link.scene, stop);
  if (stop.stopped()) return 0;
  const OfferedTool& tool = Meant(tools, given.link.tool);
  StationOptions options = given;
  options.link.scene = tool.scene;  // the user may have named its file

  const std::unique_ptr<Device> device = OpenDevice(std::move(device_options), tool);
  StationRun run(options, *device, service, stop);
  run.Introduce();
  std::exception_ptr refused;
  try {
    run.Run();
  } catch (const Error&) {  // the loop has run: print its summary before rethrowing
    if (!run.has_begun()) throw;
    refused = std::current_exception();
  }
  run.Finish();
  if (refused) std::rethrow_exception(refused);
  return 0;
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  return palpate::RunProgram("palpate-station", argc, argv, palpate::ParseStationOptions,
                             palpate::RunStation);
}
