#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>

/// Every constant of the haptic step, with its unit, its usual value and what it derives from;
/// those of the QP over rigid rows (common/qp) and of how meshes are read
/// (surface/contact_mesh.cpp) stand there.  Numbers alone, so that the kernels may include them.
/// "Taken" means chosen, not derived: another value costs time, and no guarantee depends on it.
namespace palpate::limits {

// --- StepParameters, unless the scene or a benchmark says otherwise. ---

/// k_t [N/m] and k_r [N m/rad]: the chapter's 1 N/mm and 1000 mN m/rad (2.3).
inline constexpr double kStiffness = 1000.0, kTorsionalStiffness = 1.0;
/// Widest bound on |v| [m]: the chapter's fastest hand, 0.5 m/s, in 1 ms.
inline constexpr double kMaxTranslation = 0.5e-3;
/// Largest error of linearising a rotation [m], half of the 1 um that a step may leave.  With L the
/// tool's longest lever arm, it gives the widest bound on |phi|, sqrt(2 kMaxTruncation / L).
inline constexpr double kMaxTruncation = 0.5e-6;
/// Least L [m], for a single sphere; and the largest bound [rad], reached where L is 0.1 mm.
inline constexpr double kShortestLever = 1e-6, kMostRotation = 0.1;
/// Sub-steps in a cycle.  Twelve of kMaxTranslation follow a hand at 6 m/s.
inline constexpr int kMaxSubsteps = 12;
/// Rows of a sub-step: a peg in a hole, both of spheres, has some 10,000; the next power of two.
inline constexpr int kMaxRows = 16384;
/// Halvings of a sub-step's bounds until its rows fit: from kMaxTranslation to 2 um.
inline constexpr int kMostHalvings = 8;
/// Packet pairs of a cycle, some 10 ns each.  A further sub-step begins only if one as costly as
/// the last stays within them: 50 us, about the most that a snap over a ledge costs.
inline constexpr int kMaxTested = 5000;

// --- Bounds of a cycle's sub-steps (solve/stages.h). ---

/// The first bounds over what the hand moved since the last cycle.  A tool that keeps its contacts
/// moves no farther than the hand (1.0); the rest, taken, allows for contacts gained and lost.
inline constexpr double kBoundsOverHand = 2.0;
/// Part of the hand's rotation, times rho, that is added to the bound on translation, and of its
/// translation, over rho, to that on rotation: contacts turn one into the other.  Taken.
inline constexpr double kBoundsAcross = 0.5;
/// Smallest first bounds over the widest: 20 um, as far as an encoder's noise moves a resting hand.
inline constexpr double kLeastBounds = 0.04;
/// Largest factor from one sub-step's bounds to the next's: from least to widest in two.
inline constexpr double kWiden = 8.0;
/// Share of the bounds that a shortened step aims at.  The rest is for rows that the last rotation
/// left violated, by at most kMaxTruncation: nearly 2 % of the least bounds.
inline constexpr double kBoundShare = 0.98;
/// Targets tried, each nearer than the last, until the step under the rows, which may demand a
/// lift, ends within the bounds.  Two are usual.  With one, a ball on terraces arrived in 87 %.
inline constexpr int kNearerTargets = 4;

/// Rows within the first bounds from which they are predicted where the tool goes instead
/// (PredictLeaves): at least so many, some 10 us; and so many for each packet pair tested.  A row
/// costs what a test does, so with 3 the rows have cost as much as three walks: the one that is
/// lost and the two of a tool that meets something new.  Who changes over once
/// the first way has cost what the second costs pays at most twice the lesser of both (ski rental:
/// Karlin, Manasse, Rudolph & Sleator, Algorithmica 3 (1988) 79-119).  With 2, two bodies of 22,000
/// leaves with 1,574 rows at 748 tests took 64 us in place of 47.
inline constexpr int kCrowd = 1024, kCrowdATest = 3;
/// Rows near where the tool goes below which the next cycle predicts within the first bounds again.
/// Taken.
inline constexpr int kFew = 8;
/// How far from where the tool is expected to end a sub-step may end, over the widest bounds: 10
/// um, of 2, 5, 10 and 20 um the fastest; between two smooth bodies some 200 rows.
inline constexpr double kReachAhead = 0.02;
/// Predictions of a sub-step near where the tool goes.  Taken; one or two are usual.
inline constexpr int kMostPredictions = 4;

// --- Input, and the trees' rounding (tree/sphere_tree_query.cpp). ---

/// Least |q|^2 of an orientation: of a smaller one, the sender left it zero.
inline constexpr double kLeastSquaredNorm = 1e-12;
/// Share by which every radius and lever grows: a packet test in floats errs by less than 8 ulp of
/// the sum of the radii, and an ulp is at most 1.2e-7 of it.
inline constexpr double kRadiusMargin = 1e-6;
/// The largest displacement of a sphere by a pose in floats, over the size of the scene: five
/// roundings of 6e-8 for each coordinate, times sqrt(3), is 5e-7; four times that.
inline constexpr double kPoseMargin = 2e-6;

// --- Soft leaves (rows/soft_rows.h). ---

/// How deep a soft leaf can be entered, over its radius; inside lies a rigid core with the same
/// centre.  Where the tool meets it the force is continuous, and no ball gets past another's
/// centre, so that the normal cannot flip.
inline constexpr double kSoftShare = 0.5;

/// The solver over energies (energy/energy_solver.h).  Forces and stiffness are over k_t.
namespace energy {
/// Stiffness of the spring that stands for a row below its threshold: a newton presses it 10 pm
/// into what is rigid.  Ten times as much costs a digit of the result, which errs by 1e-16 of x
/// times this for each row.
inline constexpr double kRigid = 1e8;
/// Iterations, of Newton's method and of its QPs together, after which no further one begins: 1 ms
/// with 400 rows.  In 60,000 random problems, soft rows up to 10^7 times as stiff as the coupling
/// took fewer than 60; rows with thresholds beside rigid ones took 1,918 at most.
inline constexpr int kIterations = 2000;
/// Iterations in which springs stand for thresholds, before rows rest at them.  Taken; a bur that
/// keeps moving as before takes one or two.
inline constexpr int kIterationsOnSprings = 6;
/// Factor applied to lengths where rows rest at thresholds: the QP's tolerance, 1e-12 m, becomes
/// 1e-21 m.
inline constexpr double kThresholdScale = 1e9;
/// A step must gain this part of what its slope promises (Armijo's usual value).
inline constexpr double kLeastGain = 1e-4;
/// Error of a gradient over the size of its terms: some fifty roundings of 2e-16.  A part of a step
/// that is no greater is one, too.
inline constexpr double kRounding = 1e-14;
}  // namespace energy

/// Burs (cut/cut_rows.h).
namespace cutting {
/// A sample that seems free is evaluated so far ahead of the bur, over the grid's spacing.  Half of
/// a cell's diagonal, 0.9, keeps the bur's own cut out of the cell there; the rest is taken.
inline constexpr double kAhead = 1.5;
/// What a cycle's removal may cost (CutAway::queries, some 30 ns each): 0.25 ms.  A further
/// sub-step begins only if one as costly as the last stays within this.  A sub-step of 75 um at 50
/// um takes 4,000 for a sunk ball of 1.4 mm, 15,000 for a sunk cone of 1.8 x 4 mm.  Taken.
inline constexpr int kMostQueries = 7500;
/// Share of a spinning bur's new drag that each cycle takes over: it follows within 20 ms.  With
/// shares below 2 / (1 + g^2), g some 1.5 mu_c, a bur in a hole does not whirl (cut/README.md).
/// Taken.
inline constexpr double kDragShare = 0.05;
/// Resistance of a bur's surface where it does not cut [Pa]: 10 GPa are 240 N for one of 256
/// samples of a ball of 1.4 mm, many times a device's greatest force.
inline constexpr double kUncut = 1e10;
/// Sine of 15 degrees: what leans back from an edge's sense by more does not cut.  Taken, of hand
/// instruments.
inline constexpr double kRelief = 0.25881904510252074;
/// A hand draws an edge so far in its sense before it cuts, and so far back before it stops [m]:
/// twice as far as an encoder's noise moves a resting hand.
inline constexpr double kDraw = 40e-6;
}  // namespace cutting

/// Friction (solve/friction.md).  Forces are divided by k_t, so they are lengths [m].  "Size" is
/// the length of the hand's offset and what the contacts take off it.
namespace friction {
/// Cycles without slip [ms at 1 kHz] after which mu_s applies to a contact again.  Static friction
/// needs a time of rest (Dieterich 1972).  Without one, a hand that trembles at 8 to 12 Hz while it
/// slides would stick at every reversal of the tremor.
inline constexpr int kStillCycles = 20;
/// Stiffness of a contact, over k_t: a newton presses one 1 nm into its row.  Its square must stay
/// well below 1 / epsilon = 4.5e15.  And the least that counts as solved, of contacts that begin
/// soft: 64 nm, an eighth of what meshes keep between them.
inline constexpr double kStiffness = 1 << 20, kSoftest = 1 << 14;
/// Newton's method: steps, and halvings of one that makes things worse.  Taken; two steps are usual
/// in steady motion.  With half the steps three times as many of 1,400 problems that need the
/// stages stayed unsolved.
inline constexpr int kSteps = 24, kHalvings = 3;
/// Penalties that only decide whether a contact presses and slips: about the inverse of how far a
/// unit force moves one, or more, as others hold the tool too.  The second serves where Newton's
/// method goes round with the first: the kinks of the law then lie elsewhere.  With 1, half as many
/// again of a foot's problems need the stages as with 3; with 10, six times as many of the scene
/// `friction`.
inline constexpr double kPenalties[] = {3.0, 1.0};
/// By how much a force may be off, over the size: some ten roundings of the stiffness times x.
inline constexpr double kSolved = 1e-9;
/// By how much a row may be violated, over the size, once the contacts hold their forces: twice
/// what one that holds the tool alone then yields, 1 / kStiffness^2.  And how often they may take
/// hold: each time divides what they yield by some kStiffness over the friction angle's margin.
/// Taken.
inline constexpr double kExact = 2e-12;
inline constexpr int kHolds = 3;
/// Slip, over the size, above which a contact counts as sliding: a thousand times kSolved.
inline constexpr double kSlid = 1e-6;
/// Rounds of Newton's method over the contacts and the QP over all rows: each adds a row, and six
/// hold a tool.
inline constexpr int kRounds = 6;
/// FrictionModel::kChapter: squared sine of half its angle below which a rotation has no axis.
inline constexpr double kLeastRotation = 1e-24;
}  // namespace friction

/// Contact between meshes (contact/sub_step.h).
namespace mesh {
/// delta, the separation that rows keep between the meshes [m] (StepTuning).  Taken: a thousandth
/// of a newton at 1 N/mm.
inline constexpr double kSeparation = 1e-6;
/// The largest loss of separation by rounding in a sub-step [m]: coordinates of 10 m are rounded to
/// 2e-15 m, planes at 1e-7 m to 1e-8 of a triangle's size.
inline constexpr double kRounding = 1e-9;
/// Sine of the angle between two edges below which the nearest points give the direction in place
/// of their common normal, which turns by the tool's rotation over this sine.  Taken.
inline constexpr double kParallel = 0.02;
/// A corner counts as touching if it is farther than the nearest points by no more than this ratio
/// and by no more than the same share of delta.
inline constexpr double kWitnessRatio = 1.02;
/// A row is recomputed when its direction at the candidate has turned by more than this [rad]: a
/// thousandth of the force.
inline constexpr double kTurned = 1e-3;
/// How far the direction of a row at rest may be off, as the force that it changes over k_t [m]: of
/// more than a thousandth of a newton at 1 N/mm, the row is recomputed; of more than four, no
/// contact gives it.  With one threshold for both a peg that twists in its hole lagged a third more
/// often.
inline constexpr double kForceError = 1e-6, kReleaseError = 4e-6;
/// A tool that lags is held by what is within this distance of it [m].  Taken; with a tenth or a
/// fifth of it a tool that went over a ledge was held by nothing for a millisecond.
inline constexpr double kLagAhead = 1e-4;
/// Two planes are one if their normals differ by no more than this [rad]: a hundred-thousandth of
/// the force.
inline constexpr double kSame = 1e-5;
/// Largest depth over radius of a ball that goes round an edge; a greater one is replaced by
/// this.  And the squared sine between a row and those before it below which the row stops
/// no further direction.  Taken.
inline constexpr double kMostBend = 0.99, kLeastFree = 1e-12;
/// The lengths of contact [m], in proportion to its separation.
struct Margins {
  double separation = kSeparation;
  /// h, the least separation of a pair at the end of a sub-step.  The other half of delta is for
  /// the error of a row.
  double free = 0.5 * separation;
  /// Where a tool rests: the least distance of a contact there; else 0.
  double rest = 0.0;
  /// kMaxTruncation between meshes.  Rows are exact where a candidate ends, so the linearisation
  /// error costs a candidate and no more.  But the arc of a turning point leaves its chord by up to
  /// a quarter of this, h/2, which even a pair of edges has in between (contact/certify.cpp).
  double truncation = 2.0 * free;
  /// How much a pair nearer than delta regains in a sub-step if that does not lift the tool against
  /// the spring: less than h, so that the resulting force cannot be felt.
  double regain = 0.3 * separation;
  double witness = (kWitnessRatio - 1.0) * separation;
  /// A row holds the tool if its contact has a gap less than this.
  double touching = 2.0 * separation;

