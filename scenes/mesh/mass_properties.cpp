#include "scenes/mesh/mass_properties.h"

#include <algorithm>
#include <map>
#include <utility>

namespace palpate {
namespace {

bool IsClosed(const TriangleMesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> balance;  // by edge, from low to high
  for (const auto& corners : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = corners[i], b = corners[(i + 1) % 3];
      balance[std::minmax(a, b)] += a < b ? 1 : -1;
    }
  }
  return std::ranges::all_of(balance, [](const auto& edge) { return edge.second == 0; });
}

}  // namespace

std::optional<MassProperties> MassOf(const TriangleMesh& mesh, const Pose& X_WB) {
  if (mesh.triangles.empty() || !IsClosed(mesh)) return std::nullopt;
  // About a vertex, so that far bodies lose no digits.
  const Vec3 origin = mesh.vertices[mesh.triangles[0][0]];
  double volume = 0.0;
  Vec3 first = Vec3::Zero();   // integral of x
  Mat3 second = Mat3::Zero();  // integral of x x^T
  for (const auto& corners : mesh.triangles) {
    const Vec3 a = mesh.vertices[corners[0]] - origin, b = mesh.vertices[corners[1]] - origin,
               c = mesh.vertices[corners[2]] - origin, sum = a + b + c;
    const double of = a.dot(b.cross(c)) / 6.0;
    volume += of;
    first += 0.25 * of * sum;
    second += of / 20.0 *
              (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
  }
  if (!(volume > 0.0)) return std::nullopt;
  const Vec3 centre = first / volume;
  second -= volume * centre * centre.transpose();
  const Mat3 inertia = second.trace() * Mat3::Identity() - second;
  const Mat3 R = X_WB.q.toRotationMatrix();
  return MassProperties{volume, X_WB * (origin + centre), R * inertia * R.transpose()};
}

}  // namespace palpate
