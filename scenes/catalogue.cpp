#include "scenes/catalogue.h"

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <map>
#include <mutex>
#include <numeric>
#include <sstream>
#include <system_error>
#include <thread>
#include <utility>

#include "common/coupling_fault.h"
#include "common/error.h"
#include "common/files/project_files.h"
#include "common/files/whole_file.h"
#include "common/json/json_file.h"
#include "common/math/default_rounding.h"
#include "common/math/rotation.h"
#include "common/program/machine.h"
#include "common/revision.h"
#include "common/text/hex16.h"
#include "common/text/nearest_word.h"
#include "common/text/quoted.h"
#include "scenes/files/cache_folder.h"
#include "scenes/files/effect_file.h"
#include "scenes/files/scene_bundle.h"
#include "scenes/files/scene_file.h"
#include "scenes/files/scene_size.h"
#include "scenes/grid/bur.h"
#include "scenes/grid/solid_grid.h"
#include "scenes/leaf_paint.h"
#include "scenes/mesh/ambient_light.h"
#include "scenes/mesh/curved_mesh.h"
#include "scenes/mesh/mass_properties.h"
#include "scenes/mesh/mesh_import.h"
#include "scenes/mesh/mesh_mend.h"
#include "scenes/mesh/mesh_orient.h"
#include "scenes/mesh/mesh_report.h"
#include "scenes/mesh/mesh_solid.h"
#include "scenes/mesh/mesh_spike.h"
#include "scenes/mesh/model_files.h"
#include "scenes/shapes/shape_kinds.h"
#include "scenes/shapes/shapes.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

/// Limit of a scene's text or bundle [bytes]: what its bodies may hold, and 64 MB for names,
/// materials and remarks.
constexpr std::uint64_t kLargestSceneFile = kMaxSceneBytes + (std::uint64_t{64} << 20);

fs::path CatalogueFolder() {
  if (const char* folder = std::getenv("PALPATE_CATALOGUE")) return folder;
  return PlaceOf(ProjectFile::kCatalogue);
}

/// Runs `work`, and adds to its errors which body they are about.
template <class Work>
auto About(const std::string& where, Work work) {
  try {
    return work();
  } catch (const Error& error) {
    throw Error(where + ": " + error.what());
  }
}

bool IsImported(const MeshSource& source) {
  return source.kind == MeshSource::Kind::kModel || source.kind == MeshSource::Kind::kFile;
}

/// Returns the kind of a shape; null if it is none of shape_kinds.h.
const ShapeKind* ShapeOf(const MeshSource& source) {
  return source.kind == MeshSource::Kind::kShape ? FindShapeKind(source.what) : nullptr;
}

std::string MeshFile(const MeshSource& source, const std::string& models_dir) {
  if (source.kind == MeshSource::Kind::kFile) return source.what;
  return About(source.where, [&] { return FindModel(source.what, models_dir); });
}

/// Mesh and tree of a body, and the mesh's named parts.
struct Shape {
  TriangleMesh mesh;
  SphereTree tree;
  std::vector<MeshGroup> groups;
  std::vector<std::string> remarks;  ///< what was repaired in the file, and what looks wrong
};

/// Makes the body's mesh.  Errors name the scene file's line.
/// @param body  receives the named parts of a mesh file, and what was repaired.
TriangleMesh MakeMesh(const MeshSource& source, const std::string& models_dir, Shape& body) {
  switch (source.kind) {
    case MeshSource::Kind::kBox:
      return MakeBox(source.size);
    case MeshSource::Kind::kEllipsoid:
      return MakeEllipsoid(source.size, source.triangles);
    case MeshSource::Kind::kSphere:
      return MakeSphere(source.size.x(), source.triangles);
    case MeshSource::Kind::kShape:
      return About(source.where,
                   [&] { return ShapeOf(source)->make(source.variant, source.values); });
    default:
      break;
  }
  const std::string file = MeshFile(source, models_dir);
  return About(source.where, [&] {
    TriangleMesh mesh = ImportMesh(file, &body.groups);
    const MeshReport report = InspectMesh(mesh);
    if (!report.refusal.empty()) throw Error(file + ": " + report.refusal);
    body.remarks = MendMesh(mesh, &body.groups);
    if (const auto spike = FindSpike(mesh)) {
      if (spike->certain()) throw Error(file + ": " + SpikeRemark(*spike));
      body.remarks.push_back(SpikeRemark(*spike));
    }
    PlaceMesh(source.placement, mesh);
    if (const std::string remark = UnitRemark(source.placement, mesh); !remark.empty()) {
      body.remarks.push_back(remark);
    }
    if (source.thickness && !Thicken(*source.thickness, mesh)) {
      throw Error("thickness_mm: " + file + " is closed, it has no sheets; drop it");
    }
    return mesh;
  });
}

