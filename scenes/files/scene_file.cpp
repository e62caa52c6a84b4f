#include "scenes/files/scene_file.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>
#include <span>
#include <type_traits>

#include "common/error.h"
#include "common/files/bundle_hash.h"
#include "common/step_tuning.h"
#include "common/text/hex16.h"
#include "scenes/grid/bur.h"
#include "scenes/grid/solid_grid.h"
#include "scenes/shapes/shape_kinds.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

enum class BodyKind { kTool, kObject };

constexpr std::size_t kMaxMaterials = 256;  // of a body: Body::leaf_material holds bytes
constexpr std::size_t kShapeTriangles = 5120;
constexpr std::size_t kMostKeys = 1000;
constexpr double kLastKey_s = 3600.0, kMostTurn_deg = 720.0;
constexpr double kLongest = 1000.0;  // [m]: a greater length means a forgotten unit
constexpr double kStrongestVibration = 0.5;
constexpr double kHighestVibration = 400.0;  // [Hz]: below half of the 1,000 poses per second
constexpr double kFastestBur = 500'000.0;    // [r/min]: the fastest air turbines turn at 450,000

double ReadUnit(const JsonNode& node) {
  return MetresPerUnit(node.OneOf({kUnits.begin(), kUnits.end()}));
}

/// Reads a name that is fit for file names, topics and command lines.
std::string ReadName(const JsonNode& node) {
  std::string name = node.String();
  const bool fine = name.size() <= kLongestName && std::all_of(name.begin(), name.end(), IsOfName);
  if (!fine) {
    node.Fail("\"" + name + "\" is not a name; give at most 64 letters, digits, - _ or .");
  }
  return name;
}

Vec3 ReadSize(const JsonNode& node) {
  const Vec3 size = node.Vector();
  if (!(size.minCoeff() > 0.0) || size.maxCoeff() > kLongest) {
    node.Fail("lengths must be above 0 and at most 1000 m; give metres");
  }
  return size;
}

Vec3 ReadDirection(const JsonNode& node) {
  const Vec3 direction = node.Vector();
  if (!(direction.norm() > 1e-6)) node.Fail("has length 0; give a direction");
  return direction.normalized();
}

double ReadLength(const JsonNode& node) {
  const double length = node.PositiveNumber();
  if (length > kLongest) node.Fail("is more than 1000 m; give metres");
  return length;
}

/// Returns nothing if the field is missing or false: then the mesh's own triangles are felt.
std::optional<CurvedOptions> ReadCurved(const JsonNode& mesh) {
  const auto curved = mesh.Find("curved");
  if (!curved || curved->IsFalse()) return std::nullopt;
  curved->AllowOnly({"tolerance_um", "max_triangles"});
  CurvedOptions options;
  options.tolerance = 1e-6 * curved->At("tolerance_um").Number(0.1, 1e6);
  if (auto most = curved->Find("max_triangles")) {
    options.max_triangles = static_cast<std::size_t>(most->Integer(1, kMaxCurvedTriangles));
  }
  return options;
}

/// Reads the curve of a bur (in place of "kind") or of an edge [m].
std::vector<std::array<double, 2>> ReadBurCurve(const JsonNode& node) {
  std::vector<std::array<double, 2>> curve;
  for (const JsonNode& point : node.Items(1, Bur::kMostPoints)) {
    const std::vector<JsonNode> pair = point.Items();
    if (pair.size() != 2) point.Fail("is not a point; give [radius, height above the first point]");
    curve.push_back({1e-3 * pair[0].Number(-20.0, 20.0), 1e-3 * pair[1].Number(-20.0, 20.0)});
  }
  return curve;
}

MeshSource ReadShapeKind(const JsonNode& node, const ShapeKind& shape) {
  MeshSource source;
  source.kind = MeshSource::Kind::kShape;
  source.what = shape.name;
  const auto curve = shape.bur != nullptr ? node.Find("curve_mm") : std::nullopt;
  std::vector<std::string_view> fields{"shape", "curved"};
  if (!shape.variants.empty() && !curve) fields.push_back("kind");
  if (curve) fields.push_back("curve_mm");
  for (const ShapeParameter& parameter : shape.parameters) fields.push_back(parameter.field);
  node.AllowOnly(fields);
  if (curve) {
    source.variant = shape.variants.size();
  } else if (!shape.variants.empty()) {
    const std::string variant = node.At("kind").OneOf(shape.variants);
    source.variant =
        std::find(shape.variants.begin(), shape.variants.end(), variant) - shape.variants.begin();
  }
  for (const ShapeParameter& parameter : shape.parameters) {
    double value = parameter.usual;
    if (auto given = node.Find(parameter.field)) {
      value = given->Number(parameter.smallest, parameter.largest);
    }
    source.values.push_back(parameter.unit * value);
  }
  if (curve) {
    for (const auto& [rho, z] : ReadBurCurve(*curve)) {
      source.values.insert(source.values.end(), {rho, z});
    }
  }
  return source;
}

/// Reads a tool that is a bur by its ISO 6360 number.
MeshSource ReadNamedBur(const JsonNode& node) {
  MeshSource source;
  source.kind = MeshSource::Kind::kShape;
  source.what = "bur";
  source.where = node.Where();
  try {
    const ShapeChoice bur = BurNamed(node.String());
    source.variant = bur.variant;
    source.values = bur.values;
  } catch (const Error& error) {
    node.Fail(error.what());
  }
  return source;
}

