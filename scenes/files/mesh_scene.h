#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace palpate {

/// Options for a mesh that is to be felt without a scene file.
struct MeshSceneOptions {
  std::string unit;     ///< unit of the mesh file: m, cm, mm or inch; empty: guessed
  double ball_m = 0.0;  ///< radius of the tool [m]; 0: a twentieth of the mesh's longest side
};

/// A scene made of one mesh and a ball to feel it with.
struct MeshScene {
  std::string name;
  std::string text;  ///< a scene file (catalogue/README.md)
  /// What was assumed and how to change it, a sentence each.
  std::vector<std::string> assumptions;
};

/// Makes a scene of a mesh file.
/// `folder`: the folder in which the scene file will be, and from which it names the mesh.
/// Throws Error if the mesh cannot be read or rendered, or an option is wrong.
MeshScene MakeMeshScene(const std::string& mesh_file, const MeshSceneOptions& options,
                        const std::string& folder);

/// Returns m or mm: the unit in which a mesh with that longest side is nearer, by ratio, to 50 mm,
/// the size of what a hand feels.
std::string_view GuessUnit(double longest_side);

}  // namespace palpate
