#include "client/crtk/crtk_station.h"

#include <spdlog/spdlog.h>

#include "common/dds/random_run.h"
#include "common/dds/topics.h"
#include "common/realtime/wall_clock.h"
#include "common/text/quoted.h"

namespace palpate {
namespace {

/// Loop topics stay open this long after a session ends, for samples still in flight.
constexpr std::int64_t kLinger_ns = 500'000'000;
/// The state is published again after this time, for subscribers that come later.
constexpr std::int64_t kTellAgain_ns = 500'000'000;
/// Aims need not come faster: a station looks for them every few milliseconds.
constexpr std::int64_t kAimPeriod_ns = 4'000'000;

template <class Vector>
void Put(const double (&from)[3], Vector& to) noexcept {
  to.x = from[0];
  to.y = from[1];
  to.z = from[2];
}

void StampAt(ros2::Header& header, std::int64_t system_ns) noexcept {
  header.stamp.sec = static_cast<std::int32_t>(system_ns / 1'000'000'000);
  header.stamp.nanosec = static_cast<std::uint32_t>(system_ns % 1'000'000'000);
}

/// Returns whether the frame is the station's; an empty name means the scene's frame.
bool IsFrame(const ros2::Header& header, const std::string& frame) {
  return header.frame_id == nullptr || header.frame_id[0] == '\0' || frame == header.frame_id;
}

}  // namespace

std::string RosNamespace(const std::string& station) {
  const bool digit = !station.empty() && station[0] >= '0' && station[0] <= '9';
  return (digit ? "/station_" : "/") + station;
}

std::string WhyNoRosName(const std::string& station) {
  if (station.find("__") == std::string::npos) return {};
  return "names of ROS 2 have no '__'; give the station an --id without it";
}

CrtkStation::CrtkStation(const ros2::Participant& ros, const std::string& station, bool read_only,
                         const GuideLimits& limits, dds::Writer<wire::GuideTarget>& guide,
                         dds::Writer<wire::OperateRequest>& wishes)
    : station_(station),
      namespace_(RosNamespace(station)),
      read_only_(read_only),
      limits_(limits),
      guide_(guide),
      wishes_(wishes),
      cp_(ros, namespace_ + "/measured_cp"),
      cv_(ros, namespace_ + "/measured_cv"),
      cf_(ros, namespace_ + "/measured_cf"),
      operating_state_(ros, namespace_ + "/operating_state") {
  session_.phase = palpate_SESSION_ENDED;
  wire::FromText(station, target_.station);
  target_.run = RandomRun();
  if (read_only_) return;
  // A late wrench is as bad as a lost one, and a best-effort writer has to match too.
  servo_.emplace(ros, namespace_ + "/servo_cf", ros2::Wants::kNewest);
  commands_.emplace(ros, namespace_ + "/state_command", ros2::Wants::kAll);
}

CrtkStation::~CrtkStation() {
  LeaveLoop();
}

void CrtkStation::LeaveLoop() {
  // No callback runs any more once these have returned.
  poses_ = {};
  wrenches_ = {};
  next_pose_ = 0;
  next_answer_ = 0;
  faults_ = 0;
  const std::lock_guard lock(hand_mutex_);
  hand_.reset();
}

void CrtkStation::Hear(const wire::SessionState& state, std::int64_t now_ns) {
  if (state.phase == palpate_SESSION_REFUSED) return;
  if (state.phase == palpate_SESSION_ENDED) {
    if (state.run != session_.run) return;
    if (ended_ns_ == 0) ended_ns_ = now_ns;
  } else if (state.run != session_.run || ended_ns_ != 0) {
    LeaveLoop();
    ended_ns_ = 0;
    frame_ = Printable(state.scene);
  }
  session_ = state;
}

void CrtkStation::Poll(const dds::Participant& loop, std::int64_t now_ns) {
  if (ended_ns_ != 0 && now_ns - ended_ns_ > kLinger_ns && (poses_ || wrenches_)) LeaveLoop();
  if (session_.phase != palpate_SESSION_ENDED) {
    // Over shared memory, a reader made before it has discovered the writer leaks chunks for good.
    const std::string pose_topic = dds::PoseTopic(station_, session_.run);
    if (!poses_ && dds::WriterDiscovered(loop, pose_topic)) {
      poses_ = {loop, pose_topic, dds::Qos::kRecord,
                [this](const wire::HapticPose& pose) { OnPose(pose); }};
    }
    const std::string wrench_topic = dds::WrenchTopic(station_, session_.run);
    if (!wrenches_ && dds::WriterDiscovered(loop, wrench_topic)) {
      wrenches_ = {loop, wrench_topic, dds::Qos::kRecord,
                   [this](const wire::Wrench& wrench) { OnWrench(wrench); }};
    }
  }
  TellState(now_ns);
  if (servo_) servo_->Poll([&](const ros2::WrenchStamped& wanted) { OnServo(wanted, now_ns); });
  if (commands_) {
    commands_->Poll([&](const ros2::StringStamped& command) { OnCommand(command, now_ns); });
  }
}

template <class Message>
void CrtkStation::Stamp(Message& message, std::int64_t sample_ns) const noexcept {
  StampAt(message.header, clock_.ToSystem(sample_ns));
  message.header.frame_id = const_cast<char*>(frame_.c_str());  // DDS only reads it
}

void CrtkStation::OnPose(const wire::HapticPose& pose) noexcept {
  clock_.Hear(pose.sample_time_ns, WallClock_ns());
  Stamp(cp_message_, pose.sample_time_ns);
  Put(pose.position_m, cp_message_.pose.position);
  auto& q = cp_message_.pose.orientation;
  q.w = pose.orientation_wxyz[0];
  q.x = pose.orientation_wxyz[1];
  q.y = pose.orientation_wxyz[2];
  q.z = pose.orientation_wxyz[3];
  cv_message_.header = cp_message_.header;
  Put(pose.linear_velocity_m_s, cv_message_.twist.linear);
  Put(pose.angular_velocity_rad_s, cv_message_.twist.angular);
  refused_ += std::uint64_t{!cp_.Write(cp_message_)} + std::uint64_t{!cv_.Write(cv_message_)};
  ++pose_count_;
  if (next_pose_ != 0 && pose.pose_sequence > next_pose_) {
    missing_ += pose.pose_sequence - next_pose_;
  }
  next_pose_ = pose.pose_sequence + 1;
  if (read_only_) return;
  const std::lock_guard lock(hand_mutex_);
  hand_ = wire::ToPose(pose);
}

void CrtkStation::OnWrench(const wire::Wrench& wrench) noexcept {
  Stamp(cf_message_, wrench.pose_time_ns);
  Put(wrench.force_N, cf_message_.wrench.force);
  Put(wrench.torque_Nm, cf_message_.wrench.torque);
  refused_ += std::uint64_t{!cf_.Write(cf_message_)};
  faults_.store(wrench.faults, std::memory_order_relaxed);
  ++wrench_count_;
  if (next_answer_ != 0 && wrench.answer > next_answer_) missing_ += wrench.answer - next_answer_;
  next_answer_ = wrench.answer + 1;
}

void CrtkStation::OnServo(const ros2::WrenchStamped& wanted, std::int64_t now_ns) {
  if (now_ns - aimed_ns_ < kAimPeriod_ns || session_.phase != palpate_SESSION_ACTIVE) return;
  if (!IsFrame(wanted.header, frame_)) {
    if (words_.Pass(now_ns)) {
      spdlog::warn("{}/servo_cf: ignored, because its frame is {} instead of {}", namespace_,
                   Quoted(wanted.header.frame_id), Quoted(frame_));
    }
    return;
  }
  std::optional<Pose> hand;
  {
    const std::lock_guard lock(hand_mutex_);
    hand = hand_;
  }
  if (!hand) return;
  const auto& f = wanted.wrench.force;
  const auto& t = wanted.wrench.torque;
  const auto aim = ServoAim(*hand, {Vec3(f.x, f.y, f.z), Vec3(t.x, t.y, t.z)}, limits_);
  if (!aim) {
    if (words_.Pass(now_ns)) {
      spdlog::warn("{}/servo_cf: ignored, because it is not finite", namespace_);
    }
    return;
  }
  aimed_ns_ = now_ns;
  ++target_.number;
  wire::FromPose(*aim, target_.position_m, target_.orientation_wxyz);
  guide_.Write(target_);
}

void CrtkStation::OnCommand(const ros2::StringStamped& command, std::int64_t now_ns) {
  const char* const word = command.string == nullptr ? "" : command.string;
  const auto wish = WishOf(word, session_.phase);
  if (words_.Pass(now_ns)) {
    spdlog::info("{}/state_command: {}{}", namespace_, Quoted(word),
                 wish ? "" : ": not done; enable, disable, pause and resume are");
  }
  if (!wish) return;
  wire::OperateRequest request{};
  wire::FromText(station_, request.station);
  request.server_run = session_.server_run;
  request.request = RandomRun();
  request.wish = *wish;
  wire::FromText("palpate-crtk", request.by);
  wishes_.Write(request);
}

void CrtkStation::TellState(std::int64_t now_ns) {
  const CrtkState state = CrtkStateOf(session_.phase, session_.muted, faults_);
  if (state == reported_ && told_ns_ != 0 && now_ns - told_ns_ < kTellAgain_ns) return;
  reported_ = state;
  told_ns_ = now_ns;
  ros2::OperatingState message{};
  StampAt(message.header, WallClock_ns());
  message.header.frame_id = const_cast<char*>(frame_.c_str());
  message.state = const_cast<char*>(state.state);
  message.is_homed = state.homed;
  message.is_busy = state.busy;
  operating_state_.Write(message);
}

CrtkStation::Counts CrtkStation::counts() const {
  return {pose_count_, wrench_count_, missing_, refused_};
}

}  // namespace palpate
