#include "devices/plugin/plugin_arm.h"

#include <chrono>
#include <cmath>
#include <cstring>
#include <exception>
#include <limits>
#include <sstream>
#include <thread>

#include "common/error.h"
#include "common/math/pose_check.h"
#include "common/realtime/steady_clock.h"

namespace palpate::plugin {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr const char* kRead = "palpate_device_read";
constexpr const char* kWrite = "palpate_device_write";
constexpr const char* kPage = "'An arm of your own' in devices/arm.md";

std::string WordsOf(const Trouble& trouble) {
  const std::string symbol = trouble.symbol;
  switch (trouble.kind) {
    case Trouble::kStarting:
    case Trouble::kNone:
      return "the arm is ready: forces come in by a ramp";
    case Trouble::kFailed:
      return symbol + " failed (" + std::to_string(trouble.answer) + "): " +
             (trouble.said[0] ? trouble.said
                              : "palpate_device_last_error does not say why: let it name cause and "
                                "remedy") +
             "; no force until it returns 0";
    case Trouble::kThrew:
      return symbol +
             " threw an exception; no force: catch it there, and return another number "
             "than 0";
    case Trouble::kPosition:
      return symbol +
             " gave a position_m that is not finite, or far outside of the workspace_m of "
             "its data sheet; no force: give metres about workspace_centre_m";
    case Trouble::kOrientation:
      return symbol +
             " gave an orientation_wxyz that is not of length 1; no force: normalise it, "
             "with w first";
    case Trouble::kJumped:
      return symbol +
             " gave a pose that jumped by more than 50 mm or half a radian in a tick; no "
             "force for a moment: calibrate the arm, or leave such readings out";
    case Trouble::kStuck:
      return symbol +
             " gave no new reading for 10 ms; no force: mend the link to the arm, and "
             "count each of its readings in `number`";
    case Trouble::kHung:
      if (symbol.empty()) {
        return "the loop was held up for more than 20 ms; no force for a moment: see "
               "palpate-doctor";
      }
      return symbol +
             " did not return for 20 ms; palpate_device_stop took the force off: give "
             "what blocks a thread of its own";
  }
  return "";
}

/// What the sheet says, in range: a force in grams or a length in millimetres shows here.
void CheckSheet(const palpate_device_info& sheet, const std::string& begin) {
  const bool torque = sheet.max_torque_Nm != 0.0;
  struct Row {
    const char* field;
    double value, least, most;
  };
  const double most_force = sheet.max_force_N, most_torque = sheet.max_torque_Nm;
  for (const Row& row :
       {Row{"max_force_N", most_force, 0.01, 200.0},
        Row{"continuous_force_N", sheet.continuous_force_N, 0.01, most_force},
        Row{"max_torque_Nm", most_torque, torque ? 1e-4 : 0.0, 20.0},
        Row{"continuous_torque_Nm", sheet.continuous_torque_Nm, torque ? 1e-4 : 0.0, most_torque},
        Row{"workspace_m[0]", sheet.workspace_m[0], 0.005, 5.0},
        Row{"workspace_m[1]", sheet.workspace_m[1], 0.005, 5.0},
        Row{"workspace_m[2]", sheet.workspace_m[2], 0.005, 5.0},
        Row{"workspace_centre_m[0]", sheet.workspace_centre_m[0], -5.0, 5.0},
        Row{"workspace_centre_m[1]", sheet.workspace_centre_m[1], -5.0, 5.0},
        Row{"workspace_centre_m[2]", sheet.workspace_centre_m[2], -5.0, 5.0},
        Row{"position_resolution_m", sheet.position_resolution_m, 0.0, 0.01},
        Row{"rotation_resolution_rad", sheet.rotation_resolution_rad, 0.0, 0.2},
        Row{"thermal_time_s", sheet.thermal_time_s, 1.0, 3600.0}}) {
    if (row.value >= row.least && row.value <= row.most) continue;
    std::ostringstream words;
    words << begin << "palpate_device_open: info." << row.field << " is " << row.value
          << "; give the figure of the arm's data sheet, from " << row.least << " to " << row.most;
    throw Error(words.str());
  }
}

}  // namespace