  /// The separation that a plane must give a pair before and after a sub-step, if the pair's best
  /// plane separates it by `distance` before (negative if it intersects).  A pair nearer than h may
  /// not come nearer, except for rounding, and that only while the sum of roundings does no harm.
  constexpr double LeastBefore(double distance) const {
    return distance > 0.0 ? std::min(free, 0.5 * distance) : distance - kRounding;
  }
  constexpr double LeastAfter(double distance) const {
    return distance > 0.5 * free ? std::min(free, distance) - kRounding : distance;
  }
};
/// Where friction acts: flat faces of bodies on which corners of the tool are looked for, and the
/// corners on one after which the search goes no farther.  Taken.
inline constexpr std::size_t kFlatFaces = 8, kCornersOfFace = 256;
/// Iterates of a sub-step (StepTuning); three are usual.  And directions in which a plane between
/// two patches is searched; four are usual.  Taken.
inline constexpr int kIterates = 16, kDirections = 16;
/// Failed candidates after which a sub-step begins again with its initial rows; how far the next
/// candidate may then go, as a fraction of the first one; and by how much the bounds may grow after
/// that (Conn, Gould & Toint, Trust-Region Methods (2000), 6.1: a quarter, and twice).  Taken.
inline constexpr int kTrustedCandidates = 4;
inline constexpr double kNarrow = 0.25, kRegrow = 2.0;
/// Queries of a cycle (StepTuning), some 130 ns each: 450 us.  A query is one direction tried in
/// the search for a plane, or the nearest points of two triangles.  A further sub-step begins only
/// if a quarter of them is left.  Taken.
inline constexpr int kMaxQueries = 3400;
/// Fraction of a cycle's queries, one over this, that may be spent beyond them on shorter motions
/// once there is none left.  Taken.
inline constexpr int kReserve = 4;
/// Pairs that can be refreshed, or found not to hold in a candidate, in the time of one query.
inline constexpr int kRefreshesAQuery = 8;
/// Pairs that are refreshed or tried for a merge before the code checks whether to go on.  Taken.
inline constexpr int kBatch = 32;
/// Pairs without a plane in a candidate after which the next candidate begins: six rows hold a
/// tool.  With four, queries fall by 6 %, but a ball of fine triangles on another came to rest 0.1
/// N off.
inline constexpr int kEnough = 6;
/// A candidate with at least one such pair also ends once no other has been found in this many
/// queries. Most of them are of pairs that the next candidate, which is shorter, does not reach:
/// without this, a long cycle takes an eighth more.  It is about what the next candidate costs
/// besides its own queries at pairs (ski rental, as for kCrowdATest): the pairs that it refreshes
/// or finds in doubt count as 11 queries, scans, QP and rows take the time of some 8 (two bunnies,
/// 96,000 candidates).
inline constexpr int kPatience = 20;
/// If the tool's farthest point is set farther than a cycle's sub-steps can take it [m], the front
/// is rebuilt, since all of it would be looked at anyway.
inline constexpr double kSetFar = kMaxSubsteps * kMaxTranslation;
/// Blocks of solids (surface/solid_bodies.h): the most bodies stored; the most triangles of one,
/// including those round it (of a plane a block has 32, and 40 round it; of a surface that bends
/// too much for eight cells to share a vertex, four times as many); and how many bodies are
/// discarded at once when there is no room.  Taken.
inline constexpr std::size_t kBlocks = 256, kMostOfBlock = 1024, kGivenUp = 32;
/// Most blocks followed at once: what a bur of 1.4 mm changes in some milliseconds at 50 um.
inline constexpr std::size_t kMostFollowed = 256;
/// Cost of making a body, in queries: 0.09 ms.  So a cycle makes at most four.
inline constexpr int kQueriesOfBlock = 700;
/// The most pairs that a sub-step with this many queries can reach: as many near ones as it
/// refreshes, and two for each query that splits one; rounded up to the next power of two.
constexpr std::size_t RoomForNear(int queries) {
  return std::bit_ceil(static_cast<std::size_t>((kRefreshesAQuery + 2) * queries));
}
}  // namespace mesh

namespace body {
/// A body sleeps once it has been held and moved by no more than this [m/s] for so many steps: less
/// than gravity adds in a hundredth of one, and as long as it takes a hand to come back.
inline constexpr double kStill = 1e-4;
inline constexpr int kStillSteps = 200;
/// A body that has gone as far from where it was placed [m] is lost, and sleeps: it has fallen.
inline constexpr double kLost = 10.0;
/// Rows of a body's contacts at most, of one QP that may have eight.
inline constexpr int kMaxRows = 2048;
}  // namespace body

/// How deep a tool must enter a leaf of an object that is touched by its mesh to count as starting
/// inside [m]: more than leaves may stand out of the mesh.
inline constexpr double kCoreDepth = 1e-4;

// --- A start inside an object (start_pose.h).  Not on the servo path. ---

/// Length of an outward stride over the widest step: 1 mm; the walk back makes up for it.
inline constexpr double kStartStride = 2.0;
/// Most steps back: 2.5 m with one sub-step each, 30 m in free space with twelve.
inline constexpr int kLongestWalk = 5000;
/// The walk ends when a step moves the tool by less than this [m]: an encoder's noise moves it a
/// hundred times as far.
inline constexpr double kSettled = 1e-7;

}  // namespace palpate::limits
