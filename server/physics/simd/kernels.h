#pragma once

#include <cstdint>

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

/// Centres of a tool packet in W, made once per sub-step when the packet is first visited.
struct alignas(32) WorldCentres {
  float x[kTreeArity], y[kTreeArity], z[kTreeArity];
};

/// Rotation and centroid of the graphic tool, in the precision of the query.
struct QueryTransform {
  float R[9];  ///< R_WG, row by row
  float p[3];  ///< centroid in W [m]
};

/// One level of the tool's and of the forest's tree, for ExpandPairs.
struct LevelView {
  const SpherePacket* tool;
  WorldCentres* tool_world;  ///< valid where stamp equals `now`
  std::uint32_t* tool_stamp;
  const SpherePacket* object;
};

/// Rows a . x >= b as columns of `capacity` values; columns start 64-byte aligned.  x = [v; rho
/// phi].
struct RowColumns {
  double* a[6];
  double* b;
  NodePair* pair;  ///< leaves
};

/// Sixteen rows that hold least, one per lane of the scan: lane i is the least a_r . x - b_r over
/// the rows r = i (mod 16), the first of equals.
struct ScanResult {
  alignas(64) double value[16];
  alignas(64) double row[16];
};

/// The four inner loops, compiled once per instruction set; all give the same bits.
struct Kernels {
  const char* name;

  /// Tests every child sphere of the tool packet against every one of the object packet for each of
  /// `count` pairs; writes the children's pairs that touch.  out holds 64 * count.  Returns how
  /// many.
  int (*expand_pairs)(const LevelView& level, const QueryTransform& X_WG, std::uint32_t now,
                      const NodePair* in, int count, NodePair* out);

  /// Linearised non-penetration (chapter 2.10-2.17) of `count` leaf pairs, appended at row `first`.
  /// R: R_WG row by row; p: centroid in W.  May write up to 7 rows beyond the last.
  void (*build_rows_6)(const LeafSphere* tool, const LeafSphere* object, const double* R,
                       const double* p, double inverse_rho, const NodePair* pairs, int count,
                       int first, const RowColumns& rows);
  void (*build_rows_3)(const LeafSphere* tool, const LeafSphere* object, const double* R,
                       const double* p, double inverse_rho, const NodePair* pairs, int count,
                       int first, const RowColumns& rows);

  /// `count` is a multiple of 16 and at least 16: the caller pads with rows that always hold.
  void (*scan_rows_6)(const double* const* a, const double* b, int count, const double* x,
                      ScanResult& result);
  void (*scan_rows_3)(const double* const* a, const double* b, int count, const double* x,
                      ScanResult& result);
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
