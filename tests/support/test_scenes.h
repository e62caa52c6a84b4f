#pragma once

#include <string>
#include <utility>

#include "scenes/scene.h"
#include "scenes/tree/sphere_tree_builder.h"

namespace palpate::test {

/// A body with its sphere tree, as a scene file would make it.
inline Body MakeBody(std::string name, TriangleMesh mesh, std::size_t leaves,
                     const Pose& X_WB = {}) {
  Body body;
  body.name = std::move(name);
  body.mesh = std::move(mesh);
  body.tree = BuildSphereTree(body.mesh, leaves);
  body.X_WB = X_WB;
  return body;
}

/// A scene of one tool and one object.
inline Scene MakeScene(TriangleMesh tool, std::size_t tool_leaves, TriangleMesh object,
                       std::size_t object_leaves, ContactModel contact) {
  Scene scene;
  scene.name = "test";
  scene.tools.push_back(MakeBody("tool", std::move(tool), tool_leaves));
  scene.objects.push_back(MakeBody("object", std::move(object), object_leaves));
  scene.features.contact = contact;
  return scene;
}

}  // namespace palpate::test