MeshSource ReadShape(const JsonNode& node) {
  MeshSource source;
  std::vector<std::string_view> names{"box", "ellipsoid", "sphere"};
  for (const ShapeKind& kind : ShapeKinds()) names.push_back(kind.name);
  const std::string shape = node.At("shape").OneOf(names);
  if (const ShapeKind* kind = FindShapeKind(shape)) return ReadShapeKind(node, *kind);
  if (shape == "box") {
    source.kind = MeshSource::Kind::kBox;
    node.AllowOnly({"shape", "size_m", "curved"});
    source.size = ReadSize(node.At("size_m"));
    return source;
  }
  if (shape == "ellipsoid") {
    source.kind = MeshSource::Kind::kEllipsoid;
    node.AllowOnly({"shape", "semi_axes_m", "triangles", "curved"});
    source.size = ReadSize(node.At("semi_axes_m"));
  } else {
    source.kind = MeshSource::Kind::kSphere;
    node.AllowOnly({"shape", "radius_m", "triangles", "curved"});
    source.size = Vec3::Constant(ReadLength(node.At("radius_m")));
  }
  source.triangles = kShapeTriangles;
  if (auto triangles = node.Find("triangles")) source.triangles = triangles->Integer(20, 1 << 20);
  return source;
}

MeshSource ReadImported(const JsonNode& node, const fs::path& folder) {
  MeshSource source;
  node.AllowOnly({"model", "file", "unit", "longest_side_m", "origin", "thickness_mm", "curved"});
  if (auto model = node.Find("model")) {
    if (node.Has("file")) node.Fail("names a model and a file; keep one of the two");
    source.kind = MeshSource::Kind::kModel;
    source.what = model->String();
  } else if (auto file = node.Find("file")) {
    source.kind = MeshSource::Kind::kFile;
    source.what = (folder / file->String()).lexically_normal().string();
  } else {
    node.Fail("names no mesh; add \"model\", \"file\" or \"shape\"");
  }
  const auto unit = node.Find("unit");
  const auto longest = node.Find("longest_side_m");
  if (unit && longest) longest->Fail("the scale is given twice; keep unit or longest_side_m");
  if (!unit && !longest) {
    node.Fail("has no scale; add \"unit\" (m, cm, mm or inch) or \"longest_side_m\"");
  }
  if (unit) source.placement.metres_per_unit = ReadUnit(*unit);
  if (longest) source.placement.longest_side = ReadLength(*longest);
  if (auto thickness = node.Find("thickness_mm")) {
    source.thickness = 1e-3 * thickness->PositiveNumber();
  }
  if (auto origin = node.Find("origin")) {
    const std::string at = origin->OneOf({"box_centre", "centroid", "file"});
    source.placement.origin = at == "file"       ? MeshPlacement::Origin::kFile
                              : at == "centroid" ? MeshPlacement::Origin::kCentroid
                                                 : MeshPlacement::Origin::kBoxCentre;
  }
  return source;
}

std::uint32_t ReadColour(const JsonNode& node) {
  const std::string text = node.String();
  const bool fine = text.size() == 7 && text[0] == '#' &&
                    text.find_first_not_of("0123456789abcdefABCDEF", 1) == std::string::npos;
  if (!fine) node.Fail("\"" + text + "\" is not a colour; give \"#rrggbb\", such as \"#8a5a2b\"");
  return static_cast<std::uint32_t>(std::stoul(text.substr(1), nullptr, 16));
}

MaterialDescription ReadMaterial(const JsonNode& node) {
  node.AllowOnly({"stiffness_N_per_m", "youngs_modulus_Pa", "thickness_mm", "static_friction",
                  "dynamic_friction", "hardness_J", "cutting_pressure_MPa",
                  "cutting_viscosity_MPa_s_per_mm", "cutting_friction", "colour", "name"});
  MaterialDescription read;
  Material& material = read.material;
  read.where = node.Where();
  const auto stiffness = node.Find("stiffness_N_per_m");
  const auto modulus = node.Find("youngs_modulus_Pa");
  const auto thickness = node.Find("thickness_mm");
  if (stiffness && modulus) {
    modulus->Fail("the stiffness is given twice; keep stiffness_N_per_m or youngs_modulus_Pa");
  }
  if (modulus && !thickness) {
    modulus->Fail("needs the thickness of the layer; add thickness_mm");
  }
  if (thickness && !modulus) {
    thickness->Fail("needs a Young's modulus; add youngs_modulus_Pa, or drop it");
  }
  if (stiffness) material.stiffness = stiffness->PositiveNumber();
  if (modulus) {
    read.youngs_modulus = modulus->PositiveNumber();
    read.thickness = 1e-3 * thickness->PositiveNumber();
  }
  const auto mu_s = node.Find("static_friction");
  const auto mu_d = node.Find("dynamic_friction");
  if (mu_s) material.static_friction = mu_s->Number(kFriction.least, kFriction.most);
  if (mu_d) material.dynamic_friction = mu_d->Number(kFriction.least, kFriction.most);
  if (!mu_s) material.static_friction = material.dynamic_friction;
  if (!mu_d) material.dynamic_friction = material.static_friction;
  if (material.dynamic_friction > material.static_friction) {
    mu_d->Fail("is above static_friction; give at most that");
  }
  if (auto hardness = node.Find("hardness_J")) {
    hardness->Fail(
        "is no longer supported; instead give the object \"grid_um\", the material "
        "\"cutting_pressure_MPa\", and the tool an \"edge\"");
  }
  const auto pressure = node.Find("cutting_pressure_MPa");
  if (pressure) material.cutting_pressure = 1e6 * pressure->Number(1e-3, 1e5);
  const auto beside_pressure = [&](const char* field, const std::string& why) {
    const auto found = node.Find(field);
    if (found && !pressure) found->Fail(why + "; add cutting_pressure_MPa or drop it");
    return found;
  };
  if (auto viscosity = beside_pressure("cutting_viscosity_MPa_s_per_mm", "belongs to a pressure")) {
    material.cutting_viscosity = 1e9 * viscosity->Number(0.0, 1e4);
  }
  if (auto friction = beside_pressure("cutting_friction", "belongs to a pressure")) {
    material.cutting_friction = friction->Number(0.0, 1.0);
  }
  if (auto name = beside_pressure("name", "is of what burs cut")) material.name = ReadName(*name);
  if (auto colour = beside_pressure("colour", "is of what burs cut")) {
    material.colour = ReadColour(*colour);
  }
  return read;
}

