#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <spdlog/fmt/fmt.h>

#include "client/doctor/checks.h"
#include "common/error.h"
#include "common/files/project_files.h"
#include "common/realtime/latest_mailbox.h"
#include "common/realtime/steady_clock.h"
#include "devices/wrench_limiter.h"

namespace palpate::doctor {
namespace {

/// A working arm is ready 0.1 s after it is opened.
constexpr double kReady_s = 0.3;
constexpr double kTrial_s = 2.0;
/// Time that an arm in a hand needs to yield.
constexpr double kPush_s = 0.25;
/// The limiter's bound for a guide, which, like this push, is active by design.
constexpr double kPush_N = 1.0;
/// A smaller motion cannot be distinguished from the hand's own.
constexpr double kGaveWay_m = 0.5e-3;
constexpr double kLongTurn_ms = 3.0;

/// A station's loop without a server: a device behind the limiter.
class DriverLoop {
 public:
  DriverLoop(Device& device, const RealtimeOptions& realtime, StopSignal& stop)
      : device_(device), limiter_(WrenchLimits::Of(device.info())), stop_(stop) {
    EnterRealtime(realtime);  // inherited by its threads
    device_.StartTicks([this] { Tick(); });
    LeaveRealtime();
  }
  ~DriverLoop() { device_.StopTicks(); }

  void Push(const Vec3& force) noexcept { pushes_.Write(force); }
  void For(double seconds) {
    const std::int64_t end_ns = SteadyNanoseconds() + static_cast<std::int64_t>(1e9 * seconds);
    while (SteadyNanoseconds() < end_ns && !stop_.WaitFor(std::chrono::milliseconds(10))) {
      AddLine(news, device_.Attend());
      seens_.Read(seen);
      const bool in_order = *device_.activity() == '\0';
      faulted |= ready && !in_order;
      if (in_order && !std::exchange(ready, true)) news.clear();
      if (!in_order) continue;
      least = least.cwiseMin(seen.p);
      most = most.cwiseMax(seen.p);
    }
  }

  struct Seen {
    int ticks = 0;
    double longest_ms = 0.0;  ///< between two ticks
    Vec3 p = Vec3::Zero();
    LimiterCounts limiter;
  };
  Seen seen;
  bool ready = false;    ///< was ready once
  bool faulted = false;  ///< faulted after that
  std::string news;
  Vec3 least = Vec3::Constant(HUGE_VAL), most = Vec3::Constant(-HUGE_VAL);

 private:
  void Tick() noexcept {
    const std::int64_t now_ns = SteadyNanoseconds();
    const DeviceSample sample = device_.Read();
    LimiterInput in;
    in.X_WH = sample.X_WH;
    in.V_WH = sample.V_WH;
    in.motor_temperature = sample.motor_temperature;
    in.silence_s = in.age_s = 0.0;
    if (before_ns_ > 0) in.dt_s = 1e-9 * static_cast<double>(now_ns - before_ns_);
    before_ns_ = now_ns;
    pushes_.Read(push_);
    in.led.force = push_;
    limiter_.Enable((sample.status & kDeviceFault) == 0);
    device_.Apply(limiter_.Limit(in));
    now_ = {now_.ticks + 1, std::max(now_.longest_ms, 1e3 * in.dt_s), sample.X_WH.p,
            limiter_.counts()};
    seens_.Write(now_);
  }

  Device& device_;
  WrenchLimiter limiter_;
  StopSignal& stop_;
  LatestMailbox<Vec3> pushes_;
  LatestMailbox<Seen> seens_;
  // Used by the loop only.
  Seen now_;
  std::int64_t before_ns_ = 0;
  Vec3 push_ = Vec3::Zero();
};

/// Checks that the arm yields along each axis, less the hand's own motion: pushes forwards, back,
/// back, forwards.
Finding Pushed(DriverLoop& loop) {
  Vec3 way = Vec3::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {1.0, -1.0, -1.0, 1.0}) {
      loop.For(kPush_s);
      const double before = loop.seen.p[axis];
      loop.Push(sign * kPush_N * Vec3::Unit(axis));
      loop.For(kPush_s);
      way[axis] += 0.25 * sign * (loop.seen.p[axis] - before);
      loop.Push(Vec3::Zero());
    }
  }
  const std::string found =
      fmt::format("pushed with {:g} N, the handle moved {:.1f}, {:.1f} and {:.1f} mm", kPush_N,
                  1e3 * way.x(), 1e3 * way.y(), 1e3 * way.z());
  if (way.minCoeff() > kGaveWay_m) return Ok(found);
  if (way.minCoeff() < -kGaveWay_m) {
    return Fault(found,
                 "invert the axis of the force or of the pose where the number is negative: both "
                 "must be in one frame, otherwise a wall would pull");
  }
  return Warning(found,
                 "hold the handle loosely and try again; if an axis never moves, check that write "
                 "drives its motors");
}

Finding Turned(const DriverLoop& loop, double rate_Hz) {
  if (!loop.ready || loop.faulted) {
    return Fault(loop.news.substr(0, loop.news.find('\n')), "fix what the message names");
  }
  const Vec3 box_mm = 1e3 * (loop.most - loop.least);
  const std::string found = fmt::format(
      "{:.0f} cycles per second, the longest {:.1f} ms; the handle was moved {:.1f}, {:.1f} and "
      "{:.1f} mm",
      rate_Hz, loop.seen.longest_ms, box_mm.x(), box_mm.y(), box_mm.z());
  if (loop.seen.longest_ms > kLongTurn_ms) {
    return Warning(found,
                   "let read and write return at once, and do blocking work in a thread of its "
                   "own; or fix the findings above about this host");
  }
  if (!box_mm.isZero(0.0)) return Ok(found);
  return Warning(found, "move the handle during the test: a constant pose shows nothing");
}

}  // namespace

std::vector<Finding> TryDriver(const DeviceOptions& options, bool push, StopSignal& stop) {
  std::vector<Finding> findings;
  const auto add = [&](const char* check, Finding finding) {
    finding.check = check;
    findings.push_back(std::move(finding));
  };
  StayAwake();
  try {
    const std::unique_ptr<Device> device = MakeDevice(options);
    const DeviceInfo& info = device->info();
    const Vec3 reach_mm = 1e3 * info.workspace_m;
    add("device",
        Ok(fmt::format("{}: {:g} N, continuously {:g} N; {:g} N m; workspace {:g} x {:g} x {:g} mm",
                       info.model, info.max_force_N, info.continuous_force_N, info.max_torque_Nm,
                       reach_mm.x(), reach_mm.y(), reach_mm.z())));
    DriverLoop loop(*device, options.realtime, stop);
    loop.For(kReady_s);
    const int before = loop.seen.ticks;
    loop.For(kTrial_s);
    const double rate_Hz = (loop.seen.ticks - before) / kTrial_s;
    const bool pushes = push && loop.ready;
    const Finding pushed = pushes ? Pushed(loop) : Finding{};
    add("driver", Turned(loop, rate_Hz));
    if (const LimiterCounts& counts = loop.seen.limiter; counts.too_hot + counts.too_cold > 0) {
      add("motors", Warning(TemperatureRemark(counts), "correct motor_temperature in read"));
    }
    if (pushes) add("push", pushed);
  } catch (const Error& error) {
    add("device", Fault(error.what(), "see 'An arm of your own' in " +
                                          ShownPlaceOf(ProjectFile::kDevicePages) + "/arm.md"));
  }
  return findings;
}

}  // namespace palpate::doctor
