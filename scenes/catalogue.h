#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "scenes/files/mesh_scene.h"
#include "scenes/scene.h"
#include "scenes/tree/sphere_tree_builder.h"

namespace palpate {

struct LoadOptions {
  std::string models_dir = {};  ///< searched for models first; empty: as model_files.h says
  std::string cache_dir = {};   ///< empty: $XDG_CACHE_HOME/palpate, else ~/.cache/palpate
  bool use_cache = true;
  /// Replaces the contact model of the scene file.  Trees whose mode the scene file leaves open get
  /// the mode that suits it (ChooseModes).
  std::optional<ContactModel> contact = {};
  /// Mode of every tree; unset: as the scene file says.
  std::optional<TreeMode> tree = {};
  /// Tolerance of every tree with more than one leaf; unset: as the scene file says.
  std::optional<LeafTolerance> leaves = {};
  /// Is told the progress of the whole scene, which never decreases; a stage reads "body 2 of 5,
  /// name: stage".  Called only while something is built, or while a mesh that is named in place of
  /// a scene is read; from the threads that build, never by two at once.
  Progress progress = {};
  /// Is told what went wrong and was repaired, such as a broken cache file.  Default: writes to
  /// standard error.
  std::function<void(const std::string&)> warn = {};
  /// Number of bodies that are built at the same time, one thread each; 0: one per core.  The scene
  /// does not depend on it, nor do messages, warnings and errors: they come in the order of the
  /// scene file, in the caller's thread.
  std::size_t bodies_at_once = 0;
  MeshSceneOptions mesh = {};  ///< for a mesh file that is named in place of a scene
  /// Is told what was assumed about such a mesh, and how many leaves a tolerance took.  Default:
  /// writes to standard error.
  std::function<void(const std::string&)> tell = {};
};

/// Loads a scene by its catalogue name ("bunny-bunny"), from a scene file (.json), from a bundle
/// (.palpate), or from a mesh (mesh_import.h), for which a scene with a ball to feel it is made
/// (mesh_scene.h).  What had to be built is kept in the cache.  Throws Error.
Scene LoadScene(const std::string& name_or_path, const LoadOptions& options = {});

/// Returns the hash of a scene's content, 16 digits: servers, recordings and reports identify the
/// scene by it.
std::string SceneHash(const Scene& scene);
/// Writes a scene that a program has put together to a file *.palpate, with its remarks, for
/// LoadScene and the server to read; a scene without a name gets the file's.  Throws Error.
void SaveScene(Scene scene, const std::string& file);

/// Returns the scene file for a name: NAME.json in $PALPATE_CATALOGUE, else in the catalogue that
/// comes with the programs, else among their exercises (common/files/project_files.h).
std::string FindSceneFile(const std::string& name_or_path);

/// Returns whether the scene file says that a session begins with the scene whole
/// (SceneDescription).  False for a mesh or a bundle.  Throws Error.
bool IsWholeAtStart(const std::string& name_or_path);

/// Returns the path of the hand's script beside a scene's file, NAME.path.json, which need not
/// exist; or of a tool's own, NAME.TOOL.path.json, if that exists.
std::string ScriptFileBeside(const std::string& name_or_path, const std::string& tool = "");

/// Returns the path of the criteria that palpate-replay score grades by: NAME.criteria.json.
std::string CriteriaFileBeside(const std::string& name_or_path);

/// Returns the names of the catalogue's scenes, sorted.
std::vector<std::string> CatalogueNames();

struct CatalogueEntry {
  std::string name, description;
};
/// Returns the names and the descriptions in their files.  Throws Error if a file is not JSON.
std::vector<CatalogueEntry> ListCatalogue();

}  // namespace palpate
