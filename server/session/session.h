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
  ServedTool(std::string of_scene, std::string name, HapticModel made, bool whole = false,
             bool meets = false)
      : scene(std::move(of_scene)),
        tool(std::move(name)),
        whole_at_start(whole),
        hands_meet(meets),
        shared(std::make_shared<const HapticModel>(std::move(made))) {}
  /// Returns the same tool, with the same model, in a scene of another name.
  ServedTool In(std::string other_scene) const {
    ServedTool other = *this;
    other.scene = std::move(other_scene);
    return other;
  }

  std::string scene;
  std::string tool;
  bool whole_at_start;  ///< the scene is made whole if no other session is active
  bool hands_meet;      ///< as Scene::hands_meet
  std::shared_ptr<const HapticModel> shared;
  const HapticModel& model = *shared;
};

/// What the server knows of the client that asks for a session.
struct SessionClient {
  dds::LeaveKey leave_seal{};  ///< who may end the session
  bool below_arms = false;     ///< a mouse, whose hand feels nothing: arms have priority
  bool keeps_scene = false;    ///< nobody may restore the scene while it lasts
};

/// One station that drives one tool.  Phases: waiting for poses -> acquiring (only if the tool
/// starts inside an object) -> active -> ended.
///
/// Thread contract: service thread, except loop().OnPose, which belongs to the servo thread.  Time
/// is passed in, so that tests need no clock.
class Session {
 public:
  /// Time for its first pose since its station asked for it last.
  static constexpr std::int64_t kFirstPose_ns = 5'000'000'000;
  static constexpr std::int64_t kSilence_ns = 100'000'000;  ///< longest pause between poses
  /// And of a mouse, whose hand feels nothing: as long as its station waits for an answer.  Twenty
  /// stations on two cores are often held up for more than 100 ms.
  static constexpr std::int64_t kMouseSilence_ns = 1'000'000'000;
  static constexpr double kMaxStartDepth_m = 0.010;

  /// @param loop  of the tool, if hands meet; else null, and the tool is alone in its world
  Session(std::string station, std::uint64_t run, std::shared_ptr<const ServedTool> tool,
          std::int64_t now_ns, const SessionClient& client = {},
          std::unique_ptr<ServoLoop> loop = nullptr);

  /// Advances the session; call every few milliseconds.  Returns whether phase, depth or reason
  /// changed, or the loop has begun to compute forces.
  /// @param may_start  false: no search for a start pose now, which takes up to a tenth of a second
  bool Update(std::int64_t now_ns, bool may_start = true);
  /// Returns whether a start pose should be searched: poses come, and the hand is not where
  /// the last search failed.
  bool wants_start(std::int64_t now_ns) const;
  /// Time of the last search.
  std::int64_t tried_ns() const { return tried_ns_; }
  /// Returns the longest pause between its poses.
  std::int64_t silence_ns() const { return client_.below_arms ? kMouseSilence_ns : kSilence_ns; }
  /// Notes that its station asks for it: one that waits for its recorder sends no pose yet.
  void HearAsking(std::int64_t now_ns) { asked_ns_ = now_ns; }
  void End(std::string reason);
  /// Ends it at its own station's request.
  void Leave();
  bool left() const { return left_; }
  /// Takes the next record of its loop making the scene whole, for recordings; false
  /// if there is none.
  bool TakeWhole(wire::LoopWhole& whole);
  /// Call before its first pose, with what burs have removed from the solids; the start pose is
  /// searched among what is left.  `cuts` must outlive this.
  /// @param has_all  the loop begins with `cuts`; otherwise it is given them later and starts then
  void Begin(const std::vector<CutField>& cuts, bool has_all);
  /// Restores all material.  The tool may now lie inside it, so forces are off until the tool is
  /// found to be free, as at the beginning of the session.
  void MakeWhole();

  /// While held, forces do not begin, because the loop has not been given all cuts yet.
  void HoldStart(bool hold) { start_is_held_ = hold; }
  bool start_is_held() const { return start_is_held_; }

  /// Notes how many read its wrenches, which is told until its first pose: a station that must be
  /// recorded sends none before.
  void TellListeners(int listeners) { listeners_ = listeners; }
  int listeners() const { return listeners_; }

  ServoLoop& loop() { return *loop_; }
  /// Notes a pose that is not, or not yet, given to the loop, so that the station does not count as
  /// silent.  From any thread.  Real-time: wait-free.
  void HearUnanswered() noexcept { unanswered_.fetch_add(1, std::memory_order_relaxed); }
  const std::string& station() const { return station_; }
  std::uint64_t run() const { return run_; }
  const ServedTool& tool() const { return *tool_; }
  const dds::LeaveKey& leave_seal() const { return client_.leave_seal; }
  bool below_arms() const { return client_.below_arms; }
  bool keeps_scene() const { return client_.keeps_scene; }
  wire::SessionPhase phase() const { return phase_; }
  bool ended() const { return phase_ == palpate_SESSION_ENDED; }
  /// Returns whether any pose had come at the last Update.
  bool has_heard() const { return heard_ != 0; }
  const std::string& reason() const { return reason_; }
  double start_depth() const { return start_depth_; }
  /// Sequence of the first pose that a force answers (0 until the loop has had it), and
  /// the tool's pose then.
  std::uint64_t start_sequence() const { return start_seen_ ? loop_->start_sequence() : 0; }
  const Pose& start() const { return X_WG_start_; }
  /// The loop's latest step at the last Update; has_pose is false before the first pose.
  const LoopSnapshot& snapshot() const { return snapshot_; }

 private:
  bool TryStart(std::int64_t now_ns);
  void BeginAgain();

  std::string station_;
  std::uint64_t run_;
  std::shared_ptr<const ServedTool> tool_;
  SessionClient client_;
  std::unique_ptr<ServoLoop> loop_;
  std::optional<StepWorkspace> start_workspace_;  // only until the session is active
  std::span<const CutField> start_cuts_;          // of all burs in the scene
  wire::SessionPhase phase_ = palpate_SESSION_WAITING;
  std::string reason_;
  double start_depth_ = 0.0;
  Pose X_WG_start_;
  bool left_ = false;
  bool start_waits_ = false;        // found, and told next; the loop has not been given it
  bool start_seen_ = false;         // whether the loop has taken the start
  std::uint64_t former_start_ = 0;  // the loop's start before the scene was made whole
  bool start_is_held_ = false;
  int listeners_ = 0, listeners_told_ = 0;
  std::uint32_t voids_ = 0;    // of the loop, as dealt with
  bool whole_wanted_ = false;  // whether the loop still has to make the scene whole
  LoopSnapshot snapshot_;
  std::uint64_t wholes_ = 0;
  std::atomic<std::uint64_t> unanswered_{0};
  std::uint64_t heard_ = 0;
  std::int64_t heard_ns_, asked_ns_;
  std::int64_t tried_ns_ = 0;
  Pose X_WH_tried_;
};

}  // namespace palpate
