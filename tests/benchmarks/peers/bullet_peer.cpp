// Bullet 3 (Coumans): rigid bodies whose contacts come from GImpact's triangles against triangles.
#include <memory>
#include <vector>

#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <btBulletDynamicsCommon.h>

#include "tests/benchmarks/peers/peer.h"
#include "tests/benchmarks/peers/virtual_coupling.h"

namespace palpate::bench {
namespace {

// Bullet's manual asks for bodies larger than 0.2 units: one unit is a centimetre.  Forces scale
// with lengths, torques and inertias with their square.
constexpr double kUnits = 100.0;
// Two margins, 40 um in all, lie between touching meshes.  On the bunnies' path, the mean and
// greatest depths of a vertex are 12 and 267 um with 0.0005; 2.4 and 192 with this margin; 0.9 and
// 322 with 0.01; none with the default of 0.04, but 0.8 mm apart and for nearly twice the time.
constexpr double kMargin = 0.002;
// Solver iterations; the default of 10 gives a mean depth of 9 um in the same time.
constexpr int kIterations = 50;

btVector3 ToBullet(const Vec3& v) {
  return {static_cast<btScalar>(v.x()), static_cast<btScalar>(v.y()), static_cast<btScalar>(v.z())};
}
Vec3 FromBullet(const btVector3& v) {
  return {v.x(), v.y(), v.z()};
}
btTransform ToBullet(const Pose& X) {
  const auto s = [](double x) { return static_cast<btScalar>(x); };
  return btTransform({s(X.q.x()), s(X.q.y()), s(X.q.z()), s(X.q.w())}, ToBullet(kUnits * X.p));
}

/// A mesh in Bullet's units, about `origin`.
struct BulletMesh {
  BulletMesh(const TriangleMesh& mesh, const Vec3& origin) {
    for (const Vec3& v : mesh.vertices) vertices.push_back(ToBullet(kUnits * (v - origin)));
    for (const auto& t : mesh.triangles) {
      for (const std::uint32_t corner : t) indices.push_back(static_cast<int>(corner));
    }
    array = std::make_unique<btTriangleIndexVertexArray>(
        static_cast<int>(mesh.triangles.size()), indices.data(), 3 * static_cast<int>(sizeof(int)),
        static_cast<int>(vertices.size()), &vertices[0].m_floats[0],
        static_cast<int>(sizeof(btVector3)));
  }
  std::unique_ptr<btCollisionShape> Gimpact() {
    auto shape = std::make_unique<btGImpactMeshShape>(array.get());
    shape->setMargin(static_cast<btScalar>(kMargin));
    shape->updateBound();
    return shape;
  }

  std::vector<btVector3> vertices;
  std::vector<int> indices;
  std::unique_ptr<btTriangleIndexVertexArray> array;
};

class Bullet : public Peer {
 public:
  Bullet(const PeerScene& scene, const Pose& start)
      : centroid_(scene.centroid),
        coupling_(scene.coupling, Centred(start)),
        dispatcher_(&configuration_),
        world_(&dispatcher_, &broadphase_, &solver_, &configuration_) {
    btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher_);
    world_.setGravity({0, 0, 0});
    world_.getSolverInfo().m_numIterations = kIterations;
    if (scene.ball) {
      shapes_.push_back(
          std::make_unique<btSphereShape>(static_cast<btScalar>(kUnits * *scene.ball)));
    } else {
      meshes_.push_back(std::make_unique<BulletMesh>(*scene.tool, centroid_));
      shapes_.push_back(meshes_.back()->Gimpact());
    }
    const auto inertia = static_cast<btScalar>(coupling_.inertia() * kUnits * kUnits);
    tool_ = Add(*shapes_.back(), Centred(start), coupling_.mass(), inertia);
    tool_->setActivationState(DISABLE_DEACTIVATION);
    tool_->setDamping(0, 0);
    for (const PeerScene::Object& object : scene.objects) {
      meshes_.push_back(std::make_unique<BulletMesh>(*object.mesh, Vec3::Zero()));
      shapes_.push_back(meshes_.back()->Gimpact());
      Add(*shapes_.back(), object.X_WB, 0.0, 0);
    }
  }
  ~Bullet() override {
    for (const auto& body : bodies_) world_.removeRigidBody(body.get());
  }

  PeerStep Step(const Pose& X_WH) override {
    coupling_.MoveHand(Centred(X_WH));
    const Wrench pull = coupling_.Pull(
        ToolCentre(),
        {FromBullet(tool_->getLinearVelocity()) / kUnits, FromBullet(tool_->getAngularVelocity())});
    tool_->applyCentralForce(ToBullet(kUnits * pull.force));
    tool_->applyTorque(ToBullet(kUnits * kUnits * pull.torque));
    world_.stepSimulation(static_cast<btScalar>(1e-3), 0);
    PeerStep step{ToolCentre(), coupling_.on_hand(), 0};
    step.X_WG.p = step.X_WG * -centroid_;
    for (int i = 0; i < dispatcher_.getNumManifolds(); ++i) {
      step.contacts += dispatcher_.getManifoldByIndexInternal(i)->getNumContacts();
    }
    return step;
  }

 private:
  /// The pose of the frame at the centroid.
  Pose Centred(const Pose& X_WT) const { return {X_WT * centroid_, X_WT.q}; }
  Pose ToolCentre() const {
    const btTransform& X = tool_->getWorldTransform();
    const btQuaternion q = X.getRotation();
    return {FromBullet(X.getOrigin()) / kUnits, Quat(q.w(), q.x(), q.y(), q.z()).normalized()};
  }
  btRigidBody* Add(btCollisionShape& shape, const Pose& X, double mass, btScalar inertia) {
    btRigidBody::btRigidBodyConstructionInfo info(static_cast<btScalar>(mass), nullptr, &shape,
                                                  {inertia, inertia, inertia});
    info.m_startWorldTransform = ToBullet(X);
    info.m_friction = 0;
    bodies_.push_back(std::make_unique<btRigidBody>(info));
    world_.addRigidBody(bodies_.back().get());
    return bodies_.back().get();
  }

  Vec3 centroid_;
  VirtualCoupling coupling_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_;
  std::vector<std::unique_ptr<BulletMesh>> meshes_;
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  btRigidBody* tool_ = nullptr;
};

}  // namespace

PeerKind BulletPeer() {
  return {.id = "bullet",
          .name = "Bullet",
          .package = "libbullet-dev",
          .version = "3.24",
          .settings =
              "GImpact mesh against GImpact mesh, a ball by its own sphere; double precision, "
              "a margin of 20 µm on each mesh, so that they rest 40 µm apart, a unit of 1 cm (its "
              "manual asks for bodies "
              "above 0.2 units), 50 iterations; a pair of bodies keeps 4 contacts",
          .make = [](const PeerScene& scene, const Pose& start) {
            return std::make_unique<Bullet>(scene, start);
          }};
}

}  // namespace palpate::bench
