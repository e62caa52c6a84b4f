#pragma once

#include <functional>
#include <vector>

#include <Eigen/Geometry>

#include "common/math/pose.h"
#include "scenes/scene.h"

namespace palpate {

/// A solid as a function of the point: below 0 inside, above 0 outside, about the distance near the
/// surface.  What organic shapes are put together from.
using Field = std::function<double(const Vec3&)>;

/// Smaller and larger of two values, rounded where they are nearer than `blend`: of two fields, a
/// union and an intersection whose seam is a fillet (Quilez, "Smooth minimum").
double SmoothMin(double a, double b, double blend);
double SmoothMax(double a, double b, double blend);
/// Whether a is so far above b that SmoothMin is b and SmoothMax is a, to the last bit: what a
/// field asks of a bound before it works out the other, with room for how the bound is rounded.
constexpr bool FarAbove(double a, double b, double blend) {
  return a - b >= 1.1 * blend;
}

Field EllipsoidField(const Vec3& centre, const Vec3& semi_axes);
/// Cone with round ends, from a ball at a to a ball at b.
Field ConeField(const Vec3& a, double radius_a, const Vec3& b, double radius_b);
/// Distance to the polyline, less the radius.
Field RopeField(const std::vector<Vec3>& points, double radius);
Field UnionOf(std::vector<Field> fields, double blend);
Field Without(Field from, Field what, double blend);

/// Mesh of the surface where the field is 0: closed, manifold and oriented, with vertices on the
/// surface, by marching tetrahedra over a body-centred cubic lattice, whose tetrahedra are nearly
/// regular; then smoothed along the surface.  Details smaller than `cell` are lost.
/// @param box  holds the surface; throws Error where the surface leaves it, or where there is none.
TriangleMesh MeshOfField(const Field& field, const Eigen::AlignedBox3d& box, double cell);

}  // namespace palpate
