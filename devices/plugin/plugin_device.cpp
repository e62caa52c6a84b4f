#include "devices/plugin/plugin_device.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <iomanip>
#include <limits>
#include <sstream>
#include <utility>

#include <pthread.h>

#include "common/error.h"
#include "common/files/shared_library.h"
#include "common/math/pose_check.h"
#include "common/program/forked.h"
#include "common/realtime/latest_mailbox.h"
#include "common/realtime/sleep_until.h"
#include "common/realtime/steady_clock.h"
#include "devices/arm_parts.h"
#include "devices/plugin/palpate_device.h"
#include "devices/wrench_limiter.h"

namespace palpate {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr std::chrono::milliseconds kMillisecond{1};
constexpr std::int64_t kPace_ns = 400'000'000;
constexpr const char* kRead = "palpate_device_read";
constexpr const char* kSilent = "palpate_device_last_error does not say why";

struct Functions {
  decltype(palpate_device_abi)* abi = nullptr;
  decltype(palpate_device_open)* open = nullptr;
  decltype(palpate_device_read)* read = nullptr;
  decltype(palpate_device_write)* write = nullptr;
  decltype(palpate_device_stop)* stop = nullptr;
  decltype(palpate_device_close)* close = nullptr;
  decltype(palpate_device_last_error)* last_error = nullptr;

  template <class Visit>
  void ForEach(Visit visit) {
    visit(abi, "palpate_device_abi");
    visit(open, "palpate_device_open");
    visit(read, kRead);
    visit(write, "palpate_device_write");
    visit(stop, "palpate_device_stop");
    visit(close, "palpate_device_close");
    visit(last_error, "palpate_device_last_error");
  }
};

/// Throws Error.
Functions LoadDriver(const std::string& file) {
  const std::string device = "--device " + file;
  const ForeignCall call("loading the driver");
  const Functions functions =
      SharedLibrary<Functions>::Load(
          // Without a slash the loader would search its own path.
          {file.find('/') == std::string::npos ? "./" + file : file},
          {.who = device,
           .library = "driver",
           .install = "build it as a shared object ('An arm of your own' in devices/arm.md)",
           .files = {},
           .not_it = "define every function of palpate_device.h, with its PALPATE_DEVICE_API"})
          .functions;
  CheckAbi(functions.abi(), PALPATE_DEVICE_ABI, device, "palpate_device_abi", "palpate_device.h");
  return functions;
}

/// Throws Error if a figure is invalid; this detects forces in grams and lengths in millimetres.
DeviceInfo SheetOf(const palpate_device_info& sheet, const std::string& begin) {
  const auto check = [&](const std::string& field, double value, double least, double most) {
    if (value >= least && value <= most) return value;
    std::ostringstream words;
    words << begin << "palpate_device_open: info." << field << " is " << value
          << "; give the figure of the arm's data sheet, from " << least << " to " << most;
    throw Error(words.str());
  };
  const double least_Nm = sheet.max_torque_Nm != 0.0 ? 1e-4 : 0.0;
  DeviceInfo info;
  info.model.assign(sheet.model, strnlen(sheet.model, sizeof sheet.model));
  info.max_force_N = check("max_force_N", sheet.max_force_N, 0.01, 200.0);
  info.continuous_force_N =
      check("continuous_force_N", sheet.continuous_force_N, 0.01, info.max_force_N);
  info.max_torque_Nm = check("max_torque_Nm", sheet.max_torque_Nm, least_Nm, 20.0);
  info.continuous_torque_Nm =
      check("continuous_torque_Nm", sheet.continuous_torque_Nm, least_Nm, info.max_torque_Nm);
  if (sheet.max_torque_Nm == 0.0) info.torque_axes = 0;
  for (int i = 0; i < 3; ++i) {
    const std::string axis{'[', static_cast<char>('0' + i), ']'};
    info.workspace_m[i] = check("workspace_m" + axis, sheet.workspace_m[i], 0.005, 5.0);
    info.workspace_centre_m[i] =
        check("workspace_centre_m" + axis, sheet.workspace_centre_m[i], -5.0, 5.0);
  }
  info.position_resolution_m =
      check("position_resolution_m", sheet.position_resolution_m, 0.0, 0.01);
  info.rotation_resolution_rad =
      check("rotation_resolution_rad", sheet.rotation_resolution_rad, 0.0, 0.2);
  info.thermal_time_s = check("thermal_time_s", sheet.thermal_time_s, 1.0, 3600.0);
  return info;
}

/// The reason why an arm gives no force.
struct Trouble {
  const char* words = nullptr;  ///< null: nothing has been told; behind the function's name
  const char* symbol = "";      ///< the driver's function
  char said[200] = {};          ///< by palpate_device_last_error
};

constexpr const char* kReady = "the arm is ready: forces come in by a ramp";
constexpr const char* kFailed = " failed, and no force is given until it returns 0: ";
constexpr const char* kThrew = " threw an exception: catch it there, and return that it failed";
constexpr const char* kPosition =
    " gave a position_m that is not finite, or far outside of the data sheet's workspace_m; no "
    "force: give metres about workspace_centre_m";
constexpr const char* kOrientation =
    " gave an orientation_wxyz that is not of length 1; no force: normalise it, with w first";
constexpr const char* kJumped =
    " returned a pose that jumped by more than 50 mm or half a radian in a tick; no force for a "
    "moment: calibrate the arm, or discard such readings";
constexpr const char* kStuck =
    " returned no new reading for 10 ms; no force: check the connection to the arm, and count each "
    "of its readings in `number`";
constexpr const char* kHung =
    " did not return for 20 ms; palpate_device_stop turned the force off: move blocking work to a "
    "thread of its own";
constexpr const char* kHeldUp =
    "the loop was held up for more than 20 ms; no force for a moment: see palpate-doctor";

}  // namespace

