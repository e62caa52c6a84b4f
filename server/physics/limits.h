#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>

/// Every constant of the haptic step on one page: unit, usual value, and what it derives from.
/// Elsewhere are only those of the QP over rigid rows, which other programs use without the step
/// (common/qp), and of how meshes are read (surface/contact_mesh.cpp).  Numbers alone, so that the
/// kernels may include this page too.  "Taken" means chosen, not derived: another value costs time,
/// and no rule rests on it.
namespace palpate::limits {

// --- The coupling: StepParameters, unless the scene says otherwise. ---

/// k_t [N/m] and k_r [N m/rad]: the chapter's 1 N/mm and 1000 mN m/rad (2.3).
inline constexpr double kStiffness = 1000.0;
inline constexpr double kTorsionalStiffness = 1.0;

// --- A sub-step: StepParameters, unless a benchmark says otherwise. ---

/// Widest bound on |v| [m]: the chapter's fastest hand, 0.5 m/s, in 1 ms.
inline constexpr double kMaxTranslation = 0.5e-3;
/// What linearising a rotation may miss by [m]: half of the 1 um that a step may leave.  It gives
/// the widest bound on |phi|, sqrt(2 kMaxTruncation / L) with L the tool's longest lever arm.
inline constexpr double kMaxTruncation = 0.5e-6;
/// L is taken to be at least this [m], so that the bound is finite for a single sphere; and the
/// bound at most this [rad], which it reaches where L is 2 kMaxTruncation / 0.1^2 = 0.1 mm.
inline constexpr double kShortestLever = 1e-6;
inline constexpr double kMostRotation = 0.1;
/// Sub-steps in a cycle.  Eight of kMaxTranslation follow a hand at 4 m/s.
inline constexpr int kMaxSubsteps = 8;
/// Rows of a sub-step: a peg in a hole of spheres has some 10,000, and this is the next power of
/// two.
inline constexpr int kMaxRows = 16384;
/// Packet pairs of a cycle, some 10 ns each: a further sub-step begins only where one like the last
/// stays within them, 50 us.  That is about what a snap over a ledge costs at most.
inline constexpr int kMaxTested = 5000;

// --- Bounds of a cycle's sub-steps (solve/step_bounds.h). ---

/// The first bounds over what the hand moved since the last cycle.  A tool that keeps its contacts
/// moves no further than the hand (1.0); the rest, taken, is for contacts that it gains and loses.
inline constexpr double kBoundsOverHand = 2.0;
/// What a rotation of the hand, times rho, adds to the bound on translation, and a translation,
/// over rho, to that on rotation, for contacts turn one into the other: taken.
inline constexpr double kBoundsAcross = 0.5;
/// Least first bounds over the widest: 20 um, as far as an encoder's noise moves a hand at rest.
inline constexpr double kLeastBounds = 0.04;
/// Bounds of a sub-step over those of the last one: from the least to the widest in two.
inline constexpr double kWiden = 8.0;
/// A short step aims at this share of its bounds.  The rest is for rows that the last rotation left
/// violated, by kMaxTruncation at most; 2 % of the least bounds, 20 um, is nearly as much.
inline constexpr double kBoundShare = 0.98;
/// Targets that are tried at most, each nearer than the last, until the step under the rows, which
/// may ask for a lift, ends within the bounds.  Taken; two are usual.
inline constexpr int kNearerTargets = 4;

// --- What comes in. ---

/// Least |q|^2 of an orientation: unit quaternions have 1, and what is below this is a sender's
/// zero.
inline constexpr double kLeastSquaredNorm = 1e-12;

// --- The trees' rounding (tree/sphere_tree_query.cpp). ---

/// Share by which every radius and lever grows: a packet test in floats is off by less than 8 ulp
/// of the radii's sum, and an ulp is 1.2e-7 of it at most.
inline constexpr double kRadiusMargin = 1e-6;
/// What the pose in floats may move a sphere by, over the size of the scene: five roundings of 6e-8
/// a coordinate, sqrt(3) for three of them, 5e-7; four times that.
inline constexpr double kPoseMargin = 2e-6;

// --- Soft leaves (rows/soft_rows.h). ---

/// How far a soft leaf lets itself be entered, as a share of its radius: inside is a rigid core
/// with the same centre.  The force goes on without a jump where the core is met, only its slope
/// changes; the normal cannot flip, for no ball gets past the centre of another.
inline constexpr double kSoftShare = 0.5;

/// The solver over energies (solve/energy_solver.h).  Forces are over k_t, so stiffness has no
/// unit.
namespace energy {
/// A row below its threshold is a spring so many times as stiff as the coupling: a newton of the
/// hand presses it 10 pm into what is rigid.  Ten times as much costs a digit of the result: 1e-16
/// of x times this, for each row.
inline constexpr double kRigid = 1e8;
/// Turns of Newton's method.  Two or three are usual; 60,000 random problems of soft rows, up to
/// 10^7 times as stiff as the coupling, took fewer than 60, and 16,000 with thresholds 39 at most.
inline constexpr int kTurns = 100;
/// Turns before springs are made softer, and with springs of one softness: taken.  A bur that moves
/// on as it did takes one or two.
inline constexpr int kTurnsAtOnce = 6, kTurnsOfStage = 20;
/// Where softer springs begin, about the coupling's own stiffness, and by how much they grow.  Of
/// 10, 30 and 100, only 10 solved all of those problems from any guess.
inline constexpr double kSoftest = 10.0, kStiffen = 10.0;
/// What lengths are multiplied by where rigid rows stand beside thresholds: the QP's tolerance,
/// 1e-12 m, becomes 1e-21 m.
inline constexpr double kThresholdScale = 1e9;
/// Bisections halve an interval: 60 find a spring of 1e-15 m in a step of a millimetre.
inline constexpr int kLineSearchLimit = 60;
/// A step is good where it gains this part of what its slope promises (Armijo's usual value).
inline constexpr double kLeastGain = 1e-4;
/// ... and a search along it may stop where the slope has come down to this part.
inline constexpr double kSlopeLeft = 0.1;
/// Error of a gradient over the size of its terms: some fifty roundings of 2e-16.
inline constexpr double kRounding = 1e-14;
}  // namespace energy

/// Burs (cut/cut_rows.h).
namespace cutting {
/// How far ahead of its surface a bur looks for material, over the grid's spacing: a cell's
/// diagonal is 1.7, and half of it, 0.9, keeps the bur's own cut out of the cell; the rest is
/// taken.
inline constexpr double kLookAhead = 1.5;
/// What a cycle's removal costs at most, in rows of points (CutAway::looks), some 30 ns each: a
/// further sub-step begins only where one like the last stays within it, 0.25 ms.  A ball of 1.4 mm
/// that is all in the material takes 4,000 in a sub-step of 75 um at 50 um.  Taken.
inline constexpr int kMostLooks = 7500;
/// Of the drag of a bur that spins, what a cycle takes over: 20 ms.  A drag f presses a ball
/// against the walls of its cavity by g f at most, a quarter turn on, with g some 1.5 mu_c; shares
/// below 2 / (1 + g^2) do not grow.  Taken.
inline constexpr double kDragShare = 0.05;
/// What a bur pays where it does not cut [Pa]: 10 GPa are 240 N for one of 256 samples of a ball of
/// 1.4 mm, a device's greatest force many times over.
inline constexpr double kUncut = 1e10;
/// The back of an edge falls away by so much, the sine of 15 degrees: what of it leans no farther
/// from its sense cuts.  Taken, of hand instruments.
inline constexpr double kRelief = 0.25881904510252074;
/// An edge cuts when a hand has drawn it so far in its sense, and stops when it has gone so far
/// back [m]: twice as far as an encoder's noise moves a hand at rest.
inline constexpr double kDraw = 40e-6;
}  // namespace cutting

/// Friction (solve/friction.h).  Forces are over k_t, so lengths
/// [m]; "size" is the length of the hand's offset and what the contacts take off it.
namespace friction {
/// Cycles without slip [ms at 1 kHz] after which a contact holds with mu_s again.  Static friction
/// needs a time of rest (Dieterich 1972); without one, a hand that trembles at 8 to 12 Hz while it
/// slides would stick at every turn of its tremble.
inline constexpr int kStillCycles = 20;

/// Stiffness, over k_t, against what rows and sticking contacts still miss: each Newton step
/// divides that by about as much.  Its square, 10^10, must stay well below 1 / epsilon = 4.5e15.
inline constexpr double kPenalty = 1e5;
/// The same where it only decides whether a contact presses and slips: about the inverse of how far
/// a unit force moves a contact, which makes a single contact's first guess right.
inline constexpr double kTrial = 1.0;

/// Leap: steps, and halvings of a step that gets worse.  One or two steps are usual in steady
/// motion; the limits are taken.
inline constexpr int kLeapSteps = 24, kHalvings = 3;
/// Leap ends where the forces miss their laws by no more than this, over the size: a slip of 10^-10
/// of the hand's offset is what "sticks" means here.
inline constexpr double kLeapt = 1e-10;
/// ... and by this where rows and sticking contradict each other by the rounding of the gaps.
inline constexpr double kNear = 1e-8;

/// Walk: penalties from 1 to this, tenfold each time; updates of the forces, Newton steps of
/// each, and shortenings of a step: taken.
inline constexpr double kWalkPenalty = 1e4;
inline constexpr int kWalkUpdates = 40, kWalkSteps = 30, kShorter = 6;
/// Updates after which Leap tries again, once each of the five penalties has had its turn; and the
/// steps that it has then, half of its first.
inline constexpr int kWalkRaises = 5, kSecondLeap = 12;
/// Over the size: the balance of forces that Walk asks of each update, and what the forces may miss
/// of their laws in the end.
inline constexpr double kBalanced = 1e-10, kWalked = 1e-7;
/// Newton steps of a cycle after which Walk gives up: taken, to bound what the worst cycle costs.
inline constexpr int kCycleSteps = 160;

/// Over the size: the QP's optimum against Newton's.  Ten times kLeapt, which either may be off by.
inline constexpr double kAgreed = 1e-9;
/// Over the size: the slip above which a contact is sliding.  One at its limit that others hold is
/// not, and slips by kNear at most; a hundred times that.
inline constexpr double kSlid = 1e-6;
/// Rounds of the QP over all rows and Newton's method over the contacts: each brings in a row, and
/// six hold a tool.
inline constexpr int kRounds = 6;
/// Times that forces are drawn into their cones: one for each of seven contacts, and one.
inline constexpr int kDraws = 8;
/// FrictionModel::kChapter: a turn whose squared sine of half the angle is below this has no axis.
inline constexpr double kLeastTurn = 1e-24;
}  // namespace friction

/// Contact between meshes (contact/sub_step.h).
namespace mesh {
/// delta: what rows keep between the meshes [m] (StepTuning).  Taken: a thousandth of a newton at 1
/// N/mm.
inline constexpr double kSeparation = 1e-6;
/// What rounding may take off a separation in a sub-step [m]: coordinates of 10 m are rounded to
/// 2e-15 m, planes at 1e-7 m to 1e-8 of a triangle's size.
inline constexpr double kRounding = 1e-9;
/// Sine of the angle between two edges below which their common normal turns too fast, and the
/// nearest points decide: a turn of the tool turns that normal by up to the same over this sine,
/// fifty times as much.  Taken.
inline constexpr double kParallel = 0.02;
/// A corner is the place that touches where it is no farther than the nearest points by this share,
/// and by the same share of delta.
inline constexpr double kWitnessRatio = 1.02;
/// A row is made anew where its direction at the trial has turned by more [rad]: a thousandth of
/// the force.
inline constexpr double kTurned = 1e-3;
/// Of a ball that goes round an edge, the depth over its radius: more is taken as this.  And the
/// squared sine between a row and those before it below which it stops nothing new.  Taken.
inline constexpr double kMostBend = 0.99, kLeastFree = 1e-12;
/// The lengths of contact [m], in proportion to its separation.
struct Margins {
  double separation = kSeparation;
  /// h: what a pair must be separated by at the end of a sub-step.  The other half of delta is for
  /// what a row may miss of it.
  double free = 0.5 * separation;
  /// kMaxTruncation between meshes.  Rows are exact where a trial ends, so what linearising misses
  /// costs a trial and no more.  But a turning point's arc leaves its chord by up to a quarter of
  /// this, h/2, which a pair has in between, even one of edges (contact/certify.cpp).
  double truncation = 2.0 * free;
  /// What a pair nearer than delta regains in a sub-step, where that does not lift the tool against
  /// the spring: less than h, so that no force comes of it that could be felt.
  double regain = 0.3 * separation;
  double witness = (kWitnessRatio - 1.0) * separation;
  /// A row that its contact lets the tool go by less than this holds it.
  double touching = 2.0 * separation;

