#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/math/pose.h"
#include "scenes/scene.h"

namespace palpate {

using Colour = Eigen::Array3d;  ///< linear RGB, each 0 to 1

/// A square picture of bodies in parallel projection: x to the right, y down, z towards the eye.
class Tile {
 public:
  static constexpr int kSide = 480;  ///< [pixels]

  /// @param centre, radius  of the ball that fills most of the picture [m].
  Tile(const Vec3& centre, double radius);
  /// Uses the ball round a mesh.
  explicit Tile(const TriangleMesh& mesh);

  void Draw(const TriangleMesh& mesh, const Colour& colour);
  void DrawSphere(const Vec3& centre, double radius, const Colour& colour);
  /// Darkens hollows: each pixel by the share of points around it that are nearer to the eye.
  void ShadeHollows();

  Colour At(int x, int y) const;

 private:
  static constexpr int kOversampling = 2;  ///< in each direction; averaged at the end
  static constexpr int kFine = kSide * kOversampling;

  Vec3 ToPixels(const Vec3& p) const;
  void DrawTriangle(const std::array<Vec3, 3>& p, const std::array<Vec3, 3>& n,
                    const Colour& colour);
  void Put(int x, int y, double z, const Vec3& normal, const Colour& colour);

  Vec3 centre_;
  double scale_;  ///< pixels per metre
  Mat3 view_;
  std::vector<double> depth_;
  std::vector<Colour> colour_;
};

}  // namespace palpate
