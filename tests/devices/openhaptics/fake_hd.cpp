// A libHD.so without an arm: the vendor's binary interface, a scheduler and a simulated arm.
#include "tests/devices/openhaptics/fake_hd.h"

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <thread>

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include "common/math/pose.h"
#include "common/realtime/steady_clock.h"

namespace palpate::test {
namespace {

constexpr hd::Handle kHandle = 7;
constexpr std::int64_t kWatchdog_ns = 20'000'000;
constexpr std::size_t kMostRecords = 1 << 17;
// Parameters of the arm and the hand.
constexpr double kMass_kg = 0.2;
constexpr double kHand_N_m = 2000.0;
constexpr double kHand_N_s_m = 20.0;

enum Function {
#define PALPATE_HD_INDEX(result, name, arguments) k_##name,
  PALPATE_HD_FUNCTIONS(PALPATE_HD_INDEX)
#undef PALPATE_HD_INDEX
      kFunctions
};
constexpr std::array<const char*, kFunctions> kNames{
#define PALPATE_HD_NAME(result, name, arguments) #name,
    PALPATE_HD_FUNCTIONS(PALPATE_HD_NAME)
#undef PALPATE_HD_NAME
};

int IndexOf(const std::string& function) {
  for (int i = 0; i < kFunctions; ++i) {
    if (function == kNames[static_cast<std::size_t>(i)]) return i;
  }
  std::abort();
}

struct Task {
  hd::Callback call = nullptr;
  void* data = nullptr;
  std::uint16_t priority = 0;
  bool done = false;  // of a synchronous task
};

thread_local bool in_callback = false;

class Library final : public FakeHd {
 public:
  Library() {
    calls_.reserve(kMostRecords);
    frames_.reserve(kMostRecords);
    FakeHdSetup first;
    first.held_fast = false;  // a station's server answers to how the arm moves
    if (const char* file = std::getenv(kFakeArmVariable)) {
      shared_ = MapArm(file);
      first.real_time = true;
    }
    Reset(first);
  }
  ~Library() { Stop(); }

  // The test's side.

  void Reset(const FakeHdSetup& with) override {
    Stop();
    dead_ = false;
    const std::lock_guard lock(mutex_);
    setup = with;
    own_arm_ = std::make_unique<FakeArm>();
    arm = shared_ ? shared_ : own_arm_.get();
    transform_scale.fill(0.0);
    temperature.fill(0.2);
    docked = unplugged = false;
    tick_elapsed_s = 0.0;
    endless_error = hd::kSuccess;
    rotation_wxyz = {1.0, 0.0, 0.0, 0.0};
    calibration_ = with.calibration;
    velocity_.setZero();
    initialised_ = current_ = motors_on_ = frame_open_ = false;
    rate_Hz_ = 1000;
    tick_ = frame_tick_ = 0;
    errors_ = 0;
    has_failure_ = false;
    counts_.fill(0);
    scheduled_ = Task{};
    motor_force_.setZero();
    calls_.clear();
    frames_.clear();
    violations_.clear();
    calibrations_.clear();
  }
  void Tick(int count) override {
    for (int i = 0; i < count; ++i) RunTick(nullptr);
  }
  void Fail(const std::string& function, int nth, hd::Code code) override {
    const std::lock_guard lock(mutex_);
    failing_ = function == kAnyFunction ? -1 : IndexOf(function);
    fails_in_ = nth;
    fails_with_ = code;
    has_failure_ = true;
  }
  void Die() override { dead_ = true; }
  void SetCalibration(hd::Enum status) override {
    const std::lock_guard lock(mutex_);
    calibration_ = status;
  }
  std::vector<std::string> Violations() override { return Locked(violations_); }
  std::vector<std::string> Calls() override {
    const std::lock_guard lock(mutex_);
    return {calls_.begin(), calls_.end()};
  }
  std::vector<FakeFrame> Frames() override { return Locked(frames_); }
  int CallsOf(const std::string& function) override {
    const std::lock_guard lock(mutex_);
    return counts_[static_cast<std::size_t>(IndexOf(function))];
  }
  std::vector<hd::Enum> Calibrations() override { return Locked(calibrations_); }
  bool FailurePending() override { return Locked(has_failure_); }
  double MotorForce() override {
    const std::lock_guard lock(mutex_);
    if (setup.real_time && SteadyNanoseconds() - last_frame_ns_ > kWatchdog_ns) return 0.0;
    return motors_on_ ? motor_force_.norm() : 0.0;
  }
  bool motors_on() override { return Locked(motors_on_); }
  bool running() override { return Locked(running_); }
  bool opened() override { return Locked(initialised_); }

