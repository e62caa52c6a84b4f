#pragma once

#include <cstdint>

#include "common/qp/nearest_point.h"
#include "scenes/sphere_packet.h"
#include "server/physics/limits.h"

namespace palpate {

/// Indices of a tool packet and an object packet of the same level or, below the last
/// level, of two leaves.
struct NodePair {
  std::int32_t tool;
  std::int32_t object;
  bool operator==(const NodePair&) const = default;
};

/// Names the row of a contact, so that the next step recognises it: a part of the tool and a part
/// of a body.  Only the body's geometry interprets the number of its part.
struct ContactId {
  /// Stands in place of a body for the leaves of all objects, numbered as in the forest.
  static constexpr std::int32_t kLeaves = -1;

  std::int32_t body = kLeaves;  ///< index into SceneObjects::bodies
  std::int32_t a = 0;           ///< leaf or triangle of the tool
  std::int32_t b = 0;           ///< leaf of the forest, or triangle of the body
  std::int32_t row = 0;         ///< which row of these two parts; between meshes, the corner

  bool IsOfLeaves() const { return body == kLeaves; }
  /// Returns whether both rows belong to the same two parts.
  bool IsBeside(const ContactId& other) const {
    return body == other.body && a == other.a && b == other.b;
  }
  bool operator==(const ContactId&) const = default;
};

/// A leaf as the row kernel loads it, one 32-byte record.  Centres are relative to the tool's
/// centroid in the tool's frame, or in W for objects [m].
struct alignas(32) LeafSphere {
  double x, y, z, radius;
};

/// Planes between pairs of nodes, as columns that start 64-byte aligned and are padded to a
/// multiple of eight.  n points from B to A; l is the lever arm of A's node.
struct PlaneColumns {
  double* along[6];  ///< n, and l x n [m]
  double* slack;     ///< how far A's node lies above B's along n [m]
  double* radius;    ///< of a ball about the end of l that holds the node [m]
  double* left;      ///< what a motion leaves of the slack [m]
};

/// A plane between a pair of nodes, as last known at an epoch: one cache line.
struct alignas(64) PlaneRecord {
  double n[3];       ///< unit, from B to A, in the frame of B
  double slack;      ///< how far A's node lay above B's along n [m]
  double centre[3];  ///< of a ball about A's node, in its frame [m]
  double radius;     ///< [m]
};

/// The motion of A since an epoch.
struct alignas(32) EpochMotion {
  double row[3][4];  ///< rows of R_now - R_then, then p_now - p_then
};

/// Number of epochs that are distinguished: a power of two.
inline constexpr std::uint32_t kPlaneEpochs = 64;

/// A motion of A, and the slack that must be left.
struct PlaneMotion {
  double step[6];               ///< v [m] and phi [rad], in B
  double least_old, least_new;  ///< before and after the motion [m]
};

/// Points of a convex hull [m]: x[coordinate][point].
struct alignas(64) EightPoints {
  double x[3][8];
};

/// The nearest points of two triangles' edges: at the fraction s along edge i of the one, from its
/// corner i, and at t along edge j of the other.
struct EdgePair {
  double s, t, squared;  ///< squared: of their distance [m^2]
  int place;             ///< 3 i + j
  bool apart;            ///< nothing else of the triangles is nearer
};

/// Eight searches, one in each column, for the point of a hull that is nearest to the origin.  The
/// points are those hull points between which the nearest known point lies.
struct alignas(64) Simplices {
  double point[3][3][8] = {};  ///< [which][coordinate][search]
  double added[3][8] = {};     ///< a further point of the hull
  double nearest[8] = {};      ///< distance of the nearest known point
  double n[3][8] = {};         ///< unit vector towards it
  double radius[8] = {};       ///< subtracted from the distance
  std::uint32_t with[3] = {};  ///< one bit for each search that has one, two, three points
};

/// Two triangles.  A placement is a position, then the columns of R [m].
struct TrianglePair {
  const double *a, *b;      ///< corners, in the frames of their bodies [m]
  const double *from, *to;  ///< A's placement before and after a motion
  const double* X_BS;       ///< that of B's triangle
  double radius;            ///< rounding of A [m]
};

/// Directions between two triangles, one in each column.
struct alignas(64) EightGaps {
  double n[2][3][8] = {};  ///< before and after a motion, from B to A, in B
  double gap[2][8];        ///< how far A's triangle lies above B's along n [m]
};

/// A packet of the tool's tree, and how much each of its spheres grows with the allowed rotation.
struct alignas(32) ToolPacket {
  SpherePacket sphere;
  float lever[kTreeArity];  ///< longest lever arm of a leaf below [m]
};

/// The enlarged spheres of a tool packet in W; computed once per sub-step, at the first visit.
struct alignas(32) WorldPacket {
  float x[kTreeArity], y[kTreeArity], z[kTreeArity], radius[kTreeArity];
};

/// The pose of the graphic tool and how far it may move, in the precision of the query.
struct QueryPose {
  float R[9];             ///< R_WG, row by row
  float p[3];             ///< centroid in W [m]
  float max_translation;  ///< every tool sphere grows by max_translation + max_rotation * lever
  float max_rotation;
};

/// One level of the tool's and of the forest's tree, for expand_pairs.
struct LevelView {
  const ToolPacket* tool;
  WorldPacket* tool_world;  ///< valid if its stamp equals `now`
  std::uint32_t* tool_stamp;
  const SpherePacket* object;
};

/// Rows a . x >= b, x = [v; rho phi], as columns that start 64-byte aligned.
struct RowColumns {
  double* a[6];
  double* b;
  double* lever[3];  ///< of the contact point [m], in W; only for rows between meshes
  ContactId* id;
};

/// Rows that yield.  Where a . x < b, each pushes back by its weight times s = b - a . x, and by
/// its full threshold.  Columns as in QpRows; a row of weight 0 without a threshold does nothing.
struct YieldingRows {
  QpRows rows;
  const double* weight;
  const double* threshold;  ///< [m]; null if no row has one
  double* push;  ///< push of each row [m]; each evaluation fills it, including the padding
};

/// Sum of energies, with derivatives, at a place x; divided by the coupling's stiffness.
struct EnergyAt {
  double twice = 0.0;       ///< twice the energy [m^2]
  double force[6] = {};     ///< negative gradient [m]
  double hessian[21] = {};  ///< lower triangle, row by row; at a kink, of either side
};

/// Most packet pairs that expand_pairs takes at a time.
inline constexpr int kMaxExpanded = 256;

/// The inner loops, compiled once per instruction set; all give the same bits.
struct Kernels {
  const char* name;

