#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "client/station/guide.h"
#include "common/dds/endpoint.h"
#include "common/dds/ros2.h"
#include "common/dds/wire.h"
#include "common/math/pose.h"
#include "common/math/rotation.h"
#include "common/realtime/rate_limit.h"
#include "common/step_fault.h"

namespace palpate {

/// The state of a station, as CRTK's operating_state reports it.
struct CrtkState {
  const char* state = "DISABLED";  ///< DISABLED, ENABLED, PAUSED or FAULT
  bool homed = false;              ///< true while its poses are those of a hand in the scene
  bool busy = false;               ///< on its way to a state in which forces are computed
  bool operator==(const CrtkState&) const = default;
};

/// Returns the CRTK state for a session's phase.
/// @param faults  the fault bits of the newest wrench.
inline CrtkState CrtkStateOf(wire::SessionPhase phase, bool muted, std::uint32_t faults) {
  switch (phase) {
    case palpate_SESSION_WAITING:
      return {"DISABLED", false, true};
    case palpate_SESSION_ACQUIRING:
      return {"PAUSED", true, true};
    case palpate_SESSION_ACTIVE:
      if (muted) return {"PAUSED", true, false};
      if ((faults & (kFaultBadPose | kFaultPoseRejected | kFaultUnsolved)) != 0) {
        return {"FAULT", true, false};
      }
      return {"ENABLED", true, false};
    default:
      return {};
  }
}

/// Returns the request to the server that a state_command stands for.  Returns none for a
/// command that a station does not have (it homes its device itself) and for a word that CRTK
/// does not define.
inline std::optional<wire::OperateWish> WishOf(std::string_view command, wire::SessionPhase phase) {
  if (command == "pause") return palpate_OPERATE_MUTE;
  if (command == "resume" || command == "unpause") return palpate_OPERATE_UNMUTE;
  if (command == "enable") {
    return phase == palpate_SESSION_HELD ? palpate_OPERATE_ADMIT : palpate_OPERATE_UNMUTE;
  }
  if (command == "disable") return palpate_OPERATE_TAKE_BACK;
  return std::nullopt;
}

/// Converts times of a station's steady clock into times of this host's system clock, which ROS
/// uses for its stamps.  Adds the smallest delay between sampling and arrival seen lately: some
/// tens of microseconds on one host.  It may grow by 100 us per second, faster than two clocks
/// drift apart, and starts anew when a clock was set by more than a second.
/// Thread contract: Hear one thread, ToSystem any.
class SampleClock {
 public:
  /// Takes the time of a sample that has just arrived.
  void Hear(std::int64_t sample_ns, std::int64_t system_ns) noexcept {
    const std::int64_t offset_ns = system_ns - sample_ns;
    const std::int64_t known_ns = offset_ns_.load(std::memory_order_relaxed);
    const std::int64_t allowed_ns = known_ns + (system_ns - heard_ns_) / kSlowness;
    const bool leaps =
        offset_ns - known_ns > kLeap_ns || known_ns - offset_ns > kLeap_ns || heard_ns_ == 0;
    heard_ns_ = system_ns;
    offset_ns_.store(leaps || offset_ns < allowed_ns ? offset_ns : allowed_ns,
                     std::memory_order_relaxed);
  }
  std::int64_t ToSystem(std::int64_t sample_ns) const noexcept {
    return sample_ns + offset_ns_.load(std::memory_order_relaxed);
  }

