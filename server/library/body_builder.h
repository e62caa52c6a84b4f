#pragma once

#include <cstddef>
#include <string>

#include "scenes/progress.h"
#include "scenes/scene.h"

namespace palpate {

/// How a mesh becomes a body.
struct BodyOptions {
  /// Number of leaves of its sphere tree.  0: 32 at most if the mesh is felt (BuildInnerTree); if
  /// the leaves are felt, as many as keep them within a 500th of the body's size (LeafTolerance).
  std::size_t leaves = 0;
  /// What contact uses (Features::contact): it decides how the leaves represent the mesh.
  ContactModel contact = ContactModel::kSurface;
  Material material{};  ///< objects: of all their leaves
  Progress progress{};
};

/// Returns a remark for people if the mesh is hardly of a size that a hand feels when its numbers
/// are metres, with the more likely unit; otherwise an empty string.  MakeBody and MakeBall add it
/// to the body's remarks.
std::string MetresRemark(const TriangleMesh& mesh);

/// Makes a body that can touch and be touched: repairs the mesh if needed (Body::remarks says how),
/// and builds its sphere tree.  Deterministic; takes seconds for thousands of leaves.
/// @param name     for messages, and in scenes
/// @param mesh     frame B [m]; open or closed, its faces counter-clockwise seen from outside
/// @param options  the defaults suit a mesh that is felt
/// Throws Error, which begins with the body's name, if no body can be made of the mesh.
Body MakeBody(std::string name, TriangleMesh mesh, const BodyOptions& options = {});

/// Makes a ball about the origin of B: one leaf, which is exact, and a mesh that represents it.
/// @param name      for messages, and in scenes
/// @param radius    [m], above 0
/// @param material  objects: of its one leaf
Body MakeBall(std::string name, double radius, const Material& material = {});

}  // namespace palpate
