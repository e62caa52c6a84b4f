#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "server/physics/contact/near_pairs.h"
#include "server/physics/contact/touch.h"
#include "server/physics/rows/frame_rows.h"

namespace palpate {

/// The rows of a ContactRows that belong to touches, and what they ask for.
struct TouchRows {
  std::vector<Touch*> touch;  ///< for each row its touch; null, or beyond the end,
                              ///< for rows of leaves
  std::vector<double> asked;  ///< for each row: the separation that it asks for [m]
  bool regains = true;        ///< whether rows ask for more separation than their pairs have
  double least = 0.0;         ///< rows ask for no more [m]: delta, or the least that a contact has
};

/// Scratch memory of Certify.
struct CertifyScratch {
  std::vector<std::int64_t> doubts;  ///< near pairs whose planes do not hold, as a heap by the gap
                                     ///< that is left
  PlaneSearches searches;            ///< for planes
  NearPairs::Index searched[PlaneSearches::kAtOnce] = {};  ///< the near pair of each search
  struct InBody {
    ShapeMotion motion;
    std::uint64_t certified = 0;  ///< the candidate that it is of
  };
  std::vector<InBody> in_body;  ///< for each body, the motion in its frame
  std::uint64_t certified = 0;  ///< candidates ever examined
  std::int64_t opened_at = 0;   ///< queries when the last open pair was found
};

/// Scratch memory of AddRowsOfCorners.
struct CornerScratch {
  std::vector<std::uint32_t> seen;  ///< for each vertex of the tool, the last walk that met it
  std::uint32_t walk = 0;
  std::vector<std::uint32_t> met;  ///< vertices that it met, in this order
};

/// The data of one sub-step of a body A against the bodies B, which the functions below read and
/// write. All memory is allocated on construction.
struct MeshContact {
  /// @param b           with those of other frames
  /// @param max_rows    of the ContactRows that it will fill
  /// @param separation  to be kept between the meshes [m]
  /// @param shared      the sub-step's queries
  /// @param most_queries  of a sub-step
  MeshContact(const MovingBody& a, std::span<const ContactBody> b, std::int32_t frame, int max_rows,
              double separation, Queries& shared, int most_queries);

  MeshPair meshes;
  FrameMotion moved;           ///< how B moves in W: of the step, which alone knows W
  Motion motion;               ///< the candidate that was examined last
  std::int32_t candidate = 0;  ///< its number within the sub-step
  NearPairs near;
  std::vector<Touch> touches;  ///< of those near pairs of triangles that were examined closely
  TouchRows of_rows;
  Queries& queries;
  CertifyScratch scratch;
  CornerScratch corners;
  /// Near pairs of triangles without a plane at the candidate, in the order in which they were
  /// found.
  std::vector<NearPairs::Index> open;

  /// Returns the touch of a near pair of triangles, making it if needed.
  Touch& TouchOf(NearPairs::Index k);
  bool HasRoomForTouch() const { return touches.size() < touches.capacity(); }
  /// Returns the touch that a row belongs to; null for a row of leaves.
  Touch* TouchOfRow(int row) const {
    const auto r = static_cast<std::size_t>(row);
    return r < of_rows.touch.size() ? of_rows.touch[r] : nullptr;
  }
};

/// A body A against the bodies of all frames: a MeshContact for each, which share the sub-step's
/// rows and queries.
struct BodyContact {
  /// As of MeshContact.
  BodyContact(const MovingBody& a, std::span<const ContactBody> bodies, int max_rows,
              double separation, int most_queries);
  BodyContact(const BodyContact&) = delete;  // `of` refers to `queries`

  Queries queries;
  std::vector<MeshContact> of;  ///< by the number of the frame

