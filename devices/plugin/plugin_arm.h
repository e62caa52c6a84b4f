#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>

#include "common/realtime/latest_mailbox.h"
#include "devices/arm_parts.h"
#include "devices/device_factory.h"
#include "devices/plugin/palpate_device.h"
#include "devices/vendor_library.h"

namespace palpate::plugin {

/// The functions of palpate_device.h.
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
    visit(read, "palpate_device_read");
    visit(write, "palpate_device_write");
    visit(stop, "palpate_device_stop");
    visit(close, "palpate_device_close");
    visit(last_error, "palpate_device_last_error");
  }
};

using Driver = VendorLibrary<Functions>;

/// Throws Error where the file is no driver, or one of a later version: names file, symbol and
/// remedy.
Driver LoadDriver(const std::string& file);

/// Why an arm gives no force.
struct Trouble {
  enum Kind { kStarting, kNone, kFailed, kThrew, kPosition, kOrientation, kJumped, kStuck, kHung };
  Kind kind = kStarting;
  const char* symbol = "";  ///< the driver's function; kHung: empty where the loop was held up
  int answer = 0;           ///< kFailed
  char said[200] = {};      ///< kFailed: by palpate_device_last_error
};

/// An arm behind a driver that may do anything but crash: each call is guarded, each reading
/// checked, and each failure shuts a gate, from which force returns by a ramp (ReturnGate).  Where
/// a call does not return, another thread takes the force off (Watch).
/// Thread contract: Turn in the loop's thread, Watch in a thread of its own, Attend in the main
/// thread; Leave and Stop in any; `sample` and `wanted` within a tick.
class PluginArm {
 public:
  static constexpr double kHang_s = 0.020;   ///< longer than that no turn takes
  static constexpr double kStuck_s = 0.010;  ///< without a new reading
  // No hand moves so far in a tick; an arm that is calibrated does.
  static constexpr double kJump_m = 0.05;
  static constexpr double kJump_rad = 0.5;

  /// Opens it.  Throws Error as LoadDriver does, and where the driver fails, or its data sheet is
  /// none.
  explicit PluginArm(const DeviceOptions& options);
  ~PluginArm();
  PluginArm(const PluginArm&) = delete;
  PluginArm& operator=(const PluginArm&) = delete;

  /// To be called before the first turn of a loop.
  void Begin() noexcept;
  /// A turn of it: reads, calls `tick`, writes what the tick has `wanted`.  False: Leave was
  /// called. Real-time, as far as the driver is.
  bool Turn(const std::function<void()>& tick) noexcept;
  /// Takes the force off where no turn has ended for kHang_s.
  void Watch(std::int64_t now_ns) noexcept;
  /// When it returns, no tick runs, nor will.
  void Leave() noexcept;
  /// Takes all force off.
  void Stop() noexcept;
  /// What happened since, for people.
  std::string Attend();
  /// In order: neither at fault nor hanging.
  bool ready() const noexcept { return ready_.load() && hung_in_.load() == nullptr; }

  DeviceInfo info;
  DeviceSample sample;
  Wrench wanted;

 private:
  enum class Phase { kDriver, kTick, kLeft };

  void Open(const DeviceOptions& options);
  void Close() noexcept;
  std::string LastError() const;
  template <class Function>
  bool Call(const char* symbol, Function call) noexcept;
  bool Sense() noexcept;
  bool Take(const palpate_device_reading& reading) noexcept;
  bool Fault(Trouble::Kind kind, const char* symbol, int answer = 0) noexcept;
  /// True once after each time that Watch took the force off.
  bool WasHung() noexcept;

  const std::string file_;
  const Driver driver_;
  const Functions& api_ = driver_.functions;
  palpate_device* device_ = nullptr;
  // Of the loop.
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
  std::atomic<const char*> hung_in_{nullptr};  // until the call returns
  std::atomic<bool> stop_failed_{false};
  LatestMailbox<Trouble> troubles_;
  // Of the main thread.
  Trouble seen_;
  Trouble told_;
  bool told_stop_ = false;
};

}  // namespace palpate::plugin
