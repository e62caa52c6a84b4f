#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "scenes/mesh_import.h"
#include "scenes/scene.h"

namespace palpate {

/// Where a body's mesh comes from.
struct MeshSource {
  enum class Kind {
    kModel,  ///< a well-known mesh by its name: model_files.h
    kFile,   ///< a mesh file, `what` its path
    kBox,
    kEllipsoid,
    kSphere,
  };
  Kind kind = Kind::kFile;
  std::string what;           ///< name or path
  MeshPlacement placement;    ///< of models and files
  Vec3 size = Vec3::Zero();   ///< of shapes [m]: side lengths, or semi-axes
  std::size_t triangles = 0;  ///< of shapes: at least so many
  std::string where;          ///< "file:line: field", for complaints that come later
};

struct BodyDescription {
  std::string name;
  MeshSource mesh;
  std::size_t leaves = 0;
  Pose X_WB;
};

/// A scene as people write it (catalogue/README.md has every field).
struct SceneDescription {
  std::string name;
  std::vector<BodyDescription> tools, objects;
  Coupling coupling;
};

inline constexpr std::size_t kMaxLeaves = 1u << 20;

/// Checks every field; throws Error "file:line: field: what is wrong; remedy".
/// @param file  names the scene where the text does not; mesh paths are relative to its folder.
SceneDescription ParseScene(std::string_view text, const std::string& file);

}  // namespace palpate
