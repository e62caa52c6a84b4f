#pragma once

#include <cstdint>

#include "common/qp/nearest_point.h"
#include "scenes/sphere_packet.h"

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

/// A point of a surface that may touch another surface.
struct alignas(64) SurfacePoint {
  double x[3];
  double reach;  ///< every place of the surface round it is nearer than this to some point [m]
  double m[3];   ///< outward unit normal; on a crease the middle of the normals that meet there
  /// It may touch a patch whose normal n has -n . m above this: what it may touch faces it.
  double cosine;
};
/// SurfacePoint::cosine of what may touch a patch whichever way that looks.
inline constexpr double kFacesAnything = -2.0;

/// A patch of SurfaceMesh, as the kernel wants it.
struct alignas(32) SurfacePatch {
  double p0[3], e1[3], e2[3];  ///< corner 0, and the edges from it to corners 1 and 2
  double n0[3], d1[3], d2[3];  ///< normal of corner 0, and how those of 1 and 2 differ from it
  double lift[6];              ///< e1.n0, e2.n0, e1.n1, e2.n1, e1.n2, e2.n2
  double reach;  ///< of the smooth points that sample it, the largest; infinite where none do
  double depth;  ///< a point deeper than this below it belongs to another patch [m]
  /// How far beside the patch, in barycentric coordinates, a foot still counts: patches overlap
  /// across smooth edges, so that rounding opens no gap between them, and end at creases.
  double outside;
  double unused;
};

/// What a patch lies in, for a first look: within `slack` of a plane, and within `radius` of a
/// point of it.
struct alignas(32) PatchDisc {
  double n[3], offset;      ///< the flat triangle's plane n . x = offset
  double centre[3], slack;  ///< [m]
  double radius;            ///< [m]
  double reach;             ///< the patch's
  double unused[2];
};

/// From the frame of the points to that of the patches, and on to W.
struct SurfaceFrames {
  double M[9], o[3];  ///< x_patch = M x + o
  double Q[9], c[3];  ///< lever arm in W = Q x_patch + c
  double side;        ///< 1: the points are the tool's; -1: the patches are
  double radius;      ///< of a ball round each point [m]
  double max_translation, max_rotation;
  double inverse_rho;
  double max_depth;  ///< the most that a point may lie below a patch, if less than its depth [m]
  double facing;     ///< taken off SurfacePoint::cosine: 0, or 4 where what lies inside counts too
  double max_lever;  ///< of any point of the tool [m]
  double coarser;    ///< points of a reach beyond this times the patch's are left to the other side
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
/// phi].
struct RowColumns {
  double* a[6];
  double* b;
  double* lever[3];  ///< of the contact point [m], in W; rows between surfaces only
  NodePair* pair;    ///< leaves
};

/// Rows of which some are soft, see SolveCompliant in solve/qp_solver.h.  Columns as in QpRows.
struct CompliantRows {
  QpRows rigid;            ///< what no step may violate: rigid rows, and the cores of soft ones
  const double* soft_b;    ///< a soft row pushes where a . x < soft_b
  const double* weight;    ///< ... with weight * (soft_b - a . x); 0 where the row is rigid
  double* transformed[6];  ///< scratch
  // Filled by the solver, at its result:
  double* push;  ///< of each row, to the end of the padding: weight * (soft_b - a . x), or 0
  double* pull;  ///< 6: sum of push * a
  int* pushing;  ///< rows whose push is not 0
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
  void (*build_rows_6)(const LeafSphere* tool, const LeafSphere* object, const double* R,
                       const double* p, double inverse_rho, const NodePair* pairs, int count,
                       int first, const RowColumns& rows);
  void (*build_rows_3)(const LeafSphere* tool, const LeafSphere* object, const double* R,
                       const double* p, double inverse_rho, const NodePair* pairs, int count,
                       int first, const RowColumns& rows);

  /// Keeps the pairs that may have a row, by a first look.  Writes them to out; returns how many.
  int (*near_patches)(const SurfacePoint* points, const PatchDisc* discs,
                      const SurfaceFrames& frames, const NodePair* pairs, int count, NodePair* out);

  /// Rows between points of one surface and patches of another, appended at row `first`; pairs that
  /// no sub-step within the bounds can bring together give none.  The pairs' `tool` is the index of
  /// the point or patch of the tool, and `tag` is added to it in the row.  Returns how many rows.
  int (*build_surface_rows)(const SurfacePoint* points, const SurfacePatch* patches,
                            const SurfaceFrames& frames, int degrees_of_freedom,
                            const NodePair* pairs, int count, std::int32_t tag, int first,
                            const RowColumns& rows);

  /// Nearest point of a polyhedron, see SolveNearestPoint in solve/qp_solver.h.
  QpResult (*solve_6)(const double* t, const QpRows& rows, const int* guess, int guesses);
  QpResult (*solve_3)(const double* t, const QpRows& rows, const int* guess, int guesses);

  /// The same where some rows yield, see SolveCompliant.
  QpResult (*solve_compliant_6)(const double* t, const CompliantRows& rows, const int* guess,
                                int guesses);
  QpResult (*solve_compliant_3)(const double* t, const CompliantRows& rows, const int* guess,
                                int guesses);
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