  // The driver's side; each function holds the lock.

  hd::Handle Init(const char* name) {
    const std::lock_guard lock(mutex_);
    const bool failed = Enter(k_hdInitDevice);
    Demand(!running_, "hdInitDevice while the scheduler runs");
    Demand(!initialised_, "hdInitDevice twice");
    if (failed) return hd::kInvalidHandle;
    if (setup.init_error != hd::kSuccess) return Refuse(setup.init_error), hd::kInvalidHandle;
    const bool known =
        name ? std::count(setup.names.begin(), setup.names.end(), name) > 0 : setup.default_name;
    if (!known) return Refuse(hd::kDeviceFault), hd::kInvalidHandle;
    initialised_ = current_ = true;
    motors_on_ = true;  // a driver that relies on the opposite fails
    return kHandle;
  }
  void MakeCurrent(hd::Handle handle) {
    const std::lock_guard lock(mutex_);
    if (Enter(k_hdMakeCurrentDevice) || !Known(handle)) return;
    current_ = true;
  }
  void DisableDevice(hd::Handle handle) {
    const std::lock_guard lock(mutex_);
    Enter(k_hdDisableDevice);
    if (!Known(handle)) return;
    Demand(!running_, "hdDisableDevice while the scheduler runs");
    Demand(!scheduled_.call, "hdDisableDevice before hdUnschedule");
    initialised_ = current_ = motors_on_ = false;
    motor_force_.setZero();
  }
  void Begin(hd::Handle handle) {
    const std::lock_guard lock(mutex_);
    const hd::Code failure = Enter(k_hdBeginFrame);
    if (failure >= hd::kIllegalBegin && failure <= hd::kFrameError) {
      refused_frame_ = true;  // calls within it are not the driver's mistake
      return;
    }
    refused_frame_ = false;
    if (!Known(handle)) return;
    Demand(in_callback, "a frame outside a callback");
    Demand(frame_tick_ != tick_, "a second frame in one tick");
    if (!Demand(!frame_open_, "a frame in a frame", hd::kIllegalBegin)) return;
    frame_open_ = current_ = true;
    frame_thread_ = std::this_thread::get_id();
    frame_tick_ = tick_;
    frame_ = FakeFrame{};
  }
  void End(hd::Handle handle) {
    const std::lock_guard lock(mutex_);
    Enter(k_hdEndFrame);
    if (refused_frame_) {
      refused_frame_ = false;
      Refuse(hd::kIllegalEnd);
      return;
    }
    if (!Known(handle)) return;
    if (!Demand(frame_open_, "hdEndFrame without hdBeginFrame", hd::kIllegalEnd)) return;
    frame_open_ = false;
    frame_.tick = tick_;
    frame_.motors_on = motors_on_;
    if (frames_.size() < kMostRecords) frames_.push_back(frame_);
    motor_force_ = Vec3(frame_.force_N.data());
    last_frame_ns_ = SteadyNanoseconds();
    if (unplugged) {
      motor_force_.setZero();
      Refuse(hd::kCommError);
    }
  }
  hd::ErrorInfo GetError() {
    const std::lock_guard lock(mutex_);
    if (const hd::Code code = Enter(k_hdGetError)) return {code, 1, kHandle};
    if (endless_error != hd::kSuccess) return {endless_error, 1, kHandle};
    if (errors_ == 0) return {hd::kSuccess, 0, kHandle};
    const hd::ErrorInfo error{queue_[0], 1, kHandle};
    std::copy(queue_.begin() + 1, queue_.end(), queue_.begin());
    --errors_;
    return error;
  }
  void Switch(hd::Enum what, bool on) {
    const std::lock_guard lock(mutex_);
    if (Enter(on ? k_hdEnable : k_hdDisable) || !HasDevice()) return;
    if (what == setup.refused_capability) return Refuse(hd::kInvalidEnum);
    if (what == hd::kForceOutput) {
      Demand(!running_ || in_callback, "HD_FORCE_OUTPUT switched outside a callback");
      Demand(!on || calibration_ == hd::kCalibrationOk, "motors on before calibration");
      motors_on_ = on;
      return;
    }
    const bool known = what == hd::kMaxForceClamping || what == hd::kForceRamping ||
                       what == hd::kSoftwareForceLimit || what == hd::kSoftwareVelocityLimit ||
                       what == hd::kSoftwareForceImpulseLimit || what == hd::kOneFrameLimit;
    Demand(known, "an unknown capability", hd::kInvalidEnum);
    Demand(on, "a bound of the library was switched off");
  }
  void GetBooleans(hd::Enum what, unsigned char* values) {
    const std::lock_guard lock(mutex_);
    if (Enter(k_hdGetBooleanv) || !MayRead(what)) return;
    if (what != hd::kCurrentInkwellSwitch) return WrongType(what);
    if (!setup.has_inkwell) return Refuse(hd::kInvalidEnum);
    *values = docked ? 0 : 1;
  }
  void GetIntegers(hd::Enum what, int* values) {
    const std::lock_guard lock(mutex_);
    if (Enter(k_hdGetIntegerv) || !MayRead(what)) return;
    switch (what) {
      case hd::kCurrentButtons:
        *values = static_cast<int>(arm->buttons.load());
        return;
      case hd::kInputDof:
        *values = setup.input_dof;
        return;
      case hd::kOutputDof:
        *values = setup.output_dof;
        return;
      case hd::kCalibrationStyle:
        *values = static_cast<int>(setup.styles);
        return;
      default:
        WrongType(what);
    }
  }
  void GetDoubles(hd::Enum what, double* values) {
    const std::lock_guard lock(mutex_);
    if (Enter(k_hdGetDoublev) || !MayRead(what)) return;
    const auto dof = static_cast<std::size_t>(setup.output_dof);
    switch (what) {
      case hd::kCurrentTransform: {
        const Quat q(rotation_wxyz[0], rotation_wxyz[1], rotation_wxyz[2], rotation_wxyz[3]);
        Eigen::Map<Eigen::Matrix4d> X(values);
        X.setIdentity();
        X.topLeftCorner<3, 3>() = q.toRotationMatrix();
        X.topRightCorner<3, 1>() = Position();
        X += Eigen::Map<const Eigen::Matrix4d>(transform_scale.data());
        return;
      }
      case hd::kCurrentVelocity:
        Eigen::Map<Vec3>{values} = velocity_;
        return;
      case hd::kMotorTemperature:
        if (!setup.has_temperature) return Refuse(hd::kInvalidEnum);
        std::copy_n(temperature.begin(), dof, values);
        return;
      case hd::kMaxWorkspace: {
        const double box[6] = {-210, -110, -85, 210, 205, 130};
        std::copy_n(box, 6, values);
        return;
      }
      case hd::kNominalMaxForce:
        *values = setup.max_force_N;
        return;
      case hd::kNominalMaxContinuousForce:
        *values = setup.continuous_force_N;
        return;
      case hd::kNominalMaxTorque:
      case hd::kNominalMaxContinuousTorque:
        Demand(setup.output_dof == 6, "torque limits asked of an arm without torque",
               hd::kInvalidOperation);
        *values =
            what == hd::kNominalMaxTorque ? setup.max_torque_mNm : setup.continuous_torque_mNm;
        return;
      default:
        WrongType(what);
    }
  }
  const char* GetString(hd::Enum what) {
    const std::lock_guard lock(mutex_);
    if (Enter(k_hdGetString) || !HasDevice()) return nullptr;
    switch (what) {
      case hd::kDeviceModelType:
        return "Fake arm";
      case hd::kSerialNumber:
        return "0042";
      case hd::kDriverVersion:
        return "1.2";
      case hd::kVersion:
        return "3.0-fake";
      default:
        WrongType(what);
        return nullptr;
    }
  }
  void SetDoubles(hd::Enum what, const double* values) {
    const std::lock_guard lock(mutex_);
    if (Enter(k_hdSetDoublev) || refused_frame_ || !HasDevice()) return;
    if (!Demand(frame_open_, "a force set outside a frame", hd::kInvalidOperation)) return;
    Demand(frame_thread_ == std::this_thread::get_id(), "a force set by another thread");
    const bool force = what == hd::kCurrentForce;
    if (!Demand(force || what == hd::kCurrentTorque, "an unknown output", hd::kInvalidEnum)) return;
    if (!Demand(force || setup.output_dof == 6, "torque for an arm without", hd::kInvalidOperation))
      return;
    const double size = std::hypot(values[0], values[1], values[2]);
    if (!Demand(std::isfinite(size), "an output that is not finite", hd::kInvalidValue)) return;
    const double most = force ? setup.max_force_N : setup.max_torque_mNm;
    if (size > most * (1.0 + 1e-9)) Refuse(hd::kExceededMaxForce);
    std::copy_n(values, 3, (force ? frame_.force_N : frame_.torque_mNm).begin());
    (force ? frame_.force_set : frame_.torque_set) = true;
  }
  hd::Enum CheckCalibration() {
    const std::lock_guard lock(mutex_);
    if (Enter(k_hdCheckCalibration) || !HasDevice()) return hd::kCalibrationNeedsManualInput;
    return calibration_;
  }
  void UpdateCalibration(hd::Enum style) {
    const std::lock_guard lock(mutex_);
    if (Enter(k_hdUpdateCalibration) || !HasDevice()) return;
    Demand(!motors_on_, "calibration while the motors are on");
    if (!Demand((style & setup.styles) != 0 && (style & (style - 1)) == 0, "an unknown style",
                hd::kInvalidEnum))
      return;
    Demand(style != hd::kInkwell || running_, "inkwell calibration without the scheduler");
    Demand(!frame_open_, "calibration within a frame");
    calibrations_.push_back(style);
    calibration_ = hd::kCalibrationOk;
  }
  void SetRate(unsigned long rate_Hz) {
    const std::lock_guard lock(mutex_);
    if (Enter(k_hdSetSchedulerRate)) return;
    Demand(!running_, "the rate set while the scheduler runs");
    if (rate_Hz > static_cast<unsigned long>(setup.most_rate_Hz)) return Refuse(hd::kInvalidValue);
    rate_Hz_ = static_cast<int>(rate_Hz);
  }
  hd::SchedulerHandle ScheduleAsynchronous(hd::Callback call, void* data, std::uint16_t priority) {
    const std::lock_guard lock(mutex_);
    if (Enter(k_hdScheduleAsynchronous)) return 0;
    Demand(initialised_, "a callback without a device");
    Demand(!running_, "an asynchronous callback after hdStartScheduler");
    Demand(!scheduled_.call, "a second asynchronous callback");
    scheduled_ = {call, data, priority, false};
    return 0x1'2345'6789UL;  // does not fit into an int
  }
  void Unschedule(hd::SchedulerHandle handle) {
    const std::lock_guard lock(mutex_);
    Enter(k_hdUnschedule);
    Demand(!running_, "hdUnschedule before hdStopScheduler");
    Demand(handle == 0x1'2345'6789UL, "another handle than was given");
    scheduled_ = Task{};
  }
  void ScheduleSynchronous(Task task) {
    std::unique_lock lock(mutex_);
    if (Enter(k_hdScheduleSynchronous)) return;
    Demand(!in_callback, "a synchronous callback within a callback");
    if (!running_ || !setup.real_time) {
      const bool ticks = running_;
      lock.unlock();
      if (ticks) return RunTick(&task);
      RunTask(task);
      return;
    }
    pending_.push_back(&task);
    done_.wait(lock, [&] { return task.done; });
  }
  void Start() {
    std::unique_lock lock(mutex_);
    if (Enter(k_hdStartScheduler)) return;
    Demand(scheduled_.call != nullptr, "hdStartScheduler before a callback is scheduled");
    Demand(!running_, "hdStartScheduler twice");
    Demand(!motors_on_, "hdStartScheduler with the motors on");
    running_ = true;
    if (setup.real_time) {
      thread_ = std::thread([this] { RunInRealTime(); });
      return;
    }
    lock.unlock();
    RunTick(nullptr);  // the first tick comes by itself
  }
  void StopScheduler() {
    {
      const std::lock_guard lock(mutex_);
      Enter(k_hdStopScheduler);
      Demand(!in_callback, "hdStopScheduler within a callback");
    }
    Stop();
  }
  double TimeStamp() {
    const std::lock_guard lock(mutex_);
    Enter(k_hdGetSchedulerTimeStamp);
    Demand(in_callback, "the tick's time outside a tick");
    return setup.real_time ? 1e-9 * static_cast<double>(SteadyNanoseconds() - tick_began_ns_)
                           : tick_elapsed_s;
  }