MeshSource ReadMesh(const JsonNode& node, const fs::path& folder) {
  MeshSource source = node.Has("shape") ? ReadShape(node) : ReadImported(node, folder);
  source.curved = ReadCurved(node);
  source.where = node.Where();
  return source;
}

RegionDescription ReadRegion(const JsonNode& node, const fs::path& folder) {
  node.AllowOnly({"box", "sphere", "group", "mesh", "material"});
  RegionDescription region;
  region.where = node.Where();
  region.material = ReadMaterial(node.At("material"));
  const auto box = node.Find("box");
  const auto sphere = node.Find("sphere");
  const auto group = node.Find("group");
  const auto mesh = node.Find("mesh");
  if (int(box.has_value()) + int(sphere.has_value()) + int(group.has_value()) +
          int(mesh.has_value()) !=
      1) {
    node.Fail(
        "must say what it paints; give exactly one of \"box\", \"sphere\", \"group\" or \"mesh\"");
  }
  if (box) {
    box->AllowOnly({"min_mm", "max_mm"});
    region.kind = RegionDescription::Kind::kBox;
    region.box = {1e-3 * box->At("min_mm").Vector(), 1e-3 * box->At("max_mm").Vector()};
    if (region.box.isEmpty()) box->Fail("is empty; no entry of min_mm may be above max_mm's");
  } else if (sphere) {
    sphere->AllowOnly({"centre_mm", "radius_mm"});
    region.kind = RegionDescription::Kind::kSphere;
    region.ball = {1e-3 * sphere->At("centre_mm").Vector(),
                   1e-3 * sphere->At("radius_mm").PositiveNumber()};
  } else if (mesh) {
    region.kind = RegionDescription::Kind::kMesh;
    region.mesh = ReadMesh(*mesh, folder);
  } else {
    region.kind = RegionDescription::Kind::kGroup;
    region.group = group->String();
  }
  return region;
}

FirstSight ReadFirstSight(const JsonNode& node) {
  node.AllowOnly({"centre_mm", "radius_mm", "from"});
  FirstSight sight;
  sight.centre = 1e-3 * node.At("centre_mm").Vector();
  sight.radius = 1e-3 * node.At("radius_mm").PositiveNumber();
  sight.from = ReadDirection(node.At("from"));
  return sight;
}

bool AnyMaterial(const BodyDescription& body, bool (*holds)(const MaterialDescription&)) {
  return holds(body.material) ||
         std::ranges::any_of(body.regions, holds, &RegionDescription::material);
}

bool Yields(const MaterialDescription& m) {
  return m.youngs_modulus > 0.0 || std::isfinite(m.material.stiffness);
}

bool Rubs(const MaterialDescription& m) {
  return m.material.static_friction > 0.0;
}

/// Returns whether a stiffness is finite anywhere, as HapticModel decides it.
bool FeltByLeaves(const BodyDescription& body) {
  return AnyMaterial(body, Yields);
}

Features ReadFeatures(const JsonNode& root, const SceneDescription& scene) {
  Features features;
  if (auto contact = root.Find("contact")) {
    features.contact = contact->OneOf({"surface", "spheres"}) == "surface" ? ContactModel::kSurface
                                                                           : ContactModel::kSpheres;
  }
  if (auto friction = root.Find("friction")) {
    const std::string model = friction->OneOf({"off", "chapter", "coulomb"});
    features.friction = model == "off"       ? FrictionModel::kOff
                        : model == "chapter" ? FrictionModel::kChapter
                                             : FrictionModel::kCoulomb;
    const auto rubs = [](const BodyDescription& body) { return AnyMaterial(body, Rubs); };
    if (model != "off" && std::ranges::none_of(scene.objects, rubs) &&
        std::ranges::none_of(scene.tools, rubs)) {
      friction->Fail("no material of an object has friction; add static_friction, or use \"off\"");
    }
  }
  features.compliance = std::ranges::any_of(scene.objects, FeltByLeaves);
  return features;
}

