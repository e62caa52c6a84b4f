#pragma once

#include "common/math/pose.h"
#include "scenes/scene.h"
#include "server/physics/haptic_step.h"

namespace palpate::test {

/// The cause of a change of the force by more than kJump from one step to the next.
///
/// A spring between hand and graphic tool cannot cause this by itself.  In x = [v; rho phi], rho =
/// sqrt(k_r / k_t), the step projects the hand onto the free space, and the force is k_t times the
/// distance.  If the free space is convex, as it is near a contact that does not change, neither
/// the projection nor the distance changes by more than the hand moves, so |dF| <= k_t |dx|, with
/// dx the hand's motion.  Any greater change has another cause.
///
///     hand o   o dx          A ledge: the place that held the tool ends, and the tool snaps to the
///   ____   G . . G'          next one, nearer to the hand: the spring's stretch s = sqrt(|F|^2 +
///       \   |   |            |tau|^2 / rho^2) / k_t is less than if it had stayed.  No step that
///        \__|___|_____       looks for the least stretch can end in more than that.
enum class JumpCause {
  kNone,    ///< |dF| <= kJump
  kHand,    ///< |dF| <= kSpringFactor k_t |dx|: a fast hand on a spring.  For a ball of radius r, s
            ///< deep, r / (r - s) replaces kSpringFactor if it is more
  kLedge,   ///< the graphic tool moved more than kSnapFactor |dx|; if its contacts are the same, it
            ///< had arrived, and moved to a smaller stretch than if it had stayed
  kGained,  ///< no ledge, and there is a new contact
  kLost,    ///< no ledge, no new contact, and one was lost, or its leaf was scraped off
  kLetGo,   ///< the same contacts hold, but one that stuck now slips
  /// The contacts are the same and no other cause applies; or, with any contacts, the tool had
  /// arrived and the stretch grew by more than kSpringFactor |dx|.
  kUnexplained,
};
inline constexpr int kJumpCauses = 7;
const char* NameOf(JumpCause cause);

/// A tenth of a usual force of 5 N, and what a finger notices [N].
inline constexpr double kJump = 0.5;
/// On ground with radius of curvature R, a hand at depth d moves the tool R / (R - d) times as far
/// as itself; a factor of 2 allows a depth of half the radius.  The surface on which a ball's
/// centre moves is nowhere sharper than the ball, so there R is known.
inline constexpr double kSpringFactor = 2.0;
/// "Much more than the hand" moves: with the spring's factor, F = k (x_G - x_H) allows at most 3.
inline constexpr double kSnapFactor = 3.0;

/// Judges pairs of steps of one tool.
///
/// Two contacts are the same if their pair is in both reports, or if in W their points are within
/// kSameShare of the tool's size and their normals within kSameCosine: a tool that slides over a
/// mesh changes triangles all the time, which must not count as a cause.
class JumpJudge {
 public:
  JumpJudge(const Scene& scene, const HapticModel& model);

  JumpCause Judge(const Pose& X_WH_before, const StepReport& before, const Pose& X_WH,
                  const StepReport& after) const;
  /// Returns the greatest change of the force that JumpCause::kHand allows [N].
  double ByHand(const Pose& X_WH_before, const StepReport& before, const Pose& X_WH,
                const StepReport& after) const;
  /// Returns |[dp; rho dphi]| of a motion of the tool, at its centroid [m].
  double Motion(const Pose& from, const Pose& to) const;

  /// 0.5 mm for a tool of 150 mm, which a hand at 0.5 m/s slides in a step.
  static constexpr double kSameShare = 1.0 / 300.0;
  /// 20 degrees, half the angle of a sharp edge.
  static constexpr double kSameCosine = 0.94;

 private:
  /// Returns the spring's stretch for its wrench [m].
  double Stretch(const Wrench& wrench) const;
  bool Has(const StepReport& report, const ActiveRow& contact) const;
  /// Returns how many times as far as the hand the tool may move at a stretch of the spring [m].
  double SpringFactor(double stretch) const;

  Vec3 centroid_;
  double stiffness_, rotation_length_, reach_;
  double radius_;  ///< of a ball tool; else 0
};

}  // namespace palpate::test
