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
  StationCore core(*device, options.max_force_N);
  const bool forces = options.enable_forces || device->info().simulated;
  core.EnableForces(forces);
  core.EnableLocalModel(options.local_model);
  if (options.accept_guide) core.AcceptGuide(GuideLimits::OfForce(options.guide_force_N));

  LiveTable table(stdout, StyleOf(options), std::getenv("NO_COLOR") == nullptr);
  ReplyRing replies;
  // Made first: its thread must not inherit the loop's scheduling.
  std::unique_ptr<Trace> trace;
  if (!options.trace.empty()) trace = std::make_unique<Trace>(options.trace);
  std::unique_ptr<ServoThread> servo;
  SessionLink link(
      options.link, replies,
      [&]() -> ServoThread& {
        servo = std::make_unique<ServoThread>(core, replies, table.period_s(), trace.get());
        servo->LoseForceBy(stop);
        if (!forces) servo->EnableForcesByButton();
        return *servo;
      },
      [&](const std::string& event) {
        table.Erase();
        spdlog::info(event);
      });
  spdlog::info("device: {}", device->info().model);
  if (device->info().torque_axes == 0) {
    spdlog::warn("this device renders no torque: the scene's torques are not felt");
  }
  const WrenchLimits::Bounds limits = LimitsOf(*device, core);
  spdlog::info("limits: {:.2f} N and {:.3f} N m, once the motors are warm {:.2f} N and {:.3f} N m",
               limits.force_N, limits.torque_Nm, limits.continuous_force_N,
               limits.continuous_torque_Nm);
  spdlog::info("transport: {}", link.transport().reason);
  spdlog::info("real-time: {}", link.realtime().summary);
  if (!forces) {
    spdlog::info(
        "forces are off; they are on while the first button is held, or with --enable-forces");
  }

  std::optional<GuideLink> guide;
  if (options.accept_guide) guide.emplace(service, options.link.station);

  dds::Writer<wire::StationStatistics> statistics(service, dds::kStationStatisticsTopic,
                                                  dds::Qos::kStream);
  StatisticsPeriod period(options.link.station, device->info().model);
  const auto tell_statistics = [&](const StationSnapshot& snapshot, bool last) {
    const auto figures = period.Add(snapshot, servo->missed_ticks(), link.run(), last);
    if (figures) statistics.Write(*figures);
  };

  // --seconds counts the loop's time, which begins with the first pose.
  std::int64_t began_ns = 0;
  StationView view;
  std::string phase;
  const auto seconds = [&] {
    return began_ns == 0 ? 0.0 : 1e-9 * static_cast<double>(SteadyNanoseconds() - began_ns);
  };
  std::string told_of_motors;
  const auto tell_of_motors = [&](const LimiterCounts& counts) {
    const std::string remark = TemperatureRemark(counts);
    if (remark == told_of_motors || device->info().simulated) return;
    table.Erase();
    const bool odd = counts.too_hot + counts.too_cold > 0;
    spdlog::log(odd ? spdlog::level::warn : spdlog::level::info, "device: {}", remark);
    told_of_motors = remark;
  };
  std::exception_ptr refused;
  try {
    while (!stop.WaitFor(kPoll)) {
      link.Poll(SteadyNanoseconds());
      if (const DeviceNews news = device->Attend(); !news.empty()) {
        table.Erase();
        if (!news.faults.empty()) spdlog::warn("device: {}", news.faults);
        if (!news.notes.empty()) spdlog::info("device: {}", news.notes);
      }
      if (guide) guide->Poll([&](const GuideAim& aim) { servo->SetAim(aim); });
      if (began_ns == 0 && servo->started()) began_ns = SteadyNanoseconds();
      if (device->ended()) {
        spdlog::info("the device has ended: ending the session");
        break;
      }
      if (options.seconds && seconds() >= *options.seconds) break;
      if (std::string now = link.PhaseText(); now != phase) {
        phase = std::move(now);
        spdlog::debug("session: {}", phase);
      }
      if (servo->ReadSnapshot(view.snapshot)) {
        view.seconds = seconds();
        view.phase = phase;
        tell_of_motors(view.snapshot.limiter);
        table.Show(view);
        tell_statistics(view.snapshot, false);
      }
    }
  } catch (const Error&) {  // the loop has run: print its summary before rethrowing
    if (began_ns == 0) throw;
    refused = std::current_exception();
  }

  const double ran_s = seconds();
  servo->Stop();
  if (servo->ReadSnapshot(view.snapshot)) tell_statistics(view.snapshot, false);
  const StationSnapshot end = core.TakeSnapshot(SteadyNanoseconds());
  if (began_ns != 0) tell_statistics(end, true);
  const StationSummary summary = Summarise(options, *device, core, link, *servo, end, ran_s);
  if (options.json != "-") std::fputs(("\n" + ToText(summary)).c_str(), stdout);
  if (!options.json.empty()) WriteJson(summary, options.json);
  std::fflush(stdout);
  if (trace) {
    trace->Close();
    if (trace->dropped() > 0) {
      spdlog::warn("--trace {}: {} ticks are missing, because the disk was too slow", options.trace,
                   trace->dropped());
    }
  }
  if (refused) std::rethrow_exception(refused);
  return 0;
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  return palpate::RunProgram("palpate-station", argc, argv, palpate::ParseStationOptions,
                             palpate::RunStation);
}
