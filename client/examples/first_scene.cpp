// Loads a scene as the server does, and feels it along the path that comes with it:
// first_scene [SCENE]
#include <algorithm>
#include <cstdio>
#include <exception>

#include <palpate/scenes.h>

int main(int count, char** words) try {
  using namespace palpate;
  const char* name = count > 1 ? words[1] : "bunny-bunny";  // or a file: .json, .palpate, .stl
  const Scene scene = LoadScene(name);
  const HapticModel model = MakeModel(scene, scene.tools[0], MakeObjects(scene));
  const PoseScript hand = PoseScript::Load(ScriptFileBeside(name));

  Proxy proxy(model, hand.At(0.0));
  double most = 0.0;
  for (double t = 0.0; t < hand.duration(); t += 0.001) {
    most = std::max(most, proxy.Step(hand.At(t)).wrench.force.norm());
  }
  std::printf("%s: %s feels %.2f N at most in %.1f s\n", name, scene.tools[0].name.c_str(), most,
              hand.duration());
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
