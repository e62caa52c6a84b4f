// Your own material: the same block hard and smooth, hard and rough, and soft.  Contact with soft
// leaves uses their spheres.
#include <cstdio>

#include <palpate/physics.h>

namespace {

void Press(const char* what, const palpate::Material& material) {
  using namespace palpate;
  Scene scene;
  scene.features = {
      .contact = ContactModel::kSpheres, .friction = FrictionModel::kCoulomb, .compliance = true};
  BodyOptions block{.leaves = 2000, .contact = ContactModel::kSpheres, .material = material};
  scene.objects.push_back(MakeBody("block", MakeBox({0.04, 0.04, 0.04}), block));
  scene.tools.push_back(MakeBall("ball", 0.005));
  const HapticModel model = MakeModel(scene, scene.tools[0], MakeObjects(scene));
  Pose X_WH;
  X_WH.p = {0.0, 0.030, 0.0};
  Proxy proxy(model, X_WH);
  StepReport report;
  for (int ms = 0; ms < 1000; ++ms) {  // 3 mm into the face, then 3 mm along it
    (ms < 500 ? X_WH.p.y() : X_WH.p.x()) += ms < 500 ? -1.6e-5 : 6e-6;
    report = proxy.Step(X_WH);
  }
  std::printf("%-16s press %.2f N, drag %.2f N\n", what, report.wrench.force.y(),
              -report.wrench.force.x());
}

}  // namespace

int main() {
  Press("hard and smooth", {});
  Press("hard and rough", {.static_friction = 0.6, .dynamic_friction = 0.4});
  Press("soft", {.stiffness = 500.0});
}
