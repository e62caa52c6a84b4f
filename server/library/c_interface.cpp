#include <cmath>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <functional>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/math/pose_check.h"
#include "common/revision.h"
#include "server/library/palpate.h"
#include "server/library/physics.h"
#ifdef PALPATE_READS_SCENES
#include "server/library/scenes.h"
#endif

struct palpate_scene {
  palpate::Scene scene;
  std::function<palpate::Pose(double)> hand;  // of a script, at a time [s]; may be empty
  double duration = 0.0;
};
struct palpate_shared {
  palpate::HapticModel model;
  std::vector<palpate_parameter> parameters;
};
struct palpate_model {
  std::shared_ptr<const palpate_shared> shared;
};
struct palpate_proxy {
  std::shared_ptr<const palpate_shared> shared;  // must outlive the proxy below
  palpate::Proxy proxy;
};

namespace palpate {
namespace {

/// Fixed, so that an error can be reported even without memory.
thread_local char last_error[512] = "nothing has gone wrong";

void Tell(const char* what) {
  std::snprintf(last_error, sizeof last_error, "%s", what);
}

/// Calls a function that may throw; returns `failed` if it does.
template <class Result, class Function>
Result Guarded(Result failed, const Function& function) noexcept {
  try {
    return function();
  } catch (const std::bad_alloc&) {
    Tell("there is no memory left");
  } catch (const std::exception& error) {
    Tell(error.what());
  } catch (...) {
    Tell("an exception of a kind that is not known");
  }
  return failed;
}

void Require(bool holds, const char* what) {
  if (!holds) throw Error(what);
}

Pose ToPose(const palpate_pose& pose) {
  return {Vec3::Map(pose.position_m), Quat(pose.orientation_wxyz[0], pose.orientation_wxyz[1],
                                           pose.orientation_wxyz[2], pose.orientation_wxyz[3])};
}

palpate_pose FromPose(const Pose& X) {
  return {{X.p.x(), X.p.y(), X.p.z()}, {X.q.w(), X.q.x(), X.q.y(), X.q.z()}};
}

/// For poses that are given once, not in a step: checks them.
Pose ToChecked(const palpate_pose& pose) {
  Pose X = ToPose(pose);
  Require(X.p.allFinite() && X.q.coeffs().allFinite(), "pose: a number is not finite");
  Require(IsPose(X), "pose.orientation_wxyz: is no unit quaternion; no rotation is 1 0 0 0");
  X.q.normalize();
  return X;
}

std::vector<palpate_parameter> ToC(const std::vector<Parameter>& parameters) {
  std::vector<palpate_parameter> all;
  for (const Parameter& p : parameters) {
    all.push_back({p.name, p.unit, p.what, p.least, p.most, p.usual, p.value});
  }
  return all;
}

int Add(palpate_scene* scene, palpate_role role, const palpate_body& given,
        const std::function<Body(const BodyOptions&)>& make) {
  return Guarded(-1, [&] {
    Require(scene != nullptr, "scene: is NULL");
    Require(role == PALPATE_OBJECT || role == PALPATE_TOOL,
            "role: is neither PALPATE_OBJECT nor PALPATE_TOOL");
    const std::string fault =
        MaterialFault(given.stiffness_N_m, given.static_friction, given.dynamic_friction);
    if (!fault.empty()) throw Error("body: " + fault + "; begin with palpate_body_defaults()");
    Features& features = scene->scene.features;
    BodyOptions options;
    options.leaves = given.leaves;
    options.contact = features.contact;
    options.material = {given.stiffness_N_m, given.static_friction, given.dynamic_friction};
    Body body = make(options);
    Require(!body.name.empty(), "name: is empty");
    for (const auto* bodies : {&scene->scene.tools, &scene->scene.objects}) {
      for (const Body& other : *bodies) {
        if (other.name == body.name) throw Error(body.name + ": is the name of another body, too");
      }
    }
    body.X_WB = ToChecked(given.pose);
    if (role == PALPATE_TOOL) {
      scene->scene.tools.push_back(std::move(body));
      return 0;
    }
    // As in a scene file, features follow from the materials.
    if (given.static_friction > 0.0) features.friction = FrictionModel::kCoulomb;
    if (std::isfinite(given.stiffness_N_m)) features.compliance = true;
    scene->scene.objects.push_back(std::move(body));
    return 0;
  });
}

palpate_scene* Load(const char* name_or_path, std::optional<double> tolerance_um) {
  return Guarded<palpate_scene*>(nullptr, [&] {
    Require(name_or_path != nullptr, "name_or_path: is NULL");
#ifdef PALPATE_READS_SCENES
    LoadOptions options;
    if (tolerance_um) options.leaves = HeightTolerance(*tolerance_um);
    auto loaded = std::make_unique<palpate_scene>();
    loaded->scene = LoadScene(name_or_path, options);
    const std::string script = ScriptFileBeside(name_or_path);
    if (std::filesystem::exists(script)) {
      const PoseScript hand = PoseScript::Load(script);
      loaded->duration = hand.duration();
      loaded->hand = [hand](double t) { return hand.At(t); };
    }
    return loaded.release();
#else
    (void)tolerance_um;
    throw Error("this libpalpate was built without scenes; build it with PALPATE_PROGRAMS=ON");
    return static_cast<palpate_scene*>(nullptr);
#endif
  });
}

}  // namespace
}  // namespace palpate

