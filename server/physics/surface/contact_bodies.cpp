#include "server/physics/surface/contact_bodies.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <future>
#include <limits>

#include "common/error.h"
#include "common/math/solid_angle.h"
#include "common/program/machine.h"
#include "server/physics/limits.h"

namespace palpate {
namespace {

/// Returns whether two objects have the same geometry.
bool AreAlike(const PlacedTree& a, const PlacedTree& b) {
  const SphereTree &s = *a.tree, &t = *b.tree;
  return (a.mesh == b.mesh ||
          (a.mesh->vertices == b.mesh->vertices && a.mesh->triangles == b.mesh->triangles)) &&
         (a.tree == b.tree ||
          (s.leaf_triangle == t.leaf_triangle && s.leaf_triangle_begin == t.leaf_triangle_begin &&
           s.leaf_x == t.leaf_x && s.leaf_y == t.leaf_y && s.leaf_z == t.leaf_z &&
           s.leaf_radius == t.leaf_radius));
}

std::shared_ptr<const ContactShape> MakeShape(const PlacedTree* object) {
  const TriangleMesh& mesh = *object->mesh;
  const SphereTree& tree = *object->tree;
  auto shape = std::make_shared<ContactShape>(ContactMesh(mesh));
  if (object->for_balls) shape->mesh.KeepNormals();
  // For each triangle, of the leaves that list it, the one nearest to its middle;
  // of equals the first.
  shape->leaf.assign(mesh.triangles.size(), 0);
  std::vector<double> least(mesh.triangles.size(), std::numeric_limits<double>::infinity());
  for (std::size_t leaf = 0; leaf + 1 < tree.leaf_triangle_begin.size(); ++leaf) {
    const Vec3 c(tree.leaf_x[leaf], tree.leaf_y[leaf], tree.leaf_z[leaf]);
    for (auto i = tree.leaf_triangle_begin[leaf]; i < tree.leaf_triangle_begin[leaf + 1]; ++i) {
      const std::uint32_t t = tree.leaf_triangle[i];
      Vec3 middle = Vec3::Zero();
      for (std::uint32_t v : mesh.triangles[t]) middle += mesh.vertices[v] / 3.0;
      const double distance = (middle - c).norm() - tree.leaf_radius[leaf];
      if (distance >= least[t]) continue;
      least[t] = distance;
      shape->leaf[t] = static_cast<std::int32_t>(leaf);
    }
  }
  return shape;
}

/// Makes the shapes of objects, one for each core at a time.
std::vector<std::shared_ptr<const ContactShape>> MakeShapes(
    const std::vector<const PlacedTree*>& objects) {
  std::vector<std::shared_ptr<const ContactShape>> made(objects.size());
  std::atomic<std::size_t> begun = 0;
  const auto work = [&] {
    for (std::size_t i; (i = begun++) < made.size();) made[i] = MakeShape(objects[i]);
  };
  // If there is no thread for one, it runs at its end.
  std::vector<std::future<void>> workers(static_cast<std::size_t>(UsableCores()));
  for (auto& worker : workers) worker = std::async(work);
  for (auto& worker : workers) worker.get();
  return made;
}

/// How far a corner of a bur's mesh may lie outside its profile, over the bur's radius: the corners
/// of a round body's mesh lie on it, except for float rounding.
constexpr double kOfHead = 1e-3;

/// Returns the triangles whose corners all lie in the bur's profile; they never
/// meet what it clears.
std::vector<bool> HeadOf(const TriangleMesh& mesh, const Cutting& cutting) {
  const Pose X_BT = cutting.X_TB.Inverse();
  const auto is_in = [&](std::uint32_t vertex) {
    Vec3 gradient;
    return cutting.bur.Distance(X_BT * mesh.vertices[vertex], gradient) <=
           kOfHead * cutting.bur.radius();
  };
  std::vector<bool> head;
  for (const auto& t : mesh.triangles) head.push_back(std::ranges::all_of(t, is_in));
  return head;
}

}  // namespace

bool IsOver(const Vec3* corners, const Vec3& p, double reach) {
  const Vec3 normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
  for (int i = 0; i < 3; ++i) {
    const Vec3 out = (corners[(i + 1) % 3] - corners[i]).cross(normal);
    const double beyond = out.dot(p - corners[i]);
    if (beyond > 0.0 && beyond > reach * out.norm()) return false;  // seldom needs the root
  }
  return true;
}

std::optional<std::uint32_t> FaceAt(const ContactShape& shape, const Vec3& p, const Vec3& n,
                                    double apart, double turned) {
  const HullTree& tree = shape.tree;
  if (tree.IsOfBlocks()) return std::nullopt;
  std::array<HullTree::Node, 128> stack{tree.root()};
  for (std::size_t count = 1; count > 0;) {
    const HullTree::Node node = stack[--count];
    if ((p - tree.Centre(node)).norm() > tree.Radius(node) + apart) continue;
    if (!HullTree::IsLeaf(node)) {
      if (count + 2 > stack.size()) return std::nullopt;
      for (const HullTree::Node child : tree.inner(node).child) stack[count++] = child;
      continue;
    }
    const std::uint32_t t = HullTree::TriangleOf(node);
    const Vec3 corners[3] = {shape.mesh.Corner(t, 0), shape.mesh.Corner(t, 1),
                             shape.mesh.Corner(t, 2)};
    const Vec3& normal = shape.mesh.triangles()[t].normal;
    if (normal.cross(n).norm() <= turned && std::abs(normal.dot(p - corners[0])) <= apart &&
        IsOver(corners, p, limits::mesh::kRounding)) {
      return t;
    }
  }
  return std::nullopt;
}

bool TouchesByMesh(const PlacedTree& object) {
  return !object.is_cut &&
         std::none_of(object.materials.begin(), object.materials.end(),
                      [](const Material& m) { return std::isfinite(m.stiffness); });
}

std::vector<ContactBody> MakeBodies(std::span<const PlacedTree> objects) {
  std::vector<const PlacedTree*> distinct;
  std::vector<std::size_t> shape_of;
  std::vector<ContactBody> bodies;
  std::int32_t leaves = 0;
  for (const PlacedTree& object : objects) {
    const std::int32_t first_leaf = leaves;
    leaves += static_cast<std::int32_t>(object.tree->leaves());
    if (!TouchesByMesh(object)) continue;
    if (object.mesh == nullptr || object.mesh->triangles.empty() ||
        object.tree->leaf_triangle.empty()) {
      throw Error(
          "surface contact: an object has no mesh; give it one, or use \"contact\": \"spheres\"");
    }
    const auto alike = std::ranges::find_if(
        distinct, [&](const PlacedTree* other) { return AreAlike(object, *other); });
    shape_of.push_back(static_cast<std::size_t>(alike - distinct.begin()));
    if (alike == distinct.end()) distinct.push_back(&object);
    bodies.push_back(
        {nullptr, PlacementOf(object.X_WB), first_leaf, object.frame, object.tool, object.is_body});
  }
  const auto shapes = MakeShapes(distinct);
  for (std::size_t body = 0; body < bodies.size(); ++body) {
    bodies[body].shape = shapes[shape_of[body]];
  }
  return bodies;
}

std::size_t CountFrames(std::span<const ContactBody> bodies) {
  std::int32_t most = 0;
  for (const ContactBody& body : bodies) most = std::max(most, body.frame);
  return static_cast<std::size_t>(most) + 1;
}

bool Holds(const ContactShape& shape, const Vec3& p_S) {
  const ContactMesh& mesh = shape.mesh;
  const HullTree& tree = shape.tree;
  if ((p_S - tree.Centre(tree.root())).norm() > tree.Radius(tree.root())) return false;
  double angle = 0.0;
  for (std::size_t t = 0; t < mesh.triangles().size(); ++t) {
    angle += SolidAngle(mesh.Corner(t, 0) - p_S, mesh.Corner(t, 1) - p_S, mesh.Corner(t, 2) - p_S);
  }
  return angle > 2.0 * M_PI;
}

bool Hold(std::span<const ContactBody> bodies, const Vec3& p_B) {
  return std::ranges::any_of(bodies, [&](const ContactBody& body) {
    return (body.tool < 0 || body.is_body) && Holds(*body.shape, body.X_BS.Inverse() * p_B);
  });
}

std::unique_ptr<const MovingBody> MakeMovingBody(const TriangleMesh* mesh, const SphereTree& tree,
                                                 const Vec3& reference, const Cutting* cutting) {
  if (tree.leaves() == 1) {
    MovingBody ball(ContactMesh::Point());
    ball.radius = tree.leaf_radius[0];
    if (cutting != nullptr) ball.shank.reset();
    return std::make_unique<const MovingBody>(std::move(ball));
  }
  if (mesh == nullptr || mesh->triangles.empty()) {
    throw Error(
        "surface contact: the tool has no mesh; give it one, or use \"contact\": \"spheres\"");
  }
  ContactMesh about(*mesh, reference);
  if (cutting == nullptr) return std::make_unique<const MovingBody>(std::move(about));
  const std::vector<bool> head = HeadOf(*mesh, *cutting);
  const auto in_head = static_cast<std::size_t>(std::ranges::count(head, true));
  HullTree parts(about, head);
  MovingBody bur(std::move(about), std::move(parts));
  if (in_head == head.size()) bur.shank.reset();
  if (in_head > 0 && in_head < head.size()) bur.shank = bur.tree.inner(bur.tree.root()).child[1];
  return std::make_unique<const MovingBody>(std::move(bur));
}

}  // namespace palpate
