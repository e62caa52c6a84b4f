#include <algorithm>
#include <atomic>
#include <chrono>
#include <thread>

#include <spdlog/fmt/fmt.h>

#include "client/doctor/checks.h"
#include "common/error.h"
#include "common/files/project_files.h"
#include "common/realtime/latest_mailbox.h"
#include "common/realtime/steady_clock.h"
#include "devices/wrench_limiter.h"

namespace palpate::doctor {
namespace {

/// An arm that is in order is ready 0.1 s after it is opened.
constexpr double kReady_s = 0.3;
constexpr double kTrial_s = 2.0;
/// Until an arm that a hand holds has given way.
constexpr double kPush_s = 0.25;
/// As much as the limiter lets a guide have, which is active by design as a push is.
constexpr double kPush_N = 1.0;
/// Less than that is not told from a hand's own motion.
constexpr double kGaveWay_m = 0.5e-3;
constexpr std::int64_t kLongTurn_ns = 3'000'000;

struct Seen {
  std::uint64_t ticks = 0;
  std::uint64_t faults = 0;  ///< ticks at fault since it was ready first
  std::uint64_t hung = 0;    ///< times that it did not say that it is in order, likewise
  bool ready = false;
  std::int64_t longest_ns = 0;  ///< from tick to tick
  Pose X_WH;
  Vec3 least = Vec3::Constant(HUGE_VAL), most = Vec3::Constant(-HUGE_VAL);
};

/// A station's loop without a server: the limiter, and behind it the device.
class DriverLoop {
 public:
  DriverLoop(Device& device, const RealtimeOptions& realtime)
      : device_(device), limiter_(WrenchLimits::Of(device.info())) {
    EnterRealtime(realtime);  // which its threads inherit
    device_.StartTicks([this] { Tick(); });
    LeaveRealtime();
  }
  ~DriverLoop() { device_.StopTicks(); }

  void Push(const Vec3& direction) noexcept { pushes_.Write(kPush_N * direction); }
  /// Lets the time pass, and says what there was to say.
  Seen For(double seconds, StopSignal& stop, std::string& news) {
    const std::int64_t end_ns = SteadyNanoseconds() + static_cast<std::int64_t>(1e9 * seconds);
    while (SteadyNanoseconds() < end_ns && !stop.WaitFor(std::chrono::milliseconds(10))) {
      AddLine(news, device_.Attend());
      const std::uint64_t hung = seen_.hung + (seen_.ready && *device_.activity() != '\0');
      seens_.Read(seen_);
      seen_.hung = hung;
    }
    return seen_;
  }

 private:
  void Tick() noexcept {
    const std::int64_t now_ns = SteadyNanoseconds();
    const DeviceSample sample = device_.Read();
    const bool fault = sample.status & kDeviceFault;
    LimiterInput in;
    in.X_WH = sample.X_WH;
    in.V_WH = sample.V_WH;
    in.motor_temperature = sample.motor_temperature;
    in.silence_s = in.age_s = 0.0;
    if (before_ns_ > 0) in.dt_s = 1e-9 * static_cast<double>(now_ns - before_ns_);
    pushes_.Read(push_);
    in.led.force = push_;
    limiter_.Enable(!fault);
    device_.Apply(limiter_.Limit(in));
    ++now_.ticks;
    now_.ready |= !fault;
    now_.faults += now_.ready && fault;
    if (before_ns_ > 0) now_.longest_ns = std::max(now_.longest_ns, now_ns - before_ns_);
    now_.X_WH = sample.X_WH;
    if (!fault) {
      now_.least = now_.least.cwiseMin(sample.X_WH.p);
      now_.most = now_.most.cwiseMax(sample.X_WH.p);
    }
    before_ns_ = now_ns;
    seens_.Write(now_);
  }

  Device& device_;
  WrenchLimiter limiter_;
  // Of the loop.
  Seen now_;
  std::int64_t before_ns_ = 0;
  Vec3 push_ = Vec3::Zero();