/// The state shared by the threads.  Turn and the members below it belong to the loop.
class PluginDevice::Arm {
 public:
  explicit Arm(const DeviceOptions& options)
      : file_(options.name),
        api_(LoadDriver(options.name)),
        gate_(options.rate_Hz),
        turn_rate_(options.rate_Hz) {
    const std::string begin = "--device " + file_ + ": ";
    palpate_device_info sheet{};
    sheet.thermal_time_s = info.thermal_time_s;
    try {
      const ForeignCall call("palpate_device_open");
      device_ = api_.open(options.arm.c_str(), options.rate_Hz, &sheet);
    } catch (...) {
      throw Error(begin + "palpate_device_open" + kThrew);
    }
    if (device_ == nullptr) {
      const ForeignCall call("palpate_device_last_error");
      const char* said = api_.last_error(nullptr);
      throw Error(begin + "palpate_device_open failed: " + (said ? said : kSilent));
    }
    try {
      info = SheetOf(sheet, begin);
    } catch (...) {
      Close();
      throw;
    }
    info.model += " (" + file_ + ")";
    info.rate_Hz = options.rate_Hz;
  }
  ~Arm() { Close(); }
  Arm(const Arm&) = delete;
  Arm& operator=(const Arm&) = delete;

  /// Runs the loop until Leave is called.
  void Run(const std::function<void()>& tick) noexcept {
    const auto tick_ns = static_cast<std::int64_t>(1e9 / info.rate_Hz);
    std::int64_t due_ns = SteadyNanoseconds();
    while (Turn(tick)) {
      // After a delay, continues from now, without a burst of ticks.
      due_ns = std::max(due_ns + tick_ns, SteadyNanoseconds());
      SleepUntil(due_ns);
    }
    ended = true;
  }

