#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/dds/leave_seal.h"
#include "common/dds/wire.h"
#include "server/physics/haptic_step.h"
#include "server/session/servo_loop.h"

namespace palpate {

/// A tool that a station can drive.  Immutable, shared.
struct ServedTool {
  ServedTool(std::string of_scene, std::string name, HapticModel made, bool whole = false)
      : scene(std::move(of_scene)),
        tool(std::move(name)),
        whole_at_start(whole),
        shared(std::make_shared<const HapticModel>(std::move(made))) {}
  /// The same in a scene of another name, with the one model.
  ServedTool In(std::string other_scene) const {
    ServedTool other = *this;
    other.scene = std::move(other_scene);
    return other;
  }

  std::string scene;
  std::string tool;
  bool whole_at_start;  ///< made whole for whoever is the first, or alone, to begin there
  std::shared_ptr<const HapticModel> shared;
  const HapticModel& model = *shared;
};

/// What counts of who asks for a session.
struct SessionClient {
  dds::LeaveKey leave_seal{};  ///< who may end it
  bool below_arms = false;     ///< a mouse: its hand feels nothing, so arms go before it
};

/// One station driving one tool: waiting for poses -> acquiring (only where the tool starts inside
/// an object) -> active -> ended.
///
/// Thread contract: all of it in the service thread, but for loop().OnPose, which is the servo
/// thread's.  Time is given, so that tests need no clock.
class Session {
 public:
  static constexpr std::int64_t kFirstPose_ns = 5'000'000'000;  ///< a station has this to begin
  static constexpr std::int64_t kSilence_ns = 100'000'000;      ///< ... and may pause for this
  static constexpr double kMaxStartDepth_m = 0.010;

  Session(std::string station, std::uint64_t run, std::shared_ptr<const ServedTool> tool,
          std::int64_t now_ns, const SessionClient& client = {});

  /// Looks after the session; to be called every few milliseconds.  True where phase, depth or
  /// reason changed, or the loop has begun to compute forces.
  /// @param may_start  false: not now, where that would need a start pose to be found, which takes
  ///                   up to a tenth of a second.
  bool Update(std::int64_t now_ns, bool may_start = true);
  /// A start pose is to be found: there is a hand, and it is not where the last one failed.
  bool wants_start(std::int64_t now_ns) const;
  /// When that was last tried.
  std::int64_t tried_ns() const { return tried_ns_; }
  void End(std::string reason);
  /// Ends it by its station's own wish.
  void Leave();
  bool left() const { return left_; }
  /// The next time that its loop made the scene whole, for recordings; false where there is none.
  bool TakeWhole(wire::LoopWhole& whole);
  /// Before its first pose, with what burs have taken of the solids; a start is sought in what
  /// they have then.  Outlives this.
  /// @param has_all  its loop begins with that; else it will be given it, and starts then.
  void Begin(const std::vector<CutField>& cuts, bool has_all);
  /// All is there again.  The tool may be among them: forces are off until it is found to
  /// be free, as at the session's beginning.
  void MakeWhole();

  /// Forces do not begin before the loop has been given what is to be there.
  void HoldStart(bool hold) { start_is_held_ = hold; }
  bool start_is_held() const { return start_is_held_; }

  ServoLoop& loop() { return loop_; }
  /// A pose has come that the loop is not given, or not yet: the station is not silent.  From any
  /// thread.  Real-time: wait-free.
  void HearUnanswered() noexcept { unanswered_.fetch_add(1, std::memory_order_relaxed); }
  const std::string& station() const { return station_; }
  std::uint64_t run() const { return run_; }
  const ServedTool& tool() const { return *tool_; }
  const dds::LeaveKey& leave_seal() const { return client_.leave_seal; }
  bool below_arms() const { return client_.below_arms; }
  wire::SessionPhase phase() const { return phase_; }
  bool ended() const { return phase_ == palpate_SESSION_ENDED; }
  /// A pose has come, as of the last Update.
  bool has_heard() const { return heard_ != 0; }
  const std::string& reason() const { return reason_; }
  double start_depth() const { return start_depth_; }
  /// The first pose that a force answers, 0 until the loop has had it, and where it put the tool.
  std::uint64_t start_sequence() const { return start_seen_ ? loop_.start_sequence() : 0; }
  const Pose& start() const { return X_WG_start_; }
  /// What the loop did last, as of the last Update; has_pose is false before the first pose.
  const LoopSnapshot& snapshot() const { return snapshot_; }

 private:
  bool TryStart(std::int64_t now_ns);
  void BeginAgain();

  std::string station_;
  std::uint64_t run_;
  std::shared_ptr<const ServedTool> tool_;
  SessionClient client_;
  ServoLoop loop_;
  std::optional<StepWorkspace> start_workspace_;  // only until the session is active
  std::span<const CutField> start_cuts_;          // of all burs of the scene
  wire::SessionPhase phase_ = palpate_SESSION_WAITING;
  std::string reason_;
  double start_depth_ = 0.0;
  Pose X_WG_start_;
  bool left_ = false;
  bool start_seen_ = false;         // by the loop
  std::uint64_t former_start_ = 0;  // of the loop, before the scene was made whole
  bool start_is_held_ = false;
  bool whole_wanted_ = false;  // the loop has not been seen to have made it so
  LoopSnapshot snapshot_;
  std::uint64_t wholes_ = 0;
  std::atomic<std::uint64_t> unanswered_{0};
  std::uint64_t heard_ = 0;
  std::int64_t heard_ns_;
  std::int64_t tried_ns_ = 0;
  Pose X_WH_tried_;
};

}  // namespace palpate
