#pragma once

#include "common/math/pose.h"
#include "scenes/scene.h"
#include "server/physics/haptic_step.h"

namespace palpate::test {

/// Why the force changed by more than kJump from one step to the next.
///
/// A spring between hand and graphic tool cannot do so by itself.  In x = [v; rho phi], rho =
/// sqrt(k_r / k_t), the step is a projection of the hand onto what is free, and its force k_t times
/// the way there.  Where that is convex, as it is near a touch that stays what it is, neither moves
/// further than the hand does, so |dF| <= k_t |dx|, dx the hand's motion.  What is more has another
/// cause.
///
///     hand o   o dx          A ledge: the place that held the tool ends, and the tool snaps to the
///   ____   G . . G'          next one, nearer to the hand: the spring's stretch s = sqrt(|F|^2 +
///       \   |   |            |tau|^2 / rho^2) / k_t is less than if it had stayed.  No step that
///        \__|___|_____       looks for the least stretch can end in more than that.
enum class JumpCause {
  kNone,    ///< |dF| <= kJump
  kHand,    ///< |dF| <= kSpringFactor k_t |dx|: a fast hand on a spring.  Of a ball of radius r,
            ///< s deep, r / (r - s) where that is more
  kLedge,   ///< the graphic tool moved more than kSnapFactor |dx|, and with the same contacts:
            ///< from where it had arrived, to a lesser stretch than if it had stayed there
  kGained,  ///< no ledge, and a contact came that was not there
  kLost,    ///< no ledge, none came, and one went, or its leaf was scraped off
  kLetGo,   ///< the same contacts hold, but friction does less: what stuck slips
  /// The same contacts hold and none of these is so; or, whatever the contacts, the tool had
  /// arrived and the stretch grew by more than kSpringFactor |dx|.
  kUnexplained,
};
inline constexpr int kJumpCauses = 7;
const char* NameOf(JumpCause cause);

/// A tenth of a common hand's 5 N and what a finger notices [N].
inline constexpr double kJump = 0.5;
/// On ground of radius R a hand d below it moves the tool R / (R - d) as far as itself: 2 lets it
/// be half the radius deep.  The ground that a ball's centre goes on is nowhere sharper than the
/// ball: there R is known.
inline constexpr double kSpringFactor = 2.0;
/// "Much more than the hand": what the spring's factor allows, F = k (x_G - x_H), is 3 at most.
inline constexpr double kSnapFactor = 3.0;

/// Judges pairs of steps of one tool.
///
/// A contact is the same where its pair is in both reports, or where one of the other report
/// touches within kSameShare of the tool's size of it (in W), its normal within kSameCosine: a tool
/// that slides over a mesh changes triangles all the time, which is no cause of anything.
class JumpJudge {
 public:
  JumpJudge(const Scene& scene, const HapticModel& model);

  JumpCause Judge(const Pose& X_WH_before, const StepReport& before, const Pose& X_WH,
                  const StepReport& after) const;
  /// The most that the hand's own motion can have changed the force by, JumpCause::kHand [N].
  double ByHand(const Pose& X_WH_before, const StepReport& before, const Pose& X_WH,
                const StepReport& after) const;
  /// |[dp; rho dphi]| of a motion of the tool, at its centroid [m].
  double Motion(const Pose& from, const Pose& to) const;

  /// 0.5 mm of a tool of 150 mm: what a hand at 0.5 m/s slides in a step.
  static constexpr double kSameShare = 1.0 / 300.0;
  /// 20 degrees: half of what makes an edge sharp.
  static constexpr double kSameCosine = 0.94;

 private:
  /// The spring's stretch, by its wrench [m].
  double Stretch(const Wrench& wrench) const;
  bool Has(const StepReport& report, const ActiveRow& contact) const;
  /// How much further than the hand the tool may move, the spring stretched so much [m].
  double SpringFactor(double stretch) const;

  Vec3 centroid_;
  double stiffness_, rotation_length_, reach_;
  double radius_;  ///< of a tool that is a ball; else 0
};

}  // namespace palpate::test
