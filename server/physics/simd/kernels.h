#pragma once

#include <cstdint>

#include "common/qp/nearest_point.h"
#include "scenes/sphere_packet.h"
#include "server/physics/contact_id.h"
#include "server/physics/limits.h"

namespace palpate {

/// Indices of a tool packet and an object packet of the same level; below the last level, of
/// leaves.
struct NodePair {
  std::int32_t tool;
  std::int32_t object;
  bool operator==(const NodePair&) const = default;
};

/// A leaf as the row kernel loads it: one 32-byte record.  Centres relative to the tool's centroid
/// in the tool's frame, or in W for objects [m].
struct alignas(32) LeafSphere {
  double x, y, z, radius;
};

/// Planes between pairs of nodes, column by column; columns start 64-byte aligned and go on to the
/// next multiple of eight.  With n from object to tool and l the lever arm of the tool's node:
struct PlaneColumns {
  double* along[6];  ///< n, and l x n [m]
  double* slack;     ///< how far the node lies above the other along n [m]
  double* radius;    ///< of a ball round the end of l that holds the node [m]
  double* left;      ///< of the slack, after a motion [m]
};

/// A plane between a pair of nodes, as it was known at an epoch: one cache line.
struct alignas(64) PlaneRecord {
  double n[3];       ///< unit, from object to tool, in W
  double slack;      ///< how far the tool's node lay above the object's along n [m]
  double centre[3];  ///< of a ball about the tool's node, in its frame [m]
  double radius;     ///< [m]
};

/// What the tool has moved by since an epoch.
struct alignas(32) EpochMotion {
  double row[3][4];          ///< of R_now - R_then, and of p_now - p_then
  double turned, unused[3];  ///< sum of the rotations in between [rad]
};

/// Epochs that are told apart: a power of two.
inline constexpr std::uint32_t kPlaneEpochs = 64;

/// A motion of the tool, and what it has to leave of a slack.
struct PlaneMotion {
  double step[6];               ///< v [m] and phi [rad], in W
  double angle;                 ///< |phi|
  double least_old, least_new;  ///< [m], before and after
};

/// Points of a convex hull [m]: x[coordinate][point].
struct alignas(64) EightPoints {
  double x[3][8];
};

/// The nearest points of two triangles' edges: s of the way along edge i of the one, from its
/// corner i on, and t along edge j of the other.
struct EdgePair {
  double s, t, squared;  ///< squared: of their distance [m^2]
  int place;             ///< 3 i + j
  bool apart;            ///< nothing else of the triangles is nearer
};

/// Eight searches for the point of a hull that is nearest to the origin, a column each: points of
/// the hull between which the nearest one known lies.
struct alignas(64) Simplices {
  double point[3][3][8] = {};  ///< [which][coordinate]
  double added[3][8] = {};     ///< a further point of the hull
  double nearest[8] = {};      ///< distance of the nearest point known
  double n[3][8] = {};         ///< unit, towards it
  double radius[8] = {};       ///< that is taken off the distance
  std::uint32_t with[3] = {};  ///< a bit for each that has one point, two, three
};

/// A packet of the tool's tree, and how much each sphere grows with the rotation that is allowed
/// for.
struct alignas(32) ToolPacket {
  SpherePacket sphere;
  float lever[kTreeArity];  ///< longest lever arm of a leaf below [m]
};

/// The spheres of a tool packet in W, enlarged; made once per sub-step, when first visited.
struct alignas(32) WorldPacket {
  float x[kTreeArity], y[kTreeArity], z[kTreeArity], radius[kTreeArity];
};

/// Where the graphic tool is and how far it may go, in the precision of the query.
struct QueryPose {
  float R[9];             ///< R_WG, row by row
  float p[3];             ///< centroid in W [m]
  float max_translation;  ///< every tool sphere grows by max_translation + max_rotation * lever
  float max_rotation;
};

/// One level of the tool's and of the forest's tree, for expand_pairs.
struct LevelView {
  const ToolPacket* tool;
  WorldPacket* tool_world;  ///< valid where stamp equals `now`
  std::uint32_t* tool_stamp;
  const SpherePacket* object;
};

/// Rows a . x >= b as columns of `capacity` values; columns start 64-byte aligned.  x = [v; rho
/// phi], or v alone.
struct RowColumns {
  int unknowns;  ///< 6, or 3
  double* a[6];
  double* b;
  double* lever[3];  ///< of the contact point [m], in W; rows between meshes only
  ContactId* id;
};

/// Rows that yield: each pushes back where a . x < b, by its weight times s = b - a . x, and by its
/// threshold, which is all there at once.  Columns as in QpRows; a row of weight 0 and without a
/// threshold does nothing.
struct YieldingRows {
  QpRows rows;
  const double* weight;
  const double* threshold;  ///< [m]; null: none has one
  double* push;             ///< of each row, filled at each look to the end of the padding [m]
};

/// A row below its threshold is a spring that is so many times as stiff as the coupling.
/// @field on  a row is on its spring where one so stiff has not reached the threshold
struct Springs {
  double stiffness = limits::energy::kRigid;
  double on = limits::energy::kRigid;
};

/// What energies are at a place x, over the coupling's stiffness, summed over them.
struct EnergyAt {
  double twice = 0.0;       ///< the energy [m^2]
  double force[6] = {};     ///< the opposite of its gradient [m]
  double hessian[21] = {};  ///< lower triangle, row by row
};

/// Pairs of packets that expand_pairs takes at a time.
inline constexpr int kMaxExpanded = 256;

/// The inner loops, compiled once per instruction set; all give the same bits.
struct Kernels {
  const char* name;

