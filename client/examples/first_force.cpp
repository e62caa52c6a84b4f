// From two meshes to a wrench: a small box is pressed 3 mm into a larger one.
#include <cstdio>

#include <palpate/physics.h>

int main() {
  using namespace palpate;
  Scene scene;
  scene.objects.push_back(MakeBody("block", MakeBox({0.04, 0.04, 0.04})));
  scene.tools.push_back(MakeBody("probe", MakeBox({0.01, 0.01, 0.01})));
  const HapticModel model = MakeModel(scene, scene.tools[0], MakeObjects(scene));

  Pose X_WH;                   // the hand's pose, where the probe would be without the block
  X_WH.p = {0.0, 0.030, 0.0};  // 5 mm above the block's upper face
  Proxy proxy(model, X_WH);
  StepReport report;
  for (int ms = 0; ms < 1000; ++ms) {  // down at 8 mm/s
    X_WH.p.y() -= 8e-6;
    report = proxy.Step(X_WH);
  }
  std::printf("hand at %.1f mm, probe at %.1f mm, %d contacts, force %.2f %.2f %.2f N\n",
              1e3 * X_WH.p.y(), 1e3 * report.X_WG.p.y(), report.contacts, report.wrench.force.x(),
              report.wrench.force.y(), report.wrench.force.z());
}
