// FCL (Pan, Chitta & Manocha, ICRA 2012): distance between meshes, no response.
#include <limits>
#include <memory>
#include <vector>

#include <fcl/config.h>
#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/distance.h>

#include "tests/benchmarks/peers/peer.h"

namespace palpate::bench {
namespace {

using FclMesh = fcl::BVHModel<fcl::OBBRSSd>;

std::shared_ptr<FclMesh> MakeMesh(const TriangleMesh& mesh) {
  std::vector<fcl::Triangle> triangles;
  for (const auto& t : mesh.triangles) triangles.emplace_back(t[0], t[1], t[2]);
  auto model = std::make_shared<FclMesh>();
  model->beginModel();
  model->addSubModel(mesh.vertices, triangles);
  model->endModel();
  return model;
}

fcl::Transform3d ToFcl(const Pose& X) {
  fcl::Transform3d T = fcl::Transform3d::Identity();
  T.linear() = X.q.toRotationMatrix();
  T.translation() = X.p;
  return T;
}

class Fcl : public Peer {
 public:
  explicit Fcl(const PeerScene& scene) : offset_(scene.ball ? scene.centroid : Vec3::Zero()) {
    if (scene.ball) {
      tool_ = std::make_unique<fcl::CollisionObjectd>(std::make_shared<fcl::Sphered>(*scene.ball));
    } else {
      tool_ = std::make_unique<fcl::CollisionObjectd>(MakeMesh(*scene.tool));
    }
    for (const PeerScene::Object& object : scene.objects) {
      objects_.push_back(
          std::make_unique<fcl::CollisionObjectd>(MakeMesh(*object.mesh), ToFcl(object.X_WB)));
    }
  }

  PeerStep Step(const Pose& X_WG) override {
    tool_->setTransform(ToFcl({X_WG * offset_, X_WG.q}));
    double distance = std::numeric_limits<double>::infinity();
    for (const auto& object : objects_) {
      const fcl::DistanceRequestd request(/*enable_nearest_points=*/true);
      fcl::DistanceResultd result;
      distance = std::min(distance, fcl::distance(tool_.get(), object.get(), request, result));
    }
    // Where they overlap it is -1 or, of a ball, what happens to be there.
    return {X_WG, {}, distance < 1e-9 ? 0.0 : distance, 0};
  }

 private:
  Vec3 offset_;
  std::unique_ptr<fcl::CollisionObjectd> tool_;
  std::vector<std::unique_ptr<fcl::CollisionObjectd>> objects_;
};

}  // namespace

PeerKind FclPeer() {
  return {.id = "fcl",
          .name = "FCL",
          .package = "libfcl-dev",
          .version = FCL_VERSION,
          .settings =
              "the distance between the meshes (OBB-RSS trees), where Palpate's tool is: it "
              "gives no response, so this is time and distance alone",
          .responds = false,
          .make = [](const PeerScene& scene, const Pose&, const PeerSettings&) {
            return std::make_unique<Fcl>(scene);
          }};
}

}  // namespace palpate::bench