  /// For each of `count` pairs, tests every child sphere of the tool packet against every one of
  /// the object packet; writes those pairs of children that touch to `out`, which holds 64 *
  /// count. Returns their number.
  int (*expand_pairs)(const LevelView& level, const QueryPose& pose, std::uint32_t now,
                      const NodePair* in, int count, NodePair* out);

  /// Appends the linearised non-penetration rows (chapter 2.10-2.17) of `count` leaf pairs at row
  /// `first`.
  /// R: R_WG row by row; p: centroid in W.  May write up to 7 rows beyond the last.
  void (*build_rows)(const LeafSphere* tool, const LeafSphere* object, const double* R,
                     const double* p, double inverse_rho, const NodePair* pairs, int count,
                     int first, const RowColumns& rows);

  /// Writes the indices of the values below a limit; the column is aligned and padded as in
  /// PlaneColumns.  May write up to 8 beyond the last.  Returns their number.
  int (*find_below)(const double* value, int count, double limit, std::int32_t* out);

  /// Computes the gaps of two triangles.
  void (*find_gaps)(const TrianglePair& pair, EightGaps& gaps);

  /// Returns the index of the point that is lowest along m, among those whose lane is set in
  /// `lanes`.  Of equally low points, every instruction set returns the same one.
  int (*lowest_point)(const EightPoints* eights, int count, std::uint32_t lanes, const double m[3]);

