#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "scenes/files/mesh_scene.h"
#include "scenes/scene.h"
#include "scenes/tree/sphere_tree_builder.h"
#include "scenes/tree/tree_source.h"

namespace palpate {

struct LoadOptions {
  std::string models_dir;  ///< looked in first for models; empty: model_files.h
  std::string cache_dir;   ///< empty: $XDG_CACHE_HOME/palpate, else ~/.cache/palpate
  bool use_cache = true;
  /// In place of the scene file's; trees whose mode it leaves open follow (ChooseModes).
  std::optional<ContactModel> contact;
  /// Of every body whose tree is built; left out: as the scene file says.
  std::optional<TreeMode> tree;
  /// Of every body whose tree is built of more than one leaf; left out: as the scene file says.
  std::optional<LeafTolerance> leaves;
  /// Of the first object and whoever has its mesh, whatever the scene file says; nothing of it is
  /// cached.
  std::optional<TreeSource> tree_file;
  /// Of the whole scene, never going back; stages are "body 2 of 5, name: stage".  Only while
  /// something is built, or a mesh that is named in place of a scene is read.  In the threads that
  /// build, one at a time.
  Progress progress;
  /// Told what went wrong and was mended, such as a broken cache file.  Default: to standard error.
  std::function<void(const std::string&)> warn;
  /// So many are built at once, in threads; 0: as many as there are cores.  Whatever it is, the
  /// scene is the same, and so is what is told of it, warned and complained of, in the order of the
  /// scene file and in the caller's thread.
  std::size_t bodies_at_once = 0;
  MeshSceneOptions mesh;  ///< where a mesh file is named in place of a scene
  /// Told what was assumed of such a mesh, and how a tree from a file was brought to its mesh.
  /// Default: to standard error.
  std::function<void(const std::string&)> tell;
};

/// Loads a scene by its catalogue name ("bunny-bunny"), or from a scene file (.json), a bundle
/// (.palpate), or a mesh (mesh_import.h), which makes a scene with a ball to feel it
/// (mesh_scene.h). What must be built is kept in the cache.  Throws Error.
Scene LoadScene(const std::string& name_or_path, const LoadOptions& options = {});

/// What names a scene by its content: as servers, recordings and reports write it, 16 digits.
std::string SceneHash(const Scene& scene);
/// Packs what a program has put together into a file *.palpate, which LoadScene and the server
/// read, with remarks; a scene without a name gets the file's.  Throws Error.
void SaveScene(Scene scene, const std::string& file);

/// The scene file that a name stands for: NAME.json in $PALPATE_CATALOGUE, else in
/// the catalogue that comes with the programs (common/files/project_files.h).
std::string FindSceneFile(const std::string& name_or_path);

/// The scene file says that a session begins with the scene whole (SceneDescription).  False for
/// what is no scene file: a mesh, a bundle.  Throws Error.
bool IsWholeAtStart(const std::string& name_or_path);

/// The hand's script that stands, or would stand, beside that file: NAME.path.json.
std::string ScriptFileBeside(const std::string& name_or_path);

/// What palpate-replay score grades its trials by: NAME.criteria.json.
std::string CriteriaFileBeside(const std::string& name_or_path);

/// Names of the catalogue's scenes, sorted.
std::vector<std::string> CatalogueNames();

struct CatalogueEntry {
  std::string name, description;
};
/// The same, with what their files say of them.  Throws Error where a file is no JSON.
std::vector<CatalogueEntry> ListCatalogue();

}  // namespace palpate
