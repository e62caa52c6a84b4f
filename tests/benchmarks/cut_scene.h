#pragma once

#include <string>
#include <vector>

namespace palpate::bench {

struct CutSceneOptions {
  std::string scene, poses, json, surface, sweep;
  std::vector<std::string> burs;  ///< ISO 6360 numbers, in place of the scene's own
  int repeats = 3;
};

/// `palpate-bench cut --scene`: the haptic step of a scene with a bur, over poses: time, force,
/// removed volume and work against the exact sweep, the surface that is left, the ripple of the
/// grid.
void RunCutScene(const CutSceneOptions& options);

}  // namespace palpate::bench
