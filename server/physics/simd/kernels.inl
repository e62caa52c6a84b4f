// The inner loops, included once by each kernels_*.cpp, which sets the instruction set.
#include "common/qp/dual_active_set.inl"
#include "common/qp/vector.h"
#include "server/physics/simd/kernels.h"

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
  // First the tests, without a branch on their outcome; then the results, without a branch on how
  // many of each pair touch.  Neither can be predicted, and a misprediction costs more than a test.
  // (GCC 12 branches on `next` after all; kept from it, it makes walks a quarter longer.)
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
      rows.id[first + i + k] = {ContactId::kLeaves, pair.tool, pair.object, 0};
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
    // Concentric spheres have no normal; +z is used, the same in every instruction set.
    const D8 tiny = Set1(1e-12), one = Set1(1.0), zero = Set1(0.0);
    const D8 inverse = one / SelectLess(distance, tiny, one, distance);
    const D8 n[3] = {SelectLess(distance, tiny, zero, d[0] * inverse),
                     SelectLess(distance, tiny, zero, d[1] * inverse),
                     SelectLess(distance, tiny, one, d[2] * inverse)};
    for (int c = 0; c < 3; ++c) Store(rows.a[c] + first + i, n[c]);
    const D8 scale = Set1(inverse_rho);
    for (int c = 0; c < 3; ++c) {
      const int u = (c + 1) % 3, w = (c + 2) % 3;
      Store(rows.a[3 + c] + first + i, scale * Fnma(l[w], n[u], l[u] * n[w]));
    }
    Store(rows.b + first + i, zero - gap);
  }
}

/// For each byte, the places of its set bits, the lowest first.
struct PlacesOfBits {
  std::uint8_t place[256][8] = {};
  constexpr PlacesOfBits() {
    for (unsigned bits = 0; bits < 256; ++bits) {
      int found = 0;
      for (unsigned k = 0; k < 8; ++k) {
        if ((bits >> k & 1u) != 0) place[bits][found++] = static_cast<std::uint8_t>(k);
      }
    }
  }
};
constexpr PlacesOfBits kPlacesOfBits;

/// Appends first + k for each set bit k, without a branch on their number, which cannot be
/// predicted (a step of the bunny is a tenth slower with one).  Writes up to eight; returns their
/// number.
[[gnu::always_inline]] inline int Append(std::uint32_t bits, int first, std::int32_t* out) {
  for (int k = 0; k < 8; ++k) out[k] = first + kPlacesOfBits.place[bits][k];
  return __builtin_popcount(bits);
}

int FindBelow(const double* value, int count, double limit, std::int32_t* out) {
  const D8 least = Set1(limit);
  int found = 0;
  for (int i = 0; i < count; i += 8) found += Append(Less(Load(value + i), least), i, out + found);
  return found;
}

int LowestPoint(const EightPoints* eights, int count, std::uint32_t lanes, const double m[3]) {
  const auto along = [&](const EightPoints& p) {
    return Fma(Set1(m[2]), Load(p.x[2]), Fma(Set1(m[1]), Load(p.x[1]), Set1(m[0]) * Load(p.x[0])));
  };
  const D8 one = Set1(1.0);
  D8 least = along(eights[0]), in = Set1(0.0), number = in;
  for (int k = 1; k < count; ++k) {
    const D8 here = along(eights[k]);
    number = number + one;
    in = SelectLess(here, least, number, in);
    least = Min(here, least);
  }
  const D8 lowest = Set1(LeastLane(SelectLanes(lanes, least, Set1(kInfinity))));
  const int best = __builtin_ctz(~Less(lowest, least) & lanes);
  if (count == 1) return best;
  double eight[8];
  Store(eight, in);
  return 8 * static_cast<int>(eight[best]) + best;
}

