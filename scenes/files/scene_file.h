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
#include "scenes/tree/tree_mode.h"

namespace palpate {

// The most of each in a scene file, so that none takes minutes to be refused or to load: far more
// than the 32 stations of a server can hold, or than fits between two poses.
inline constexpr std::size_t kMostBodies = 256;    ///< tools, and objects
inline constexpr std::size_t kMostCutBodies = 16;  ///< a second for each cubic centimetre at 50 um
inline constexpr std::size_t kMostEffects = 64;

/// Where a body's mesh comes from.
struct MeshSource {
  enum class Kind {
    kModel,  ///< a well-known mesh, `what` its name: model_files.h
    kFile,   ///< a mesh file, `what` its path
    kBox,
    kEllipsoid,
    kSphere,
    kShape,  ///< `what` names one of shape_kinds.h
  };
  Kind kind = Kind::kFile;
  std::string what;                     ///< a name or a path, by kind
  MeshPlacement placement;              ///< for models and files
  Vec3 size = Vec3::Zero();             ///< for shapes [m]: side lengths, or semi-axes
  std::size_t triangles = 0;            ///< for shapes: the least number
  std::size_t variant = 0;              ///< for kShape
  std::vector<double> values;           ///< for kShape: its parameters in SI
  std::optional<CurvedOptions> curved;  ///< none: the triangles stay as they are
  /// for open pieces of a model or file [m]; none: they stay open
  std::optional<double> thickness;
  std::string where;  ///< "file:line: field", for later error messages
};

/// A material as written.  The stiffness for a Young's modulus is computed when leaves exist.
struct MaterialDescription {
  Material material;            ///< its stiffness counts if no modulus is given
  double youngs_modulus = 0.0;  ///< E [Pa]; 0: not given
  double thickness = 0.0;       ///< L, of the layer that is compressed [m]
  std::string where;            ///< "file:line: field", for later error messages
};

/// A region of a body that has another material than the body.
struct RegionDescription {
  enum class Kind {
    kBox,     ///< leaves whose centre lies in `box`
    kSphere,  ///< leaves whose centre lies in `ball`
    kGroup,   ///< leaves with most of their surface in the mesh file's part `group`
    kMesh,    ///< for bodies that burs cut: what lies within `mesh`, given in frame B
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
  /// 0: as many as the tolerance needs; if there is none, as ChooseLeaves decides.
  std::size_t leaves = 0;
  std::optional<LeafTolerance> tolerance;  ///< if `leaves` is 0
  TreeMode tree = TreeMode::kInside;
  bool tree_left_open = true;  ///< whether its mode follows from the contact: ChooseModes
  bool mesh_alone = false;     ///< whether only the start pose uses its leaves: ChooseLeaves
  Pose X_WB;
  MaterialDescription material;            ///< objects: where no region applies
  std::vector<RegionDescription> regions;  ///< objects: a later one overrides earlier ones
  std::optional<double> grid;              ///< for objects that burs cut: spacing [m]
  BurSpin spin;                            ///< for tools that are burs
  std::optional<BurProfile> edge;          ///< for tools that cut with an edge of their mesh
  std::string edge_where;                  ///< "file:line: field"
  std::string look;                        ///< one of kLooks; empty: by its material
  std::uint32_t moved = 0;                 ///< objects: as Body::moved
  std::optional<double> density;           ///< of a free body whose mass is not given [kg/m^3]
  std::string free_where;                  ///< of a free body: "file:line: field"
};

/// The looks that viewers can draw.  Those of teeth, gums, tongues and probes assume the frames
/// that catalogue/README.md gives for these shapes.
inline constexpr std::string_view kLooks[] = {"tooth",    "gum",   "tongue", "face",
                                              "calculus", "steel", "probe"};

/// A scene as written in a scene file (catalogue/README.md has every field).
struct SceneDescription {
  std::string name;
  std::vector<BodyDescription> tools, objects;
  std::vector<MovedGroup> moved;
  bool hands_meet = false;
  Vec3 gravity = Vec3::Zero();
  Coupling coupling;
  StepTuning tuning;
  std::string coupling_where;  ///< "file:line: field" of the torsional stiffness
  Features features;           ///< compliance follows from the materials
  std::optional<FirstSight> first_sight;
  /// to be read by LoadEffect: their fields depend on the shared object
  std::vector<JsonNode> effects;
  bool whole_at_start = false;  ///< whether a session begins without the cuts of former ones
};

/// Limit of the name of a scene or body [bytes]; it consists of letters, digits, - _ and the dot.
inline constexpr std::size_t kLongestName = 64;
bool IsOfName(unsigned char c);
/// Returns the name of a scene whose file gives none: the file's name without folder and last
/// ending, with - in place of characters that names must not have; if that leaves fewer than two
/// letters or digits, a hash of it.
std::string SceneNameOf(const std::filesystem::path& file);

/// Sets the mode of trees that the scene file leaves open to the one that suits
/// the contact (ModeFor).
void ChooseModes(SceneDescription& scene);

/// Sets the leaves of objects for which the scene file gives none: the tolerance "auto" if leaves
/// are felt or have their own materials, else no tolerance (BuildInnerTree).
void ChooseLeaves(SceneDescription& scene);

/// Parses a scene file and checks every field; throws Error "file:line: field: what
/// is wrong; remedy".
/// @param file  names the scene if the text does not; mesh paths are relative to its folder.
SceneDescription ParseScene(std::string_view text, const std::string& file);

}  // namespace palpate
