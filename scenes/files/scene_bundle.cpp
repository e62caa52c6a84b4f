#include "scenes/files/scene_bundle.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <optional>
#include <set>
#include <string_view>
#include <system_error>
#include <utility>

#include <unistd.h>
#define XXH_INLINE_ALL  // so that no library must be linked
#include <xxhash.h>

#include "common/error.h"
#include "common/step_tuning.h"
#include "common/text/quoted.h"
#include "idl/scene_generated.h"
#include "scenes/files/scene_file.h"
#include "scenes/files/scene_size.h"
#include "scenes/grid/solid_grid.h"

namespace palpate {
namespace {

static_assert(std::endian::native == std::endian::little, "bundles are little-endian");

struct Header {
  char magic[8];
  std::uint32_t version;
  std::uint32_t reserved;  ///< 0
  std::uint64_t content_key;
  std::uint64_t size;      ///< of the rest
  std::uint64_t checksum;  ///< XXH64 of the rest, seeded with the content key
};
static_assert(sizeof(Header) == 40);

// The second half reveals a transfer that changed line ends, as PNG's signature does.
constexpr char kMagic[8] = {'P', 'A', 'L', 'P', '\r', '\n', '\x1a', '\n'};

/// Limit of a tree's levels.  In a tree that branches each level has at least twice the nodes of
/// the one above, and there are at most a million leaves.  Rejects trees of thousands of levels
/// with one node each, which would slow down code that visits every level.
constexpr std::size_t kMaxLevels = 24;

template <class T>
bool SameBytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

wire::Vec3 ToWire(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

/// A mesh's numbers as flat arrays, three for each vertex and for each triangle.
struct FlatMesh {
  explicit FlatMesh(const TriangleMesh& mesh) {
    vertices.reserve(3 * mesh.vertices.size());
    for (const Vec3& v : mesh.vertices) vertices.insert(vertices.end(), v.begin(), v.end());
    triangles.reserve(3 * mesh.triangles.size());
    for (const auto& t : mesh.triangles) triangles.insert(triangles.end(), t.begin(), t.end());
  }
  std::vector<double> vertices;
  std::vector<std::uint32_t> triangles;
};

flatbuffers::Offset<wire::Geometry> PackGeometry(const Body& body,
                                                 flatbuffers::FlatBufferBuilder& out) {
  const SphereTree& tree = body.tree;
  // Returns one member of all packets as one vector, eight entries per packet.
  const auto nodes = [&]<class T>(T(SpherePacket::*member)[kTreeArity]) {
    std::vector<T> all;
    all.reserve(tree.packets.size() * kTreeArity);
    for (const SpherePacket& p : tree.packets) {
      all.insert(all.end(), std::begin(p.*member), std::end(p.*member));
    }
    return all;
  };
  const FlatMesh mesh(body.mesh);
  const auto x = nodes(&SpherePacket::x), y = nodes(&SpherePacket::y), z = nodes(&SpherePacket::z);
  const auto radius = nodes(&SpherePacket::radius);
  const auto child = nodes(&SpherePacket::child);
  const wire::Vec3 centroid = ToWire(tree.centroid);
  return wire::CreateGeometryDirect(out, &mesh.vertices, &mesh.triangles, &tree.leaf_x,
                                    &tree.leaf_y, &tree.leaf_z, &tree.leaf_radius,
                                    &tree.leaf_triangle_begin, &tree.leaf_triangle, &x, &y, &z,
                                    &radius, &child, &tree.level_begin, &centroid);
}

flatbuffers::Offset<wire::Grid> PackGrid(const Body& body, flatbuffers::FlatBufferBuilder& out) {
  if (!body.grid) return 0;
  std::vector<double> pressures, viscosities, frictions;
  std::vector<std::uint32_t> colours;
  std::vector<std::string> names;
  for (const Material& m : body.materials) {
    pressures.push_back(m.cutting_pressure);
    viscosities.push_back(m.cutting_viscosity);
    frictions.push_back(m.cutting_friction);
    colours.push_back(m.colour);
    names.push_back(m.name);
  }
  // Omitted if no region has a mesh, so that older files keep the same bytes.
  const bool meshed = std::ranges::any_of(
      body.grid->regions, [](const MaterialRegion& r) { return !r.mesh.triangles.empty(); });
  const bool coloured = std::ranges::any_of(
      colours, [](std::uint32_t colour) { return colour != Material::kNoColour; });
  const bool rubs = std::ranges::any_of(frictions, [](double friction) { return friction > 0.0; });
  const bool named = std::ranges::any_of(names, [](const std::string& n) { return !n.empty(); });
  std::vector<wire::Region> regions;
  std::vector<flatbuffers::Offset<wire::RegionMesh>> meshes;
  for (const MaterialRegion& r : body.grid->regions) {
    regions.emplace_back(ToWire(r.low), ToWire(r.high), r.radius, r.material);
    if (!meshed) continue;
    const FlatMesh mesh(r.mesh);
    meshes.push_back(wire::CreateRegionMeshDirect(out, &mesh.vertices, &mesh.triangles));
  }
  const auto pressures_at = out.CreateVector(pressures);
  const auto viscosities_at = out.CreateVector(viscosities);
  return wire::CreateGrid(
      out, body.grid->spacing, pressures_at, viscosities_at, out.CreateVectorOfStructs(regions),
      meshed ? out.CreateVector(meshes) : 0, coloured ? out.CreateVector(colours) : 0,
      named ? out.CreateVectorOfStrings(names) : 0, rubs ? out.CreateVector(frictions) : 0);
}

flatbuffers::Offset<wire::Bur> PackBur(const Body& body, flatbuffers::FlatBufferBuilder& out) {
  if (!body.bur) return 0;
  std::vector<double> curve;
  for (const auto& point : body.bur->curve) curve.insert(curve.end(), point.begin(), point.end());
  const std::optional<EdgePlace>& edge = body.bur->edge;
  const EdgePlace place = edge.value_or(EdgePlace{});
  const wire::Vec3 at = ToWire(place.at), along = ToWire(place.along), sense = ToWire(place.sense);
  return wire::CreateBurDirect(out, &curve, body.bur->rounding, body.bur->dead_tip,
                               body.bur->cutting, body.bur->spin.speed, body.bur->spin.tooth_Hz,
                               body.bur->spin.vibration, edge ? &at : nullptr,
                               edge ? &along : nullptr, edge ? &sense : nullptr);
}

auto PackEffects(const Scene& scene, flatbuffers::FlatBufferBuilder& out) {
  std::vector<flatbuffers::Offset<wire::Effect>> packed;
  for (const Effect& effect : scene.effects) {
    std::vector<std::uint32_t> sizes;
    std::vector<double> numbers;
    for (const std::vector<double>& values : effect.values) {
      sizes.push_back(static_cast<std::uint32_t>(values.size()));
      numbers.insert(numbers.end(), values.begin(), values.end());
    }
    packed.push_back(
        wire::CreateEffectDirect(out, effect.file.c_str(), effect.hash, &sizes, &numbers));
  }
  return packed.empty() ? 0 : out.CreateVector(packed);
}

flatbuffers::Offset<wire::FreeBody> PackFree(const FreeBody& body,
                                             flatbuffers::FlatBufferBuilder& out) {
  const Mat3& I = body.inertia;
  const std::vector<double> inertia{I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)};
  const BodyJoint& joint = body.joint;
  const wire::Vec3 centre = ToWire(body.centre), point = ToWire(joint.point),
                   axis = ToWire(joint.axis);
  return wire::CreateFreeBodyDirect(out, body.mass, &centre, &inertia,
                                    static_cast<std::uint8_t>(joint.kind), &point, &axis, joint.low,
                                    joint.high, joint.stiffness, joint.damping,
                                    joint.torsional_stiffness, joint.torsional_damping);
}

auto PackMoved(const Scene& scene, flatbuffers::FlatBufferBuilder& out) {
  std::vector<flatbuffers::Offset<wire::MovedGroup>> packed;
  for (const MovedGroup& group : scene.moved) {
    std::vector<wire::MotionKey> keys;
    for (const MotionKey& key : group.keys) keys.emplace_back(key.at, key.turn, ToWire(key.shift));
    const wire::Vec3 point = ToWire(group.point), axis = ToWire(group.axis);
    const auto free =
        group.free ? PackFree(*group.free, out) : flatbuffers::Offset<wire::FreeBody>();
    packed.push_back(wire::CreateMovedGroupDirect(out, group.name.c_str(), &point, &axis,
                                                  group.smooth, group.repeats, &keys, free));
  }
  return packed.empty() ? 0 : out.CreateVector(packed);
}

void Require(bool holds, const char* what) {
  if (!holds) throw Error(what);
}
template <class T>
std::span<const T> All(const flatbuffers::Vector<T>* vector) {
  Require(vector != nullptr, "a list is missing");
  return {vector->data(), vector->size()};
}

/// Writes the mesh of a Geometry or a RegionMesh.
template <class Wire>
void ReadMesh(const Wire& in, TriangleMesh& out) {
  const auto vertices = All(in.vertices());
  const auto triangles = All(in.triangles());
  Require(vertices.size() % 3 == 0 && triangles.size() % 3 == 0, "the mesh is cut short");
  out.vertices.reserve(vertices.size() / 3);
  for (std::size_t i = 0; i < vertices.size(); i += 3) {
    out.vertices.emplace_back(vertices[i], vertices[i + 1], vertices[i + 2]);
    Require(out.vertices.back().allFinite(), "a vertex is not finite");
  }
  out.triangles.reserve(triangles.size() / 3);
  for (std::size_t i = 0; i < triangles.size(); i += 3) {
    out.triangles.push_back({triangles[i], triangles[i + 1], triangles[i + 2]});
    for (std::uint32_t v : out.triangles.back()) {
      Require(v < out.vertices.size(), "a triangle names no vertex");
    }
  }
}

/// Reads one geometry.  Throws inconsistencies as text, to which the caller adds the name.
class GeometryReader {
 public:
  GeometryReader(const wire::Geometry& in, Body& out) : in_(in), out_(out) {}