Driver LoadDriver(const std::string& file) {
  // Without a slash the loader would look elsewhere.
  const std::string path = file.find('/') == std::string::npos ? "./" + file : file;
  const std::string device = "--device " + file;
  Driver driver = Driver::Load(
      {path}, {.device = device,
               .library = "driver",
               .install = std::string("build it as a shared object (") + kPage + ")",
               .files = {},
               .not_it = "define every function of palpate_device.h, with its PALPATE_DEVICE_API"});
  const std::uint32_t version = driver.functions.abi();
  if (version == 0 || version > PALPATE_DEVICE_ABI) {
    throw Error(device + ": palpate_device_abi returns " + std::to_string(version) +
                ", and this station knows 1 to " + std::to_string(PALPATE_DEVICE_ABI) +
                "; build the driver with the palpate_device.h of this version of palpate");
  }
  return driver;
}

// Opening.

PluginArm::PluginArm(const DeviceOptions& options)
    : file_(options.name),
      driver_(LoadDriver(options.name)),
      gate_(options.rate_Hz),
      turn_rate_(options.rate_Hz) {
  try {
    Open(options);
  } catch (...) {
    Close();
    throw;
  }
}

PluginArm::~PluginArm() {
  Close();
}

void PluginArm::Open(const DeviceOptions& options) {
  const std::string begin = "--device " + file_ + ": ";
  palpate_device_info sheet{};
  sheet.thermal_time_s = info.thermal_time_s;
  try {
    device_ = api_.open(options.arm.c_str(), options.rate_Hz, &sheet);
  } catch (...) {
    throw Error(begin +
                "palpate_device_open threw an exception; catch it there, and return a null "
                "pointer");
  }
  if (device_ == nullptr) throw Error(begin + "palpate_device_open failed: " + LastError());
  CheckSheet(sheet, begin);
  info.model =
      std::string(sheet.model, strnlen(sheet.model, sizeof sheet.model)) + " (" + file_ + ")";
  info.max_force_N = sheet.max_force_N;
  info.continuous_force_N = sheet.continuous_force_N;
  info.max_torque_Nm = sheet.max_torque_Nm;
  info.continuous_torque_Nm = sheet.continuous_torque_Nm;
  if (sheet.max_torque_Nm == 0.0) info.torque_axes = 0;
  info.workspace_m = Vec3(sheet.workspace_m);
  info.workspace_centre_m = Vec3(sheet.workspace_centre_m);
  info.position_resolution_m = sheet.position_resolution_m;
  info.rotation_resolution_rad = sheet.rotation_resolution_rad;
  info.thermal_time_s = sheet.thermal_time_s;
  info.rate_Hz = options.rate_Hz;
}

void PluginArm::Close() noexcept {
  if (device_ == nullptr) return;
  Stop();
  try {
    api_.close(device_);
  } catch (...) {
  }
  device_ = nullptr;
}

std::string PluginArm::LastError() const {
  const char* said = api_.last_error(device_);
  return said && *said ? said : "palpate_device_last_error does not say why";
}

// The loop: no allocation, lock, log or exception of ours.

void PluginArm::Begin() noexcept {
  alive_ns_.store(SteadyNanoseconds());
  phase_.store(Phase::kDriver);
}

bool PluginArm::Fault(Trouble::Kind kind, const char* symbol, int answer) noexcept {
  gate_.Fault();
  // What comes of the first cause is not told in its place.
  if (trouble_.kind > Trouble::kNone) return false;
  trouble_ = {kind, symbol, answer};
  if (kind == Trouble::kFailed) {
    try {
      const char* said = api_.last_error(device_);
      if (said) std::memcpy(trouble_.said, said, strnlen(said, sizeof trouble_.said - 1));
    } catch (...) {  // a driver that does not even know that
    }
  }
  troubles_.Write(trouble_);
  return false;
}

