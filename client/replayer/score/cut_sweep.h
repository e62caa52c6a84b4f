#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/replayer/score/performance.h"
#include "client/replayer/verify/cut_replay.h"
#include "client/replayer/verify/verify.h"
#include "common/recording/recording_reader.h"
#include "server/physics/haptic_model.h"
#include "server/physics/step_state.h"

namespace palpate {

/// What one hand of a recording cut, from where its answers say that the tool was: its way in each
/// cycle is taken out of the solids as the step took it, and no step is solved again.  A tenth of
/// the work of Verify, which alone says whether the answers are the physics' own.
///
/// Not known so is what a tool cut in a cycle of several sub-steps, which it takes where it goes
/// farther in one than half the grid's band or stays behind its hand; and what others cut in the
/// scene, or anybody before the recording.  Then Finish says so, and Verify is to be asked.
class CutSweep {
 public:
  /// @param tool  the name of one of the scene's.   Throws Error where there is no such one.
  CutSweep(const PlayedScene& played, const std::string& tool, std::string station,
           std::uint64_t run);

  /// A sample of the recording, in its order, while that is made or later.
  void Hear(const RecordedSample& sample);
  /// All has been heard.  None: it is not known here.
  std::optional<SolidsCut> Finish();

 private:
  struct Hand {
    std::uint64_t pose_sequence;
    Pose X_WH;
    bool spins;
  };
  using SceneRun = std::pair<std::string, std::uint64_t>;

  void HearOfLoop(const RecordedSample& sample);
  void HearOfScene(const RecordedSample& sample);
  void Advance(std::size_t left);
  void Follow(const Hand& hand, const wire::Wrench& answer);
  void Sweep(const Pose& from, const Pose& to, bool stays_behind);
  bool IsAlone() const;

  const std::string station_, poses_, wrenches_;
  const std::uint64_t run_;
  HapticModel model_;
  StepState state_;
  SolidsCut cut_;
  std::deque<Hand> hands_;                         ///< by their sequence; not yet used
  std::deque<wire::Wrench> answers_;               ///< not yet used
  std::map<std::uint64_t, Pose> starts_;           ///< X_WG by the pose
  std::map<std::uint64_t, std::uint64_t> wholes_;  ///< poses by their numbers
  std::uint64_t wholes_done_ = 0;                  ///< the last number
  std::map<SceneRun, CutLogFacts> logs_;
  std::optional<SceneRun> scene_run_;
  std::uint64_t last_pose_ = 0;
  std::uint32_t last_answer_ = 0;
  bool sure_ = true, cut_before_ = false;
};

}  // namespace palpate