  void Read() {
    ReadMesh(in_, out_.mesh);
    ReadLeaves();
    ReadPackets();
    const wire::Vec3* centroid = in_.centroid();
    Require(centroid != nullptr, "no centroid");
    out_.tree.centroid = {centroid->x(), centroid->y(), centroid->z()};
    Require(out_.tree.centroid.allFinite(), "the centroid is not finite");
  }

 private:
  template <class T>
  static void Copy(const flatbuffers::Vector<T>* from, std::vector<T>& to) {
    const auto all = All(from);
    to.assign(all.begin(), all.end());
  }

  void ReadLeaves() {
    SphereTree& tree = out_.tree;
    Copy(in_.leaf_x(), tree.leaf_x);
    Copy(in_.leaf_y(), tree.leaf_y);
    Copy(in_.leaf_z(), tree.leaf_z);
    Copy(in_.leaf_radius(), tree.leaf_radius);
    Copy(in_.leaf_triangle_begin(), tree.leaf_triangle_begin);
    Copy(in_.leaf_triangle(), tree.leaf_triangle);
    const std::size_t leaves = tree.leaves();
    Require(leaves > 0 && tree.leaf_x.size() == leaves && tree.leaf_y.size() == leaves &&
                tree.leaf_z.size() == leaves,
            "the leaves' counts differ");
    for (std::size_t i = 0; i < leaves; ++i) {
      Require(std::isfinite(tree.leaf_x[i]) && std::isfinite(tree.leaf_y[i]) &&
                  std::isfinite(tree.leaf_z[i]) && std::isfinite(tree.leaf_radius[i]) &&
                  tree.leaf_radius[i] >= 0.0,
              "a leaf is not a ball");
    }
    const auto& begin = tree.leaf_triangle_begin;
    Require(begin.size() == leaves + 1 && begin.front() == 0 &&
                begin.back() == tree.leaf_triangle.size(),
            "the leaves' triangles do not add up");
    for (std::size_t i = 0; i < leaves; ++i) {
      Require(begin[i] <= begin[i + 1], "the leaves' triangles do not add up");
    }
    for (std::uint32_t t : tree.leaf_triangle) {
      Require(t < out_.mesh.triangles.size(), "a leaf names no triangle");
    }
  }