  const MovingBody& a() const { return of.front().meshes.a; }
  const limits::mesh::Margins& margins() const { return of.front().meshes.margins; }
  bool IsBall() const { return a().radius > 0.0; }
  /// Call f for each frame, and return whether all, or how many in sum, it returns.
  template <class F>
  bool All(F f) {
    bool all = true;
    for (MeshContact& contact : of) all = f(contact) && all;
    return all;
  }
  template <class F>
  int Sum(F f) {
    int sum = 0;
    for (MeshContact& contact : of) sum += f(contact);
    return sum;
  }
};

// One sub-step between meshes: BeginSubStep; CheckCandidate until a candidate is free; Relinearise,
// CheckRest and Release, which may ask for more candidates; EndSubStep.  README.md has the order
// and drawings. Real-time: no allocation, lock, log or clock.  Deterministic.

/// When Certify may stop at a candidate that is not free.
enum class Until {
  kFirst,   ///< when one pair has no plane, or the queries do not pay for all pairs in doubt
  kEnough,  ///< when limits::mesh::kEnough have none: there will be another candidate
};

/// Searches for planes that separate every pair of triangles throughout the candidate [v; phi] from
/// the beginning of the sub-step (../surface/README.md, "What counts as proof"), and leaves them in
/// `near`.  Patches that such a plane separates are not split.
///
/// Returns 0 if every pair has a plane; otherwise the number of pairs that have none or, once the
/// queries are spent, were not examined.  With kEnough, `contact.open` lists the triangles among
/// them; those within their cones have chosen the planes of their rows.
int Certify(MeshContact& contact, const Vec3& v, const Vec3& phi, Until until) noexcept;

/// Which touches have rows from the beginning of a sub-step on.
enum class First {
  kActive,      ///< those that held the tool last
  kContacts,    ///< and all contacts
  kAllCorners,  ///< and all corners on flat faces, each once (flat_faces.cpp).  With friction a
                ///< tool would tip over those that held it last, on rows made for that pose.
  kTouching,    ///< and all that touch.  A tool that lags feels what it has just come to.
};

/// Updates the front at `from`, and adds the rows of those `active` pairs that still touch.  This
/// includes pairs outside their cones; otherwise a tool at rest would find them again in each step,
/// at slightly different places.
/// Once the sub-step's queries are spent, pairs whose planes do not hold count as not separate.
void BeginSubStep(MeshContact& contact, const Kernels& kernels, SeparationFront& front,
                  const RelativePose& from, std::span<const ContactId> active, First first,
                  FrameRows& rows) noexcept;

/// Returns whether the candidate [v; phi] is free.  If not, adds rows for pairs without a plane, or
/// recomputes those rows that the candidate violates.
bool CheckCandidate(MeshContact& contact, const Vec3& v, const Vec3& phi, FrameRows& rows) noexcept;
/// CheckCandidate for a tool that rests at the candidate's end: a contact may be no nearer there
/// than the separation that rows ask for, and not h alone.
bool CheckRest(MeshContact& contact, const Vec3& v, const Vec3& phi, FrameRows& rows) noexcept;
/// CheckCandidate without rows: stops at the first pair without a plane.
bool IsFree(MeshContact& contact, const Vec3& v, const Vec3& phi) noexcept;

/// Moves the tool to the candidate that was examined last, which must be free, and stores the
/// planes in the front.
/// @param merges  whether pairs of the front may be merged.  A merge saves time in later cycles; in
///                each sub-step of a cycle, it would mostly be undone by the next one.
void EndSubStep(MeshContact& contact, bool merges) noexcept;

/// Returns whether, at a pose, no triangle of A intersects one of B.  A body wholly inside a closed
/// mesh intersects none.  Not real-time.
bool IsFree(const MeshPair& meshes, const RelativePose& at);

// --- The rows of touches (touch_rows.cpp). ---

/// A row of a touch's plane, exact at a candidate: a corner of one triangle stays above a
/// plane of the other.
struct TouchRow {
  int slot;    ///< index into touch.row, modulo 3: the corner; 3 for edges
  Vec3 n;      ///< rate of the gap as the tool moves
  Vec3 lever;  ///< from the reference point to the contact, at the beginning of the sub-step [m]
  Vec3 by_rotation;    ///< rate of the gap as phi grows [m]
  double before, now;  ///< gap at the sub-step's beginning and at the candidate [m]
  /// Whether the corner lies over the other triangle at the candidate.  If not, the row is the
  /// plane's and no contact's: nothing is there that could hold the tool.
  bool is_over;
};
struct TouchRowsAtCandidate {
  TouchRow row[3];
  int count;
};

/// Returns the id of a row of two triangles.
ContactId IdOf(const NodesOfPair& triangles, int corner = 0);
/// Returns the rows of a touch's plane at the candidate.
TouchRowsAtCandidate RowsAt(const MeshContact& contact, const Touch& touch);

/// Adds the rows that the candidate violates, of touches that Certify found open.  Touches within
/// their cones come first; only if those give no row, the others: in these a neighbour is nearer,
/// and its rows mostly keep them apart too.  Returns whether there were any.
bool AddRowsOfOpen(MeshContact& contact, FrameRows& rows);
/// Adds the rows of those corners of a near pair's touch that touch.
void AddRowsThatTouch(MeshContact& contact, NearPairs::Index k, FrameRows& rows);
/// Adds or changes a row, with what it asks for at the candidate.
void SetRow(MeshContact& contact, Touch& touch, const TouchRow& row, FrameRows& rows);
/// Recomputes all rows, exact at the beginning of the sub-step: each allows the zero step.
void RelineariseAtStart(MeshContact& contact, FrameRows& rows);
/// Returns whether a ball's rows still turn with the smooth surface from candidate to candidate,
/// which also changes where the ball goes.  After many candidates they stay as they are, and the
/// next sub-step turns them.
inline bool TurnsRows(const MeshContact& contact) {
  return contact.candidate <= limits::mesh::kTrustedCandidates;
}
/// Removes a touch's rows.
void TakeOut(Touch& touch, FrameRows& rows);

/// Returns the separation [m] that a row asks for if its pair has `before` [m]: the full
/// separation, or a part of what is missing.
double Asked(const MeshContact& contact, double before);
/// Stops rows, until the end of the sub-step, from asking for separation that their pairs have
/// lost, or for more than the least that a contact has: if regaining it would lift the tool against
/// the spring, a tool at rest would never stay.  Returns false if they had already stopped.
bool GiveUpRegain(MeshContact& contact, FrameRows& rows);
/// Returns at most how much of 1/2 |x - t|^2 at an optimum is the price of regaining separation:
/// its derivative by what a row asks for is the row's multiplier [m^2].
double PriceOfRegain(const MeshContact& contact, const QpResult& qp);

// --- flat_faces.cpp: contacts on flat faces, where friction acts or lags (README.md). ---

/// AddRowsThatTouch for a tool that lies on a flat face: it touches with its corners, each of them
/// once.
void AddRowsOnFace(MeshContact& contact, Touch& touch, FrameRows& rows);
/// AddRowsOnFace for those `active` pairs, no farther apart than `reach` [m], that are hidden in
/// patches: no near pairs.  If a corner
/// of one has left its triangle, its row is that of the triangle below.
void AddRowsOfHidden(MeshContact& contact, std::span<const ContactId> active, double reach,
                     FrameRows& rows);
/// Adds the rows of all corners of the tool that touch a flat face beside those pairs that have
/// one, in whatever patch they are.
void AddRowsOfCorners(MeshContact& contact, FrameRows& rows);

// --- reconcile.cpp ---
//
// Whether the rows that hold the tool at a free candidate are those that the geometry gives there
// (../solve/README.md, "Arrival").  Functions that change rows return how many touches they
// changed; if that is not 0, the rows must be solved again.  Rows of leaves, and of pairs that
// intersect, are not changed.

/// For a ball, or with friction: gives the rows of each touch that does not touch at the candidate
/// another plane that separates it, if there is one; a ball's others the smooth surface's normal.
int Retract(MeshContact& contact, std::span<const int> active, FrameRows& rows) noexcept;
/// Recomputes each row whose direction in configuration space has turned by more than `most` [rad],
/// or whose gap at the candidate is not the geometry's, at most once in a sub-step.
int Relinearise(MeshContact& contact, std::span<const int> active, double most,
                FrameRows& rows) noexcept;
/// Returns whether contacts give all active rows at the candidate, in directions that differ by no
/// more than `most` [rad].
bool AreOfContacts(const MeshContact& contact, std::span<const int> active, double most,
                   const FrameRows& rows) noexcept;
/// Removes the active rows of touches that were no contacts when the sub-step began.
int Release(MeshContact& contact, std::span<const int> active, FrameRows& rows) noexcept;

/// Returns the derivative [1/m] of the normal of a ball's row by the ball's motion round the edge
/// or corner that it touches, which the straight row neglects.  Zero for other rows.
Mat3 CurvatureOf(const MeshContact& contact, int row) noexcept;
/// Returns by how much, at most, an active row's direction differs from that in which its pair
/// touches a ball at the candidate, or a row of its curvature has turned along the motion [rad];
/// infinite if a pair is farther from the ball than its row says.
double Turned(const MeshContact& contact, std::span<const int> active,
              const FrameRows& rows) noexcept;

}  // namespace palpate