  /// Makes one turn; false if Leave was called.  Real-time if the driver is.
  bool Turn(const std::function<void()>& tick) noexcept {
    if (!Sense()) {  // keeps the last pose
      turn_rate_.Restart();
      sample.V_WH = {};
      sample.buttons = 0;
      sample.motor_temperature = kNaN;
    }
    sample.status = gate_.open() ? kDeviceOk : kDeviceFault;
    wanted = {};
    Phase phase = Phase::kDriver;
    if (!phase_.compare_exchange_strong(phase, Phase::kTick)) return false;
    tick();
    phase_ = Phase::kDriver;
    WasHung();
    const Wrench given = gate_.Passes(wanted) ? wanted : Wrench{};
    if (!Call("palpate_device_write",
              [&] { return api_.write(device_, given.force.data(), given.torque.data()); })) {
      Stop();
    }
    if (gate_.open() && trouble_.words != kReady) troubles_.Write(trouble_ = {kReady});
    ready_ = gate_.open();
    ++turns_;
    return true;
  }

  /// Removes the force if a turn takes too long.
  void Watch() noexcept {
    int policy = 0;
    sched_param parameters{};
    pthread_getschedparam(pthread_self(), &policy, &parameters);
    ++parameters.sched_priority;  // must preempt a loop that spins
    if (policy == SCHED_FIFO) pthread_setschedparam(pthread_self(), policy, &parameters);
    for (; watched; std::this_thread::sleep_for(5 * kMillisecond)) {
      const double silence_s = 1e-9 * static_cast<double>(SteadyNanoseconds() - alive_ns_);
      if (silence_s < kHang_s || hung_in_ != nullptr) continue;
      hung_in_ = calling_.load();
      Stop();
    }
  }

  void Begin() noexcept {
    alive_ns_ = SteadyNanoseconds();
    began_ns_ = alive_ns_.load();
    phase_ = Phase::kDriver;
    ended = false;
    watched = true;
  }
  /// Stops the ticks: none runs once it has returned.
  void Leave() noexcept {
    Phase phase = Phase::kDriver;
    while (!phase_.compare_exchange_strong(phase, Phase::kLeft) && phase != Phase::kLeft) {
      phase = Phase::kDriver;
      std::this_thread::sleep_for(kMillisecond);
    }
  }
  void Stop() noexcept {
    int answer = -1;
    try {
      const ForeignCall call("palpate_device_stop");
      answer = api_.stop(device_);
    } catch (...) {
    }
    if (answer != 0) stop_failed_ = true;
  }

  bool ready() const noexcept { return ready_ && hung_in_ == nullptr; }
  DeviceNews Attend() {
    troubles_.Read(seen_);
    Trouble now = seen_;
    if (const char* in = hung_in_) now = {*in ? kHung : kHeldUp, in};
    DeviceNews news;
    if (now.words != reported_.words || now.symbol != reported_.symbol) {
      reported_ = now;
      if (now.words == kReady) told_stop_ = false;
      AddLine(now.words == kReady ? news.notes : news.faults,
              file_ + ": " + now.symbol + now.words + now.said);
    }
    if (stop_failed_.exchange(false) && !std::exchange(told_stop_, true)) {
      AddLine(news.faults,
              file_ + ": palpate_device_stop failed: forces may still be on; switch the arm off");
    }
    WatchPace(news);
    return news;
  }

  DeviceInfo info;
  // Within a tick.
  DeviceSample sample;
  Wrench wanted;

  std::atomic<bool> ended{false};
  std::atomic<bool> watched{true};

 private:
  enum class Phase { kDriver, kTick, kLeft };

  void Close() noexcept {
    if (device_ == nullptr) return;
    Stop();
    try {
      const ForeignCall call("palpate_device_close");
      api_.close(device_);
    } catch (...) {
    }
  }