 private:
  static constexpr std::int64_t kSlowness = 10'000;
  static constexpr std::int64_t kLeap_ns = 1'000'000'000;
  std::atomic<std::int64_t> offset_ns_{0};
  std::int64_t heard_ns_ = 0;
};

/// Returns the aim with which a guide makes a station pull a hand at rest with the wanted wrench.
/// A station pulls in proportion to the distance, up to its full force at Guide::kReach_m, so an
/// aim within that reach sets a force.  A wrench beyond the limits is shortened to them, keeping
/// its direction.  Returns none if a number is not finite.
/// @param wanted  force and torque on the hand, in W.
/// @param limits  those of the station (its --guide-force).
inline std::optional<Pose> ServoAim(const Pose& X_WH, const Wrench& wanted,
                                    const GuideLimits& limits) {
  if (!wanted.force.allFinite() || !wanted.torque.allFinite() || !(limits.force_N > 0.0)) {
    return std::nullopt;
  }
  // A guide treats a hand beyond the reach, even by a rounding error, as one that resists.
  constexpr double kWithin = 1.0 - 1e-9;
  const auto part = [](const Vec3& v, double limit, double reach) {
    const double norm = v.stableNorm();
    return Vec3(v * (kWithin * reach / std::max(norm, limit)));
  };
  const Vec3 step = part(wanted.force, limits.force_N, Guide::kReach_m);
  const Vec3 turn = part(wanted.torque, limits.torque_Nm, Guide::kReach_rad);
  return Pose{X_WH.p + step, (RotationExp(turn) * X_WH.q).normalized()};
}

/// Returns the ROS namespace of a station, such as "/hand".  ROS names must not begin with a digit.
std::string RosNamespace(const std::string& station);

/// Returns why a station's name cannot be a ROS 2 name, and what to do; empty if it can.  ROS
/// names have no two adjacent underscores (design.ros2.org, "Topic and Service name mapping to
/// DDS").  Such names are refused rather than changed, since two stations could otherwise get the
/// same name.
std::string WhyNoRosName(const std::string& station);

/// One station on ROS 2.  Each pose and wrench of its loop is published in the thread that received
/// it, so no sample waits for another thread; messages from ROS wait for Poll.
/// Thread contract: all methods in one thread; the loop's callbacks run in others.
class CrtkStation {
 public:
  /// @param guide  receives the aims that servo_cf asks for; not used if `read_only`.
  /// Throws Error.
  CrtkStation(const ros2::Participant& ros, const std::string& station, bool read_only,
              const GuideLimits& limits, dds::Writer<wire::GuideTarget>& guide,
              dds::Writer<wire::OperateRequest>& wishes);
  ~CrtkStation();
  CrtkStation(const CrtkStation&) = delete;
  CrtkStation& operator=(const CrtkStation&) = delete;

  /// Takes a state that the server reports of its session.
  void Hear(const wire::SessionState& state, std::int64_t now_ns);
  /// Opens the loop's topics once their writers are known, publishes the state and handles messages
  /// from ROS.  Call it every few milliseconds.
  void Poll(const dds::Participant& loop, std::int64_t now_ns);

  /// Counts over all sessions: samples of the loop that arrived, samples missing by their sequence
  /// numbers, and messages that DDS refused.
  struct Counts {
    std::uint64_t poses = 0, wrenches = 0, missing = 0, refused = 0;
  };
  Counts counts() const;
  const std::string& ros_namespace() const { return namespace_; }

 private:
  void OnPose(const wire::HapticPose& pose) noexcept;
  void OnWrench(const wire::Wrench& wrench) noexcept;
  void OnServo(const ros2::WrenchStamped& wanted, std::int64_t now_ns);
  void OnCommand(const ros2::StringStamped& command, std::int64_t now_ns);
  void LeaveLoop();
  void TellState(std::int64_t now_ns);
  template <class Message>
  void Stamp(Message& message, std::int64_t sample_ns) const noexcept;

  const std::string station_, namespace_;
  const bool read_only_;
  const GuideLimits limits_;
  dds::Writer<wire::GuideTarget>& guide_;
  dds::Writer<wire::OperateRequest>& wishes_;
  ros2::Writer<ros2::PoseStamped> cp_;
  ros2::Writer<ros2::TwistStamped> cv_;
  ros2::Writer<ros2::WrenchStamped> cf_;
  ros2::Writer<ros2::OperatingState> operating_state_;
  std::optional<ros2::Reader<ros2::WrenchStamped>> servo_;
  std::optional<ros2::Reader<ros2::StringStamped>> commands_;

  wire::SessionState session_{};
  std::int64_t ended_ns_ = 0;  // 0: it has not ended
  std::string frame_;          // changes only while nobody reads the loop
  CrtkState reported_;
  std::int64_t told_ns_ = 0;
  wire::GuideTarget target_{};
  std::int64_t aimed_ns_ = 0;
  RateLimit words_;

  SampleClock clock_;
  std::mutex hand_mutex_;
  std::optional<Pose> hand_;
  std::atomic<std::uint32_t> faults_{0};
  // Each used by one callback only.
  std::uint64_t next_pose_ = 0;
  std::uint32_t next_answer_ = 0;
  ros2::PoseStamped cp_message_{};
  ros2::TwistStamped cv_message_{};
  ros2::WrenchStamped cf_message_{};
  std::atomic<std::uint64_t> pose_count_{0}, wrench_count_{0}, missing_{0}, refused_{0};

  // Last members: their callbacks use the members above.
  dds::Reader<wire::HapticPose> poses_;
  dds::Reader<wire::Wrench> wrenches_;
};

}  // namespace palpate