bool PluginArm::WasHung() noexcept {
  const char* in = hung_in_.exchange(nullptr);
  if (in != nullptr) Fault(Trouble::kHung, in);
  return in != nullptr;
}

template <class Function>
bool PluginArm::Call(const char* symbol, Function call) noexcept {
  int answer = 0;
  bool threw = false;
  calling_.store(symbol);
  try {
    answer = call();
  } catch (...) {
    threw = true;
  }
  calling_.store("");
  alive_ns_.store(SteadyNanoseconds());
  if (WasHung()) return false;
  if (threw) return Fault(Trouble::kThrew, symbol);
  return answer == 0 || Fault(Trouble::kFailed, symbol, answer);
}

bool PluginArm::Take(const palpate_device_reading& reading) noexcept {
  const Vec3 p(reading.position_m);
  const double* const wxyz = reading.orientation_wxyz;
  Quat q(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
  if (!((p - info.workspace_centre_m).norm() <= info.workspace_m.norm())) {
    return Fault(Trouble::kPosition, kRead);
  }
  if (!IsPose({p, q})) return Fault(Trouble::kOrientation, kRead);
  q.normalize();
  stuck_ticks_ = has_pose_ && reading.number == number_ ? stuck_ticks_ + 1 : 0;
  if (stuck_ticks_ >= kStuck_s * info.rate_Hz) return Fault(Trouble::kStuck, kRead);
  const Vec3 way = p - sample.X_WH.p;
  const bool jumped =
      has_pose_ && (way.norm() > kJump_m || sample.X_WH.q.angularDistance(q) > kJump_rad);
  if (jumped) Fault(Trouble::kJumped, kRead);
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

bool PluginArm::Sense() noexcept {
  palpate_device_reading reading{};
  for (double& coordinate : reading.position_m) coordinate = kNaN;
  reading.orientation_wxyz[0] = 1.0;
  reading.motor_temperature = kNaN;
  return Call(kRead, [&] { return api_.read(device_, &reading); }) && Take(reading);
}

bool PluginArm::Turn(const std::function<void()>& tick) noexcept {
  if (!Sense()) {  // the pose is held
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
  phase_.store(Phase::kDriver);
  WasHung();  // while it ticked
  const Wrench given = gate_.Passes(wanted) ? wanted : Wrench{};
  const auto write = [&] { return api_.write(device_, given.force.data(), given.torque.data()); };
  if (!Call(kWrite, write)) Stop();
  if (gate_.open() && trouble_.kind != Trouble::kNone) {
    trouble_ = {Trouble::kNone};
    troubles_.Write(trouble_);
  }
  ready_.store(gate_.open());
  return true;
}

// Other threads.

void PluginArm::Watch(std::int64_t now_ns) noexcept {
  if (now_ns - alive_ns_.load() < static_cast<std::int64_t>(1e9 * kHang_s)) return;
  if (hung_in_.load() != nullptr) return;
  hung_in_.store(calling_.load());
  Stop();
}

void PluginArm::Leave() noexcept {
  for (Phase phase = Phase::kDriver; !phase_.compare_exchange_weak(phase, Phase::kLeft);) {
    if (phase == Phase::kLeft) return;
    phase = Phase::kDriver;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

void PluginArm::Stop() noexcept {
  int answer = -1;
  try {
    answer = api_.stop(device_);
  } catch (...) {
  }
  if (answer != 0) stop_failed_.store(true);
}

std::string PluginArm::Attend() {
  troubles_.Read(seen_);
  Trouble now = seen_;
  if (const char* in = hung_in_.load()) now = {Trouble::kHung, in};
  std::string news;
  if (now.kind != told_.kind || now.symbol != told_.symbol) {
    told_ = now;
    if (now.kind == Trouble::kNone) told_stop_ = false;
    AddLine(news, file_ + ": " + WordsOf(now));
  }
  if (stop_failed_.exchange(false) && !told_stop_) {
    told_stop_ = true;
    AddLine(news, file_ +
                      ": palpate_device_stop failed: forces may still be on; switch the arm "
                      "off");
  }
  return news;
}

}  // namespace palpate::plugin
