#pragma once

#include <string>
#include <vector>

namespace palpate::bench {

struct CutSceneOptions {
  std::string scene, poses, json, surface, sweep;
  std::vector<std::string> burs;  ///< ISO 6360 numbers, instead of the scene's own burs
  int repeats = 3;
};

/// `palpate-bench cut --scene`: runs the haptic step of a scene with a bur over poses, and reports
/// time, force, removed volume and work compared with the exact sweep, the remaining surface, and
/// the ripple of the grid.
void RunCutScene(const CutSceneOptions& options);

}  // namespace palpate::bench
