#include "tests/support/curved_bodies.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "common/error.h"
#include "common/math/rotation.h"
#include "scenes/shapes/shapes.h"

namespace palpate::test {
namespace {

/// Adds a grid that is closed along i, and along j too if `closed`.
template <class At>
void AddTube(TriangleMesh& mesh, int around, int along, bool closed, At at) {
  for (int j = 0; j < (closed ? along : along + 1); ++j) {
    for (int i = 0; i < around; ++i) mesh.vertices.push_back(at(i, j));
  }
  const auto corner = [&](int i, int j) {
    return static_cast<std::uint32_t>((closed ? j % along : j) * around + i % around);
  };
  for (int j = 0; j < along; ++j) {
    for (int i = 0; i < around; ++i) {
      const std::uint32_t a = corner(i, j), b = corner(i + 1, j), c = corner(i + 1, j + 1),
                          d = corner(i, j + 1);
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({a, c, d});
    }
  }
}

TriangleMesh Cylinder(double radius, double half, std::size_t triangles) {
  const double square = std::sqrt(0.5 * static_cast<double>(triangles) * M_PI * radius / half);
  const int around = std::max(8, static_cast<int>(square));
  const int along = std::max(2, static_cast<int>(0.5 * static_cast<double>(triangles) / around));
  TriangleMesh mesh;
  AddTube(mesh, around, along, false, [&](int i, int j) {
    const double angle = 2.0 * M_PI * i / around;
    return Vec3(radius * std::cos(angle), radius * std::sin(angle), half * (2.0 * j / along - 1.0));
  });
  for (const double end : {-1.0, 1.0}) {
    const auto first = static_cast<std::uint32_t>(end < 0.0 ? 0 : around * along);
    const auto middle = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.push_back({0.0, 0.0, end * half});
    for (int i = 0; i < around; ++i) {
      const auto a = first + static_cast<std::uint32_t>(i),
                 b = first + static_cast<std::uint32_t>((i + 1) % around);
      mesh.triangles.push_back(end < 0.0 ? std::array{b, a, middle} : std::array{a, b, middle});
    }
  }
  return mesh;
}

TriangleMesh Torus(double ring, double tube, std::size_t triangles) {
  const double square = std::sqrt(0.5 * static_cast<double>(triangles) * ring / tube);
  const int around = std::max(8, static_cast<int>(square));
  const int across = std::max(8, static_cast<int>(0.5 * static_cast<double>(triangles) / around));
  TriangleMesh mesh;
  AddTube(mesh, around, across, true, [&](int i, int j) {
    const double a = 2.0 * M_PI * i / around, b = 2.0 * M_PI * j / across;
    const double out = ring + tube * std::cos(b);
    return Vec3(out * std::cos(a), out * std::sin(a), tube * std::sin(b));
  });
  return mesh;
}

/// Returns the point of an ellipsoid nearest to p, a_i^2 p_i / (a_i^2 + t), by Newton's method.
Vec3 NearestOfEllipsoid(const Vec3& axes, const Vec3& p) {
  const Vec3 squares = axes.cwiseProduct(axes);
  double t = 0.0;
  for (int i = 0; i < 30; ++i) {
    const Vec3 sum = squares + Vec3::Constant(t);
    const Vec3 part = axes.cwiseProduct(p).cwiseQuotient(sum);
    const double value = part.squaredNorm() - 1.0;
    t += value / (2.0 * part.cwiseProduct(part).cwiseQuotient(sum).sum());
    if (std::abs(value) < 1e-15) break;
  }
  return squares.cwiseProduct(p).cwiseQuotient(squares + Vec3::Constant(t));
}

}  // namespace

CurvedBody::CurvedBody(std::string_view kind, std::size_t triangles, Random& random) {
  const auto at = std::find(kCurvedKinds.begin(), kCurvedKinds.end(), kind);
  if (at == kCurvedKinds.end()) {
    throw Error("no curved body is called '" + std::string(kind) + "'");
  }
  kind_ = static_cast<Kind>(at - kCurvedKinds.begin());
  const double size = random.Uniform(0.015, 0.03), y = random.Uniform(0.65, 1.0),
               z = random.Uniform(0.65, 1.0);
  switch (kind_) {
    case Kind::kSphere:
    case Kind::kEllipsoid: {
      size_ = kind_ == Kind::kSphere ? Vec3::Constant(size) : Vec3(size * Vec3(1.0, y, z));
      // Divisions multiply by 4; the nearest of them.
      mesh_ = MakeEllipsoid(size_, static_cast<std::size_t>(0.8 * static_cast<double>(triangles)));
      const double longest = size_.maxCoeff(), shortest = size_.minCoeff();
      greatest_ = longest / (shortest * shortest);
      least_ = shortest / (longest * longest);
      break;
    }
    case Kind::kCylinder:
      size_ = {0.7 * size, 0.03, 0.0};
      mesh_ = Cylinder(size_.x(), size_.y(), triangles);
      greatest_ = 1.0 / size_.x();
      break;
    case Kind::kTorus:
      size_ = {0.025 + 0.3 * size, 0.5 * size, 0.0};
      mesh_ = Torus(size_.x(), size_.y(), triangles);
      greatest_ = 1.0 / size_.y();
      least_ = -1.0 / (size_.x() - size_.y());
      break;
  }
  Measure();
}

CurvedBody::Point CurvedBody::Nearest(const Vec3& p) const {
  const Vec3 aside = Vec3(p.x(), p.y(), 0.0).normalized();
  switch (kind_) {
    case Kind::kSphere:
      return {size_.x() * p.normalized(), p.normalized()};
    case Kind::kEllipsoid: {
      const Vec3 on = NearestOfEllipsoid(size_, p);
      return {on, on.cwiseQuotient(size_.cwiseProduct(size_)).normalized()};
    }
    case Kind::kCylinder:
      return {size_.x() * aside + Vec3(0.0, 0.0, p.z()), aside};
    case Kind::kTorus:
      break;
  }
  const Vec3 middle = size_.x() * aside, normal = (p - middle).normalized();
  return {middle + size_.y() * normal, normal};
}

CurvedBody::Point CurvedBody::Start(bool convex, Vec3& along, Random& random) const {
  const Vec3 direction = random.Direction(), other = random.Direction();
  const double angle = random.Uniform(-M_PI, M_PI), height = random.Uniform(-0.005, 0.005);
  Vec3 p = 0.02 * direction;
  if (kind_ == Kind::kCylinder) p = {std::cos(angle), std::sin(angle), height};
  if (kind_ == Kind::kTorus) {
    const Vec3 out(std::cos(angle), std::sin(angle), 0.0);
    p = size_.x() * out +
        size_.y() * (convex ? Vec3(out + 20.0 * height * Vec3::UnitZ()) : direction);
  }
  const Point start = Nearest(p);
  along = other;
  if (kind_ == Kind::kTorus && convex) {
    along = Vec3::UnitZ().cross(p).normalized() + 60.0 * height * Vec3::UnitZ();
  }
  along = (along - along.dot(start.normal) * start.normal).normalized();
  return start;
}

void CurvedBody::Measure() {
  for (const auto& [i, j, k] : mesh_.triangles) {
    const std::array<Vec3, 3> corner{mesh_.vertices[i], mesh_.vertices[j], mesh_.vertices[k]};
    const Vec3 facet = (corner[1] - corner[0]).cross(corner[2] - corner[0]).normalized();
    double sagitta = 0.0, angle = 0.0, edge = 0.0;
    bool is_lid = false;
    for (std::size_t c = 0; c < 3; ++c) {
      const Point on = Nearest(corner[c]);
      is_lid = is_lid || on.normal.isZero();  // the middle of one lies on the axis
      angle = std::max(angle, std::atan2(facet.cross(on.normal).norm(), facet.dot(on.normal)));
      const Vec3 middle = 0.5 * (corner[c] + corner[(c + 1) % 3]);
      sagitta = std::max(sagitta, (Nearest(middle).at - middle).norm());
      edge = std::max(edge, (corner[c] - middle).norm());
    }
    if (is_lid) continue;
    sagitta_ = std::max(sagitta_, 4.0 / 3.0 * sagitta);
    facet_angle_ = std::max(facet_angle_, angle);
    longest_edge_ = std::max(longest_edge_, 2.0 * edge);
  }
}

}  // namespace palpate::test