  /// Says within a second that the loop is too slow, and whose time it is.
  void WatchPace(DeviceNews& news) {
    const Pace now{SteadyNanoseconds(), turns_, read_ns_, write_ns_};
    if (began_ns_ == 0 || now.time_ns - std::max(began_ns_.load(), pace_.time_ns) < kPace_ns)
      return;
    const Pace last = std::exchange(pace_, now);
    const auto turns = static_cast<double>(now.turns - last.turns);
    if (last.time_ns < began_ns_ || turns == 0.0) return;  // a call that hangs is told by Attend
    const double rate_Hz = 1e9 * turns / static_cast<double>(now.time_ns - last.time_ns);
    const bool slow = rate_Hz < kLeastRate * info.rate_Hz;
    if (slow == std::exchange(slow_, slow)) return;
    if (!slow) return AddLine(news.notes, file_ + ": the loop keeps its rate again");
    const auto each_ms = [&](std::int64_t ns) { return 1e-6 * static_cast<double>(ns) / turns; };
    const double read_ms = each_ms(now.read_ns - last.read_ns);
    const double write_ms = each_ms(now.write_ns - last.write_ns);
    std::ostringstream words;
    words << std::fixed << std::setprecision(1) << file_ << ": the loop makes "
          << std::round(rate_Hz) << " turns per second instead of " << std::round(info.rate_Hz)
          << ", which weakens forces or removes them: palpate_device_read takes " << read_ms
          << " ms and palpate_device_write " << write_ms << " ms of a turn; "
          << (read_ms + write_ms > 0.5e3 / info.rate_Hz
                  ? "let them return at once, and move what blocks to a thread of its own"
                  : "see palpate-doctor for what this host lacks");
    AddLine(news.faults, words.str());
  }

  bool Fault(const char* words, const char* symbol) noexcept {
    gate_.Fault();
    // Consequences of the first cause are not reported instead of it.
    if (trouble_.words != nullptr && trouble_.words != kReady) return false;
    trouble_ = {words, symbol};
    if (words == kFailed) {
      try {
        const ForeignCall call("palpate_device_last_error");
        const char* said = api_.last_error(device_);
        if (said == nullptr || *said == '\0') said = kSilent;
        std::memcpy(trouble_.said, said, strnlen(said, sizeof trouble_.said - 1));
      } catch (...) {
      }
    }
    troubles_.Write(trouble_);
    return false;
  }

  /// Returns true once after each time that the other thread removed the force.
  bool WasHung() noexcept {
    const char* in = hung_in_.exchange(nullptr);
    if (in != nullptr) Fault(*in ? kHung : kHeldUp, in);
    return in != nullptr;
  }

  template <class Function>
  bool Call(const char* symbol, Function call) noexcept {
    int answer = 0;
    bool threw = false;
    calling_ = symbol;
    const std::int64_t began_ns = SteadyNanoseconds();
    try {
      const ForeignCall foreign(symbol);
      answer = call();
    } catch (...) {
      threw = true;
    }
    calling_ = "";
    alive_ns_ = SteadyNanoseconds();
    (symbol == kRead ? read_ns_ : write_ns_) += alive_ns_ - began_ns;
    if (WasHung()) return false;
    if (threw) return Fault(kThrew, symbol);
    return answer == 0 || Fault(kFailed, symbol);
  }

  bool Sense() noexcept {
    palpate_device_reading reading{};
    for (double& coordinate : reading.position_m) coordinate = kNaN;
    reading.orientation_wxyz[0] = 1.0;
    reading.motor_temperature = kNaN;
    return Call(kRead, [&] { return api_.read(device_, &reading); }) && Take(reading);
  }

