#pragma once

#include <functional>
#include <vector>

#include <Eigen/Geometry>

#include "common/math/pose.h"
#include "scenes/scene.h"

namespace palpate {

/// A solid as a function of a point: negative inside, positive outside, about the distance near the
/// surface.  Organic shapes are combined from such functions.
using Field = std::function<double(const Vec3&)>;

/// The smaller and the larger of two values, blended if they differ by less than `blend`.  For two
/// fields they are a union and an intersection with a fillet (Quilez, "Smooth minimum").
double SmoothMin(double a, double b, double blend);
double SmoothMax(double a, double b, double blend);
/// Returns whether a exceeds b by so much that SmoothMin is b and SmoothMax is a, to the last bit,
/// with a margin for rounding.  A field may then skip the computation of the other value.
constexpr bool FarAbove(double a, double b, double blend) {
  return a - b >= 1.1 * blend;
}

Field EllipsoidField(const Vec3& centre, const Vec3& semi_axes);
/// Returns a cone with round ends, from a ball at a to a ball at b.
Field ConeField(const Vec3& a, double radius_a, const Vec3& b, double radius_b);
/// Returns the distance to the polyline, less the radius.
Field RopeField(const std::vector<Vec3>& points, double radius);
Field UnionOf(std::vector<Field> fields, double blend);
Field Without(Field from, Field what, double blend);

/// Makes a mesh of the surface where the field is 0: closed, manifold and oriented, with vertices
/// on the surface.  Uses marching tetrahedra over a body-centred cubic lattice, whose tetrahedra
/// are nearly regular, then smooths along the surface.  Details smaller than `cell` are lost.
/// @param box  contains the surface; throws Error if the surface leaves it, or there is none.
TriangleMesh MeshOfField(const Field& field, const Eigen::AlignedBox3d& box, double cell);

}  // namespace palpate
