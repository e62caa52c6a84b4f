#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace palpate {

/// What may be said of a mesh that is to be felt without a scene file.
struct MeshSceneOptions {
  std::string unit;     ///< what a number in the file means: m, cm, mm or inch; empty: guessed
  double ball_m = 0.0;  ///< radius of the tool [m]; 0: a twentieth of the mesh's longest side
};

/// A scene of one mesh and a ball to feel it with.
struct MeshScene {
  std::string name;
  std::string text;  ///< a scene file (catalogue/README.md)
  /// What was assumed, with how to change it: a sentence each.
  std::vector<std::string> assumptions;
};

/// Makes a scene of a mesh file.
/// `folder`: that the scene file is to stand in, which names the mesh from there.
/// Throws Error where the mesh cannot be read or rendered, or an option is wrong.
MeshScene MakeMeshScene(const std::string& mesh_file, const MeshSceneOptions& options,
                        const std::string& folder);

/// m or mm: in which a mesh whose longest side is so many units is nearer, by the ratio, to the
/// size of what a hand feels, 50 mm.
std::string_view GuessUnit(double longest_side);

}  // namespace palpate