void Warn(const LoadOptions& options, const std::string& what) {
  options.warn ? options.warn(what) : void(std::cerr << "warning: " << Printable(what) << '\n');
}

void Tell(const LoadOptions& options, const std::string& what) {
  options.tell ? options.tell(what) : void(std::cerr << Printable(what) << '\n');
}

/// Throws Error if no triangle of the mesh lies in the edge, because then nothing would cut.
void CheckEdge(const BurProfile& edge, const TriangleMesh& mesh, const std::string& where) {
  const Bur bur(edge.curve, edge.rounding);
  const Quat to_T = RotationBetween(edge.edge->along, Vec3::UnitZ());
  const auto is_in = [&](std::uint32_t vertex) {
    Vec3 gradient;
    return bur.Distance(to_T * (mesh.vertices[vertex] - edge.edge->at), gradient) <= 0.0;
  };
  if (std::ranges::none_of(mesh.triangles,
                           [&](const auto& t) { return std::ranges::all_of(t, is_in); })) {
    throw Error(where +
                ": holds no triangle of the tool's mesh; give an at_mm and a curve_mm that enclose "
                "the cutting part of the mesh");
  }
}

/// Refines the body's mesh as its scene file asks.  All that follows, trees, bundles, viewers,
/// physics and oracles, uses only the refined mesh.
void Curve(const MeshSource& source, const LoadOptions& options, Shape& body) {
  CurvedMesh refined = RefineCurved(body.mesh, *source.curved);
  if (refined.tolerance > source.curved->tolerance) {
    std::ostringstream text;
    text << source.where << ".curved: " << source.curved->max_triangles
         << " triangles do not suffice for " << 1e6 * source.curved->tolerance
         << " um; the mesh is true to " << 1e6 * refined.tolerance << " um with "
         << refined.mesh.triangles.size() << " (raise max_triangles or tolerance_um)";
    Warn(options, text.str());
  }
  // Named parts are ranges of triangles, and refining keeps the triangles' order.
  const auto first_of = [&](std::uint32_t triangle) {
    return static_cast<std::uint32_t>(
        std::lower_bound(refined.source.begin(), refined.source.end(), triangle) -
        refined.source.begin());
  };
  for (MeshGroup& group : body.groups) {
    group.begin = first_of(group.begin);
    group.end = first_of(group.end);
  }
  body.mesh = std::move(refined.mesh);
}

/// The approximate cost of building a body, in units of one leaf inside a mesh.
struct Work {
  double mesh = 0.0, tree = 0.0;
  double all() const { return mesh + tree; }
};

/// Estimates the cost; for mesh files, from their size.  As measured with 2,000,000 triangles
/// (mesh-import.md) and a bunny of 70,000, reading and repairing a triangle costs a hundredth of a
/// leaf, and half of that again in building the tree.
Work WorkOf(const BodyDescription& body, const std::string& models_dir) {
  constexpr double kBytesPerTriangle = 40.0;
  const bool ball = body.mesh.kind == MeshSource::Kind::kSphere;
  double triangles = double(body.mesh.triangles);
  if (IsImported(body.mesh)) {
    std::error_code none;
    const auto bytes = fs::file_size(MeshFile(body.mesh, models_dir), none);
    triangles = none ? 0.0 : double(bytes) / kBytesPerTriangle;
  }
  double leaves = double(body.leaves);
  if (body.tolerance) leaves = ball ? 1.0 : 8192.0;  // the sum over all counts that are tried
  const bool moved = body.tree == TreeMode::kBalanced;
  return {1.0 + 0.01 * triangles, (moved ? 6.0 : 1.0) * leaves + 0.005 * triangles};
}

