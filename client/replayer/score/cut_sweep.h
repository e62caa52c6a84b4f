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

/// Computes what one recorded hand cut from the tool's poses in the recorded answers: removes the
/// tool's path in each cycle from the solids as the step did, without solving a step.  It takes a
/// tenth of the time of Verify, which alone checks that the answers are the physics' own.
///
/// The result is not known if the tool may have cut in a cycle of several sub-steps (it moved
/// farther in it than half the grid's band, or stayed behind its hand), if others cut in the
/// scene, if anything was cut before the recording, or if it lacks where forces began.  Finish then
/// returns none, and Verify has to be used.
class CutSweep {
 public:
  /// @param tool  name of a tool of the scene.  Throws Error if there is none of that name.
  CutSweep(const PlayedScene& played, const std::string& tool, std::string station,
           std::uint64_t run);

  /// Takes the next sample, in the recording's order, during the recording or later.
  void Hear(const RecordedSample& sample);
  /// Returns the result after the last sample; none if it cannot be known here.
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
  std::deque<Hand> hands_;                         ///< by sequence; not yet used
  std::deque<wire::Wrench> answers_;               ///< not yet used
  std::map<std::uint64_t, Pose> starts_;           ///< X_WG by the pose's sequence
  bool has_force_ = false;                         ///< in the last answer
  std::map<std::uint64_t, std::uint64_t> wholes_;  ///< poses by the numbers of the wholes
  std::uint64_t wholes_done_ = 0;                  ///< the last number
  std::map<SceneRun, CutLogFacts> logs_;
  std::optional<SceneRun> scene_run_;
  std::uint64_t last_pose_ = 0;
  std::uint32_t last_answer_ = 0;
  bool sure_ = true, cut_before_ = false;
};

}  // namespace palpate