struct Vectors {
  D8 x, y, z;
};
inline Vectors operator+(const Vectors& a, const Vectors& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Vectors operator-(const Vectors& a, const Vectors& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vectors operator*(const D8& s, const Vectors& a) {
  return {s * a.x, s * a.y, s * a.z};
}
inline D8 Dot(const Vectors& a, const Vectors& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Vectors Cross(const Vectors& a, const Vectors& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Vectors SelectLanes(std::uint32_t bits, const Vectors& a, const Vectors& b) {
  return {SelectLanes(bits, a.x, b.x), SelectLanes(bits, a.y, b.y), SelectLanes(bits, a.z, b.z)};
}
inline Vectors LoadVectors(const double x[3][8]) {
  return {Load(x[0]), Load(x[1]), Load(x[2])};
}
inline void Store(double x[3][8], const Vectors& a) {
  Store(x[0], a.x);
  Store(x[1], a.y);
  Store(x[2], a.z);
}
inline D8 Negative(const D8& x) {
  return Set1(-0.0) - x;
}
inline D8 Clamp(const D8& x) {
  const D8 zero = Set1(0.0), one = Set1(1.0);
  return SelectLess(x, zero, zero, SelectLess(one, x, one, x));
}

/// A vector in each lane, the same.
inline Vectors Set1(const double* x) {
  return {Set1(x[0]), Set1(x[1]), Set1(x[2])};
}
/// R^T n, with R the placement's.
inline Vectors TurnBack(const double* placement, const Vectors& n) {
  return {Dot(Set1(placement + 3), n), Dot(Set1(placement + 6), n), Dot(Set1(placement + 9), n)};
}

void FindGaps(const TrianglePair& pair, EightGaps& gaps) {
  for (int i = 0; i < 2; ++i) {
    const double* const at = i == 0 ? pair.from : pair.to;
    const Vectors n = LoadVectors(gaps.n[i]);
    const Vectors m = TurnBack(at, n), k = TurnBack(pair.X_BS, n);
    const auto along = [](const double* corners, int c, const Vectors& direction) {
      return Dot(direction, Set1(corners + 3 * c));
    };
    D8 low = along(pair.a, 0, m), high = along(pair.b, 0, k);
    for (int c = 1; c < 3; ++c) {
      const D8 here = along(pair.b, c, k);
      low = Min(along(pair.a, c, m), low);
      high = SelectLess(high, here, here, high);
    }
    Store(gaps.gap[i],
          Dot(n, Set1(at)) + low - Set1(pair.radius) - (Dot(n, Set1(pair.X_BS)) + high));
  }
}

/// Corners of a triangle, three times the index in each lane: one, the next, and the third.
struct alignas(64) Corners {
  long long at[3][8];
};
/// The places 3 i + j of eight pairs of edges; and the ninth.
constexpr Corners kFirstEdge = {
    {{0, 0, 0, 3, 3, 3, 6, 6}, {3, 3, 3, 6, 6, 6, 0, 0}, {6, 6, 6, 0, 0, 0, 3, 3}}};
constexpr Corners kSecondEdge = {
    {{0, 3, 6, 0, 3, 6, 0, 3}, {3, 6, 0, 3, 6, 0, 3, 6}, {6, 0, 3, 6, 0, 3, 6, 0}}};
constexpr Corners kLastEdge = {
    {{6, 6, 6, 6, 6, 6, 6, 6}, {0, 0, 0, 0, 0, 0, 0, 0}, {3, 3, 3, 3, 3, 3, 3, 3}}};

/// Nearest points of edges p + s u and q + t w, eight pairs at once.
struct EdgePairs {
  D8 s, t, squared;
  std::uint32_t apart;

  EdgePairs(const double* a, const double* b, const Corners& of_a, const Corners& of_b) {
    const auto corner = [](const double* x, const long long* at) {
      return Vectors{Spread(x, at), Spread(x + 1, at), Spread(x + 2, at)};
    };
    const D8 zero = Set1(0.0), one = Set1(1.0);
    const Vectors p = corner(a, of_a.at[0]), q = corner(b, of_b.at[0]);
    const Vectors u = corner(a, of_a.at[1]) - p, w = corner(b, of_b.at[1]) - q, r = p - q;
    const D8 uu = Dot(u, u), ww = Dot(w, w), uw = Dot(u, w), ur = Dot(u, r), wr = Dot(w, r);
    const auto along_u = [&](const D8& x) { return SelectLess(zero, uu, Clamp(x / uu), zero); };
    const D8 across = uu * ww - uw * uw;
    s = SelectLess(zero, across, Clamp((uw * wr - ur * ww) / across), zero);
    t = SelectLess(zero, ww, (uw * s + wr) / ww, zero);
    // At an end of the second edge, or where that is a point:
    const D8 end = along_u(SelectLess(one, t, uw - ur, Negative(ur)));
    s = SelectLess(zero, ww, SelectLess(t, zero, end, SelectLess(one, t, end, s)), end);
    t = Clamp(t);
    const Vectors to_p = s * u, to_q = t * w;
    const Vectors away = r + to_p - to_q;
    squared = Dot(away, away);
    // A slab across the shortest way also keeps the third corners out, so nothing is nearer
    // (Larsen, Gottschalk, Lin & Manocha, UNC TR99-018 (1999)).
    const Vectors past_p = corner(a, of_a.at[2]) - (p + to_p);
    const Vectors past_q = corner(b, of_b.at[2]) - (q + to_q);
    apart = ~(Less(Dot(away, past_p), zero) | Less(zero, Dot(away, past_q))) & Less(zero, squared);
  }

  EdgePair Take(int lane, int place, bool is_apart) const {
    const auto of = [lane](const D8& x) {
      Lanes lanes;
      lanes.Set(x);
      return lanes[lane];
    };
    return {of(s), of(t), of(squared), place, is_apart};
  }
};

EdgePair NearestEdges(const double a[9], const double b[9]) {
  const EdgePairs pairs(a, b, kFirstEdge, kSecondEdge);
  Lanes squared;
  squared.Set(pairs.squared);
  for (std::uint32_t apart = pairs.apart; apart != 0; apart &= apart - 1) {
    const int k = __builtin_ctz(apart);
    const std::uint32_t as_near = ~Less(Set1(squared[k]), pairs.squared);
    if ((as_near & ((1u << k) - 1u)) == 0) return pairs.Take(k, k, true);
  }
  const D8 least = Set1(LeastLane(pairs.squared));
  const EdgePairs last(a, b, kLastEdge, kLastEdge);
  if ((Less(last.squared, least) & 1u) != 0) return last.Take(0, 8, (last.apart & 1u) != 0);
  const int best = __builtin_ctz(~Less(least, pairs.squared));
  return pairs.Take(best, best, false);
}

/// The point of a simplex nearest to the origin, between a and those of `second` and `third`
/// whose bit is set.
struct NearestOfSimplex {
  Vectors x, second, third;
  std::uint32_t two, three;
};

/// For triangles a b c, if the origin is not beyond b c; for edges a b where a bit of `edges` is
/// set (Ericson, Real-Time Collision Detection (2005), 5.1 and 9.5).  `outside`: bits of the
/// triangles whose plane does not have the origin and d on the same side.
NearestOfSimplex OfTriangles(const Vectors& a, const Vectors& b, const Vectors& c, const Vectors& d,
                             std::uint32_t edges, std::uint32_t& outside) {
  const D8 zero = Set1(0.0), one = Set1(1.0);
  const Vectors ab = b - a, ac = c - a, normal = Cross(ab, ac);
  const D8 to_b = Negative(Dot(a, ab)), to_c = Negative(Dot(a, ac));
  const std::uint32_t past_ac = Less(Dot(Cross(normal, ac), a), zero);
  const std::uint32_t past_ab = Less(Dot(Cross(ab, normal), a), zero);
  const D8 size2 = Dot(normal, normal), height = Dot(normal, a);
  outside = ~Less(zero, Dot(normal, d - a) * Negative(height));
  const std::uint32_t inside = ~(past_ab | past_ac | edges) & Less(zero, size2);
  const std::uint32_t on_ac = ((past_ac & Less(zero, to_c)) | ~Less(zero, to_b)) & ~edges;
  const Vectors edge = SelectLanes(on_ac, ac, ab);
  const D8 along = SelectLanes(on_ac, to_c, to_b), length2 = Dot(edge, edge);
  const std::uint32_t on = Less(zero, along) & Less(zero, length2);
  // One division for both, because it takes as long as twenty multiplications.
  const D8 part = SelectLanes(inside, height, along) / SelectLanes(inside, size2, length2);
  const Vectors on_edge = a + SelectLess(part, one, part, one) * edge;
  const Vectors on_face = part * normal;
  return {SelectLanes(inside, on_face, SelectLanes(on, on_edge, a)),
          SelectLanes(on_ac & ~inside, c, b), c, inside | on, inside};
}

std::uint32_t AdvanceSimplices(Simplices& simplices, std::uint32_t searches, double least) {
  const D8 zero = Set1(0.0);
  const auto [one, two, three] = simplices.with;
  const Vectors a = LoadVectors(simplices.added);
  const Vectors p[3] = {LoadVectors(simplices.point[0]), LoadVectors(simplices.point[1]),
                        LoadVectors(simplices.point[2])};
  std::uint32_t outside;
  NearestOfSimplex best = OfTriangles(a, p[0], p[1], p[2], ~two, outside);
  if ((three & searches) != 0) {
    // For a tetrahedron: the nearest of the faces that the origin is outside of.
    std::uint32_t is_out = outside | ~three;
    for (int i = 1; i < 3; ++i) {
      const Vectors &b = p[i], &c = p[(i + 1) % 3], &d = p[(i + 2) % 3];
      const NearestOfSimplex face = OfTriangles(a, b, c, d, 0, outside);
      const std::uint32_t nearer = Less(Dot(face.x, face.x), Dot(best.x, best.x));
      const std::uint32_t take = three & outside & (~is_out | nearer);
      is_out |= outside;
      best = {SelectLanes(take, face.x, best.x), SelectLanes(take, face.second, best.second),
              SelectLanes(take, face.third, best.third), (take & face.two) | (~take & best.two),
              (take & face.three) | (~take & best.three)};
    }
    best.x = SelectLanes(is_out, best.x, {zero, zero, zero});
  }
  best.x = SelectLanes(one, best.x, a);
  Store(simplices.point[0], a);
  Store(simplices.point[1], best.second);
  Store(simplices.point[2], best.third);
  simplices.with[0] = ~0u;
  simplices.with[1] = one & best.two;
  simplices.with[2] = one & best.three;
  // No direction separates the hulls by more than the nearest point's distance.  A search also
  // stops when rounding keeps it from coming nearer.
  const D8 length = Sqrt(Dot(best.x, best.x));
  const std::uint32_t nearer = Less(zero, length) & Less(length, Load(simplices.nearest));
  Store(simplices.nearest, length);
  Store(simplices.n, {best.x.x / length, best.x.y / length, best.x.z / length});
  return searches & nearer & ~Less(length - Load(simplices.radius), Set1(least));
}

void RefreshPlanes(const PlaneRecord* records, const std::uint32_t* epochs,
                   const std::int32_t* slots, int count, const EpochMotion* since, const double* R,
                   int first, const PlaneColumns& out) {
  for (int i = 0; i < count; i += 8) {
    const double *plane[8], *ball[8], *row[3][8];
    for (int k = 0; k < 8; ++k) {
      const std::int32_t slot = slots[i + k < count ? i + k : count - 1];
      const EpochMotion& motion = since[epochs[slot] % kPlaneEpochs];
      plane[k] = records[slot].n;
      ball[k] = records[slot].centre;
      for (int r = 0; r < 3; ++r) row[r][k] = motion.row[r];
    }
    D8 n[4], c[4], m[4], l[3];
    LoadTransposed(plane, n);
    LoadTransposed(ball, c);
    const D8 zero = Set1(0.0);
    D8 slack = n[3], turned[3] = {zero, zero, zero};
    for (int r = 0; r < 3; ++r) {
      LoadTransposed(row[r], m);
      for (int k = 0; k < 3; ++k) turned[k] = Fma(n[r], m[k], turned[k]);
      slack = Fma(n[r], Fma(m[2], c[2], Fma(m[1], c[1], Fma(m[0], c[0], m[3]))), slack);
      l[r] = Fma(Set1(R[3 * r + 2]), c[2], Fma(Set1(R[3 * r + 1]), c[1], Set1(R[3 * r]) * c[0]));
    }
    const int at = first + i;
    for (int r = 0; r < 3; ++r) {
      const int u = (r + 1) % 3, w = (r + 2) % 3;
      Store(out.along[r] + at, n[r]);
      Store(out.along[3 + r] + at, Fnma(l[w], n[u], l[u] * n[w]));
    }
    const Vectors by = {turned[0], turned[1], turned[2]};
    Store(out.slack + at, Fnma(Sqrt(Dot(by, by)), c[3], slack));
    Store(out.radius + at, c[3]);
  }
}

int FindUsedUp(const PlaneColumns& planes, int first, int count, const PlaneMotion& motion,
               std::int32_t* out) {
  D8 along[6];
  for (int c = 0; c < 6; ++c) along[c] = Set1(motion.step[c]);
  const Vectors phi = {along[3], along[4], along[5]};
  const D8 least_old = Set1(motion.least_old);
  const D8 least_new = Set1(motion.least_new);
  int found = 0;
  for (int i = first & ~7; i < count; i += 8) {
    const D8 slack = Load(planes.slack + i);
    const Vectors turned = Cross(
        {Load(planes.along[0] + i), Load(planes.along[1] + i), Load(planes.along[2] + i)}, phi);
    D8 left = Fnma(Sqrt(Dot(turned, turned)), Load(planes.radius + i), slack);
    for (int c = 0; c < 6; ++c) left = Fma(Load(planes.along[c] + i), along[c], left);
    Store(planes.left + i, left);
    std::uint32_t low = Less(slack, least_old) | Less(left, least_new);
    if (i < first) low &= ~0u << (first - i);
    if (i + 8 > count) low &= (1u << (count - i)) - 1u;
    found += Append(low, i, out + found);
  }
  return found;
}

bool RowsHold(const QpRows& rows, const double* x, double tolerance) {
  D8 xs[6], least = Set1(0.0);
  for (int c = 0; c < 6; ++c) xs[c] = Set1(x[c]);
  for (int i = 0; i < rows.count; i += 8) {
    D8 s = Set1(0.0) - Load(rows.b + i);
    for (int c = 0; c < 6; ++c) s = Fma(Load(rows.a[c] + i), xs[c], s);
    least = Min(s, least);
  }
  return Less(least, Set1(-tolerance)) == 0;
}

/// By forward substitution.
void TransformRows(const QpRows& rows, const double* L, const double* inverse_diagonal,
                   double scale, double* const out[6], double* b) {
  const int padded = (rows.count + 15) & ~15;
  for (int i = 0; i < padded; i += 8) {
    D8 a[6];
    for (int r = 0; r < 6; ++r) {
      D8 sum = Load(rows.a[r] + i);
      for (int c = 0; c < r; ++c) sum = Fnma(Set1(L[r * 6 + c]), a[c], sum);
      a[r] = sum * Set1(inverse_diagonal[r]);
      Store(out[r] + i, a[r]);
    }
    Store(b + i, Set1(scale) * Load(rows.b + i));
  }
}

inline double SumOfLanes(D8 a) {
  Lanes lanes;
  lanes.Set(a);
  return ((lanes[0] + lanes[1]) + (lanes[2] + lanes[3])) +
         ((lanes[4] + lanes[5]) + (lanes[6] + lanes[7]));
}

template <bool kWithHessian>
int AddYielding(const YieldingRows& yielding, const double* x, double spring_stiffness,
                EnergyAt& at) {
  const D8 zero = Set1(0.0), stiffness = Set1(spring_stiffness);
  const D8 softness = Set1(1.0 / spring_stiffness);
  D8 xs[6], force[6], hessian[21], twice = zero;
  for (int c = 0; c < 6; ++c) xs[c] = Set1(x[c]);
  for (D8& sum : force) sum = zero;
  for (D8& sum : hessian) sum = zero;
  int pushing = 0;
  for (int i = 0; i < yielding.rows.count; i += 8) {
    D8 a[6], s = Load(yielding.rows.b + i);  // s: the overlap
    for (int c = 0; c < 6; ++c) {
      a[c] = Load(yielding.rows.a[c] + i);
      s = Fnma(a[c], xs[c], s);
    }
    D8 weight = SelectLess(zero, s, Load(yielding.weight + i), zero), push = weight * s;
    std::uint32_t rows = Less(zero, weight);
    if (rows != 0) twice = Fma(push, s, twice);
    if (yielding.threshold != nullptr) {
      // Up to its threshold P, the force of a row is k s while on its spring, and P beyond; twice
      // its energy is k s^2, and P (2 s - P / k).
      const D8 P = Load(yielding.threshold + i), above = SelectLess(zero, s, s, zero);
      const D8 spring = stiffness * above;
      const D8 below = SelectLess(spring, P, spring, SelectLess(zero, s, P, zero));
      twice = twice + SelectLess(spring, P, spring * above, below * (above + above - P * softness));
      push = push + below;
      rows |= Less(zero, below);
      weight = weight + SelectLess(zero, s, SelectLess(spring, P, stiffness, zero), zero);
    }
    Store(yielding.push + i, push);
    if (rows == 0) continue;
    pushing += __builtin_popcount(rows);
    for (int r = 0, k = 0; r < 6; ++r) {
      force[r] = Fma(push, a[r], force[r]);
      if constexpr (!kWithHessian) continue;
      const D8 wa = weight * a[r];
      for (int c = 0; c <= r; ++c, ++k) hessian[k] = Fma(wa, a[c], hessian[k]);
    }
  }
  for (int r = 0; r < 6; ++r) at.force[r] += SumOfLanes(force[r]);
  for (int k = 0; kWithHessian && k < 21; ++k) at.hessian[k] += SumOfLanes(hessian[k]);
  at.twice += SumOfLanes(twice);
  return pushing;
}

constexpr Kernels MakeKernels(const char* name) {
  return {name,        ExpandPairs,   BuildRows,          FindBelow,        FindGaps,
          LowestPoint, NearestEdges,  AdvanceSimplices,   RefreshPlanes,    FindUsedUp,
          Solve<6>,    Solve<12>,     Solve<24>,          Solve<48>,        SolveWithLimits<6>,
          RowsHold,    TransformRows, AddYielding<false>, AddYielding<true>};
}

}  // namespace
}  // namespace palpate