  LatestMailbox<Vec3> pushes_;
  LatestMailbox<Seen> seens_;
  Seen seen_;  // of the main thread
};

/// How far it gives way along each axis, less what a hand does meanwhile: there, back, back, there.
Vec3 GivesWay(DriverLoop& loop, StopSignal& stop, std::string& news) {
  Vec3 way = Vec3::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {1.0, -1.0, -1.0, 1.0}) {
      const double before = loop.For(kPush_s, stop, news).X_WH.p[axis];
      loop.Push(sign * Vec3::Unit(axis));
      way[axis] += 0.25 * sign * (loop.For(kPush_s, stop, news).X_WH.p[axis] - before);
      loop.Push(Vec3::Zero());
    }
  }
  return way;
}

Finding OfLoop(double rate_Hz, const Seen& seen, const std::string& news) {
  const Vec3 box_mm = seen.ready ? Vec3(1e3 * (seen.most - seen.least)) : Vec3::Zero();
  const std::string found = fmt::format(
      "{:.0f} turns a second, the longest {:.1f} ms; the handle was moved by {:.1f}, {:.1f} and "
      "{:.1f} mm",
      rate_Hz, 1e-6 * static_cast<double>(seen.longest_ns), box_mm.x(), box_mm.y(), box_mm.z());
  if (!seen.ready || seen.faults + seen.hung > 0) {
    return Fault(news.empty() ? found + "; it was never ready" : news.substr(0, news.find('\n')),
                 "mend what the sentence names");
  }
  if (seen.longest_ns > kLongTurn_ns) {
    return Warning(found,
                   "let read and write return at once: what blocks has a thread of its own; "
                   "or mend what stands above of this host");
  }
  if (box_mm.isZero(0.0)) {
    return Warning(found,
                   "move the handle while this is tried: a pose that stands still tells "
                   "nothing");
  }
  return Ok(found);
}

Finding OfPush(const Vec3& way_m) {
  const std::string found =
      fmt::format("pushed by {:g} N, the handle gave way by {:.1f}, {:.1f} and {:.1f} mm", kPush_N,
                  1e3 * way_m.x(), 1e3 * way_m.y(), 1e3 * way_m.z());
  if (way_m.minCoeff() > kGaveWay_m) return Ok(found);
  if (way_m.minCoeff() < -kGaveWay_m) {
    return Fault(found,
                 "turn the force's or the pose's axis round where the figure is negative: "
                 "both are in one frame, or a wall would pull");
  }
  return Warning(found,
                 "hold the handle loosely, and try again; where an axis never gives way, see "
                 "that write moves the motors of that axis");
}

}  // namespace

std::vector<Finding> TryDriver(const DeviceOptions& options, bool push, StopSignal& stop) {
  std::vector<Finding> findings;
  const auto add = [&](const char* check, Finding finding) {
    finding.check = check;
    findings.push_back(std::move(finding));
  };
  const std::string page = ShownPlaceOf(ProjectFile::kDevicePages) + "/arm.md";
  try {
    const std::unique_ptr<Device> device = MakeDevice(options);
    const DeviceInfo& info = device->info();
    add("device",
        Ok(fmt::format("{}: {:g} N, for long {:g} N; {:g} N m; reaches {:g} x {:g} x {:g} mm",
                       info.model, info.max_force_N, info.continuous_force_N, info.max_torque_Nm,
                       1e3 * info.workspace_m.x(), 1e3 * info.workspace_m.y(),
                       1e3 * info.workspace_m.z())));
    std::string news;
    DriverLoop loop(*device, options.realtime);
    const Seen first = loop.For(kReady_s, stop, news);
    if (first.ready) news.clear();  // which said so
    const Seen then = loop.For(kTrial_s, stop, news);
    const bool pushes = push && then.ready;
    const Vec3 way = pushes ? GivesWay(loop, stop, news) : Vec3::Zero();
    const double rate_Hz = static_cast<double>(then.ticks - first.ticks) / kTrial_s;
    add("driver", OfLoop(rate_Hz, loop.For(0.0, stop, news), news));
    if (pushes) add("push", OfPush(way));
  } catch (const Error& error) {
    add("device",
        Fault(error.what(), "'An arm of your own' in " + page + " says what a driver is"));
  }
  return findings;
}

}  // namespace palpate::doctor
