// ODE (Smith): rigid bodies whose contacts come from triangle meshes against each other.
#include <memory>
#include <mutex>
#include <vector>

#include <ode/ode.h>

#include "tests/benchmarks/peers/peer.h"
#include "tests/benchmarks/peers/virtual_coupling.h"

namespace palpate::bench {
namespace {

constexpr int kMostContacts = 1024;  // per pair of geometries; the bunnies' path has at most 43

// All else is ODE's default: QuickStep with 20 iterations, ERP 0.2, CFM 1e-10.  The greatest depth
// of a vertex on the bunnies' path is then 74 um; 151 with ERP 0.8, 103 with 50 iterations, 112
// with the exact dWorldStep, 69 with CFM 1e-5, 65 with a surface layer of 10 um.

/// A mesh in ODE's layout, about `origin`.
struct OdeMesh {
  OdeMesh(const TriangleMesh& mesh, const Vec3& origin) : data(dGeomTriMeshDataCreate()) {
    for (const Vec3& v : mesh.vertices) {
      for (int i = 0; i < 3; ++i) vertices.push_back(v[i] - origin[i]);
    }
    for (const auto& t : mesh.triangles) {
      for (const std::uint32_t corner : t) indices.push_back(corner);
    }
    dGeomTriMeshDataBuildDouble(data, vertices.data(), 3 * sizeof(double),
                                static_cast<int>(mesh.vertices.size()), indices.data(),
                                static_cast<int>(indices.size()), 3 * sizeof(dTriIndex));
  }
  ~OdeMesh() { dGeomTriMeshDataDestroy(data); }
  OdeMesh(const OdeMesh&) = delete;
  OdeMesh& operator=(const OdeMesh&) = delete;

  std::vector<double> vertices;
  std::vector<dTriIndex> indices;
  dTriMeshDataID data;
};

class Ode : public Peer {
 public:
  Ode(const PeerScene& scene, const Pose& start)
      : centroid_(scene.centroid), coupling_(scene.coupling, Centred(start)) {
    static std::once_flag once;
    std::call_once(once, [] { dInitODE2(0); });
    dAllocateODEDataForThread(dAllocateMaskAll);
    dRandSetSeed(0);  // QuickStep shuffles its rows
    world_ = dWorldCreate();
    contacts_ = dJointGroupCreate(0);
    tool_ = dBodyCreate(world_);
    dMass mass;
    dMassSetParameters(&mass, coupling_.mass(), 0, 0, 0, coupling_.inertia(), coupling_.inertia(),
                       coupling_.inertia(), 0, 0, 0);
    dBodySetMass(tool_, &mass);
    if (scene.ball) {
      tool_geom_ = dCreateSphere(nullptr, *scene.ball);
    } else {
      meshes_.push_back(std::make_unique<OdeMesh>(*scene.tool, centroid_));
      tool_geom_ = dCreateTriMesh(nullptr, meshes_.back()->data, nullptr, nullptr, nullptr);
    }
    dGeomSetBody(tool_geom_, tool_);
    const Pose X = Centred(start);
    dBodySetPosition(tool_, X.p.x(), X.p.y(), X.p.z());
    const dQuaternion q = {X.q.w(), X.q.x(), X.q.y(), X.q.z()};
    dBodySetQuaternion(tool_, q);
    for (const PeerScene::Object& object : scene.objects) {
      meshes_.push_back(std::make_unique<OdeMesh>(*object.mesh, Vec3::Zero()));
      dGeomID geom = dCreateTriMesh(nullptr, meshes_.back()->data, nullptr, nullptr, nullptr);
      const Pose& X_WB = object.X_WB;
      dGeomSetPosition(geom, X_WB.p.x(), X_WB.p.y(), X_WB.p.z());
      const dQuaternion r = {X_WB.q.w(), X_WB.q.x(), X_WB.q.y(), X_WB.q.z()};
      dGeomSetQuaternion(geom, r);
      objects_.push_back(geom);
    }
    found_.resize(kMostContacts);
  }
  ~Ode() override {
    for (dGeomID geom : objects_) dGeomDestroy(geom);
    dGeomDestroy(tool_geom_);
    dJointGroupDestroy(contacts_);
    dWorldDestroy(world_);
  }

  PeerStep Step(const Pose& X_WH) override {
    coupling_.MoveHand(Centred(X_WH));
    const Wrench pull = coupling_.Pull(
        ToolCentre(), {FromOde(dBodyGetLinearVel(tool_)), FromOde(dBodyGetAngularVel(tool_))});
    dBodyAddForce(tool_, pull.force.x(), pull.force.y(), pull.force.z());
    dBodyAddTorque(tool_, pull.torque.x(), pull.torque.y(), pull.torque.z());
    int contacts = 0;
    for (dGeomID object : objects_) contacts += Collide(object);
    dWorldQuickStep(world_, 1e-3);
    dJointGroupEmpty(contacts_);
    PeerStep step{ToolCentre(), coupling_.on_hand(), contacts};
    step.X_WG.p = step.X_WG * -centroid_;
    return step;
  }

 private:
  static Vec3 FromOde(const dReal* v) { return {v[0], v[1], v[2]}; }
  Pose Centred(const Pose& X_WT) const { return {X_WT * centroid_, X_WT.q}; }
  Pose ToolCentre() const {
    const dReal* q = dBodyGetQuaternion(tool_);
    return {FromOde(dBodyGetPosition(tool_)), Quat(q[0], q[1], q[2], q[3]).normalized()};
  }
  int Collide(dGeomID object) {
    const int n = dCollide(tool_geom_, object, kMostContacts, found_.data(), sizeof(dContactGeom));
    for (int i = 0; i < n; ++i) {
      dContact contact{};
      contact.surface.mode = 0;
      contact.surface.mu = 0;
      contact.geom = found_[static_cast<std::size_t>(i)];
      dJointAttach(dJointCreateContact(world_, contacts_, &contact), tool_, nullptr);
    }
    return n;
  }

  Vec3 centroid_;
  VirtualCoupling coupling_;
  dWorldID world_;
  dJointGroupID contacts_;
  dBodyID tool_;
  dGeomID tool_geom_;
  std::vector<std::unique_ptr<OdeMesh>> meshes_;
  std::vector<dGeomID> objects_;
  std::vector<dContactGeom> found_;
};

}  // namespace

PeerKind OdePeer() {
  return {.id = "ode",
          .name = "ODE",
          .package = "libode-dev",
          .version = PALPATE_ODE_VERSION,
          .settings =
              "trimesh against trimesh (OPCODE), a ball by its own sphere; QuickStep, "
              "with the iterations, ERP and CFM that it comes with",
          .make = [](const PeerScene& scene, const Pose& start) {
            return std::make_unique<Ode>(scene, start);
          }};
}

}  // namespace palpate::bench
