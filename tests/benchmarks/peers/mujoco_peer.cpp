// MuJoCo (Todorov, Erez & Tassa, IROS 2012): soft contacts between the convex hulls of the meshes.
#include <cstring>
#include <memory>

#include <mujoco/mujoco.h>
#include <spdlog/fmt/fmt.h>

#include "common/error.h"
#include "tests/benchmarks/peers/peer.h"
#include "tests/benchmarks/peers/virtual_coupling.h"

namespace palpate::bench {
namespace {

std::string MeshAsset(const std::string& name, const TriangleMesh& mesh, const Vec3& origin) {
  std::string xml = fmt::format("<mesh name=\"{}\" vertex=\"", name);
  for (const Vec3& v : mesh.vertices) {
    const Vec3 p = v - origin;
    xml += fmt::format("{:.9g} {:.9g} {:.9g} ", p.x(), p.y(), p.z());
  }
  return xml + "\"/>\n";
}

/// The scene in MuJoCo's MJCF.
std::string Mjcf(const PeerScene& scene, const VirtualCoupling& coupling) {
  std::string assets, bodies;
  std::string tool = "type=\"mesh\" mesh=\"tool\"";
  if (scene.ball) {
    tool = fmt::format("type=\"sphere\" size=\"{:.9g}\"", *scene.ball);
  } else {
    assets += MeshAsset("tool", *scene.tool, scene.centroid);
  }
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const std::string name = fmt::format("object{}", i);
    assets += MeshAsset(name, *scene.objects[i].mesh, Vec3::Zero());
    const Pose& X = scene.objects[i].X_WB;
    bodies += fmt::format(
        "<body pos=\"{:.17g} {:.17g} {:.17g}\" quat=\"{:.17g} {:.17g} {:.17g} {:.17g}\">"
        "<geom type=\"mesh\" mesh=\"{}\"/></body>\n",
        X.p.x(), X.p.y(), X.p.z(), X.q.w(), X.q.x(), X.q.y(), X.q.z(), name);
  }
  return fmt::format(R"(<mujoco>
<option timestep="{:.17g}" gravity="0 0 0"/>
<default><geom condim="1" solref="{:.17g} 1" solimp="0.95 0.99 0.0001"/></default>
<asset>
{}</asset>
<worldbody>
{}<body name="tool"><freejoint/>
<inertial pos="0 0 0" mass="{:.17g}" diaginertia="{:.17g} {:.17g} {:.17g}"/><geom {}/></body>
</worldbody></mujoco>)",
                     1e-3, 2e-3, assets, bodies, coupling.mass(), coupling.inertia(),
                     coupling.inertia(), coupling.inertia(), tool);
}

mjModel* Compile(const std::string& xml) {
  const auto vfs = std::make_unique<mjVFS>();
  mj_defaultVFS(vfs.get());
  mj_makeEmptyFileVFS(vfs.get(), "scene.xml", static_cast<int>(xml.size()));
  std::memcpy(vfs->filedata[mj_findFileVFS(vfs.get(), "scene.xml")], xml.data(), xml.size());
  char reason[1000] = "";
  mjModel* model = mj_loadXML("scene.xml", vfs.get(), reason, sizeof reason);
  mj_deleteVFS(vfs.get());
  if (model == nullptr) throw Error(std::string("MuJoCo cannot load the scene: ") + reason);
  return model;
}

class Mujoco : public Peer {
 public:
  Mujoco(const PeerScene& scene, const Pose& start)
      : centroid_(scene.centroid),
        coupling_(scene.coupling, Centred(start)),
        model_(Compile(Mjcf(scene, coupling_))),
        data_(mj_makeData(model_.get())),
        tool_(mj_name2id(model_.get(), mjOBJ_BODY, "tool")) {
    const Pose X = Centred(start);
    const double qpos[7] = {X.p.x(), X.p.y(), X.p.z(), X.q.w(), X.q.x(), X.q.y(), X.q.z()};
    std::copy(qpos, qpos + 7, data_->qpos);
  }

  PeerStep Step(const Pose& X_WH) override {
    coupling_.MoveHand(Centred(X_WH));
    const Pose X = ToolCentre();
    // A free joint's angular velocity is in the body's frame.
    const Wrench pull = coupling_.Pull(X, {Vec3(data_->qvel), X.q * Vec3(data_->qvel + 3)});
    mjtNum* applied = data_->xfrc_applied + 6 * tool_;
    for (int k = 0; k < 3; ++k) {
      applied[k] = pull.force[k];
      applied[k + 3] = pull.torque[k];
    }
    mj_step(model_.get(), data_.get());
    PeerStep step{ToolCentre(), coupling_.on_hand(), data_->ncon};
    step.X_WG.p = step.X_WG * -centroid_;
    return step;
  }

 private:
  Pose Centred(const Pose& X_WT) const { return {X_WT * centroid_, X_WT.q}; }
  Pose ToolCentre() const {
    const double* q = data_->qpos;
    return {Vec3(q), Quat(q[3], q[4], q[5], q[6]).normalized()};
  }
  struct Delete {
    void operator()(mjModel* model) const { mj_deleteModel(model); }
    void operator()(mjData* data) const { mj_deleteData(data); }
  };

  Vec3 centroid_;
  VirtualCoupling coupling_;
  std::unique_ptr<mjModel, Delete> model_;
  std::unique_ptr<mjData, Delete> data_;
  int tool_;
};

}  // namespace

PeerKind MujocoPeer() {
  return {.id = "mujoco",
          .name = "MuJoCo",
          .package = "libmujoco-dev",
          .version = mj_versionString(),
          .settings =
              "the convex hulls of the meshes, for it collides nothing else: the bunnies are "
              "hulls, and what it says of their meshes is of those (a decomposition into convex "
              "parts is its user's to make, and was not made); a ball by its own sphere; contacts "
              "as stiff as 1 kHz allows (solref 2 ms, solimp 0.95 0.99)",
          .convex = true,
          .make = [](const PeerScene& scene, const Pose& start) {
            return std::make_unique<Mujoco>(scene, start);
          }};
}

}  // namespace palpate::bench