  void ReadPackets() {
    SphereTree& tree = out_.tree;
    Copy(in_.level_begin(), tree.level_begin);
    const auto x = All(in_.node_x());
    const auto y = All(in_.node_y());
    const auto z = All(in_.node_z());
    const auto radius = All(in_.node_radius());
    const auto child = All(in_.node_child());
    const std::size_t nodes = x.size();
    const std::size_t packets = nodes / kTreeArity;
    Require(nodes % kTreeArity == 0 && y.size() == nodes && z.size() == nodes &&
                radius.size() == nodes && child.size() == nodes,
            "the nodes' counts differ");
    const auto& level = tree.level_begin;
    Require(level.size() <= kMaxLevels + 1, "a tree has more than 24 levels");
    Require(level.size() >= 2 && level[0] == 0 && level[1] == 1 &&
                static_cast<std::size_t>(level.back()) == packets,
            "the levels do not add up");
    tree.packets.resize(packets);
    for (int l = 0; l < tree.levels(); ++l) {
      Require(level[l] < level[l + 1], "the levels do not add up");
      // Every child is named once, in order: the traversal and the bounds of the leaves rely on it.
      const bool last = l + 1 == tree.levels();
      std::int64_t next = 0;  // index in the next level
      for (std::int32_t p = level[l]; p < level[l + 1]; ++p) {
        for (int lane = 0; lane < kTreeArity; ++lane) {
          const std::size_t n = std::size_t(p) * kTreeArity + lane;
          SpherePacket& packet = tree.packets[p];
          packet.x[lane] = x[n];
          packet.y[lane] = y[n];
          packet.z[lane] = z[n];
          packet.radius[lane] = radius[n];
          packet.child[lane] = child[n];
          if (child[n] < 0) {
            Require(child[n] == -1 && std::isnan(x[n]) && std::isnan(y[n]) && std::isnan(z[n]) &&
                        std::isnan(radius[n]),
                    "an empty lane is not empty");
          } else {
            Require(child[n] == next++, "the nodes' children are out of order");
            Require(std::isfinite(x[n]) && std::isfinite(y[n]) && std::isfinite(z[n]) &&
                        std::isfinite(radius[n]) && radius[n] >= 0.0f,
                    "a node is not a ball");
          }
        }
      }
      const std::int64_t end = last                        ? std::int64_t(tree.leaves())
                               : l + 2 < int(level.size()) ? level[l + 2] - level[l + 1]
                                                           : 0;
      Require(next == end, "the nodes' children do not add up");
    }
  }