/// The share of a scene that is done, over all bodies that are being built; it never decreases.
class SceneProgress {
 public:
  SceneProgress(const std::vector<const BodyDescription*>& bodies, const LoadOptions& options)
      : bodies_(bodies), progress_(options.progress), done_(bodies.size(), 0.0) {
    for (const BodyDescription* body : bodies) {
      work_.push_back(WorkOf(*body, options.models_dir).all());
    }
  }
  /// May be called from any thread.
  /// @param fraction  of the n-th body.
  void Tell(std::size_t n, std::string_view stage, double fraction) {
    if (!progress_) return;
    std::string who = bodies_[n]->name + ": ";
    if (bodies_.size() > 1) {
      who = "body " + std::to_string(n + 1) + " of " + std::to_string(bodies_.size()) + ", " + who;
    }
    const std::lock_guard lock(mutex_);
    done_[n] = std::max(done_[n], work_[n] * fraction);
    progress_(who.append(stage), Sum(done_) / Sum(work_));
  }

 private:
  static double Sum(const std::vector<double>& all) {
    return std::accumulate(all.begin(), all.end(), 0.0);
  }

  const std::vector<const BodyDescription*>& bodies_;
  const Progress& progress_;
  std::vector<double> work_, done_;
  std::mutex mutex_;
};

Shape MakeShape(const BodyDescription& description, const LoadOptions& options,
                const Progress& progress) {
  const Work work = WorkOf(description, options.models_dir);
  Shape body;
  progress("reading the mesh", 0.0);
  body.mesh = MakeMesh(description.mesh, options.models_dir, body);
  if (description.mesh.curved) Curve(description.mesh, options, body);
  const bool ball = description.mesh.kind == MeshSource::Kind::kSphere;
  // The ball itself is more accurate than any number of leaves.
  if (ball && (description.leaves == 1 || description.tolerance)) {
    body.tree = SingleSphereTree(body.mesh, {Vec3::Zero(), description.mesh.size.x()});
    return body;
  }
  const auto tell = [&](std::string_view stage, double fraction) {
    progress(stage, (work.mesh + work.tree * fraction) / work.all());
  };
  if (description.tolerance) {
    TolerantTree built = About(description.name, [&] {
      return BuildToTolerance(body.mesh, *description.tolerance, tell, description.tree);
    });
    Tell(options, description.name + ": " + built.found);
    if (!built.shortfall.empty()) body.remarks.push_back(built.shortfall);
    body.tree = std::move(built.tree);
    return body;
  }
  body.tree = About(description.name, [&] {
    return description.mesh_alone
               ? BuildInnerTree(body.mesh)
               : BuildSphereTree(body.mesh, description.leaves, tell, description.tree);
  });
  return body;
}

