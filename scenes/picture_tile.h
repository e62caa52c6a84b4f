#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "common/math/pose.h"
#include "scenes/mesh/surface_samples.h"
#include "scenes/scene.h"

namespace palpate {

using Colour = Eigen::Array3d;  ///< linear, 0 to 1

/// One square picture of bodies, seen by a distant eye: x to the right, y down, z towards the eye.
class Tile {
 public:
  static constexpr int kSide = 480;  ///< [pixels]

  /// @param centre, radius  ball that fills most of the picture [m].
  Tile(const Vec3& centre, double radius);
  /// The same of the ball round a mesh.
  explicit Tile(const TriangleMesh& mesh);

  void Draw(const TriangleMesh& mesh, const Colour& colour);
  void DrawSphere(const Vec3& centre, double radius, const Colour& colour);
  /// Darkens what lies in hollows: the share of points around that stand nearer to the eye.
  void ShadeHollows();

  /// Gives what is seen of a mesh other colours, and less shade, so that colours can be compared.
  /// @param mesh      the last that was drawn.
  /// @param colours   of points of its surface, with their triangles' normals; as many.
  void Paint(const TriangleMesh& mesh,
             const std::function<std::vector<Colour>(const std::vector<SurfaceSample>&)>& colours);

  Colour At(int x, int y) const;

 private:
  static constexpr int kOversampling = 2;  ///< each way, averaged away in the end
  static constexpr int kFine = kSide * kOversampling;

  Vec3 ToPixels(const Vec3& p) const;
  Vec3 FromPixels(int x, int y, double z) const;
  void DrawTriangle(std::uint32_t triangle, const std::array<Vec3, 3>& p,
                    const std::array<Vec3, 3>& n, const Colour& colour);
  bool Put(int x, int y, double z, const Vec3& normal, const Colour& colour);

  Vec3 centre_;
  double scale_;  ///< pixels per metre
  Mat3 view_;
  std::vector<double> depth_;
  std::vector<Colour> colour_;
  std::vector<std::uint32_t> triangle_;  ///< of the last mesh; kNothing: none of it is seen there
};

}  // namespace palpate
