// The inner loops, included once by each kernels_*.cpp, which sets the instruction set.
#include "server/physics/simd/compliant.inl"
#include "server/physics/simd/dual_active_set.inl"
#include "server/physics/simd/kernels.h"
#include "server/physics/simd/vector.h"

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
  NodePair* end = out;
  for (int i = 0; i < count; ++i) {
    const std::int32_t t = in[i].tool;
    const ToolPacket& tool = level.tool[t];
    const SpherePacket& object = level.object[in[i].object];
    if (level.tool_stamp[t] != now) {
      level.tool_stamp[t] = now;
      TransformPacket(tool, pose, level.tool_world[t]);
    }
    std::uint64_t touching = TestPackets(level.tool_world[t], object);
    while (touching != 0) {
      const int bit = __builtin_ctzll(touching);
      touching &= touching - 1;
      *end++ = {tool.sphere.child[bit >> 3], object.child[bit & 7]};
    }
  }
  return static_cast<int>(end - out);
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

constexpr Kernels MakeKernels(const char* name) {
  return {name,     ExpandPairs, BuildRows<6>,          BuildRows<3>,
          Solve<6>, Solve<3>,    SolveCompliantRows<6>, SolveCompliantRows<3>};
}

}  // namespace
}  // namespace palpate
