#pragma once

#include <cstddef>
#include <string>

#include "scenes/progress.h"
#include "scenes/scene.h"

namespace palpate {

/// How a mesh becomes a body.
struct BodyOptions {
  /// Leaves of its sphere tree.  0: a few where the mesh is what is felt (BuildInnerTree); where
  /// the leaves are, as many as bring them within a 500th of the body's size (LeafTolerance).
  std::size_t leaves = 0;
  /// What the scene is felt by (Features::contact): it decides how the leaves stand for the mesh.
  ContactModel contact = ContactModel::kSurface;
  Material material{};  ///< objects: of all of it
  Progress progress{};
};

/// For people: that a mesh hardly has the size that a hand feels where its numbers are metres, and
/// which unit they more likely are in; else empty.  MakeBody and MakeBall have it among the body's
/// remarks.
std::string MetresRemark(const TriangleMesh& mesh);

/// Makes of a mesh what can touch and be touched: mends it where that is needed (Body::remarks says
/// what was done), and builds its sphere tree.  Deterministic; seconds for thousands of leaves.
/// @param name     for messages, and in scenes.
/// @param mesh     frame B [m]; open or closed, its faces counter-clockwise seen from outside.
/// @param options  what is not said has a default that suits a mesh that is felt.
/// Throws Error, which begins with the body's name, where nothing can be made of the mesh.
Body MakeBody(std::string name, TriangleMesh mesh, const BodyOptions& options = {});

/// A ball round the origin of B: one leaf, which is exact, and a mesh that stands for it.
/// @param name      for messages, and in scenes.
/// @param radius    [m], above 0.
/// @param material  objects: of its one leaf.
Body MakeBall(std::string name, double radius, const Material& material = {});

}  // namespace palpate
