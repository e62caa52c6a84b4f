#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>

#include "client/crtk/operating_state.h"
#include "client/crtk/sample_clock.h"
#include "client/crtk/servo_aim.h"
#include "common/dds/endpoint.h"
#include "common/dds/ros2.h"
#include "common/realtime/rate_limit.h"

namespace palpate {

/// "/hand": a station's name as a namespace of ROS, whose names begin with no digit.
std::string RosNamespace(const std::string& station);

/// Why a station's name cannot be a name of ROS 2, and what to do; empty where it can.  Names of
/// ROS have no two underscores side by side (design.ros2.org, "Topic and Service name mapping to
/// DDS"). They are refused and not made one, or two stations could come to have one name.
std::string WhyNoRosName(const std::string& station);

/// One station on ROS 2: each pose and wrench of its loop goes out in the thread that received it,
/// so that nothing waits for another thread; what comes from ROS waits for Poll.
/// Thread contract: all but the loop's callbacks one thread.
class CrtkStation {
 public:
  /// @param guide  where what servo_cf asks for goes; not looked at where `read_only`.
  /// Throws Error.
  CrtkStation(const ros2::Participant& ros, const std::string& station, bool read_only,
              const GuideLimits& limits, dds::Writer<wire::GuideTarget>& guide,
              dds::Writer<wire::OperateRequest>& wishes);
  ~CrtkStation();
  CrtkStation(const CrtkStation&) = delete;
  CrtkStation& operator=(const CrtkStation&) = delete;

  /// What the server says of its session.
  void Hear(const wire::SessionState& state, std::int64_t now_ns);
  /// To be called every few milliseconds: opens the loop's topics once their writers are known,
  /// tells of the state, takes what came from ROS.
  void Poll(const dds::Participant& loop, std::int64_t now_ns);

  /// In all its sessions: samples of the loop that came, that their numbers say are missing, and
  /// messages that DDS refused.
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
  std::int64_t ended_ns_ = 0;  // 0: it has not
  std::string frame_;          // changes only while nobody hears the loop
  CrtkState told_;
  std::int64_t told_ns_ = 0;
  wire::GuideTarget target_{};
  std::int64_t aimed_ns_ = 0;
  RateLimit words_;

  SampleClock clock_;
  std::mutex hand_mutex_;
  std::optional<Pose> hand_;
  std::atomic<std::uint32_t> faults_{0};
  // Of one callback each.
  std::uint64_t next_pose_ = 0;
  std::uint32_t next_answer_ = 0;
  ros2::PoseStamped cp_message_{};
  ros2::TwistStamped cv_message_{};
  ros2::WrenchStamped cf_message_{};
  std::atomic<std::uint64_t> pose_count_{0}, wrench_count_{0}, missing_{0}, refused_{0};

  // Last: their callbacks use what stands before them.
  dds::Reader<wire::HapticPose> poses_;
  dds::Reader<wire::Wrench> wrenches_;
};

}  // namespace palpate