  /// What a plane must separate a pair by before and after a sub-step, whose best plane separates
  /// it by `distance` before (less than zero where it intersects).  A pair that is nearer than h
  /// may not come nearer, but for rounding; and that only as long as the sum of roundings does no
  /// harm.
  constexpr double LeastBefore(double distance) const {
    return distance > 0.0 ? std::min(free, 0.5 * distance) : distance - kRounding;
  }
  constexpr double LeastAfter(double distance) const {
    return distance > 0.5 * free ? std::min(free, distance) - kRounding : distance;
  }
};
/// Iterates of a sub-step (StepTuning), of which three are usual; and directions in which a plane
/// between two patches is looked for, of which four are.  Taken.
inline constexpr int kIterates = 16, kDirections = 16;
/// Trials that are not free before a sub-step begins anew with the rows of its beginning; and the
/// part of the first one's way that the next may go, from the second time on (a quarter: Conn,
/// Gould & Toint, Trust-Region Methods (2000), 6.1).  Taken.
inline constexpr int kTrustedTrials = 4;
inline constexpr double kNarrow = 0.25;
/// Looks of a cycle at most (StepTuning), some 130 ns each: 450 us.  A look is a direction in which
/// a plane is looked for, or the nearest points of two triangles.  A further sub-step is begun
/// where a quarter of them is left.  Taken.
inline constexpr int kMaxLooks = 3400;
/// Pairs that are brought up to date, or found not to hold in a trial, in the time of one look;
/// eight times as many are tested in it.
inline constexpr int kRefreshesALook = 8;
/// Pairs that are brought up to date, looked at, or tried to be made one, before it is seen how to
/// go on: taken.
inline constexpr int kBatch = 32;
/// Pairs that are not apart in a trial for which there is another one: six rows hold a tool.
inline constexpr int kEnough = 6;
/// Where the pose was set, and the tool's farthest point goes further than the sub-steps of a cycle
/// take it [m], the front begins anew: it would be looked at as a whole.
inline constexpr double kSetFar = kMaxSubsteps * kMaxTranslation;
/// Blocks of solids (surface/felt_solids.h): bodies that there is room for, and triangles that one
/// may have, those round it included.  Of a plane there are 32 and 40 more, or four times as many
/// of one that bends more than by what eight cells may have one vertex of.  And how many bodies are
/// given up at once where there is no room.  Taken.
inline constexpr std::size_t kBlocks = 256, kMostOfBlock = 1024, kGivenUp = 32;
/// Blocks that are followed at once: what a bur of 1.4 mm changes in some milliseconds at 50 um.
inline constexpr std::size_t kMostFollowed = 256;
/// What making a body counts, in looks: 0.15 ms.  So a cycle makes three at most.
inline constexpr int kLooksOfBlock = 1200;
/// Pairs that a sub-step of so many looks can come to: as many near ones as it brings up to date,
/// and two for each look that splits one.  The next power of two.
constexpr std::size_t RoomForNear(int looks) {
  return std::bit_ceil(static_cast<std::size_t>((kRefreshesALook + 2) * looks));
}
}  // namespace mesh

/// How deep a leaf of an object that is felt by its mesh must be entered to tell that a tool starts
/// inside [m]: more than leaves may stand out.
inline constexpr double kCoreDepth = 1e-4;

// --- A start inside an object (start_pose.h).  Not on the servo path. ---

/// Strides outward over the widest step: 1 mm, which the walk back makes good.
inline constexpr double kStartStride = 2.0;
/// Steps back at most: 2.5 m with a sub-step each, 20 m in free space with eight.
inline constexpr int kLongestWalk = 5000;
/// The walk ends where a step moves the tool by less than this [m]: an encoder's noise
/// moves it a hundred times as far.
inline constexpr double kSettled = 1e-7;

}  // namespace palpate::limits