/// Rejects a refined mesh where the mesh is not felt: it would cost time and change nothing.
void CheckCurved(const JsonNode& root, const SceneDescription& scene) {
  const auto check = [&](const char* list, const std::vector<BodyDescription>& bodies) {
    const std::vector<JsonNode> nodes = root.At(list).Items();
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      if (!bodies[i].mesh.curved) continue;
      const JsonNode curved = nodes[i].At("mesh").At("curved");
      if (scene.features.contact == ContactModel::kSpheres) {
        curved.Fail("has no effect with sphere contact; drop it, or use \"surface\"");
      }
      if (FeltByLeaves(bodies[i])) {
        curved.Fail("has no effect on a soft object, which is felt by its leaves; drop it");
      }
    }
  };
  for (const BodyDescription& tool : scene.tools) {
    if (tool.mesh.curved && tool.tolerance && tool.mesh.kind == MeshSource::Kind::kSphere) {
      throw Error(tool.mesh.where +
                  ".curved: does not go with a tolerance, which may choose a single leaf, a ball "
                  "without a mesh; drop it, or give \"leaves\" a number");
    }
    if (tool.mesh.curved && tool.leaves == 1) {
      throw Error(
          tool.mesh.where +
          ".curved: has no effect on a tool of one leaf, which is felt as that ball; drop it");
    }
  }
  check("tools", scene.tools);
  check("objects", scene.objects);
}

LeafTolerance ReadTolerance(const JsonNode& node) {
  node.AllowOnly({"tolerance_um", "tolerance_deg", "most_leaves"});
  const auto um = node.Find("tolerance_um");
  const auto degrees = node.Find("tolerance_deg");
  if (um && degrees)
    degrees->Fail("the tolerance is given twice; keep tolerance_um or tolerance_deg");
  if (!um && !degrees) {
    node.Fail("has no tolerance; add \"tolerance_um\" or \"tolerance_deg\", or give \"auto\"");
  }
  LeafTolerance tolerance;
  if (um) tolerance.most = 1e-6 * um->Number(kLeastTolerance_um, kMostTolerance_um);
  if (degrees) {
    tolerance.of = LeafTolerance::Of::kLean;
    tolerance.most = M_PI / 180.0 * degrees->Number(kLeastTolerance_deg, kMostTolerance_deg);
  }
  if (auto most = node.Find("most_leaves")) {
    tolerance.most_leaves = static_cast<std::size_t>(most->Integer(1, kMaxLeaves));
  }
  return tolerance;
}

/// Reads 4096, "auto", {"tolerance_um": 100} or {"tolerance_deg": 5}.
void ReadLeaves(const JsonNode& node, BodyDescription& body) {
  if (node.IsObject()) {
    body.tolerance = ReadTolerance(node);
  } else if (node.IsString()) {
    if (node.String() != "auto") {
      node.Fail("\"" + node.String() +
                "\" is not a number of leaves; give a number, \"auto\" or {\"tolerance_um\": 100}");
    }
    body.tolerance = LeafTolerance{};
  } else {
    body.leaves = node.Integer(1, kMaxLeaves);
  }
}

/// Reads the grid, and checks that all materials of the body can be cut.
void ReadGrid(const JsonNode& node, BodyDescription& body) {
  body.grid = 1e-6 * node.Number(25.0, 200.0);
  const auto check = [&](const MaterialDescription& of) {
    const Material& m = of.material;
    const std::string where = of.where.empty() ? node.Where() : of.where;
    if (!(m.cutting_pressure > 0.0)) {
      throw Error(where + ": does not say how hard it is to cut; add cutting_pressure_MPa");
    }
    if (Yields(of)) {
      throw Error(
          where +
          ": a body that burs cut must be rigid; drop grid_um, or the stiffness and modulus");
    }
  };
  check(body.material);
  for (const RegionDescription& region : body.regions) {
    check(region.material);
    if (region.kind == RegionDescription::Kind::kGroup) {
      throw Error(region.where +
                  ": a group is a part of the surface, but a body that burs cut needs regions of "
                  "its volume; give \"box\", \"sphere\" or \"mesh\"");
    }
  }
  if (body.regions.size() >= SolidGrid::kMaterials) {
    node.Fail("goes with " + std::to_string(SolidGrid::kMaterials - 1) + " regions at most");
  }
}

/// Checks that a bur or an edge can be made, and is not too small for the grid; errors
/// name its line.
void CheckBur(const JsonNode& node, const BurProfile& profile, const BodyDescription* cut) {
  const std::string name = profile.edge ? "an edge" : "a bur";
  if (cut == nullptr) {
    node.Fail("is " + name + ", but nothing can be cut; give an object \"grid_um\", or " +
              (profile.edge ? "drop it" : "another tool"));
  }
  std::optional<Bur> bur;
  try {
    bur.emplace(profile.curve, profile.rounding);
  } catch (const Error& error) {
    node.Fail(error.what());
  }
  const auto um = [](double metres) { return std::to_string(std::lround(1e6 * metres)) + " um"; };
  if (bur->half_width() < *cut->grid) {
    node.Fail("is " + name + " of " + um(2.0 * bur->half_width()) + ", finer than two cells of \"" +
              cut->name + "\"; give that a \"grid_um\" of " + um(bur->half_width()) +
              " at most, or the tool a wider " + (profile.edge ? "edge" : "bur"));
  }
  const double head = bur->high() - bur->low();
  if (profile.dead_tip >= (profile.cutting > 0.0 ? std::min(profile.cutting, head) : head)) {
    node.Fail("has no cutting part; give a dead_tip_mm below cutting_mm and below its length");
  }
}

