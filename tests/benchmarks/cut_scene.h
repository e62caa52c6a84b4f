#pragma once

#include <string>
#include <vector>

namespace palpate::bench {

struct CutSceneOptions {
  std::string scene, poses, json, surface;
  std::vector<std::string> burs;  ///< ISO 6360 numbers, instead of the scene's own burs
  int repeats = 3;
};

/// `palpate-bench cut --scene`: steps a scene with a bur over poses, and reports time, force,
/// volume and work against the exact sweep, the remaining surface, and the grid's ripple.
void RunCutScene(const CutSceneOptions& options);

}  // namespace palpate::bench
