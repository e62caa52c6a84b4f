#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "client/doctor/checks.h"
#include "common/error.h"
#include "common/files/project_files.h"
#include "common/program/forked.h"
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
/// Least cosine between push and motion.  A handle whose inertia is six times as great in one
/// direction as across gives way up to 36 degrees to the side.
constexpr double kAlong = 0.8;
/// Where force and pose have one frame, the push along one axis moves the handle as far along
/// another as that one's moves it along the first, whatever its inertia.  A frame that is turned by
/// 23 degrees has this share of motion for which that is not so; a hand that moves has some as
/// well.
constexpr double kSkew = 0.32;
/// From this cosine on, a motion is along an axis.
constexpr double kOnAxis = 0.95;
constexpr double kLongTurn_ms = 3.0;
/// An arm that is calibrated while it is opened may take this long.
constexpr double kPatience_s = 120.0;

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
      AddLine(news, device_.Attend().Lines());
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

/// Pushes forwards, back, back, forwards along each axis, which cancels the hand's own motion.
/// Returns the motions by a push along x, y and z, as columns [m].
Mat3 Push(DriverLoop& loop) {
  Mat3 way = Mat3::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {1.0, -1.0, -1.0, 1.0}) {
      loop.For(kPush_s);
      const Vec3 before = loop.seen.p;
      loop.Push(sign * kPush_N * Vec3::Unit(axis));
      loop.For(kPush_s);
      way.col(axis) += 0.25 * sign * (loop.seen.p - before);
      loop.Push(Vec3::Zero());
    }
  }
  return way;
}

Finding Turned(const DriverLoop& loop, double rate_Hz, double nominal_Hz) {
  if (!loop.ready || loop.faulted) {
    return Fault(loop.news.substr(0, loop.news.find('\n')), "fix what the message names");
  }
  const Vec3 box_mm = 1e3 * (loop.most - loop.least);
  const std::string found = fmt::format(
      "{:.0f} of {:.0f} cycles per second, the longest {:.1f} ms; the handle was moved {:.1f}, "
      "{:.1f} and "
      "{:.1f} mm",
      rate_Hz, nominal_Hz, loop.seen.longest_ms, box_mm.x(), box_mm.y(), box_mm.z());
  const std::string remedy =
      "let read and write return at once, and do blocking work in a thread of its own; or fix the "
      "findings above about this host";
  if (rate_Hz < kLeastRate * nominal_Hz) {
    return Fault(loop.news.empty() ? found : found + "; " + loop.news, remedy);
  }
  if (loop.seen.longest_ms > kLongTurn_ms) return Warning(found, remedy);
  if (!box_mm.isZero(0.0)) return Ok(found);
  return Warning(found, "move the handle during the test: a constant pose shows nothing");
}

}  // namespace

Finding JudgePush(double force_N, const Mat3& way) {
  constexpr const char* kAxes[] = {"x", "y", "z"};
  std::string found = fmt::format("pushed with {:g} N", force_N);
  bool still = false, astray = false;
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3 moved = way.col(axis);
    const double size = moved.norm();
    found += fmt::format("{} along {}, the handle ", axis == 0 ? "" : ";", kAxes[axis]);
    if (size < kGaveWay_m) {
      still = true;
      found += "did not move";
      continue;
    }
    astray |= moved[axis] < kAlong * size;
    int most = 0;
    moved.cwiseAbs().maxCoeff(&most);
    if (std::abs(moved[most]) >= kOnAxis * size) {
      found += fmt::format("moved {:.1f} mm along {}{}", 1e3 * size, moved[most] < 0.0 ? "-" : "",
                           kAxes[most]);
    } else {
      found += fmt::format("moved obliquely, by {:.1f}, {:.1f} and {:.1f} mm", 1e3 * moved.x(),
                           1e3 * moved.y(), 1e3 * moved.z());
    }
  }
  if (astray) {
    return Fault(found,
                 "if a hand moved the handle, hold it still, and try again; else give the pose in "
                 "read and take the force in write in one frame: exchange, invert or turn the axes "
                 "that differ, otherwise a wall pushes to the side or pulls");
  }
  if (still) {
    return Warning(
        found,
        "hold the handle loosely and try again; if an axis never moves, check that write "
        "drives its motors");
  }
  const Mat3 skew = 0.5 * (way - way.transpose());
  if (skew.norm() <= kSkew * way.norm()) return Ok(found);
  return Warning(found,
                 "hold the handle loosely and still, and try again; if it moves to the same side "
                 "again, the force of write is in another frame than the pose of read: turn it");
}

namespace {

using Add = std::function<void(const char* check, const Finding& finding)>;

void RunDriver(const DeviceOptions& options, bool push, StopSignal& stop, const Add& add) {
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
    const Mat3 way = pushes ? Push(loop) : Mat3::Zero();
    add("driver", Turned(loop, rate_Hz, info.rate_Hz));
    if (const LimiterCounts& counts = loop.seen.limiter; counts.too_hot + counts.too_cold > 0) {
      add("motors", Warning(TemperatureRemark(counts), "correct motor_temperature in read"));
    }
    if (pushes) add("push", JudgePush(kPush_N, way));
  } catch (const Error& error) {
    add("device", Fault(error.what(), "see 'An arm of your own' in " +
                                          ShownPlaceOf(ProjectFile::kDevicePages) + "/arm.md"));
  }
}

std::string ToLine(const char* check, const Finding& finding) {
  return nlohmann::json{check, finding.status, finding.found, finding.remedy}.dump(
      -1, ' ', false, nlohmann::json::error_handler_t::replace);
}
Finding FromLine(const std::string& line) {
  const nlohmann::json json = nlohmann::json::parse(line);
  return {.check = json[0].get<std::string>(),
          .status = json[1].get<Status>(),
          .found = json[2].get<std::string>(),
          .remedy = json[3].get<std::string>()};
}

}  // namespace

std::vector<Finding> TryDriver(const DeviceOptions& options, bool push, StopSignal& stop) {
  StayAwake();
  const ForkedEnd end = RunForked(
      [&](const auto& tell) {
        RunDriver(options, push, stop,
                  [&](const char* check, const Finding& finding) { tell(ToLine(check, finding)); });
      },
      kPatience_s, [&] { return stop.stopped(); });
  std::vector<Finding> findings;
  for (const std::string& line : end.lines) findings.push_back(FromLine(line));
  if (end.finished || stop.stopped()) return findings;
  findings.push_back(Fault(options.name + ": " + end.how,
                           "correct that function; a crash ends a station, too, and the arm keeps "
                           "its last force until its own watchdog ends it"));
  findings.back().check = "driver";
  return findings;
}

}  // namespace palpate::doctor