/// Checks contact and tools against the objects that burs cut, which are felt by their surface.
void CheckCutting(const JsonNode& root, const SceneDescription& scene) {
  const auto coarsest = [](const BodyDescription& a, const BodyDescription& b) {
    return a.grid.value_or(0.0) < b.grid.value_or(0.0);
  };
  const BodyDescription* cut = &*std::ranges::max_element(scene.objects, coarsest);
  if (!cut->grid) cut = nullptr;
  if (cut != nullptr && scene.features.contact == ContactModel::kSpheres) {
    root.At("contact").Fail("is spheres, and what burs cut, as \"" + cut->name +
                            "\", is felt by its surface; leave it out, or that object's grid_um");
  }
  const std::vector<JsonNode> tools = root.At("tools").Items();
  for (std::size_t i = 0; i < scene.tools.size(); ++i) {
    const MeshSource& mesh = scene.tools[i].mesh;
    const ShapeKind* kind = FindShapeKind(mesh.what);
    const bool is_bur = mesh.kind == MeshSource::Kind::kShape && kind != nullptr && kind->bur;
    const JsonNode tool = tools[i];
    const JsonNode node = tool.At(tool.Has("bur") ? "bur" : "mesh");
    if (const auto& edge = scene.tools[i].edge) {
      if (is_bur) tool.At("edge").Fail("is for tools without a bur; drop it, or the bur");
      CheckBur(tool.At("edge"), *edge, cut);
    }
    if (is_bur) {
      CheckBur(node, kind->bur(mesh.variant, mesh.values), cut);
    } else if (scene.tools[i].spin.speed > 0.0) {
      tool.At("speed_rpm")
          .Fail("is for burs; drop it, or give the tool a \"bur\", such as \"001/014\"");
    }
  }
}

BurSpin ReadSpin(const JsonNode& tool) {
  BurSpin spin;
  double rpm = 0.0;
  if (auto speed = tool.Find("speed_rpm")) rpm = speed->Number(0.0, kFastestBur);
  spin.speed = 2.0 * M_PI / 60.0 * rpm;
  const auto vibration = tool.Find("vibration");
  if (!vibration) return spin;
  vibration->AllowOnly({"teeth", "share"});
  spin.vibration = vibration->At("share").Number(0.0, kStrongestVibration);
  const JsonNode teeth = vibration->At("teeth");
  spin.tooth_Hz = static_cast<double>(teeth.Integer(1, 40)) * rpm / 60.0;
  if (!(spin.tooth_Hz > 0.0 && spin.tooth_Hz <= kHighestVibration)) {
    teeth.Fail(
        "pass " + std::to_string(std::lround(spin.tooth_Hz)) +
        " times per second, but a vibration must have 1 to 400 Hz; give another speed_rpm, or "
        "drop the vibration");
  }
  return spin;
}

BurProfile ReadEdge(const JsonNode& node) {
  node.AllowOnly({"curve_mm", "rounding_mm", "at_mm", "along", "sense"});
  BurProfile profile;
  profile.curve = ReadBurCurve(node.At("curve_mm"));
  profile.rounding = 1e-3 * node.At("rounding_mm").Number(0.02, 5.0);
  EdgePlace& edge = profile.edge.emplace();
  edge.at = 1e-3 * node.At("at_mm").Vector();
  edge.along = ReadDirection(node.At("along"));
  edge.sense = ReadDirection(node.At("sense"));
  return profile;
}

BodyDescription ReadBody(const JsonNode& node, BodyKind kind, const fs::path& folder) {
  const bool object = kind == BodyKind::kObject;
  const std::string_view pose_field = object ? "pose" : "start";
  if (object) {
    node.AllowOnly({"name", "mesh", "leaves", "tree", pose_field, "look", "material", "regions",
                    "grid_um", "moved", "free"});
  } else {
    node.AllowOnly({"name", "mesh", "bur", "speed_rpm", "vibration", "edge", "leaves", "tree",
                    pose_field, "look", "material"});
  }
  BodyDescription body;
  body.name = ReadName(node.At("name"));
  const auto bur = node.Find("bur");
  if (bur && node.Has("mesh")) bur->Fail("is also a mesh; keep either \"bur\" or \"mesh\"");
  body.mesh = bur ? ReadNamedBur(*bur) : ReadMesh(node.At("mesh"), folder);
  body.spin = ReadSpin(node);
  if (auto edge = node.Find("edge")) {
    body.edge = ReadEdge(*edge);
    body.edge_where = edge->Where();
  }
  if (auto tree = node.Find("tree")) {
    body.tree = TreeModeNamed(tree->OneOf({kTreeModes.begin(), kTreeModes.end()}));
    body.tree_left_open = false;
  }
  const bool may_lack_leaves = object && body.tree_left_open && !node.Has("leaves");
  if (!may_lack_leaves) ReadLeaves(node.At("leaves"), body);
  if (auto pose = node.Find(pose_field)) {
    pose->AllowOnly({"position_mm", "rotation_deg", "quaternion_wxyz"});
    body.X_WB = pose->ReadPose();
  }
  if (auto look = node.Find("look")) {
    body.look = look->OneOf({std::begin(kLooks), std::end(kLooks)});
  }
  if (auto material = node.Find("material")) {
    if (!object) material->AllowOnly({"static_friction", "dynamic_friction"});
    body.material = ReadMaterial(*material);
  }
  if (object) {
    if (auto regions = node.Find("regions")) {
      for (const JsonNode& region : regions->Items(0, kMaxMaterials - 1)) {
        body.regions.push_back(ReadRegion(region, folder));
        if (body.regions.back().kind == RegionDescription::Kind::kMesh && !node.Has("grid_um")) {
          region.At("mesh").Fail(
              "paints the inside of what burs cut; give the object \"grid_um\", or \"box\", "
              "\"sphere\" or \"group\" instead");
        }
      }
    }
    if (auto grid = node.Find("grid_um")) ReadGrid(*grid, body);
  }
  return body;
}