 private:
  static FakeArm* MapArm(const char* file) {
    const int fd = open(file, O_RDWR);
    void* memory = fd < 0
                       ? MAP_FAILED
                       : mmap(nullptr, sizeof(FakeArm), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    if (fd >= 0) close(fd);
    if (memory == MAP_FAILED) std::abort();
    return static_cast<FakeArm*>(memory);
  }

  template <class T>
  T Locked(const T& value) {
    const std::lock_guard lock(mutex_);
    return value;
  }
  /// Records a call.  Returns the error that the test wants it to have, or 0.
  hd::Code Enter(Function function) {
    const auto index = static_cast<std::size_t>(function);
    ++counts_[index];
    if (calls_.size() < kMostRecords) calls_.push_back(kNames[index]);
    const bool meant = has_failure_ && (failing_ < 0 || failing_ == function);
    if (!meant || --fails_in_ > 0) return hd::kSuccess;
    has_failure_ = false;
    if (function != k_hdGetError) Refuse(fails_with_);
    return fails_with_;
  }
  void Refuse(hd::Code code) {
    if (errors_ < queue_.size()) queue_[errors_++] = code;
  }
  bool Demand(bool so, const char* otherwise, hd::Code code = hd::kSuccess) {
    if (so) return true;
    if (violations_.size() < 100) violations_.push_back(otherwise);
    if (code != hd::kSuccess) Refuse(code);
    return false;
  }
  bool Known(hd::Handle handle) {
    return Demand(initialised_ && handle == kHandle, "a handle of no device", hd::kBadHandle);
  }
  bool HasDevice() { return Demand(current_, "a call without a current device", hd::kBadHandle); }
  bool MayRead(hd::Enum what) {
    if (refused_frame_ || !HasDevice() || unplugged) return false;
    const bool state = (what >= 0x2000 && what < 0x2400) || what == hd::kMotorTemperature;
    return !state || Demand(frame_open_, "state read outside a frame", hd::kInvalidOperation);
  }
  void WrongType(hd::Enum) { Demand(false, "a query of another type", hd::kInvalidInputType); }
  Vec3 Position() const {
    return Vec3(arm->position_mm[0], arm->position_mm[1], arm->position_mm[2]);
  }

  void RunTask(const Task& task) {
    in_callback = true;
    task.call(task.data);
    in_callback = false;
  }
  void RunTick(const Task* once) {
    Task servo;
    {
      const std::lock_guard lock(mutex_);
      ++tick_;
      tick_began_ns_ = SteadyNanoseconds();
      servo = scheduled_;
      MoveArm(1.0 / rate_Hz_);
    }
    // The higher priority first.
    const bool once_first = once && once->priority > servo.priority;
    if (once_first) RunTask(*once);
    if (servo.call) {
      RunTask(servo);
      const std::lock_guard lock(mutex_);
      Demand(!frame_open_, "a frame left open");
      Demand(errors_ == 0, "errors left in the queue");
    }
    if (once && !once_first) RunTask(*once);
    const std::lock_guard lock(mutex_);
    const double force = motors_on_ ? motor_force_.norm() : 0.0;
    arm->force_N = force;
    arm->most_force_N = std::max(arm->most_force_N.load(), force);
    if (force > 0.0) arm->last_force_ns = SteadyNanoseconds();
    ++arm->ticks;
  }
  void RunInRealTime() {
    std::unique_lock lock(mutex_);
    auto next = std::chrono::steady_clock::now();
    const auto finish = [this](std::vector<Task*>& tasks) {
      for (Task* task : tasks) task->done = true;
      tasks.clear();
      done_.notify_all();
    };
    std::vector<Task*> once;
    while (running_ && !dead_) {
      std::swap(once, pending_);
      lock.unlock();
      RunTick(nullptr);
      for (Task* task : once) RunTask(*task);
      next = std::max(next + std::chrono::nanoseconds(1'000'000'000 / rate_Hz_),
                      std::chrono::steady_clock::now());
      std::this_thread::sleep_until(next);
      lock.lock();
      finish(once);
    }
    finish(pending_);
  }
  void Stop() {
    {
      const std::lock_guard lock(mutex_);
      running_ = false;
    }
    if (thread_.joinable()) thread_.join();
  }
  void MoveArm(double dt) {
    if (setup.held_fast) {
      for (std::size_t i = 0; i < 3; ++i) arm->position_mm[i] = arm->hand_mm[i].load();
      velocity_ = Vec3::Zero();
      return;
    }
    const double h = dt / 4.0;
    for (int step = 0; step < 4; ++step) {
      for (int i = 0; i < 3; ++i) {
        const auto axis = static_cast<std::size_t>(i);
        const double x = arm->position_mm[axis];
        const double motor = motors_on_ ? motor_force_[i] : 0.0;
        const double hand =
            1e-3 * (kHand_N_m * (arm->hand_mm[axis] - x) - kHand_N_s_m * velocity_[i]);
        velocity_[i] += h * 1e3 * (motor + hand) / kMass_kg;
        arm->position_mm[axis] = x + h * velocity_[i];
      }
    }
  }

  std::mutex mutex_;
  std::condition_variable done_;
  std::thread thread_;
  std::atomic<bool> dead_{false};
  std::unique_ptr<FakeArm> own_arm_;
  FakeArm* shared_ = nullptr;
  Vec3 velocity_ = Vec3::Zero();  // mm/s
  Vec3 motor_force_ = Vec3::Zero();
  hd::Enum calibration_ = hd::kCalibrationOk;
  bool initialised_ = false, current_ = false, motors_on_ = false, running_ = false;
  bool frame_open_ = false, refused_frame_ = false;
  std::thread::id frame_thread_;
  FakeFrame frame_;
  std::uint64_t tick_ = 0, frame_tick_ = 0;
  std::int64_t tick_began_ns_ = 0, last_frame_ns_ = 0;
  int rate_Hz_ = 1000;
  Task scheduled_;
  std::vector<Task*> pending_;
  std::array<hd::Code, 32> queue_{};
  std::size_t errors_ = 0;
  bool has_failure_ = false;
  int failing_ = 0, fails_in_ = 0;
  hd::Code fails_with_ = 0;
  std::array<int, kFunctions> counts_{};
  std::vector<const char*> calls_;
  std::vector<FakeFrame> frames_;
  std::vector<std::string> violations_;
  std::vector<hd::Enum> calibrations_;
};

Library& TheLibrary() {
  static Library library;
  return library;
}

}  // namespace
}  // namespace palpate::test

using namespace palpate;  // NOLINT: the functions below have C's names
using palpate::test::TheLibrary;

extern "C" {
palpate::test::FakeHd* palpate_fake_hd() {
  return &TheLibrary();
}

#define PALPATE_FAKE(result, name, parameters, call) \
  result name parameters {                           \
    return TheLibrary().call;                        \
  }
PALPATE_FAKE(hd::Handle, hdInitDevice, (const char* name), Init(name))
PALPATE_FAKE(void, hdMakeCurrentDevice, (hd::Handle device), MakeCurrent(device))
PALPATE_FAKE(void, hdDisableDevice, (hd::Handle device), DisableDevice(device))
PALPATE_FAKE(void, hdBeginFrame, (hd::Handle device), Begin(device))
PALPATE_FAKE(void, hdEndFrame, (hd::Handle device), End(device))
PALPATE_FAKE(hd::ErrorInfo, hdGetError, (), GetError())
PALPATE_FAKE(void, hdEnable, (hd::Enum what), Switch(what, true))
PALPATE_FAKE(void, hdDisable, (hd::Enum what), Switch(what, false))
PALPATE_FAKE(void, hdGetBooleanv, (hd::Enum what, unsigned char* values), GetBooleans(what, values))
PALPATE_FAKE(void, hdGetIntegerv, (hd::Enum what, int* values), GetIntegers(what, values))
PALPATE_FAKE(void, hdGetDoublev, (hd::Enum what, double* values), GetDoubles(what, values))
PALPATE_FAKE(const char*, hdGetString, (hd::Enum what), GetString(what))
PALPATE_FAKE(void, hdSetDoublev, (hd::Enum what, const double* values), SetDoubles(what, values))
PALPATE_FAKE(hd::Enum, hdCheckCalibration, (), CheckCalibration())
PALPATE_FAKE(void, hdUpdateCalibration, (hd::Enum style), UpdateCalibration(style))
PALPATE_FAKE(void, hdStartScheduler, (), Start())
PALPATE_FAKE(void, hdStopScheduler, (), StopScheduler())
PALPATE_FAKE(void, hdSetSchedulerRate, (unsigned long rate_Hz), SetRate(rate_Hz))
PALPATE_FAKE(void, hdScheduleSynchronous, (hd::Callback call, void* data, std::uint16_t priority),
             ScheduleSynchronous({call, data, priority, false}))
PALPATE_FAKE(hd::SchedulerHandle, hdScheduleAsynchronous,
             (hd::Callback call, void* data, std::uint16_t priority),
             ScheduleAsynchronous(call, data, priority))
PALPATE_FAKE(void, hdUnschedule, (hd::SchedulerHandle handle), Unschedule(handle))
PALPATE_FAKE(double, hdGetSchedulerTimeStamp, (), TimeStamp())
#undef PALPATE_FAKE
}