  /// For two triangles, given by their corners, returns the nearest points of the first
  /// pair of edges such that nothing of the triangles is nearer; if there is none, those
  /// of the nearest pair.
  EdgePair (*nearest_edges)(const double a[9], const double b[9]);

  /// Takes the added points of `searches` (one bit each) into their simplices.
  /// Returns the searches that continue: those whose nearest point came nearer and is
  /// still at least `least` away.
  std::uint32_t (*advance_simplices)(Simplices& simplices, std::uint32_t searches, double least);

  /// Computes the current planes of `count` slots, as columns from `first` on: each slack falls by
  /// its node's motion against n since its epoch, and by how far that has turned n in A's
  /// frame times its radius: a rotation about n changes nothing.
  /// R: R_WG row by row.  May write up to 7 columns beyond the last.
  void (*refresh_planes)(const PlaneRecord* records, const std::uint32_t* epochs,
                         const std::int32_t* slots, int count, const EpochMotion* since,
                         const double* R, int first, const PlaneColumns& out);

  /// Writes the indices, from `first` on, of the planes that do not hold throughout a motion:
  /// slack < least_old, or left = slack + n . v + (l x n) . phi - |n x phi| radius < least_new.
  /// Fills the column `left`, from the multiple of eight below `first` on.  May write up to 8
  /// indices beyond the last.  Returns their number.
  int (*find_used_up)(const PlaneColumns& planes, int first, int count, const PlaneMotion& motion,
                      std::int32_t* out);

  /// SolveNearestPoint (common/qp).
  QpResult (*solve)(const double* t, const QpRows& rows, const int* guess, int guesses);
  QpResultOf<12> (*solve_two)(const double* t, const QpRowsOf<12>& rows, const int* guess,
                              int guesses);
  QpResultOf<24> (*solve_four)(const double* t, const QpRowsOf<24>& rows, const int* guess,
                               int guesses);
  QpResultOf<48> (*solve_eight)(const double* t, const QpRowsOf<48>& rows, const int* guess,
                                int guesses);
  /// SolveLimited (common/qp).
  QpResult (*solve_limited)(const double* t, const LimitedRows& rows, const int* guess,
                            int guesses);

  /// Returns whether all rows hold at x, within `tolerance`.
  bool (*rows_hold)(const QpRows& rows, const double* x, double tolerance);
  /// Computes L^-1 a and b times a scale for each row, including the padding.
  /// L: lower triangle of 6 x 6, row by row.  a, b: columns to write.
  void (*transform_rows)(const QpRows& rows, const double* L, const double* inverse_diagonal,
                         double scale, double* const a[6], double* b);

  /// Adds the energy of rows and its force at x; the second also adds the Hessian.  Returns the
  /// number of rows that push.
  /// @param stiffness  of the spring as which a row acts below its threshold, over the coupling's
  using AddYielding = int(const YieldingRows& rows, const double* x, double stiffness,
                          EnergyAt& at);
  AddYielding *add_yielding, *add_yielding_with_hessian;
};

extern const Kernels kScalarKernels;
extern const Kernels kAvx2Kernels;
extern const Kernels kAvx512Kernels;

/// Returns the widest kernels that this processor runs.  PALPATE_SIMD=scalar|avx2|avx512 in the
/// environment selects narrower ones (for tests and comparisons).  Chosen once, at first use.
const Kernels& ActiveKernels();

/// Writes the kernels of every level that this processor runs, the scalar ones
/// first; returns their number.
int AvailableKernels(const Kernels* out[3]);

/// For tests: sets what ActiveKernels returns from now on.
void UseKernels(const Kernels& kernels);

}  // namespace palpate