std::vector<BodyDescription> ReadBodies(const JsonNode& list, BodyKind kind, const fs::path& folder,
                                        std::set<std::string>& names) {
  std::vector<BodyDescription> bodies;
  std::size_t cut = 0;
  for (const JsonNode& item : list.Items(1, kMostBodies)) {
    bodies.push_back(ReadBody(item, kind, folder));
    if (!names.insert(bodies.back().name).second) {
      item.At("name").Fail("\"" + bodies.back().name + "\" is taken; give each body its own name");
    }
    if (bodies.back().grid && ++cut > kMostCutBodies) {
      item.At("grid_um").Fail("is that of one body more than " + std::to_string(kMostCutBodies) +
                              ", the most that burs may cut in a scene; drop it here");
    }
  }
  return bodies;
}

/// Reads how a group of objects moves.
MovedGroup ReadMoved(const JsonNode& node) {
  node.AllowOnly({"name", "point_mm", "axis", "motion", "repeats", "keys"});
  MovedGroup group;
  group.name = ReadName(node.At("name"));
  if (auto point = node.Find("point_mm")) group.point = 1e-3 * point->Vector();
  if (auto axis = node.Find("axis")) group.axis = ReadDirection(*axis);
  if (auto motion = node.Find("motion")) {
    group.smooth = motion->OneOf({"smooth", "steady"}) == "smooth";
  }
  if (auto repeats = node.Find("repeats")) group.repeats = repeats->Boolean();
  for (const JsonNode& item : node.At("keys").Items(2, kMostKeys)) {
    item.AllowOnly({"t", "turn_deg", "shift_mm"});
    MotionKey& key = group.keys.emplace_back();
    key.at = std::llround(1e3 * item.At("t").Number(0.0, kLastKey_s));
    if (auto turn = item.Find("turn_deg")) {
      if (!node.Has("axis")) {
        turn->Fail("is about no axis; give \"" + group.name + "\" an \"axis\"");
      }
      key.turn = M_PI / 180.0 * turn->Number(-kMostTurn_deg, kMostTurn_deg);
    }
    if (auto shift = item.Find("shift_mm")) key.shift = 1e-3 * shift->Vector();
  }
  if (const std::string fault = MotionFault(group); !fault.empty()) node.At("keys").Fail(fault);
  return group;
}

/// Reads the groups of objects that move, and which objects belong to them.
void ReadAllMoved(const JsonNode& root, SceneDescription& scene) {
  if (auto moved = root.Find("moved")) {
    for (const JsonNode& item : moved->Items(1, kMostMoved)) {
      MovedGroup group = ReadMoved(item);
      if (std::ranges::count(scene.moved, group.name, &MovedGroup::name) > 0) {
        item.At("name").Fail("\"" + group.name + "\" is taken; give each group its own name");
      }
      scene.moved.push_back(std::move(group));
    }
  }
  const std::vector<JsonNode> objects = root.At("objects").Items();
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const auto name = objects[i].Find("moved");
    if (!name) continue;
    if (scene.moved.empty()) {
      name->Fail("names no group; list it under \"moved\", beside \"objects\"");
    }
    std::vector<std::string_view> groups;
    for (const MovedGroup& group : scene.moved) groups.push_back(group.name);
    const std::string group = name->OneOf(groups);
    BodyDescription& object = scene.objects[i];
    object.moved =
        static_cast<std::uint32_t>(std::ranges::find(groups, group) - groups.begin() + 1);
    if (object.grid || FeltByLeaves(object) || scene.features.contact == ContactModel::kSpheres) {
      name->Fail("only what is rigid, not cut and felt by its mesh can move; drop it, or " +
                 std::string(object.grid            ? "grid_um"
                             : FeltByLeaves(object) ? "the stiffness and modulus"
                                                    : "use \"contact\": \"surface\""));
    }
  }
  for (std::size_t i = 0; i < scene.moved.size(); ++i) {
    if (std::ranges::count(scene.objects, i + 1, &BodyDescription::moved) > 0) continue;
    root.At("moved").Items()[i].Fail("moves nothing; give an object \"moved\": \"" +
                                     scene.moved[i].name + "\", or drop it");
  }
  if (!scene.moved.empty() && scene.tools.size() > 1) {
    root.At("moved").Fail("goes with one tool only; drop the others, or serve seats (--seats)");
  }
}

/// Refuses what cannot be stepped as one problem with several hands, or with free bodies.
/// @param field, what  that asks for it, and its name for people
void RefuseBeside(const std::string& field, const std::string& what, const JsonNode& root,
                  const SceneDescription& scene) {
  const auto refuse = [&](const JsonNode& node, const char* other, const char* why) {
    if (auto found = node.Find(other)) {
      found->Fail("does not go with \"" + field + "\": " + why + "; drop one of the two");
    }
  };
  if (scene.features.contact == ContactModel::kSpheres) {
    root.At("contact").Fail(what + " touch by their meshes; use \"surface\", or drop \"" + field +
                            "\"");
  }
  if (scene.features.friction == FrictionModel::kChapter) {
    root.At("friction")
        .Fail("chapter friction is of one tool; use \"coulomb\", or drop \"" + field + "\"");
  }
  refuse(root, "effects", "they count the steps of one hand");
  const std::vector<JsonNode> objects = root.At("objects").Items();
  for (std::size_t i = 0; i < objects.size(); ++i) {
    refuse(objects[i], "grid_um", "nothing is cut there");
    if (FeltByLeaves(scene.objects[i])) {
      objects[i]
          .At("material")
          .Fail("only rigid objects go with \"" + field + "\"; drop the stiffness and modulus");
    }
  }
}

