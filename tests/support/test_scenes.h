#pragma once

#include <string>
#include <utility>
#include <vector>

#include "scenes/scene.h"
#include "scenes/shapes/shapes.h"
#include "scenes/tree/sphere_tree_builder.h"

namespace palpate::test {

/// Makes a body with its sphere tree, as a scene file would.
inline Body MakeBody(std::string name, TriangleMesh mesh, std::size_t leaves,
                     const Pose& X_WB = {}) {
  Body body;
  body.name = std::move(name);
  body.mesh = std::move(mesh);
  body.tree = BuildSphereTree(body.mesh, leaves);
  body.X_WB = X_WB;
  return body;
}

/// Makes a body for contact with its mesh from outside.  A leaf only identifies a part of the mesh,
/// for which some of its vertices suffice; fitting balls would take longer than most tests.
inline Body MakeMeshBody(std::string name, TriangleMesh mesh, const Pose& X_WB = {}) {
  std::vector<Sphere> leaves;
  const std::size_t stride = mesh.vertices.size() / 64 + 1;
  for (std::size_t v = 0; v < mesh.vertices.size(); v += stride) {
    leaves.push_back({mesh.vertices[v], 1e-6});
  }
  Body body;
  body.name = std::move(name);
  body.tree = TreeOverBalls(mesh, leaves);
  body.mesh = std::move(mesh);
  body.X_WB = X_WB;
  return body;
}

/// The same with a tree that is a rough model of its inside, as a scene file makes it.
inline Body MakeSolidBody(std::string name, TriangleMesh mesh) {
  Body body;
  body.name = std::move(name);
  body.tree = BuildInnerTree(mesh);
  body.mesh = std::move(mesh);
  return body;
}

inline Scene MakeScene(TriangleMesh tool, std::size_t tool_leaves, TriangleMesh object,
                       std::size_t object_leaves, ContactModel contact) {
  Scene scene;
  scene.name = "test";
  scene.tools.push_back(MakeBody("tool", std::move(tool), tool_leaves));
  scene.objects.push_back(MakeBody("object", std::move(object), object_leaves));
  scene.features.contact = contact;
  return scene;
}

/// Makes a scene in which contact is between the meshes.
inline Scene MeshScene(TriangleMesh tool, TriangleMesh object) {
  Scene scene;
  scene.name = "test";
  scene.tools.push_back(MakeMeshBody("tool", std::move(tool)));
  scene.objects.push_back(MakeMeshBody("object", std::move(object)));
  return scene;
}

/// Makes a tool that is a ball for contact.
inline Body BallBody(double radius) {
  Body ball;
  ball.name = "ball";
  ball.mesh = MakeSphere(radius, 320);
  ball.tree = SingleSphereTree(ball.mesh, {Vec3::Zero(), radius});
  return ball;
}

}  // namespace palpate::test
