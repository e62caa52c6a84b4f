// The inner loops, included once by each kernels_*.cpp, which sets the instruction set.
#include "server/physics/simd/compliant.inl"
#include "common/qp/dual_active_set.inl"
#include "server/physics/simd/kernels.h"
#include "common/qp/vector.h"

namespace palpate {
namespace {

void TransformPacket(const ToolPacket& tool, const QueryPose& X, WorldPacket& out) {
  const SpherePacket& packet = tool.sphere;
  const F16 x = LoadTwice(packet.x), y = LoadTwice(packet.y), z = LoadTwice(packet.z);
  const auto row = [&](int i) {
    return Fma(Set1(X.R[3 * i + 2]), z,
               Fma(Set1(X.R[3 * i + 1]), y, Fma(Set1(X.R[3 * i]), x, Set1(X.p[i]))));
  };
  StoreFirst8(out.x, row(0));
  StoreFirst8(out.y, row(1));
  StoreFirst8(out.z, row(2));
  const F16 reach = Fma(Set1(X.max_rotation), LoadTwice(tool.lever), Set1(X.max_translation));
  StoreFirst8(out.radius, LoadTwice(packet.radius) + reach);
}

/// Bit 8 i + j: tool sphere i touches object sphere j.
[[gnu::always_inline]] inline std::uint64_t TestPackets(const WorldPacket& tool,
                                                        const SpherePacket& object) {
  const F16 tx = LoadTwice(tool.x), ty = LoadTwice(tool.y), tz = LoadTwice(tool.z);
  const F16 tr = LoadTwice(tool.radius);
  const F16 ox = LoadTwice(object.x), oy = LoadTwice(object.y), oz = LoadTwice(object.z);
  const F16 radius = LoadTwice(object.radius);
  const auto two = [&]<int k>() -> std::uint64_t {
    const F16 dx = SpreadPair<k>(tx) - ox;
    const F16 dy = SpreadPair<k>(ty) - oy;
    const F16 dz = SpreadPair<k>(tz) - oz;
    const F16 sum = SpreadPair<k>(tr) + radius;
    return static_cast<std::uint64_t>(LessEqual(Fma(dz, dz, Fma(dy, dy, dx * dx)), sum * sum))
           << (16 * k);
  };
  return two.template operator()<0>() | two.template operator()<1>() |
         two.template operator()<2>() | two.template operator()<3>();
}

int ExpandPairs(const LevelView& level, const QueryPose& pose, std::uint32_t now,
                const NodePair* in, int count, NodePair* out) {
  // First the tests, without a branch on their outcome; then the outcome, without a branch on how
  // many touch of each pair: neither can be foretold, and a wrong guess costs more than a test.
  std::uint64_t touching[kMaxExpanded + 1];
  NodePair parent[kMaxExpanded + 1];
  int some = 0, found = 0;
  for (int i = 0; i < count; ++i) {
    const std::int32_t t = in[i].tool;
    if (level.tool_stamp[t] != now) {
      level.tool_stamp[t] = now;
      TransformPacket(level.tool[t], pose, level.tool_world[t]);
    }
    const std::uint64_t mask = TestPackets(level.tool_world[t], level.object[in[i].object]);
    touching[some] = mask;
    parent[some] = in[i];
    some += mask != 0 ? 1 : 0;
    found += __builtin_popcountll(mask);
  }
  touching[some] = 0;
  parent[some] = {0, 0};
  int at = 0;
  std::uint64_t mask = touching[0];
  for (int k = 0; k < found; ++k) {
    const int bit = __builtin_ctzll(mask);
    out[k] = {level.tool[parent[at].tool].sphere.child[bit >> 3],
              level.object[parent[at].object].child[bit & 7]};
    mask &= mask - 1;
    const bool next = mask == 0;
    at += next ? 1 : 0;
    mask = next ? touching[at] : mask;
  }
  return found;
}

template <int N>
void BuildRows(const LeafSphere* tool, const LeafSphere* object, const double* R, const double* p,
               double inverse_rho, const NodePair* pairs, int count, int first,
               const RowColumns& rows) {
  for (int i = 0; i < count; i += 8) {
    const double* tool_record[8];
    const double* object_record[8];
    for (int k = 0; k < 8; ++k) {
      const NodePair pair = pairs[i + k < count ? i + k : count - 1];
      tool_record[k] = &tool[pair.tool].x;
      object_record[k] = &object[pair.object].x;
      rows.pair[first + i + k] = pair;
    }
    D8 t[4], o[4];
    LoadTransposed(tool_record, t);
    LoadTransposed(object_record, o);
    // Lever arm l in W, then d = c_T - c_O.
    D8 l[3], d[3];
    for (int r = 0; r < 3; ++r) {
      l[r] = Fma(Set1(R[3 * r + 2]), t[2], Fma(Set1(R[3 * r + 1]), t[1], Set1(R[3 * r]) * t[0]));
      d[r] = (l[r] + Set1(p[r])) - o[r];
    }
    const D8 distance = Sqrt(Fma(d[2], d[2], Fma(d[1], d[1], d[0] * d[0])));
    const D8 gap = distance - (t[3] + o[3]);
    // Concentric spheres have no normal; any will do, and +z is the same everywhere.
    const D8 tiny = Set1(1e-12), one = Set1(1.0), zero = Set1(0.0);
    const D8 inverse = one / SelectLess(distance, tiny, one, distance);
    const D8 n[3] = {SelectLess(distance, tiny, zero, d[0] * inverse),
                     SelectLess(distance, tiny, zero, d[1] * inverse),
                     SelectLess(distance, tiny, one, d[2] * inverse)};
    for (int c = 0; c < 3; ++c) Store(rows.a[c] + first + i, n[c]);
    if constexpr (N == 6) {
      const D8 scale = Set1(inverse_rho);
      for (int c = 0; c < 3; ++c) {
        const int u = (c + 1) % 3, w = (c + 2) % 3;
        Store(rows.a[3 + c] + first + i, scale * Fnma(l[w], n[u], l[u] * n[w]));
      }
    }
    Store(rows.b + first + i, zero - gap);
  }
}

struct D8x3 {
  D8 x, y, z;
};
inline D8x3 operator+(D8x3 a, D8x3 b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline D8x3 operator-(D8x3 a, D8x3 b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline D8x3 operator*(D8 s, D8x3 a) {
  return {s * a.x, s * a.y, s * a.z};
}
/// s a + b.
inline D8x3 Fma(D8 s, D8x3 a, D8x3 b) {
  return {Fma(s, a.x, b.x), Fma(s, a.y, b.y), Fma(s, a.z, b.z)};
}
inline D8 Dot(D8x3 a, D8x3 b) {
  return Fma(a.z, b.z, Fma(a.y, b.y, a.x * b.x));
}
inline D8x3 Cross(D8x3 a, D8x3 b) {
  return {Fnma(a.z, b.y, a.y * b.z), Fnma(a.x, b.z, a.z * b.x), Fnma(a.y, b.x, a.x * b.y)};
}
inline D8x3 Turn(const double* R, D8x3 a) {
  const auto row = [&](int i) {
    return Fma(Set1(R[i + 2]), a.z, Fma(Set1(R[i + 1]), a.y, Set1(R[i]) * a.x));
  };
  return {row(0), row(3), row(6)};
}
inline D8x3 Spread(const double* v) {
  return {Set1(v[0]), Set1(v[1]), Set1(v[2])};
}

/// `fields` fields of eight records of doubles.
template <int fields>
inline void LoadRecords(const double* const record[8], D8 (&field)[fields]) {
  static_assert(fields % 4 == 0);
  for (int f = 0; f < fields; f += 4) {
    const double* at[8];
    for (int k = 0; k < 8; ++k) at[k] = record[k] + f;
    LoadTransposed(at, field + f);
  }
}

/// What the normal of a patch's plane may miss by of SurfacePoint::cosine, because the patch's own
/// normals leave it by up to 32 degrees.
constexpr double kLean = 0.56;

/// Where a point projects on a patch along the patch's own normal: p - foot = height n.
struct Foot {
  D8x3 normal;
  D8 height;
  D8 inside;  ///< the least of the three barycentric coordinates
};

Foot Project(const D8 (&patch)[28], D8x3 p) {
  const auto vec = [&](int f) { return D8x3{patch[f], patch[f + 1], patch[f + 2]}; };
  const D8x3 e1 = vec(3), e2 = vec(6), n0 = vec(9), d1 = vec(12), d2 = vec(15);
  const D8* lift = patch + 18;
  const D8 one = Set1(1.0), half = Set1(0.5);
  const D8x3 d = p - vec(0), n1 = n0 + d1, n2 = n0 + d2;
  D8 b1 = Set1(1.0 / 3.0), b2 = b1, t = Set1(0.0);
  D8x3 normal, residual;
  const auto evaluate = [&] {
    const D8 b0 = (one - b1) - b2;
    normal = Fma(b1, d1, Fma(b2, d2, n0));
    const D8 c0 = half * b0 * Fma(b2, lift[1], b1 * lift[0]);
    const D8 c1 = half * b1 * Fma(b2, lift[3], (b1 - one) * lift[2]);
    const D8 c2 = half * b2 * Fma(b2 - one, lift[5], b1 * lift[4]);
    const D8x3 flat = d - Fma(b1, e1, b2 * e2);
    residual = Fma(c0, n0, Fma(c1, n1, Fma(c2, n2, flat)));
  };
  // Newton on p = P(b) + t N(b), but for the derivative of the lift, which is small.  Flat patches
  // are exact after one turn, curved ones gain a factor of about their turn's angle a turn.
  for (int turn = 0; turn < 4; ++turn) {
    evaluate();
    const D8x3 r = residual - t * normal;
    const D8x3 j1 = Fma(t, d1, e1), j2 = Fma(t, d2, e2);
    const D8x3 across = Cross(j1, j2);
    const D8 inverse = one / Dot(across, normal);
    b1 = Fma(Dot(r, Cross(j2, normal)), inverse, b1);
    b2 = Fma(Dot(r, Cross(normal, j1)), inverse, b2);
    t = Fma(Dot(r, across), inverse, t);
  }
  evaluate();
  Foot foot;
  foot.normal = (one / Sqrt(Dot(normal, normal))) * normal;
  foot.height = Dot(residual, foot.normal);
  foot.inside = Min(Min(b1, b2), (one - b1) - b2);
  return foot;
}

/// A point whose reach is beyond frames.coarser times the patch's is left to the other side; and
/// two places that touch face each other.
inline std::uint32_t MayTouch(D8 reach, D8x3 outward, D8 cosine, const SurfaceFrames& frames,
                              D8 patch_reach, D8x3 patch_outward) {
  return Less(reach, Set1(frames.coarser) * patch_reach) &
         Less(cosine, Set1(0.0) - Dot(outward, patch_outward));
}

int NearPatches(const SurfacePoint* points, const PatchDisc* discs, const SurfaceFrames& frames,
                const NodePair* pairs, int count, NodePair* out) {
  const bool of_tool = frames.side > 0.0;
  const D8 above = Set1(frames.max_translation + frames.max_rotation * frames.max_lever);
  const D8 below = Set1(frames.max_depth), zero = Set1(0.0);
  int end = 0;
  for (int i = 0; i < count; i += 8) {
    const double* point_record[8];
    const double* disc_record[8];
    for (int k = 0; k < 8; ++k) {
      const NodePair pair = pairs[i + k < count ? i + k : count - 1];
      point_record[k] = points[of_tool ? pair.tool : pair.object].x;
      disc_record[k] = discs[of_tool ? pair.object : pair.tool].n;
    }
    D8 point[8], disc[12];
    LoadRecords(point_record, point);
    LoadRecords(disc_record, disc);
    const D8x3 x = Turn(frames.M, {point[0], point[1], point[2]}) + Spread(frames.o);
    const D8x3 m = Turn(frames.M, {point[4], point[5], point[6]});
    const D8x3 n = {disc[0], disc[1], disc[2]};
    const D8 height = Dot(x, n) - disc[3];
    const D8 slack = disc[7] + Set1(frames.radius);
    // The foot lies beside the point's projection on the plane by no more than the patch's normals
    // lean (surface_mesh.h lets them lean by 0.62 at most).
    const D8x3 d = x - D8x3{disc[4], disc[5], disc[6]};
    const D8 size = Set1(0.62) * Sqrt(height * height) + (Set1(1.1) * disc[8] + disc[7]);
    std::uint32_t near =
        Less(height, slack + above) & Less(zero - (slack + below), height) &
        Less(Fnma(height, height, Dot(d, d)), size * size) &
        MayTouch(point[3], m, point[7] - Set1(frames.facing + kLean), frames, disc[9], n);
    if (count - i < 8) near &= (1u << (count - i)) - 1u;
    for (; near != 0; near &= near - 1) out[end++] = pairs[i + __builtin_ctz(near)];
  }
  return end;
}

int BuildSurfaceRows(const SurfacePoint* points, const SurfacePatch* patches,
                     const SurfaceFrames& frames, int degrees_of_freedom, const NodePair* pairs,
                     int count, std::int32_t tag, int first, const RowColumns& rows) {
  const D8 zero = Set1(0.0);
  const bool of_tool = frames.side > 0.0;
  int end = first;
  for (int i = 0; i < count; i += 8) {
    const double* point_record[8];
    const double* patch_record[8];
    for (int k = 0; k < 8; ++k) {
      const NodePair pair = pairs[i + k < count ? i + k : count - 1];
      point_record[k] = points[of_tool ? pair.tool : pair.object].x;
      patch_record[k] = patches[of_tool ? pair.object : pair.tool].p0;
    }
    D8 point[8], patch[28];
    LoadRecords(point_record, point);
    LoadRecords(patch_record, patch);
    const D8x3 x = Turn(frames.M, {point[0], point[1], point[2]}) + Spread(frames.o);
    const D8x3 m = Turn(frames.M, {point[4], point[5], point[6]});
    const Foot foot = Project(patch, x);
    const D8 gap = foot.height - Set1(frames.radius);
    const D8x3 contact = Fma(zero - Set1(frames.radius), foot.normal, x);

    const D8x3 n_W = Set1(frames.side) * Turn(frames.Q, foot.normal);
    const D8x3 lever = Turn(frames.Q, contact) + Spread(frames.c);
    const D8 bound =
        Fma(Set1(frames.max_rotation), Sqrt(Dot(lever, lever)), Set1(frames.max_translation));
    const std::uint32_t valid =
        Less(zero - patch[26], foot.inside) & Less(gap, bound) &
        Less(zero - Min(patch[25], Set1(frames.max_depth)), gap) &
        MayTouch(point[3], m, point[7] - Set1(frames.facing), frames, patch[24], foot.normal);
    if (valid == 0) continue;

    alignas(64) double out[10][8];
    Store(out[0], n_W.x);
    Store(out[1], n_W.y);
    Store(out[2], n_W.z);
    const D8x3 turned = Set1(frames.inverse_rho) * Cross(lever, n_W);
    Store(out[3], turned.x);
    Store(out[4], turned.y);
    Store(out[5], turned.z);
    Store(out[6], zero - gap);
    Store(out[7], lever.x);
    Store(out[8], lever.y);
    Store(out[9], lever.z);
    const int lanes = count - i < 8 ? count - i : 8;
    for (int k = 0; k < lanes; ++k) {
      if ((valid >> k & 1u) == 0) continue;
      for (int f = 0; f < degrees_of_freedom; ++f) rows.a[f][end] = out[f][k];
      rows.b[end] = out[6][k];
      for (int f = 0; f < 3; ++f) rows.lever[f][end] = out[7 + f][k];
      rows.pair[end] = {pairs[i + k].tool + tag, pairs[i + k].object};
      ++end;
    }
  }
  return end - first;
}

constexpr Kernels MakeKernels(const char* name) {
  return {name,
          ExpandPairs,
          BuildRows<6>,
          BuildRows<3>,
          NearPatches,
          BuildSurfaceRows,
          Solve<6>,
          Solve<3>,
          SolveCompliantRows<6>,
          SolveCompliantRows<3>};
}

}  // namespace
}  // namespace palpate