  const wire::Geometry& in_;
  Body& out_;
};

Vec3 FromWire(const wire::Vec3& in) {
  return {in.x(), in.y(), in.z()};
}

Pose FromWire(const wire::Pose* in) {
  Require(in != nullptr, "a body has no pose");
  const Pose pose{FromWire(in->p()), Quat(in->qw(), in->qx(), in->qy(), in->qz())};
  Require(pose.p.allFinite() && std::abs(pose.q.squaredNorm() - 1.0) < 1e-6,
          "the pose of a body is invalid");
  return pose;
}

void ReadMaterials(const wire::Body& in, Body& out) {
  const auto count = [](const auto* list) { return list == nullptr ? 0 : list->size(); };
  out.materials.clear();
  for (const wire::Material* m : *in.materials()) {
    Require(MaterialFault(m->stiffness(), m->static_friction(), m->dynamic_friction()).empty(),
            "a material is invalid");
    out.materials.push_back({m->stiffness(), m->static_friction(), m->dynamic_friction()});
  }
  Require(!out.materials.empty(), "a body is made of nothing");
  out.leaf_material.clear();
  if (count(in.leaf_material()) == 0) return;
  Require(count(in.leaf_material()) == out.tree.leaves(), "the leaves' materials do not add up");
  for (const std::uint8_t m : *in.leaf_material()) {
    Require(m < out.materials.size(), "a leaf names no material");
    out.leaf_material.push_back(m);
  }
}

TreeOrigin FromWire(wire::TreeOrigin origin) {
  static_assert(static_cast<int>(wire::TreeOrigin::MAX) == static_cast<int>(TreeOrigin::kBall));
  if (origin > wire::TreeOrigin::MAX) throw Error("its tree has an unknown origin");
  return static_cast<TreeOrigin>(origin);
}

void ReadAmbient(const wire::Body& in, Body& out) {
  if (in.ambient() == nullptr) return;
  out.ambient.assign(in.ambient()->begin(), in.ambient()->end());
  Require(out.ambient.size() == out.mesh.vertices.size(), "the vertices' light does not add up");
}

void ReadMargin(const wire::Body& in, Body& out) {
  if (in.margin() == nullptr) return;
  for (const wire::Vec3* point : *in.margin()) {
    out.margin.push_back(FromWire(*point));
    if (!out.margin.back().allFinite()) throw Error("a margin is invalid");
  }
}

/// Checks a name as in scene files, because it becomes part of file names, topics, command lines
/// and terminal output.
bool IsName(const std::string& name) {
  return name.size() <= kLongestName && std::ranges::all_of(name, IsOfName);
}

std::string ReadName(const flatbuffers::String& in) {
  std::string name = in.str();
  if (!IsName(name)) throw Error(Quoted(name) + " is not a name");
  return name;
}

void ReadGrid(const wire::Grid* in, Body& out) {
  if (in == nullptr) return;
  const auto all_of_materials = [&](const auto* list) {
    return list != nullptr && list->size() == out.materials.size();
  };
  Require(in->spacing() > 24e-6 && in->spacing() < 201e-6 &&
              out.materials.size() <= SolidGrid::kMaterials && all_of_materials(in->pressures()) &&
              all_of_materials(in->viscosities()),
          "a grid is none");
  out.grid.emplace().spacing = in->spacing();
  for (unsigned m = 0; m < out.materials.size(); ++m) {
    const double pressure = in->pressures()->Get(m), viscosity = in->viscosities()->Get(m);
    Require(
        pressure > 0.0 && std::isfinite(pressure) && viscosity >= 0.0 && std::isfinite(viscosity),
        "a cutting material is invalid");
    out.materials[m].cutting_pressure = pressure;
    out.materials[m].cutting_viscosity = viscosity;
  }
  if (const auto* frictions = in->frictions()) {
    Require(all_of_materials(frictions), "frictions do not add up");
    for (unsigned m = 0; m < out.materials.size(); ++m) {
      const double friction = frictions->Get(m);
      Require(friction >= 0.0 && friction <= 1.0, "a friction is invalid");
      out.materials[m].cutting_friction = friction;
    }
  }
  if (const auto* colours = in->colours()) {
    Require(all_of_materials(colours), "colours do not add up");
    for (unsigned m = 0; m < out.materials.size(); ++m) out.materials[m].colour = colours->Get(m);
  }
  if (const auto* names = in->names()) {
    Require(all_of_materials(names), "names do not add up");
    for (unsigned m = 0; m < out.materials.size(); ++m) {
      out.materials[m].name = ReadName(*names->Get(m));
    }
  }
  if (in->regions() == nullptr) return;
  const auto* meshes = in->region_meshes();
  Require(meshes == nullptr || meshes->size() == in->regions()->size(),
          "the regions' meshes do not add up");
  for (unsigned i = 0; i < in->regions()->size(); ++i) {
    const wire::Region* r = in->regions()->Get(i);
    MaterialRegion region{FromWire(r->low()), FromWire(r->high()), r->radius(), r->material(), {}};
    if (meshes != nullptr) ReadMesh(*meshes->Get(i), region.mesh);
    if (!region.mesh.triangles.empty()) CheckEncloses(region.mesh, "a region");
    Require(region.low.allFinite() && region.high.allFinite() && std::isfinite(region.radius) &&
                region.material < out.materials.size(),
            "a region is invalid");
    out.grid->regions.push_back(std::move(region));
  }
}

void ReadBur(const wire::Bur* in, Body& out) {
  if (in == nullptr) return;
  const auto* curve = in->curve();
  Require(curve != nullptr && curve->size() >= 2 && curve->size() % 2 == 0, "a bur is none");
  for (const double number :
       {in->dead_tip(), in->cutting(), in->speed(), in->tooth_Hz(), in->vibration()}) {
    Require(number >= 0.0 && std::isfinite(number), "a bur is none");
  }
  out.bur = BurProfile{{},
                       in->rounding(),
                       in->dead_tip(),
                       in->cutting(),
                       {in->speed(), in->tooth_Hz(), in->vibration()}};
  for (unsigned i = 0; i < curve->size(); i += 2) {
    out.bur->curve.push_back({curve->Get(i), curve->Get(i + 1)});
  }
  if (in->at() == nullptr) return;
  Require(in->along() != nullptr && in->sense() != nullptr, "an edge is invalid");
  const EdgePlace edge{FromWire(*in->at()), FromWire(*in->along()), FromWire(*in->sense())};
  const auto is_unit = [](const Vec3& v) { return std::abs(v.squaredNorm() - 1.0) < 1e-9; };
  Require(edge.at.allFinite() && is_unit(edge.along) && is_unit(edge.sense), "an edge is invalid");
  out.bur->edge = edge;
}

Effect FromWire(const wire::Effect& in) {
  Effect effect;
  effect.file = ReadName(*in.file());
  effect.hash = in.hash();
  auto numbers = All(in.numbers());
  for (const std::uint32_t size : All(in.sizes())) {
    Require(size <= numbers.size(), "an effect's numbers do not add up");
    effect.values.emplace_back(numbers.begin(), numbers.begin() + size);
    numbers = numbers.subspan(size);
  }
  Require(numbers.empty(), "an effect's numbers do not add up");
  return effect;
}

FreeBody FromWire(const wire::FreeBody& in) {
  Require(in.centre() != nullptr && in.point() != nullptr && in.axis() != nullptr &&
              in.inertia()->size() == 6 &&
              in.kind() <= static_cast<std::uint8_t>(BodyJoint::Kind::kSprings),
          "a free body is incomplete");
  const auto I = [&](unsigned i) { return in.inertia()->Get(i); };
  FreeBody body{in.mass(), FromWire(*in.centre())};
  body.inertia << I(0), I(3), I(4), I(3), I(1), I(5), I(4), I(5), I(2);
  body.joint = {static_cast<BodyJoint::Kind>(in.kind()),
                FromWire(*in.point()),
                FromWire(*in.axis()),
                in.low(),
                in.high(),
                in.stiffness(),
                in.damping(),
                in.torsional_stiffness(),
                in.torsional_damping()};
  return body;
}

MovedGroup FromWire(const wire::MovedGroup& in) {
  Require(in.point() != nullptr && in.axis() != nullptr, "a group that moves has no axis");
  MovedGroup group{
      .name = ReadName(*in.name()),
      .free = in.free() == nullptr ? std::nullopt : std::optional(FromWire(*in.free())),
      .point = FromWire(*in.point()),
      .axis = FromWire(*in.axis()),
      .keys = {},
      .smooth = in.smooth(),
      .repeats = in.repeats()};
  for (const wire::MotionKey* key : *in.keys()) {
    group.keys.push_back({key->at(), key->turn(), FromWire(key->shift())});
  }
  if (const std::string fault = MotionFault(group); !fault.empty()) {
    throw Error(group.name + ": " + fault);
  }
  return group;
}

Features FromWire(const wire::Features& in) {
  Require(in.contact() <= wire::Contact::MAX && in.friction() <= wire::Friction::MAX,
          "its features are not known");
  return {static_cast<ContactModel>(in.contact()), static_cast<FrictionModel>(in.friction()),
          in.compliance()};
}

/// The value of a slot of the material that is no longer used.
constexpr double kHardness = std::numeric_limits<double>::infinity();

wire::Features ToWire(const Features& f) {
  return {static_cast<wire::Contact>(f.contact), static_cast<wire::Friction>(f.friction),
          f.compliance, false};
}

Scene ReadScene(const wire::Scene& in) {
  std::vector<Body> geometries;
  for (const wire::Geometry* geometry : *in.geometries()) {
    GeometryReader(*geometry, geometries.emplace_back()).Read();
  }
  SceneSize size;  // before any copy is made
  for (const auto* list : {in.tools(), in.objects()}) {
    Require(list->size() > 0, "it has no tool, or no object");
    for (const wire::Body* body : *list) {
      Require(body->geometry() < geometries.size(), "a body names no geometry");
      const Body& geometry = geometries[body->geometry()];
      size.Add(body->name()->str(), geometry.mesh, geometry.tree);
    }
  }
  const auto read_bodies = [&](const auto& list) {
    std::vector<Body> bodies;
    for (const wire::Body* body : list) {
      bodies.push_back(geometries[body->geometry()]);
      bodies.back().name = ReadName(*body->name());
      bodies.back().X_WB = FromWire(body->pose());
      if (body->look() != nullptr) bodies.back().look = body->look()->str();
      if (body->remarks() != nullptr) {
        for (const auto* remark : *body->remarks()) bodies.back().remarks.push_back(remark->str());
      }
      bodies.back().tree.origin = FromWire(body->tree_origin());
      ReadAmbient(*body, bodies.back());
      ReadMargin(*body, bodies.back());
      ReadMaterials(*body, bodies.back());
      ReadGrid(body->grid(), bodies.back());
      ReadBur(body->bur(), bodies.back());
      bodies.back().moved = body->moved();
    }
    return bodies;
  };
  Scene scene;
  scene.name = ReadName(*in.name());
  scene.tools = read_bodies(*in.tools());
  scene.objects = read_bodies(*in.objects());
  scene.coupling = {in.stiffness(), in.torsional_stiffness()};
  const std::string spring = SpringFault(in.stiffness(), in.torsional_stiffness());
  if (!spring.empty()) throw Error("coupling: " + spring);
  scene.tuning = {in.separation(), in.widest_step(), in.sub_steps(),
                  in.iterates(),   in.queries(),     in.still_cycles()};
  if (const std::string fault = TuningFault(scene.tuning); !fault.empty()) throw Error(fault);
  scene.features = FromWire(*in.features());
  if (in.effects() != nullptr) {
    for (const wire::Effect* effect : *in.effects()) scene.effects.push_back(FromWire(*effect));
  }
  scene.hands_meet = in.hands_meet();
  Require(!scene.hands_meet || (scene.tools.size() >= 2 && scene.tools.size() <= kMostHands),
          "hands meet, and there are not two to four");
  if (in.moved() != nullptr) {
    Require(in.moved()->size() <= kMostMoved, "too many groups move");
    for (const wire::MovedGroup* group : *in.moved()) scene.moved.push_back(FromWire(*group));
  }
  if (in.gravity() != nullptr) scene.gravity = FromWire(*in.gravity());
  Require(scene.gravity.allFinite(), "gravity is not finite");
  for (const Body& object : scene.objects) {
    Require(object.moved <= scene.moved.size(), "an object moves with no group");
  }
  if (const wire::FirstSight* sight = in.first_sight()) {
    scene.first_sight = {FromWire(sight->centre()), sight->radius(), FromWire(sight->from())};
    Require(std::isfinite(sight->radius()) && sight->radius() > 0.0 &&
                scene.first_sight->centre.allFinite() &&
                std::abs(scene.first_sight->from.squaredNorm() - 1.0) < 1e-6,
            "the first sight is invalid");
  }
  return scene;
}

/// Returns the header after checking it, and that the rest has the size it gives.
Header ReadHeader(std::span<const std::uint8_t> bytes, const std::string& source) {
  const auto refuse = [&](const std::string& why) { throw Error(source + ": " + why); };
  const std::size_t magic = std::min(bytes.size(), sizeof kMagic);
  if (bytes.empty() || std::memcmp(bytes.data(), kMagic, magic) != 0) {
    refuse("is not a Palpate scene bundle; make one with palpate-scene build");
  }
  if (bytes.size() < sizeof(Header)) {
    refuse("is cut short (" + std::to_string(bytes.size()) +
           " bytes, not even a header); build or copy it again");
  }
  Header header;
  std::memcpy(&header, bytes.data(), sizeof header);
  if (header.version != kBundleVersion) {
    refuse("has bundle version " + std::to_string(header.version) + ", this program reads " +
           std::to_string(kBundleVersion) + "; build it again with palpate-scene build");
  }
  const std::size_t size = bytes.size() - sizeof header;
  if (size < header.size) {
    refuse("is cut short (" + std::to_string(size) + " of " + std::to_string(header.size) +
           " bytes); build or copy it again");
  }
  if (size > header.size) {
    refuse("is longer than it says (" + std::to_string(size) + ", not " +
           std::to_string(header.size) + " bytes); build or copy it again");
  }
  return header;
}

}  // namespace

bool SameGeometry(const Body& a, const Body& b) {
  const SphereTree& s = a.tree;
  const SphereTree& t = b.tree;
  return SameBytes(a.mesh.vertices, b.mesh.vertices) &&
         SameBytes(a.mesh.triangles, b.mesh.triangles) && SameBytes(s.leaf_x, t.leaf_x) &&
         SameBytes(s.leaf_y, t.leaf_y) && SameBytes(s.leaf_z, t.leaf_z) &&
         SameBytes(s.leaf_radius, t.leaf_radius) && SameBytes(s.packets, t.packets) &&
         s.level_begin == t.level_begin && s.leaf_triangle_begin == t.leaf_triangle_begin &&
         s.leaf_triangle == t.leaf_triangle && s.centroid == t.centroid;
}

std::uint64_t HashBytes(std::string_view bytes, std::uint64_t seed) {
  return XXH64(bytes.data(), bytes.size(), seed);
}

bool LooksLikeBundle(std::string_view bytes) {
  return bytes.substr(0, sizeof kMagic) == std::string_view(kMagic, sizeof kMagic);
}

std::vector<std::uint8_t> PackScene(const Scene& scene, std::uint64_t content_key,
                                    Remarks remarks) {
  flatbuffers::FlatBufferBuilder out(1 << 20);
  std::vector<const Body*> distinct;
  std::vector<flatbuffers::Offset<wire::Geometry>> geometries;
  const auto pack_bodies = [&](const std::vector<Body>& bodies) {
    std::vector<flatbuffers::Offset<wire::Body>> packed;
    for (const Body& body : bodies) {
      std::uint32_t geometry = 0;
      while (geometry < distinct.size() && !SameGeometry(body, *distinct[geometry])) ++geometry;
      if (geometry == distinct.size()) {
        distinct.push_back(&body);
        geometries.push_back(PackGeometry(body, out));
      }
      const Quat& q = body.X_WB.q;
      const wire::Pose pose(ToWire(body.X_WB.p), q.w(), q.x(), q.y(), q.z());
      std::vector<wire::Material> materials;
      for (const Material& m : body.materials) {
        materials.emplace_back(m.stiffness, m.static_friction, m.dynamic_friction, kHardness);
      }
      const auto name = out.CreateString(body.name);
      const auto materials_at = out.CreateVectorOfStructs(materials);
      const auto leaf_material = out.CreateVector(body.leaf_material);
      std::vector<wire::Vec3> margin;
      for (const Vec3& point : body.margin) margin.push_back(ToWire(point));
      const bool keep = remarks == Remarks::kKeep;
      packed.push_back(wire::CreateBody(
          out, name, geometry, &pose, materials_at, leaf_material,
          body.look.empty() ? 0 : out.CreateString(body.look),
          body.ambient.empty() ? 0 : out.CreateVector(body.ambient),
          keep && !body.remarks.empty() ? out.CreateVectorOfStrings(body.remarks) : 0,
          keep ? static_cast<wire::TreeOrigin>(body.tree.origin) : wire::TreeOrigin::Unknown,
          margin.empty() ? 0 : out.CreateVectorOfStructs(margin), PackGrid(body, out),
          PackBur(body, out), body.moved));
    }
    return out.CreateVector(packed);
  };
  const auto tools = pack_bodies(scene.tools);
  const auto objects = pack_bodies(scene.objects);
  const auto geometries_at = out.CreateVector(geometries);
  const auto name = out.CreateString(scene.name);
  const auto effects = PackEffects(scene, out);
  const auto moved = PackMoved(scene, out);
  const wire::Features features = ToWire(scene.features);
  std::optional<wire::Vec3> gravity;
  if (!scene.gravity.isZero(0.0)) gravity = ToWire(scene.gravity);
  std::optional<wire::FirstSight> sight;
  if (scene.first_sight) {
    sight.emplace(ToWire(scene.first_sight->centre), scene.first_sight->radius,
                  ToWire(scene.first_sight->from));
  }
  out.Finish(
      wire::CreateScene(out, name, geometries_at, tools, objects, scene.coupling.stiffness,
                        scene.coupling.torsional_stiffness, &features, sight ? &*sight : nullptr,
                        scene.tuning.separation, scene.tuning.widest_step, scene.tuning.sub_steps,
                        scene.tuning.iterates, scene.tuning.queries, scene.tuning.still_cycles,
                        effects, moved, scene.hands_meet, gravity ? &*gravity : nullptr),
      wire::SceneIdentifier());

  Header header{};
  std::memcpy(header.magic, kMagic, sizeof kMagic);
  header.version = kBundleVersion;
  header.content_key = content_key;
  header.size = out.GetSize();
  header.checksum = XXH64(out.GetBufferPointer(), out.GetSize(), content_key);
  std::vector<std::uint8_t> bytes(sizeof header + out.GetSize());
  std::memcpy(bytes.data(), &header, sizeof header);
  std::memcpy(bytes.data() + sizeof header, out.GetBufferPointer(), out.GetSize());
  return bytes;
}

std::uint64_t ContentKey(std::span<const std::uint8_t> bytes, const std::string& source) {
  return ReadHeader(bytes, source).content_key;
}

Scene UnpackScene(std::span<const std::uint8_t> bytes, const std::string& source) {
  const Header header = ReadHeader(bytes, source);
  std::span<const std::uint8_t> payload = bytes.subspan(sizeof header);
  if (header.reserved != 0 ||
      XXH64(payload.data(), payload.size(), header.content_key) != header.checksum) {
    throw Error(source + ": is damaged (its checksum does not match); build or copy it again");
  }
  std::vector<std::uint64_t> aligned;  // a FlatBuffer needs its doubles aligned
  if (reinterpret_cast<std::uintptr_t>(payload.data()) % alignof(double) != 0) {
    aligned.resize(payload.size() / sizeof aligned[0] + 1);
    std::memcpy(aligned.data(), payload.data(), payload.size());
    payload = {reinterpret_cast<const std::uint8_t*>(aligned.data()), payload.size()};
  }
  flatbuffers::Verifier verifier(payload.data(), payload.size());
  if (!wire::VerifySceneBuffer(verifier)) {
    throw Error(source + ": is not a valid scene bundle; build it again");
  }
  const wire::Scene& scene = *wire::GetScene(payload.data());
  if (scene.features()->removal()) {
    throw Error(source +
                ": removes material leaf by leaf, which is no longer supported; build it again "
                "from a scene file with \"grid_um\"");
  }
  try {
    return ReadScene(scene);
  } catch (const Error& error) {
    throw Error(source + ": is inconsistent (" + error.what() + "); build it again");
  }
}

namespace {

/// Delays Ctrl-C for its lifetime.
class UndisturbedBySignals {
 public:
  UndisturbedBySignals() {
    sigset_t signals;
    sigemptyset(&signals);
    for (const int signal : {SIGHUP, SIGINT, SIGQUIT, SIGTERM}) sigaddset(&signals, signal);
    pthread_sigmask(SIG_BLOCK, &signals, &before_);
  }
  ~UndisturbedBySignals() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  UndisturbedBySignals(const UndisturbedBySignals&) = delete;
  UndisturbedBySignals& operator=(const UndisturbedBySignals&) = delete;