std::span<const std::uint8_t> Bytes(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

std::uint64_t HashOfMesh(const std::string& file) {
  std::uint64_t hash = 0;
  for (const std::string& part : FilesOfMesh(file))
    hash = HashBytes(ReadWholeFile(part, kLargestMeshFile), hash);
  return hash;
}

/// Returns the hash of everything that decides what a compiled scene contains.
std::uint64_t KeyOf(const SceneDescription& scene, const std::string& text,
                    const std::string& models_dir) {
  std::uint64_t key = HashBytes(text, HashBytes(kScenesRevision, 0));
  key = HashBytes(scene.name, key + static_cast<std::uint64_t>(scene.features.contact));
  std::map<std::string, std::uint64_t> hashes;  // of each mesh file, computed once
  const auto add_file_of = [&](const MeshSource& mesh) {
    if (!IsImported(mesh)) return;
    const std::string file = MeshFile(mesh, models_dir);
    const auto [it, fresh] = hashes.try_emplace(file, 0);
    if (fresh) it->second = About(mesh.where, [&] { return HashOfMesh(file); });
    key = HashBytes(std::to_string(it->second), key);
  };
  for (const auto* bodies : {&scene.tools, &scene.objects}) {
    for (const BodyDescription& body : *bodies) {
      for (const RegionDescription& region : body.regions) {
        if (region.kind == RegionDescription::Kind::kMesh) add_file_of(region.mesh);
      }
      key = HashBytes(NameOf(body.tree), key);
      add_file_of(body.mesh);
    }
  }
  return key;
}

bool SameMesh(const MeshSource& m, const MeshSource& n) {
  return m.kind == n.kind && m.what == n.what && m.size == n.size && m.triangles == n.triangles &&
         m.variant == n.variant && m.values == n.values && m.curved == n.curved &&
         m.thickness == n.thickness && m.placement.metres_per_unit == n.placement.metres_per_unit &&
         m.placement.longest_side == n.placement.longest_side &&
         m.placement.origin == n.placement.origin;
}

bool SameGeometry(const BodyDescription& a, const BodyDescription& b) {
  return a.leaves == b.leaves && a.tolerance == b.tolerance && a.mesh_alone == b.mesh_alone &&
         a.tree == b.tree && SameMesh(a.mesh, b.mesh);
}

/// Returns the bodies to build: of several with the same geometry only the first.
std::vector<const BodyDescription*> DistinctBodies(const SceneDescription& scene) {
  std::vector<const BodyDescription*> distinct;
  for (const auto* bodies : {&scene.tools, &scene.objects}) {
    for (const BodyDescription& body : *bodies) {
      if (std::ranges::none_of(
              distinct, [&](const BodyDescription* other) { return SameGeometry(body, *other); })) {
        distinct.push_back(&body);
      }
    }
  }
  return distinct;
}

/// Returns how far a tool reaches from its centroid [m]; 0 for a ball, which contacts cannot turn.
double ReachOf(const Body& tool) {
  if (tool.tree.leaves() == 1) return 0.0;
  double reach = 0.0;
  for (const Vec3& v : tool.mesh.vertices) reach = std::max(reach, (v - tool.tree.centroid).norm());
  return reach;
}

/// Returns the number of bodies to build at the same time: by default one per core.
std::size_t BodiesAtOnce(const LoadOptions& options) {
  return options.bodies_at_once > 0 ? options.bodies_at_once
                                    : static_cast<std::size_t>(UsableCores());
}

/// A body's shape that a thread has made, and the messages about it.
struct MadeShape {
  Shape shape;
  std::vector<std::function<void()>> said;
  std::exception_ptr failed;

  /// Passes the messages on, and throws what was thrown in the thread.
  void Tell() {
    for (const auto& say : std::exchange(said, {})) say();
    if (failed) std::rethrow_exception(failed);
  }
};

/// Makes the shapes of bodies in several threads; bodies are independent.  Entries after one that
/// fails may be missing.
std::vector<MadeShape> MakeShapes(const std::vector<const BodyDescription*>& bodies,
                                  const LoadOptions& options) {
  struct NobodyTakesIt {};
  std::vector<MadeShape> all(bodies.size());
  SceneProgress progress(bodies, options);
  std::atomic<std::size_t> next = 0, end = bodies.size();
  const auto make = [&](std::size_t n) {
    MadeShape& made = all[n];
    LoadOptions saying = options;
    saying.warn = [&](const std::string& what) {
      made.said.emplace_back([&options, what] { Warn(options, what); });
    };
    saying.tell = [&](const std::string& what) {
      made.said.emplace_back([&options, what] { Tell(options, what); });
    };
    const auto tell = [&](std::string_view stage, double fraction) {
      if (n >= end) throw NobodyTakesIt();
      progress.Tell(n, stage, fraction);
    };
    made.shape = MakeShape(*bodies[n], saying, tell);
    tell("done", 1.0);
  };
  const auto make_some = [&] {
    for (std::size_t n = next++; n < end; n = next++) {
      try {
        make(n);
      } catch (...) {
        all[n].failed = std::current_exception();
        for (std::size_t last = end; n < last && !end.compare_exchange_weak(last, n + 1);) {
        }
      }
    }
  };
  std::vector<std::jthread> helpers;
  try {
    while (helpers.size() + 1 < std::min(bodies.size(), BodiesAtOnce(options))) {
      helpers.emplace_back(make_some);
    }
  } catch (const std::system_error&) {
    // Go on with fewer threads.
  }
  make_some();
  helpers.clear();  // joins them
  return all;
}

/// Makes a body of its shape.
Body BodyOf(const BodyDescription& from, Shape shape, const LoadOptions& options, SceneSize& size) {
  Body body;
  body.name = from.name;
  body.mesh = std::move(shape.mesh);
  body.tree = std::move(shape.tree);
  body.X_WB = from.X_WB;
  body.look = from.look;
  body.moved = from.moved;
  body.remarks = std::move(shape.remarks);
  if (const ShapeKind* kind = ShapeOf(from.mesh); kind != nullptr && kind->margin != nullptr) {
    body.margin = kind->margin(from.mesh.variant, from.mesh.values);
  }
  if (const ShapeKind* kind = ShapeOf(from.mesh); kind != nullptr && kind->bur != nullptr) {
    body.bur = kind->bur(from.mesh.variant, from.mesh.values);
    body.bur->spin = from.spin;
  }
  if (from.edge) {
    CheckEdge(*from.edge, body.mesh, from.edge_where);
    body.bur = from.edge;
  }
  PaintLeaves(from, shape.groups, body);
  for (std::size_t i = 0; body.grid && i < from.regions.size(); ++i) {
    const MeshSource& inner = from.regions[i].mesh;
    if (from.regions[i].kind != RegionDescription::Kind::kMesh) continue;
    Shape within;
    within.mesh = MakeMesh(inner, options.models_dir, within);
    if (inner.curved) Curve(inner, options, within);
    About(inner.where, [&] { CheckEncloses(within.mesh, body.name); });
    About(inner.where, [&] { size.Add(from.name, within.mesh, {}); });
    body.grid->regions[i].mesh = std::move(within.mesh);
  }
  return body;
}

/// Gives a free body the mass and the inertia of its mesh.
void Weigh(const BodyDescription& from, const Body& object, FreeBody& body) {
  const std::optional<MassProperties> solid = MassOf(object.mesh, object.X_WB);
  if (!solid) {
    throw Error(from.free_where + ": " + from.name +
                " has no volume: its mesh is open, or inside out; give a closed mesh, or let it "
                "stand still");
  }
  if (from.density) body.mass = *from.density * solid->volume;
  body.centre = solid->centre;
  body.inertia = body.mass / solid->volume * solid->inertia;
  if (const std::string fault = BodyFault(body); !fault.empty()) {
    throw Error(from.free_where + ": " + from.name + " " + fault);
  }
}

Scene Compile(const SceneDescription& description, const LoadOptions& options) {
  Scene scene;
  scene.name = description.name;
  scene.coupling = description.coupling;
  scene.tuning = description.tuning;
  scene.features = description.features;
  scene.first_sight = description.first_sight;
  scene.moved = description.moved;
  scene.hands_meet = description.hands_meet;
  scene.gravity = description.gravity;
  const std::vector<const BodyDescription*> distinct = DistinctBodies(description);
  std::vector<MadeShape> shapes = MakeShapes(distinct, options);
  const auto number_of = [&](const BodyDescription& body) {
    const auto same = std::ranges::find_if(
        distinct, [&](const BodyDescription* other) { return SameGeometry(body, *other); });
    return static_cast<std::size_t>(same - distinct.begin());
  };
  std::vector<std::size_t> users(distinct.size(), 0);  // bodies that still need it
  for (const auto* bodies : {&description.tools, &description.objects}) {
    for (const BodyDescription& body : *bodies) ++users[number_of(body)];
  }
  SceneSize size;
  const auto compile = [&](const BodyDescription& from) {
    const std::size_t number = number_of(from);
    MadeShape& made = shapes[number];  // bodies of the same geometry share it
    made.Tell();
    Shape shape = --users[number] > 0 ? made.shape : std::move(made.shape);
    About(from.mesh.where, [&] { size.Add(from.name, shape.mesh, shape.tree); });
    return BodyOf(from, std::move(shape), options, size);
  };
  for (const BodyDescription& tool : description.tools) {
    scene.tools.push_back(compile(tool));
    const std::string fault = CouplingFault(
        scene.coupling.stiffness, scene.coupling.torsional_stiffness, ReachOf(scene.tools.back()));
    if (!fault.empty()) throw Error(description.coupling_where + ": " + fault);
  }
  for (const BodyDescription& object : description.objects) {
    scene.objects.push_back(compile(object));
    if (object.moved > 0 && scene.moved[object.moved - 1].free) {
      Weigh(object, scene.objects.back(), *scene.moved[object.moved - 1].free);
    }
  }
  if (std::ranges::none_of(scene.objects, [](const Body& body) { return body.look.empty(); })) {
    LightObjects(scene.objects);
  }
  return scene;
}

/// Throws Error for a file of another program, such as a CAD file: it says which files are
/// accepted, instead of where the JSON is wrong.
void RefuseWhatIsNoScene(const std::string& file, const std::string& text) {
  const std::size_t begin = text.find_first_not_of(" \t\r\n");
  const bool like_json = begin != std::string::npos && (text[begin] == '{' || text[begin] == '/');
  if (like_json || IsMeshFile(file) || fs::path(file).extension() == ".json") return;
  throw Error(file +
              ": is neither a scene nor a supported mesh; give a scene file (.json), a bundle "
              "(.palpate), or export the mesh as .stl, .obj, .ply, .3ds, .gltf or .glb");
}

std::string SceneTextOfMesh(const std::string& file, const LoadOptions& options) {
  if (options.progress) options.progress("reading " + file, 0.0);
  const MeshScene scene = MakeMeshScene(file, options.mesh, fs::path(file).parent_path().string());
  for (const std::string& assumption : scene.assumptions) Tell(options, assumption);
  Tell(options, "to change any of it, make a scene file of it: palpate-scene new " +
                    ShellWord(file) + " -o " + ShellWord(scene.name + ".json"));
  return scene.text;
}

/// Returns what to compile: the scene file, with the changes that the options make.
SceneDescription Describe(const std::string& text, const std::string& file,
                          const LoadOptions& options) {
  SceneDescription scene = ParseScene(text, file);
  if (options.contact) {
    scene.features.contact = *options.contact;
    ChooseModes(scene);
  }
  if (options.leaves) {
    for (auto* bodies : {&scene.tools, &scene.objects}) {
      for (BodyDescription& body : *bodies) {
        // Keep a single leaf: it is the exact ball.
        if (body.leaves == 1) continue;
        body.leaves = 0;
        body.tolerance = options.leaves;
      }
    }
  }
  for (auto* bodies : {&scene.tools, &scene.objects}) {
    if (!options.tree) break;
    for (BodyDescription& body : *bodies) {
      body.tree = *options.tree;
      body.tree_left_open = false;
    }
  }
  ChooseLeaves(scene);
  return scene;
}

Scene LoadBundle(const std::string& bytes, const std::string& file, const LoadOptions& options) {
  if (options.tree || options.leaves) {
    throw Error(file +
                ": is a bundle, whose trees cannot be changed; give the scene file, or omit the " +
                (options.tree ? "mode" : "tolerance"));
  }
  Scene scene = UnpackScene(Bytes(bytes), file);
  LoadEffects(scene.effects, fs::path(file).parent_path(), file);
  return scene;
}

/// Returns the compiled scene, from the cache if it is there; without effects, which
/// need no compiling.
Scene CompileOnce(const SceneDescription& description, const std::string& text,
                  const LoadOptions& options) {
  if (!options.use_cache) return Compile(description, options);

  const auto warn = [&](const std::string& what) { Warn(options, what); };
  const std::string folder = options.cache_dir.empty() ? DefaultCacheFolder() : options.cache_dir;
  if (folder.empty()) return Compile(description, options);
  try {
    PrepareCacheFolder(folder);
  } catch (const Error& error) {
    warn(std::string(error.what()) + " (the scene is used without being cached)");
    return Compile(description, options);
  }
  std::uint64_t key = KeyOf(description, text, options.models_dir);
  // Options that the text does not include.
  if (options.leaves) key = HashBytes(ToText(*options.leaves), key);
  std::ostringstream name;
  name << description.name << '-' << std::hex << std::setw(16) << std::setfill('0') << key
       << ".palpate";
  const std::string cached = (fs::path(folder) / name.str()).string();
  std::error_code ignored;
  if (fs::exists(cached, ignored)) {
    try {
      if (!IsOwnFile(cached)) throw Error(cached + ": is not owned by this user");
      const std::string bundle = ReadWholeFile(cached, kLargestSceneFile);
      if (ContentKey(Bytes(bundle), cached) != key) throw Error(cached + ": is of another scene");
      return UnpackScene(Bytes(bundle), cached);
    } catch (const Error& error) {
      warn(std::string(error.what()) + " (a cached scene: it is being rebuilt)");
    }
  }
  Scene scene = Compile(description, options);
  try {
    WriteFileAtomically(cached, PackScene(scene, key, Remarks::kKeep));
  } catch (const Error& error) {
    warn(std::string(error.what()) + " (the scene is used without being cached)");
  }
  return scene;
}

}  // namespace

