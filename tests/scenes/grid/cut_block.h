#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>

#include "scenes/grid/cut_field.h"
#include "scenes/shapes/shapes.h"

namespace palpate::test {

/// A block in a frame P with its face at z = 0; q rotates P into the grid's frame.
struct CutBlock {
  CutBlock(double spacing, const Quat& q_BP,
           std::function<std::uint8_t(const Vec3&)> material = nullptr, std::size_t blocks = 0)
      : q(q_BP),
        solid(MeshOf(q_BP), {.spacing = spacing, .most_bytes = 512u << 20, .material = material},
              "block"),
        cut(solid, 512u << 20, "block", blocks) {}

  static Vec3 Size() { return {1.8e-3, 1.6e-3, 0.8e-3}; }
  static TriangleMesh MeshOf(const Quat& q) {
    TriangleMesh mesh = MakeBox(Size());
    for (Vec3& v : mesh.vertices) v = q * (v - Vec3(0, 0, 0.4e-3));
    return mesh;
  }

  /// Cuts along a line in steps of at most `length`; the bur's axis is P's z, turned by `tilt`.
  /// @returns whether storage ran out.
  bool Go(const Bur& bur, const Vec3& from_P, const Vec3& to_P, double length = 3e-6,
          const Quat& tilt = Quat::Identity()) {
    bool full = false;
    const int steps = std::max(1, static_cast<int>(std::ceil((to_P - from_P).norm() / length)));
    const Vec3 step = q * ((to_P - from_P) / steps);
    for (int n = 0; n < steps; ++n) {
      full |= cut.Remove(bur, {q * from_P + n * step, q * tilt}, step).full;
    }
    return full;
  }

  /// As Go, but also measures the removed volume, which takes longer.
  struct Moved {
    std::array<double, SolidGrid::kMaterials> volume;  ///< removed, of each material [m^3]
    bool full = false;
    double total() const { return std::accumulate(volume.begin(), volume.end(), 0.0); }
  };
  Moved Move(const Bur& bur, const Vec3& from_P, const Vec3& to_P, double length = 3e-6,
             const Quat& tilt = Quat::Identity()) {
    Moved moved{cut.VolumeLeft()};
    moved.full = Go(bur, from_P, to_P, length, tilt);
    const auto left = cut.VolumeLeft();
    for (std::size_t m = 0; m < left.size(); ++m) moved.volume[m] -= left[m];
    return moved;
  }

  Quat q;
  SolidGrid solid;
  CutField cut;
};

}  // namespace palpate::test