  bool Take(const palpate_device_reading& reading) noexcept {
    const Vec3 p(reading.position_m);
    const double* const wxyz = reading.orientation_wxyz;
    Quat q(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
    if (!((p - info.workspace_centre_m).norm() <= info.workspace_m.norm())) {
      return Fault(kPosition, kRead);
    }
    if (!IsPose({p, q})) return Fault(kOrientation, kRead);
    q.normalize();
    stuck_ticks_ = has_pose_ && reading.number == number_ ? stuck_ticks_ + 1 : 0;
    if (stuck_ticks_ >= kStuck_s * info.rate_Hz) return Fault(kStuck, kRead);
    const Vec3 way = p - sample.X_WH.p;
    const bool jumped =
        has_pose_ && (way.norm() > kJump_m || sample.X_WH.q.angularDistance(q) > kJump_rad);
    if (jumped) Fault(kJumped, kRead);
    if (jumped || !has_pose_) {
      turn_rate_.Restart();
      sample.V_WH = {};
    } else {
      sample.V_WH.v += turn_rate_.share() * (way * info.rate_Hz - sample.V_WH.v);
    }
    sample.V_WH.w = turn_rate_.Of(q);
    sample.X_WH = {p, q};
    sample.buttons = reading.buttons;
    sample.motor_temperature = reading.motor_temperature;
    number_ = reading.number;
    has_pose_ = true;
    return true;
  }

  const std::string file_;
  const Functions api_;
  palpate_device* device_ = nullptr;
  ReturnGate gate_;
  TurnRate turn_rate_;
  bool has_pose_ = false;
  std::uint64_t number_ = 0;
  int stuck_ticks_ = 0;
  Trouble trouble_;

  std::atomic<Phase> phase_{Phase::kDriver};
  std::atomic<bool> ready_{false};
  std::atomic<std::int64_t> alive_ns_{0};
  std::atomic<const char*> calling_{""};
  std::atomic<const char*> hung_in_{nullptr};  // until that call returns
  std::atomic<bool> stop_failed_{false};
  std::atomic<std::int64_t> began_ns_{0};  // when the loop began
  std::atomic<std::uint64_t> turns_{0};
  std::atomic<std::int64_t> read_ns_{0}, write_ns_{0};  // spent in them so far
  LatestMailbox<Trouble> troubles_;
  // Used by the main thread.
  Trouble seen_;
  Trouble reported_;
  bool told_stop_ = false;
  struct Pace {
    std::int64_t time_ns = 0;
    std::uint64_t turns = 0;
    std::int64_t read_ns = 0, write_ns = 0;
  };
  Pace pace_;
  bool slow_ = false;
};

PluginDevice::PluginDevice(const DeviceOptions& options) : arm_(std::make_shared<Arm>(options)) {}

const DeviceInfo& PluginDevice::info() const {
  return arm_->info;
}

DeviceSample PluginDevice::Read() noexcept {
  return arm_->sample;
}

void PluginDevice::Apply(const LimitedWrench& wrench) noexcept {
  arm_->wanted = wrench.wrench();
}

DeviceNews PluginDevice::Attend() {
  return arm_->Attend();
}

const char* PluginDevice::activity() const noexcept {
  return arm_->ready() ? "" : "arm at fault";
}

void PluginDevice::Turn(const std::function<void()>& tick) noexcept {
  arm_->Turn(tick);
}

bool PluginDevice::StartTicks(std::function<void()> tick) {
  arm_->Begin();
  turns_ = std::thread([arm = arm_, tick = std::move(tick)] { arm->Run(tick); });
  watch_ = std::thread([arm = arm_] { arm->Watch(); });
  return true;
}

void PluginDevice::StopTicks() {
  if (!turns_.joinable()) return;
  arm_->Leave();
  for (int ms = 0; ms < 500 && !arm_->ended; ++ms) std::this_thread::sleep_for(kMillisecond);
  if (arm_->ended) {
    turns_.join();
  } else {
    turns_.detach();
  }
  arm_->watched = false;
  watch_.join();
  arm_->Stop();
}

DeviceKind PluginKind() {
  return {.name = "./DRIVER.so",
          .what = "an arm of your own, by a driver that you build: devices/arm.md",
          .max_rate_Hz = 4000.0,
          .is_file = true,
          .check_host = [](const std::string& name) { LoadDriver(name); },
          .make = [](const DeviceOptions& options) -> std::unique_ptr<Device> {
            return std::make_unique<PluginDevice>(options);
          }};
}

}  // namespace palpate