std::vector<std::string> CatalogueNames() {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(CatalogueFolder(), ignored)) {
    const fs::path name = entry.path().stem();
    // NAME.path.json is the hand's script for NAME, and NAME.criteria.json its grading criteria.
    if (entry.path().extension() == ".json" && name.extension() != ".path" &&
        name.extension() != ".criteria") {
      names.push_back(name.string());
    }
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::vector<CatalogueEntry> ListCatalogue() {
  std::vector<CatalogueEntry> entries;
  for (const std::string& name : CatalogueNames()) {
    const JsonNode scene = JsonNode::Load(FindSceneFile(name));
    const std::optional<JsonNode> description = scene.Find("description");
    entries.push_back({name, description ? description->String() : ""});
  }
  return entries;
}

std::string FindSceneFile(const std::string& name_or_path) {
  if (name_or_path.find('/') != std::string::npos || fs::path(name_or_path).has_extension()) {
    return name_or_path;
  }
  const fs::path file = CatalogueFolder() / (name_or_path + ".json");
  std::error_code ignored;
  if (fs::exists(file, ignored)) return file.string();
  const fs::path of_exercise = fs::path(PlaceOf(ProjectFile::kExercises)) / file.filename();
  if (fs::exists(of_exercise, ignored)) return of_exercise.string();
  const std::vector<std::string> names = CatalogueNames();
  std::string message = "there is no scene \"" + name_or_path + "\"" +
                        DidYouMean(name_or_path, {names.begin(), names.end()}) + " (in " +
                        CatalogueFolder().string() + ":";
  for (const std::string& name : names) message += " " + name;
  throw Error(message + "; the path of a scene or a mesh has a / or an ending, as .json or .stl)");
}

void SaveScene(Scene scene, const std::string& file) {
  if (!file.ends_with(".palpate")) throw Error(file + ": give a name that ends in .palpate");
  if (scene.name.empty()) scene.name = SceneNameOf(file);
  CheckPackable(scene);
  WriteFileAtomically(file, PackScene(scene, 0, Remarks::kKeep));
}

std::string ScriptFileBeside(const std::string& name_or_path, const std::string& tool) {
  const fs::path scene(FindSceneFile(name_or_path));
  const fs::path of_tool = fs::path(scene).replace_extension("." + tool + ".path.json");
  if (!tool.empty() && fs::exists(of_tool)) return of_tool.string();
  return fs::path(scene).replace_extension(".path.json").string();
}

std::string CriteriaFileBeside(const std::string& name_or_path) {
  return fs::path(FindSceneFile(name_or_path)).replace_extension(".criteria.json").string();
}

bool IsWholeAtStart(const std::string& name_or_path) {
  const std::string file = FindSceneFile(name_or_path);
  if (IsMeshFile(file)) return false;
  const std::string text = ReadWholeFile(file, kLargestSceneFile);
  return !LooksLikeBundle(text) && ParseScene(text, file).whole_at_start;
}

Scene LoadScene(const std::string& name_or_path, const LoadOptions& options) {
  const DefaultRounding rounding;
  const std::string file = FindSceneFile(name_or_path);
  const std::string text =
      IsMeshFile(file) ? SceneTextOfMesh(file, options) : ReadWholeFile(file, kLargestSceneFile);
  if (LooksLikeBundle(text)) return LoadBundle(text, file, options);
  RefuseWhatIsNoScene(file, text);
  const SceneDescription description = Describe(text, file, options);
  std::vector<Effect> effects;  // first, because what follows may take a minute
  for (const JsonNode& effect : description.effects) {
    effects.push_back(LoadEffect(effect, fs::path(file).parent_path()));
  }
  Scene scene = CompileOnce(description, text, options);
  scene.effects = std::move(effects);
  return scene;
}

std::string SceneHash(const Scene& scene) {
  return Hex16(BundleHash(PackScene(scene)));
}

}  // namespace palpate