using namespace palpate;

extern "C" {

const char* palpate_version(void) {
  return PALPATE_VERSION;
}

const char* palpate_physics_revision(void) {
  return kPhysicsRevision;
}
const char* palpate_last_error(void) {
  return last_error;
}

size_t palpate_fault_words(uint32_t faults, char* text, size_t size) {
  return Guarded(std::size_t{0}, [&] {
    const std::string words = FaultWords(faults);
    if (text != nullptr && size > 0) std::snprintf(text, size, "%s", words.c_str());
    return words.size();
  });
}

palpate_body palpate_body_defaults(void) {
  return {{{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0}}, 0, 0.0, 0.0, INFINITY};
}

palpate_scene* palpate_scene_new(palpate_contact contact) {
  return Guarded<palpate_scene*>(nullptr, [&] {
    Require(contact == PALPATE_SURFACE || contact == PALPATE_SPHERES,
            "contact: is neither PALPATE_SURFACE nor PALPATE_SPHERES");
    auto scene = std::make_unique<palpate_scene>();
    scene->scene.features.contact =
        contact == PALPATE_SPHERES ? ContactModel::kSpheres : ContactModel::kSurface;
    return scene.release();
  });
}

void palpate_scene_free(palpate_scene* scene) {
  delete scene;
}

palpate_scene* palpate_scene_load(const char* name_or_path) {
  return Load(name_or_path, std::nullopt);
}
palpate_scene* palpate_scene_load_to(const char* name_or_path, double tolerance_um) {
  return Load(name_or_path, tolerance_um);
}

int palpate_scene_save(const palpate_scene* scene, const char* file) {
  return Guarded(-1, [&] {
    Require(scene != nullptr && file != nullptr, "scene or file: is NULL");
#ifdef PALPATE_READS_SCENES
    SaveScene(scene->scene, file);
    return 0;
#else
    throw Error("this libpalpate was built without scenes; build it with PALPATE_PROGRAMS=ON");
    return -1;
#endif
  });
}

const char* palpate_scene_tool(const palpate_scene* scene, size_t tool, palpate_pose* start) {
  if (scene == nullptr || tool >= scene->scene.tools.size()) return nullptr;
  if (start != nullptr) *start = FromPose(scene->scene.tools[tool].X_WB);
  return scene->scene.tools[tool].name.c_str();
}

double palpate_scene_hand(const palpate_scene* scene, double seconds, palpate_pose* hand) {
  if (scene == nullptr || !scene->hand) return 0.0;
  if (hand != nullptr) *hand = FromPose(scene->hand(seconds));
  return scene->duration;
}

int palpate_scene_parameter(const palpate_scene* scene, size_t index, palpate_parameter* into) {
  return Guarded(-1, [&] {
    Require(scene != nullptr && into != nullptr, "scene or parameter: is NULL");
    const std::vector<palpate_parameter> all = ToC(ParametersOf(scene->scene));
    Require(index < all.size(), "index: there are no more parameters");
    *into = all[index];
    return 0;
  });
}

int palpate_scene_set_parameter(palpate_scene* scene, const char* name, double value) {
  return Guarded(-1, [&] {
    Require(scene != nullptr && name != nullptr, "scene or name: is NULL");
    SetParameter(scene->scene, name, value);
    return 0;
  });
}

int palpate_scene_add_mesh(palpate_scene* scene, palpate_role role, const char* name,
                           const double* vertices_m, size_t vertex_count, const uint32_t* triangles,
                           size_t triangle_count, const palpate_body* body) {
  return Add(scene, role, body ? *body : palpate_body_defaults(), [&](const BodyOptions& options) {
    Require(name != nullptr && vertices_m != nullptr && triangles != nullptr,
            "name, vertices_m or triangles: is NULL");
    TriangleMesh mesh;
    mesh.vertices.resize(vertex_count);
    for (std::size_t i = 0; i < vertex_count; ++i) mesh.vertices[i] = Vec3::Map(vertices_m + 3 * i);
    mesh.triangles.resize(triangle_count);
    for (std::size_t t = 0; t < triangle_count; ++t) {
      mesh.triangles[t] = {triangles[3 * t], triangles[3 * t + 1], triangles[3 * t + 2]};
    }
    return MakeBody(name, std::move(mesh), options);
  });
}

int palpate_scene_add_box(palpate_scene* scene, palpate_role role, const char* name,
                          const double size_m[3], const palpate_body* body) {
  return Add(scene, role, body ? *body : palpate_body_defaults(), [&](const BodyOptions& options) {
    Require(name != nullptr && size_m != nullptr, "name or size_m: is NULL");
    return MakeBody(name, MakeBox(Vec3::Map(size_m)), options);
  });
}

int palpate_scene_add_ball(palpate_scene* scene, palpate_role role, const char* name,
                           double radius_m, const palpate_body* body) {
  return Add(scene, role, body ? *body : palpate_body_defaults(), [&](const BodyOptions& options) {
    Require(name != nullptr, "name: is NULL");
    return MakeBall(name, radius_m, options.material);
  });
}

palpate_model* palpate_model_new(const palpate_scene* scene, size_t tool) {
  return Guarded<palpate_model*>(nullptr, [&] {
    Require(scene != nullptr, "scene: is NULL");
    if (tool >= scene->scene.tools.size()) {
      throw Error("tool: there is no tool " + std::to_string(tool) + ", the scene has " +
                  std::to_string(scene->scene.tools.size()) + "; add one as PALPATE_TOOL");
    }
    const Scene& whole = scene->scene;
    return new palpate_model{std::make_shared<const palpate_shared>(palpate_shared{
        MakeModel(whole, whole.tools[tool], MakeObjects(whole)), ToC(ParametersOf(whole))})};
  });
}

void palpate_model_free(palpate_model* model) {
  delete model;
}

palpate_proxy* palpate_proxy_new(const palpate_model* model, const palpate_pose* hand) {
  return Guarded<palpate_proxy*>(nullptr, [&] {
    Require(model != nullptr && hand != nullptr, "model or hand: is NULL");
    ToChecked(*hand);
    return new palpate_proxy{model->shared, Proxy(model->shared->model, ToPose(*hand))};
  });
}

void palpate_proxy_free(palpate_proxy* proxy) {
  delete proxy;
}

double palpate_proxy_start_depth(const palpate_proxy* proxy) {
  return proxy ? proxy->proxy.start_depth() : 0.0;
}

uint32_t palpate_proxy_step(palpate_proxy* proxy, const palpate_pose* hand,
                            palpate_report* report) {
  if (report == nullptr) return kFaultNotStarted;
  if (proxy == nullptr || hand == nullptr) {
    *report = palpate_report{};
    report->tool.orientation_wxyz[0] = 1.0;
    return report->faults = kFaultNotStarted;
  }
  Pose X_WH = ToPose(*hand);
  if (!IsPose(X_WH)) X_WH.q.coeffs().setZero();  // a fault of the step
  const StepReport step = proxy->proxy.Step(X_WH);
  Vec3::Map(report->force_N) = step.wrench.force;
  Vec3::Map(report->torque_Nm) = step.wrench.torque;
  report->tool = FromPose(step.X_WG);
  report->faults = step.faults;
  int rigid = 0;
  while (rigid < step.contacts && std::isinf(step.active[rigid].stiffness)) ++rigid;
  report->contacts = rigid + step.soft_contacts;
  report->points = step.contacts;
  report->parameter = proxy->shared->parameters.data();
  report->parameters = proxy->shared->parameters.size();
  for (int i = 0; i < PALPATE_POINTS; ++i) {
    palpate_point& point = report->point[i];
    if (i >= step.contacts) {
      point = palpate_point{};
      continue;
    }
    Vec3::Map(point.point_m) = step.active[i].contact_W;
    Vec3::Map(point.force_N) =
        step.active[i].force * step.active[i].normal + step.active[i].friction;
  }
  return report->faults;
}

size_t palpate_proxy_save(const palpate_proxy* proxy, void* bytes, size_t size) {
  return Guarded(std::size_t{0}, [&] {
    Require(proxy != nullptr, "proxy: is NULL");
    const Proxy& of = proxy->proxy;
    const std::vector<std::uint8_t> state = ToBytes(of.model(), {of.state(), of.start_depth()});
    if (bytes != nullptr && size >= state.size()) std::memcpy(bytes, state.data(), state.size());
    return state.size();
  });
}

int palpate_proxy_restore(palpate_proxy* proxy, const void* bytes, size_t size) {
  return Guarded(-1, [&] {
    Require(proxy != nullptr && bytes != nullptr, "proxy or bytes: is NULL");
    const ProxyState state =
        StateOf(proxy->proxy.model(), {static_cast<const std::uint8_t*>(bytes), size});
    proxy->proxy.set_state(state.step, state.start_depth);
    return 0;
  });
}

}  // extern "C"