  /// Tests every child sphere of the tool packet against every one of the object packet for each of
  /// `count` pairs; writes the children's pairs that touch.  out holds 64 * count.  Returns how
  /// many.
  int (*expand_pairs)(const LevelView& level, const QueryPose& pose, std::uint32_t now,
                      const NodePair* in, int count, NodePair* out);

  /// Linearised non-penetration (chapter 2.10-2.17) of `count` leaf pairs, appended at row `first`.
  /// R: R_WG row by row; p: centroid in W.  May write up to 7 rows beyond the last.
  void (*build_rows)(const LeafSphere* tool, const LeafSphere* object, const double* R,
                     const double* p, double inverse_rho, const NodePair* pairs, int count,
                     int first, const RowColumns& rows);

  /// Indices of the values below a limit; the column is aligned and padded as PlaneColumns.  May
  /// write up to 8 beyond the last.  Returns how many.
  int (*find_below)(const double* value, int count, double limit, std::int32_t* out);

  /// Index of the point that is lowest along m, of those whose place in their eight has its bit in
  /// `lanes`; of several one that is the same everywhere.
  int (*lowest_point)(const EightPoints* eights, int count, std::uint32_t lanes, const double m[3]);

  /// Of two triangles, given by their corners, the nearest points of a pair of edges that nothing
  /// is nearer than, the first such; else those of the nearest pair.
  EdgePair (*nearest_edges)(const double a[9], const double b[9]);

  /// Takes the added points of `searches`, a bit each, into their simplices.  Returns those that go
  /// on: whose nearest point has come nearer, and is `least` away at least.
  std::uint32_t (*advance_simplices)(Simplices& simplices, std::uint32_t searches, double least);

  /// The planes of `count` slots as they are now, as columns from `first` on: each slack less by
  /// what its node moved against n since its epoch, and what it turned times its radius.
  /// R: R_WG row by row.  May write up to 7 columns beyond the last.
  void (*refresh_planes)(const PlaneRecord* records, const std::uint32_t* epochs,
                         const std::int32_t* slots, int count, const EpochMotion* since,
                         const double* R, int first, const PlaneColumns& out);

  /// Indices, from `first` on, of the planes that do not hold throughout a motion: slack <
  /// least_old, or left = slack + n . v + (l x n) . phi - |phi| radius < least_new.  Fills the
  /// column `left`, from the multiple of eight below `first` on.  May write up to 8 indices beyond
  /// the last.  Returns how many.
  int (*find_used_up)(const PlaneColumns& planes, int first, int count, const PlaneMotion& motion,
                      std::int32_t* out);

  /// SolveNearestPoint (common/qp), in 3 or 6 unknowns; the first columns of so many are used.
  QpResult (*solve)(const double* t, int unknowns, const QpRows& rows, const int* guess,
                    int guesses);

  /// Whether all rows hold at x, but for `tolerance`.
  bool (*rows_hold)(const QpRows& rows, int unknowns, const double* x, double tolerance);
  /// L^-1 a of each row, and its b by a scale, to the end of the padding.  L: lower triangle of
  /// unknowns x unknowns, row by row.  a, b: columns to write.
  void (*transform_rows)(const QpRows& rows, int unknowns, const double* L,
                         const double* inverse_diagonal, double scale, double* const a[6],
                         double* b);

  /// Adds the energy of rows and its force at x, or its Hessian.  The first returns how many rows
  /// push.
  int (*add_yielding)(const YieldingRows& rows, int unknowns, const double* x,
                      const Springs& springs, EnergyAt& at);
  void (*add_yielding_hessian)(const YieldingRows& rows, int unknowns, const double* x,
                               const Springs& springs, EnergyAt& at);
};

extern const Kernels kScalarKernels;
extern const Kernels kAvx2Kernels;
extern const Kernels kAvx512Kernels;

/// The widest that this processor runs; PALPATE_SIMD=scalar|avx2|avx512 in the environment asks for
/// a narrower one (for tests and comparisons).  Chosen once, at first use.
const Kernels& ActiveKernels();

/// Every level that this processor runs, the scalar one first.
int AvailableKernels(const Kernels* out[3]);

/// For tests: what ActiveKernels gives from now on.
void UseKernels(const Kernels& kernels);

}  // namespace palpate