/// Reads the joint of a free body.
BodyJoint ReadJoint(const JsonNode& node) {
  using Kind = BodyJoint::Kind;
  static constexpr std::string_view kKinds[] = {"hinge", "slider", "ball", "springs"};
  const std::string word = node.At("kind").OneOf({std::begin(kKinds), std::end(kKinds)});
  BodyJoint joint;
  joint.kind = static_cast<Kind>(std::ranges::find(kKinds, word) - kKinds + 1);
  const bool has_axis = joint.kind == Kind::kHinge || joint.kind == Kind::kSlider;
  const bool shifts = joint.kind == Kind::kSlider || joint.kind == Kind::kSprings;
  const char* const limits = joint.kind == Kind::kHinge ? "limits_deg" : "limits_mm";
  std::vector<std::string_view> fields{"kind"};
  if (joint.kind != Kind::kSlider) {
    fields.push_back("point_mm");
    joint.point = 1e-3 * node.At("point_mm").Vector();
  }
  if (has_axis) {
    fields.insert(fields.end(), {"axis", limits});
    joint.axis = ReadDirection(node.At("axis"));
    if (auto range = node.Find(limits)) {
      const double unit = joint.kind == Kind::kHinge ? M_PI / 180.0 : 1e-3;
      const std::vector<JsonNode> ends = range->Items(2, 2);
      joint.low = unit * ends[0].Number();
      joint.high = unit * ends[1].Number();
      if (!(joint.low <= 0.0 && joint.high >= 0.0)) {
        range->Fail("must include 0, where the object is placed; give a first number of at most 0");
      }
    }
  }
  const auto read = [&](const char* field, double& value) {
    fields.push_back(field);
    if (auto number = node.Find(field)) value = number->Number(0.0, 1e9);
  };
  if (shifts) {
    read("stiffness_N_per_m", joint.stiffness);
    read("damping_N_s_per_m", joint.damping);
  }
  if (joint.kind != Kind::kSlider) {
    read("torsional_stiffness_Nm_per_rad", joint.torsional_stiffness);
    read("torsional_damping_Nm_s_per_rad", joint.torsional_damping);
  }
  node.AllowOnly(fields);
  return joint;
}

/// Reads the objects that are free bodies, each of which is a group of its own, and gravity.
void ReadAllFree(const JsonNode& root, SceneDescription& scene) {
  if (auto gravity = root.Find("gravity_m_per_s2")) scene.gravity = gravity->Vector(100.0);
  const bool scripted = !scene.moved.empty();
  const std::vector<JsonNode> objects = root.At("objects").Items();
  bool any = false;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const auto node = objects[i].Find("free");
    if (!node) continue;
    any = true;
    BodyDescription& object = scene.objects[i];
    const std::size_t hands = scene.hands_meet ? scene.tools.size() : 1;
    if (scripted) {
      node->Fail("does not go with \"moved\": scripts count the steps; drop one of the two");
    }
    if (!scene.hands_meet && scene.tools.size() > 1) {
      node->Fail(
          "goes with one tool, or with tools that touch each other; add \"hands_meet\": true to "
          "the scene, drop the other tools, or serve seats (--seats)");
    }
    if (hands + scene.moved.size() + 1 > kMostMembers) {
      node->Fail("is that of one body more than can move together with the hands, " +
                 std::to_string(kMostMembers - hands) + "; let others stand still");
    }
    if (object.leaves == 1) {
      objects[i].At("leaves").Fail("a free body touches by its mesh; give it more leaves");
    }
    node->AllowOnly({"mass_kg", "density_kg_per_m3", "joint"});
    FreeBody body;
    object.free_where = node->Where();
    const auto mass = node->Find("mass_kg"), density = node->Find("density_kg_per_m3");
    if (mass.has_value() == density.has_value()) {
      node->Fail("needs its mass; give either \"mass_kg\" or \"density_kg_per_m3\"");
    }
    if (mass) body.mass = mass->Number(1e-6, 1e3);
    if (density) object.density = density->Number(1.0, 30'000.0);
    if (auto joint = node->Find("joint")) body.joint = ReadJoint(*joint);
    scene.moved.push_back({.name = object.name, .free = body});
    object.moved = static_cast<std::uint32_t>(scene.moved.size());
  }
  if (any) RefuseBeside("free", "free bodies", root, scene);
}

