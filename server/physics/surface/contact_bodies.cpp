#include "server/physics/surface/contact_bodies.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <future>
#include <limits>
#include <thread>

#include "common/error.h"
#include "common/math/solid_angle.h"

namespace palpate {
namespace {

/// Leaves that list each triangle of a body's mesh.
class LeavesOfTriangle {
 public:
  LeavesOfTriangle(const SphereTree& tree, std::size_t triangles)
      : tree_(tree), begin_(triangles + 1, 0) {
    for (std::uint32_t t : tree.leaf_triangle) ++begin_[t + 1];
    for (std::size_t t = 0; t < triangles; ++t) begin_[t + 1] += begin_[t];
    leaf_.resize(tree.leaf_triangle.size());
    std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
    for (std::uint32_t leaf = 0; leaf + 1 < tree.leaf_triangle_begin.size(); ++leaf) {
      for (std::uint32_t i = tree.leaf_triangle_begin[leaf]; i < tree.leaf_triangle_begin[leaf + 1];
           ++i) {
        leaf_[next[tree.leaf_triangle[i]]++] = leaf;
      }
    }
  }

  std::uint32_t Nearest(std::uint32_t triangle, const Vec3& p) const {
    std::uint32_t nearest = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::uint32_t i = begin_[triangle]; i < begin_[triangle + 1]; ++i) {
      const std::uint32_t leaf = leaf_[i];
      const Vec3 c(tree_.leaf_x[leaf], tree_.leaf_y[leaf], tree_.leaf_z[leaf]);
      const double distance = (p - c).norm() - tree_.leaf_radius[leaf];
      if (distance < least) {
        least = distance;
        nearest = leaf;
      }
    }
    return nearest;
  }

 private:
  const SphereTree& tree_;
  std::vector<std::uint32_t> begin_, leaf_;
};

ContactBody MakeBody(const PlacedTree* object, std::int32_t first_leaf) {
  const TriangleMesh& mesh = *object->mesh;
  const LeavesOfTriangle leaves(*object->tree, mesh.triangles.size());
  ContactBody body(ContactMesh(mesh, object->X_WB));
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    Vec3 middle = Vec3::Zero();
    for (std::uint32_t v : mesh.triangles[t]) middle += mesh.vertices[v] / 3.0;
    body.leaf.push_back(first_leaf + static_cast<std::int32_t>(leaves.Nearest(t, middle)));
  }
  return body;
}

}  // namespace

bool IsFeltByMesh(const PlacedTree& object) {
  return !object.is_cut &&
         std::none_of(object.materials.begin(), object.materials.end(), [](const Material& m) {
           return std::isfinite(m.stiffness) || std::isfinite(m.hardness);
         });
}

std::unique_ptr<const ContactBodies> ContactBodies::Make(std::span<const PlacedTree> objects) {
  std::vector<const PlacedTree*> felt;
  std::vector<std::int32_t> first_leaf;
  std::int32_t leaves = 0;
  for (const PlacedTree& object : objects) {
    const std::int32_t first = leaves;
    leaves += static_cast<std::int32_t>(object.tree->leaves());
    if (!IsFeltByMesh(object)) continue;
    if (object.mesh == nullptr || object.mesh->triangles.empty() ||
        object.tree->leaf_triangle.empty()) {
      throw Error(
          "surface contact: an object has no mesh; give it one, or use \"contact\": \"spheres\"");
    }
    felt.push_back(&object);
    first_leaf.push_back(first);
  }
  if (felt.empty()) return nullptr;
  auto made = std::make_unique<ContactBodies>();
  made->bodies_.reserve(felt.size());
  // As many at once as there are cores.
  const std::size_t at_once = std::max(std::thread::hardware_concurrency(), 1u);
  std::deque<std::future<ContactBody>> making;
  std::size_t begun = 0;
  for (std::size_t body = 0; body < felt.size(); ++body) {
    for (; begun < std::min(felt.size(), body + at_once + 1); ++begun) {
      // Where there is no thread: at get().
      making.push_back(std::async(MakeBody, felt[begun], first_leaf[begun]));
    }
    made->bodies_.push_back(making.front().get());
    making.pop_front();
  }
  return made;
}

bool ContactBodies::Hold(const Vec3& p_W) const {
  return std::ranges::any_of(bodies_, [&](const ContactBody& body) {
    const HullTree& tree = body.tree;
    if ((p_W - tree.Centre(tree.root())).norm() > tree.Radius(tree.root())) return false;
    double angle = 0.0;
    for (std::size_t t = 0; t < body.mesh.triangles().size(); ++t) {
      angle += SolidAngle(body.mesh.Corner(t, 0) - p_W, body.mesh.Corner(t, 1) - p_W,
                          body.mesh.Corner(t, 2) - p_W);
    }
    return angle > 2.0 * M_PI;
  });
}

std::unique_ptr<const ContactBody> MakeToolBody(const TriangleMesh* mesh, const SphereTree& tree,
                                                const Vec3& reference) {
  if (tree.leaves() == 1) {
    return std::make_unique<const ContactBody>(ContactMesh::Point(), tree.leaf_radius[0]);
  }
  if (mesh == nullptr || mesh->triangles.empty()) {
    throw Error(
        "surface contact: the tool has no mesh; give it one, or use \"contact\": \"spheres\"");
  }
  return std::make_unique<const ContactBody>(
      ContactMesh(*mesh, Pose{-reference, Quat::Identity()}));
}

}  // namespace palpate
