#pragma once

#include <string>

#include <assimp/Exporter.hpp>
#include <assimp/scene.h>

#include "common/error.h"
#include "scenes/shapes/shapes.h"

namespace palpate::test {

/// Returns a box of 1 x 2 x 3, written by assimp in one of its formats.
inline std::string ExportBox(const std::string& format, const std::string& file) {
  const TriangleMesh box = MakeBox(Vec3(1, 2, 3));
  aiScene scene;  // owns what follows
  scene.mRootNode = new aiNode("root");
  scene.mNumMaterials = 1;
  scene.mMaterials = new aiMaterial* [1] { new aiMaterial };
  scene.mNumMeshes = 1;
  scene.mMeshes = new aiMesh* [1] { new aiMesh };
  scene.mRootNode->mNumMeshes = 1;
  scene.mRootNode->mMeshes = new unsigned[1]{0};
  aiMesh& mesh = *scene.mMeshes[0];
  mesh.mPrimitiveTypes = aiPrimitiveType_TRIANGLE;
  mesh.mNumVertices = box.vertices.size();
  mesh.mVertices = new aiVector3D[box.vertices.size()];
  for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
    const Vec3& v = box.vertices[i];
    mesh.mVertices[i] = aiVector3D(v.x(), v.y(), v.z());
  }
  mesh.mNumFaces = box.triangles.size();
  mesh.mFaces = new aiFace[box.triangles.size()];
  for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
    mesh.mFaces[i].mNumIndices = 3;
    mesh.mFaces[i].mIndices =
        new unsigned[3]{box.triangles[i][0], box.triangles[i][1], box.triangles[i][2]};
  }
  Assimp::Exporter exporter;
  if (exporter.Export(&scene, format, file) != aiReturn_SUCCESS) {
    throw Error(format + ": " + exporter.GetErrorString());
  }
  return file;
}

}  // namespace palpate::test