/// Reads whether the tools touch each other, and refuses what cannot be stepped with several hands.
void ReadHandsMeet(const JsonNode& root, SceneDescription& scene) {
  const auto meet = root.Find("hands_meet");
  scene.hands_meet = meet && meet->Boolean();
  const std::vector<JsonNode> tools = root.At("tools").Items();
  if (!scene.hands_meet) {
    for (const JsonNode& tool : tools) {
      if (auto material = tool.Find("material")) {
        material->Fail(
            "is felt by other tools only; add \"hands_meet\": true to the scene, or drop it");
      }
    }
    return;
  }
  if (tools.size() < 2 || tools.size() > kMostHands) {
    meet->Fail("needs two to four tools, and there are " + std::to_string(tools.size()) +
               "; list others under \"tools\", or drop it");
  }
  RefuseBeside("hands_meet", "hands that meet", root, scene);
  for (std::size_t i = 0; i < tools.size(); ++i) {
    if (i > 0 && scene.tools[i].leaves == 1) {
      tools[i].At("leaves").Fail("a ball can meet other tools only as the first; list it first");
    }
  }
}

}  // namespace

bool IsOfName(unsigned char c) {
  return std::isalnum(c) || c == '-' || c == '_' || c == '.';
}

std::string SceneNameOf(const fs::path& file) {
  const std::string stem = file.stem().string();
  std::string name = stem.substr(0, kLongestName);
  const auto is_letter = [](unsigned char c) { return c < 128 && std::isalnum(c); };
  if (std::ranges::count_if(name, is_letter) < 2 && !std::ranges::all_of(name, IsOfName)) {
    // Of another script: names in it would all be the same.
    const std::span bytes(reinterpret_cast<const std::uint8_t*>(stem.data()), stem.size());
    return "scene-" + Hex16(BundleHash(bytes)).substr(0, 8);
  }
  std::ranges::replace_if(
      name, [](unsigned char c) { return !IsOfName(c); }, '-');
  return name;
}

void ChooseModes(SceneDescription& scene) {
  const TreeMode mode = ModeFor(scene.features.contact);
  for (auto* bodies : {&scene.tools, &scene.objects}) {
    for (BodyDescription& body : *bodies) {
      if (body.tree_left_open) body.tree = mode;
    }
  }
}

void ChooseLeaves(SceneDescription& scene) {
  for (BodyDescription& body : scene.objects) {
    if (body.leaves > 0 || body.tolerance) continue;
    body.mesh_alone = body.tree_left_open && (body.regions.empty() || body.grid) &&
                      !FeltByLeaves(body) &&
                      (scene.features.contact == ContactModel::kSurface || body.grid);
    if (!body.mesh_alone) body.tolerance = LeafTolerance{};
  }
}

void ReadTuning(const JsonNode& node, StepTuning& tuning) {
  std::vector<std::string_view> names;
  ForEachField(tuning, [&](const Tunable& of, auto& field) {
    names.push_back(of.name);
    const auto number = node.Find(of.name);
    if (!number) return;
    if constexpr (std::is_integral_v<std::remove_reference_t<decltype(field)>>) {
      field =
          static_cast<int>(number->Integer(static_cast<int>(of.least), static_cast<int>(of.most)));
    } else {
      field = of.scale * number->Number(of.least, of.most);
    }
  });
  node.AllowOnly(names);
}

SceneDescription ParseScene(std::string_view text, const std::string& file) {
  const JsonNode root = JsonNode::Parse(text, file);
  root.AllowOnly({"name", "description", "tools", "objects", "coupling", "contact", "friction",
                  "first_sight", "step", "effects", "whole_at_start", "moved", "hands_meet",
                  "gravity_m_per_s2"});
  SceneDescription scene;
  const fs::path path(file);
  scene.name = SceneNameOf(path);
  if (auto name = root.Find("name")) scene.name = ReadName(*name);
  if (auto description = root.Find("description")) description->String();
  std::set<std::string> names;
  scene.tools = ReadBodies(root.At("tools"), BodyKind::kTool, path.parent_path(), names);
  scene.objects = ReadBodies(root.At("objects"), BodyKind::kObject, path.parent_path(), names);
  scene.coupling_where = file + ": coupling.torsional_stiffness_Nm_per_rad";
  if (auto coupling = root.Find("coupling")) {
    coupling->AllowOnly({"stiffness_N_per_m", "torsional_stiffness_Nm_per_rad"});
    if (auto k = coupling->Find("stiffness_N_per_m")) {
      scene.coupling.stiffness = k->Number(kCouplingStiffness.least, kCouplingStiffness.most);
    }
    if (auto k = coupling->Find("torsional_stiffness_Nm_per_rad")) {
      scene.coupling.torsional_stiffness =
          k->Number(kCouplingTorsionalStiffness.least, kCouplingTorsionalStiffness.most);
      scene.coupling_where = k->Where();
    }
  }
  if (auto step = root.Find("step")) ReadTuning(*step, scene.tuning);
  if (auto sight = root.Find("first_sight")) scene.first_sight = ReadFirstSight(*sight);
  if (auto effects = root.Find("effects")) scene.effects = effects->Items(0, kMostEffects);
  scene.features = ReadFeatures(root, scene);
  ChooseModes(scene);
  CheckCurved(root, scene);
  CheckCutting(root, scene);
  ReadAllMoved(root, scene);
  ReadHandsMeet(root, scene);
  ReadAllFree(root, scene);
  if (auto whole = root.Find("whole_at_start")) {
    scene.whole_at_start = whole->Boolean();
    const bool is_cut = std::ranges::any_of(
        scene.objects, [](const BodyDescription& body) { return body.grid.has_value(); });
    if (scene.whole_at_start && !is_cut) {
      whole->Fail("has no effect, since nothing can be cut: no object has \"grid_um\"; drop it");
    }
  }
  return scene;
}

}  // namespace palpate
