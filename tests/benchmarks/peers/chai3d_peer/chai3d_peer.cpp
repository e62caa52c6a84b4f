// CHAI3D (Conti et al.): its finger proxy, the god-object with a radius (Ruspini, Kolarov & Khatib,
// SIGGRAPH 1997), against a triangle mesh.  It knows no tool but balls.
#include <map>
#include <memory>

#include <forces/CAlgorithmFingerProxy.h>
#include <version.h>
#include <world/CMesh.h>
#include <world/CWorld.h>

#include "common/error.h"
#include "tests/benchmarks/peers/peer.h"

namespace palpate::bench {
namespace {

chai3d::cVector3d ToChai(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}
Vec3 FromChai(const chai3d::cVector3d& v) {
  return {v.x(), v.y(), v.z()};
}

/// One step is one call of the algorithm, as in the servo loop of its examples; the world does not
/// move, so its global poses are computed once.
class Chai3d : public Peer {
 public:
  /// @param units  of CHAI3D in a metre.  Its tolerances are lengths in its units (an epsilon of
  ///               1e-4), so they are a tenth of a millimetre where a unit is a metre.
  Chai3d(const PeerScene& scene, const Pose& start, double units) : units_(units) {
    if (!scene.ball) throw Error("it renders balls only, no mesh against a mesh");
    centroid_ = scene.centroid;
    for (const PeerScene::Object& object : scene.objects) {
      auto* mesh = new chai3d::cMesh();
      world_.addChild(mesh);  // which deletes it
      for (const Vec3& v : object.mesh->vertices) {
        const Vec3 at = units_ * (object.X_WB * v);
        mesh->newVertex(at.x(), at.y(), at.z());
      }
      for (const auto& t : object.mesh->triangles) mesh->newTriangle(t[0], t[1], t[2]);
      mesh->computeAllNormals();
      mesh->setHapticEnabled(true);
      // Its force is in newtons, its lengths are in its units.
      mesh->setStiffness(scene.coupling.stiffness / units_, true);
      mesh->createAABBCollisionDetector(units_ * *scene.ball);
    }
    world_.computeGlobalPositions(true);
    proxy_.initialize(&world_, ToChai(units_ * (start * centroid_)));
    proxy_.setProxyRadius(units_ * *scene.ball);
  }

  PeerStep Step(const Pose& X_WH) override {
    const chai3d::cVector3d still(0.0, 0.0, 0.0);  // without friction it is not used
    const Vec3 force = FromChai(proxy_.computeForces(ToChai(units_ * (X_WH * centroid_)), still));
    const Pose X_WG{FromChai(proxy_.getProxyGlobalPosition()) / units_ - X_WH.q * centroid_,
                    X_WH.q};
    return {X_WG, {force, Vec3::Zero()}, proxy_.getNumCollisionEvents()};
  }

 private:
  double units_;
  Vec3 centroid_ = Vec3::Zero();
  chai3d::cWorld world_;
  chai3d::cAlgorithmFingerProxy proxy_;
};

}  // namespace
}  // namespace palpate::bench

extern "C" void PalpatePeers(std::vector<palpate::bench::PeerKind>& kinds) {
  using namespace palpate::bench;
  for (const auto& [unit, units] : std::map<std::string, double>{{"1 m", 1.0}, {"1 cm", 100.0}}) {
    kinds.push_back(
        {.id = unit == "1 m" ? "chai3d-m" : "chai3d-cm",
         .name = "CHAI3D, a unit of " + unit,
         .package = "",
         .version = CHAI3D_VERSION,
         .settings = "finger proxy, with the tolerances that it comes with, in units of " + unit,
         .make = [units](const PeerScene& scene, const palpate::Pose& start, const PeerSettings&) {
           return std::make_unique<Chai3d>(scene, start, units);
         }});
  }
}
