#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/json/json_file.h"
#include "scenes/mesh/curved_mesh.h"
#include "scenes/mesh/mesh_import.h"
#include "scenes/mesh/units.h"
#include "scenes/scene.h"
#include "scenes/tree/leaf_count.h"
#include "scenes/tree/sphere.h"
#include "scenes/tree/tree_source.h"

namespace palpate {

/// Where a body's mesh comes from.
struct MeshSource {
  enum class Kind {
    kModel,  ///< a well-known mesh by its name: model_files.h
    kFile,   ///< a mesh file, `what` its path
    kBox,
    kEllipsoid,
    kSphere,
    kShape,  ///< `what` names one of shape_kinds.h
  };
  Kind kind = Kind::kFile;
  std::string what;                     ///< name or path
  MeshPlacement placement;              ///< of models and files
  Vec3 size = Vec3::Zero();             ///< of shapes [m]: side lengths, or semi-axes
  std::size_t triangles = 0;            ///< of shapes: at least so many
  std::size_t variant = 0;              ///< of a kShape
  std::vector<double> values;           ///< of a kShape: its parameters in SI
  std::optional<CurvedOptions> curved;  ///< none: the triangles are taken as they are
  std::optional<double> thickness;      ///< of a model's or file's open pieces [m]; none: stay open
  std::string where;                    ///< "file:line: field", for complaints that come later
};

/// A material as written.  What a Young's modulus means is known once there are leaves.
struct MaterialDescription {
  Material material;            ///< its stiffness counts where there is no modulus
  double youngs_modulus = 0.0;  ///< E [Pa]; 0: none is given
  double thickness = 0.0;       ///< L of the layer that gives way [m]
  std::string where;            ///< "file:line: field", for complaints that come later
};

/// Leaves of a body that are of another material than the body.
struct RegionDescription {
  enum class Kind {
    kBox,     ///< leaves whose centre lies in `box`
    kSphere,  ///< leaves whose centre lies in `ball`
    kGroup,   ///< leaves most of whose surface is of the mesh file's part `group`
    kMesh,    ///< of what burs cut: what lies within `mesh`, which is given in frame B
  };
  Kind kind = Kind::kBox;
  Eigen::AlignedBox3d box;  ///< frame B [m]
  Sphere ball;              ///< frame B [m]
  std::string group;
  MeshSource mesh;
  MaterialDescription material;
  std::string where;
};

struct BodyDescription {
  std::string name;
  MeshSource mesh;
  /// 0: as many as the tolerance needs, or as the tree's file has; without either, as ChooseLeaves
  /// says.
  std::size_t leaves = 0;
  std::optional<LeafTolerance> tolerance;  ///< of a tree that is built, where its leaves say none
  TreeSource tree;
  bool tree_left_open = true;  ///< its mode follows the contact: ChooseModes
  bool mesh_alone = false;     ///< nothing asks for its leaves but a start: ChooseLeaves
  Pose X_WB;
  MaterialDescription material;            ///< objects: of what no region paints
  std::vector<RegionDescription> regions;  ///< objects: later ones over earlier ones
  std::optional<double> grid;              ///< objects that burs cut: spacing [m]
  BurSpin spin;                            ///< tools that are burs
  std::optional<BurProfile> edge;          ///< tools that cut by an edge of their mesh
  std::string edge_where;                  ///< "file:line: field"
  std::string look;                        ///< one of kLooks; empty: what its material is
};

/// What viewers know how to draw.  That of teeth, gums, tongues and probes follows the frames that
/// catalogue/README.md gives for their shapes.
inline constexpr std::string_view kLooks[] = {"tooth",    "gum",   "tongue", "face",
                                              "calculus", "steel", "probe"};

/// A scene as people write it (catalogue/README.md has every field).
struct SceneDescription {
  std::string name;
  std::vector<BodyDescription> tools, objects;
  Coupling coupling;
  StepTuning tuning;
  std::string coupling_where;  ///< "file:line: field" of its torsional stiffness
  Features features;           ///< compliance follows from the materials
  std::optional<FirstSight> first_sight;
  std::vector<JsonNode> effects;  ///< what each may say, its shared object knows: LoadEffect
  bool whole_at_start = false;    ///< a session begins with what former ones have cut
};

/// What a scene or a body may be called: so many bytes at most, all of them letters, digits, - _ .
inline constexpr std::size_t kLongestName = 64;
bool IsOfName(unsigned char c);
/// What a scene is called that its file gives no name: as the file, without folder and last ending,
/// and with - where there is what no name has.
std::string SceneNameOf(const std::filesystem::path& file);

/// Gives the trees that the scene file leaves open the mode that suits the contact (ModeFor).
void ChooseModes(SceneDescription& scene);

/// Of objects whose leaves the scene file leaves out: the tolerance "auto" where leaves are felt or
/// have materials of their own, else none (BuildInnerTree).
void ChooseLeaves(SceneDescription& scene);

/// Checks every field; throws Error "file:line: field: what is wrong; remedy".
/// @param file  names the scene where the text does not; mesh paths are relative to its folder.
SceneDescription ParseScene(std::string_view text, const std::string& file);

}  // namespace palpate
