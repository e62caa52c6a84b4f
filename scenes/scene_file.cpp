#include "scenes/scene_file.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <set>
#include <utility>

#include "scenes/json_file.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kShapeTriangles = 5120;
constexpr double kLongest = 1000.0;  // [m]: a length beyond it is a forgotten unit

double ReadUnit(const JsonNode& node) {
  const std::string unit = node.OneOf({"m", "cm", "mm", "inch"});
  return unit == "m" ? 1.0 : unit == "cm" ? 0.01 : unit == "mm" ? 0.001 : 0.0254;
}

/// Names end up in file names, topics and command lines.
std::string ReadName(const JsonNode& node) {
  std::string name = node.String();
  const bool fine = name.size() <= 64 && std::all_of(name.begin(), name.end(), [](unsigned char c) {
                      return std::isalnum(c) || c == '-' || c == '_' || c == '.';
                    });
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

double ReadLength(const JsonNode& node) {
  const double length = node.PositiveNumber();
  if (length > kLongest) node.Fail("is more than 1000 m; give metres");
  return length;
}

MeshSource ReadShape(const JsonNode& node) {
  MeshSource source;
  const std::string shape = node.At("shape").OneOf({"box", "ellipsoid", "sphere"});
  if (shape == "box") {
    source.kind = MeshSource::Kind::kBox;
    node.AllowOnly({"shape", "size_m"});
    source.size = ReadSize(node.At("size_m"));
    return source;
  }
  if (shape == "ellipsoid") {
    source.kind = MeshSource::Kind::kEllipsoid;
    node.AllowOnly({"shape", "semi_axes_m", "triangles"});
    source.size = ReadSize(node.At("semi_axes_m"));
  } else {
    source.kind = MeshSource::Kind::kSphere;
    node.AllowOnly({"shape", "radius_m", "triangles"});
    source.size = Vec3::Constant(ReadLength(node.At("radius_m")));
  }
  source.triangles = kShapeTriangles;
  if (auto triangles = node.Find("triangles")) source.triangles = triangles->Integer(20, 1 << 20);
  return source;
}

MeshSource ReadImported(const JsonNode& node, const fs::path& folder) {
  MeshSource source;
  node.AllowOnly({"model", "file", "unit", "longest_side_m", "origin"});
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
  if (auto origin = node.Find("origin")) {
    const std::string at = origin->OneOf({"box_centre", "centroid", "file"});
    source.placement.origin = at == "file"       ? MeshPlacement::Origin::kFile
                              : at == "centroid" ? MeshPlacement::Origin::kCentroid
                                                 : MeshPlacement::Origin::kBoxCentre;
  }
  return source;
}

BodyDescription ReadBody(const JsonNode& node, std::string_view pose_field,
                         const fs::path& folder) {
  node.AllowOnly({"name", "mesh", "leaves", pose_field});
  BodyDescription body;
  body.name = ReadName(node.At("name"));
  const JsonNode mesh = node.At("mesh");
  body.mesh = mesh.Has("shape") ? ReadShape(mesh) : ReadImported(mesh, folder);
  body.mesh.where = mesh.Where();
  body.leaves = node.At("leaves").Integer(1, kMaxLeaves);
  if (auto pose = node.Find(pose_field)) {
    pose->AllowOnly({"position_mm", "rotation_deg", "quaternion_wxyz"});
    body.X_WB = pose->ReadPose();
  }
  return body;
}

std::vector<BodyDescription> ReadBodies(const JsonNode& list, std::string_view pose_field,
                                        const fs::path& folder, std::set<std::string>& names) {
  std::vector<BodyDescription> bodies;
  for (const JsonNode& item : list.Items(1)) {
    bodies.push_back(ReadBody(item, pose_field, folder));
    if (!names.insert(bodies.back().name).second) {
      item.At("name").Fail("\"" + bodies.back().name + "\" is taken; give each body its own name");
    }
  }
  return bodies;
}

}  // namespace

SceneDescription ParseScene(std::string_view text, const std::string& file) {
  const JsonNode root = JsonNode::Parse(text, file);
  root.AllowOnly({"name", "description", "tools", "objects", "coupling"});
  SceneDescription scene;
  const fs::path path(file);
  scene.name = path.stem().string();
  if (auto name = root.Find("name")) scene.name = ReadName(*name);
  if (auto description = root.Find("description")) description->String();
  std::set<std::string> names;
  scene.tools = ReadBodies(root.At("tools"), "start", path.parent_path(), names);
  scene.objects = ReadBodies(root.At("objects"), "pose", path.parent_path(), names);
  if (auto coupling = root.Find("coupling")) {
    coupling->AllowOnly({"stiffness_N_per_m", "torsional_stiffness_Nm_per_rad"});
    if (auto k = coupling->Find("stiffness_N_per_m")) {
      scene.coupling.stiffness = k->PositiveNumber();
    }
    if (auto k = coupling->Find("torsional_stiffness_Nm_per_rad")) {
      scene.coupling.torsional_stiffness = k->PositiveNumber();
    }
  }
  return scene;
}

}  // namespace palpate