 private:
  sigset_t before_;
};

}  // namespace

void WriteFileAtomically(const std::string& file, std::span<const std::uint8_t> bytes) {
  namespace fs = std::filesystem;
  const UndisturbedBySignals undisturbed;
  const fs::path path(file);
  const std::string temporary = file + "." + std::to_string(getpid()) + ".tmp";
  std::error_code error;
  if (path.has_parent_path() && !fs::is_directory(path.parent_path(), error)) {
    throw Error(file + ": cannot be written; there is no folder " + path.parent_path().string());
  }
  std::ofstream out(temporary, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()), std::ssize(bytes));
  out.close();
  if (out) fs::rename(temporary, path, error);
  if (!out || error) {
    fs::remove(temporary, error);
    throw Error(file + ": cannot be written; check the rights and the space left on the disk");
  }
}

void CheckPackable(const Scene& scene) {
  if (scene.tools.empty() || scene.objects.empty()) {
    throw Error(scene.name + ": has no tool, or no object; a scene file has both");
  }
  const auto check = [](const std::string& name) {
    if (!name.empty() && IsName(name)) return;
    throw Error(Quoted(name) + ": is no name in a scene file; give letters, digits, - _ and ., " +
                std::to_string(kLongestName) + " at most");
  };
  check(scene.name);
  std::set<std::string_view> names;
  for (const auto* bodies : {&scene.tools, &scene.objects}) {
    for (const Body& body : *bodies) {
      check(body.name);
      if (names.insert(body.name).second) continue;
      throw Error(body.name + ": is the name of two bodies; give each its own");
    }
  }
}

}  // namespace palpate
