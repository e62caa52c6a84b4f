#pragma once

#include <cstdint>
#include <cstring>
#include <functional>
#include <string>

#include "scenes/catalogue.h"
#include "tests/replayer/hand_recording.h"

namespace palpate::test {

/// A ball bur of 1 mm above a block of 3 mm, whose top is y = 1.5 mm, of enamel on dentine.
inline constexpr const char* kBlockScene = R"({
  "tools": [{"name": "bur", "leaves": 16,
             "mesh": {"shape": "bur", "kind": "ball", "diameter_mm": 1.0, "handle_mm": 40},
             "start": {"position_mm": [0, 3, 0]}}],
  "objects": [{"name": "block", "mesh": {"shape": "box", "size_m": [0.003, 0.003, 0.003]},
    "pose": {"position_mm": [10, 0, 0]}, "grid_um": 100,
    "material": {"cutting_pressure_MPa": 0.02, "colour": "#ff0000", "name": "enamel"},
    "regions": [{"box": {"min_mm": [-9, -9, -9], "max_mm": [9, 0.55, 9]},
                 "material": {"cutting_pressure_MPa": 0.02, "name": "dentine"}}]}]})";

/// Records a session of `poses` milliseconds in that scene.
/// @param hand  position of the tip at a millisecond [m].
inline void RecordCut(const std::string& file, std::uint64_t poses,
                      const std::function<Vec3(std::uint64_t)>& hand) {
  const Folder folder;
  WriteBytes(folder / "block.json", {kBlockScene, kBlockScene + std::strlen(kBlockScene)});
  const Scene scene = LoadScene(folder / "block.json", {.use_cache = false});
  const HapticModel model = MakeModel(scene, scene.tools.front(), MakeObjects(scene));
  const auto at = [&](std::uint64_t i) { return Pose{hand(i), Quat::Identity()}; };
  RecordHand(scene, model, {.poses = poses, .at = at}, file);
}

/// Moves the tip down on the block's middle, from 0.5 mm above it, at 10 mm/s to a depth [mm].
inline std::function<Vec3(std::uint64_t)> Down(double depth_mm, double x_mm = 0.0) {
  return [=](std::uint64_t i) {
    const double y = std::max(2.0 - 0.01 * static_cast<double>(i), 1.5 - depth_mm);
    return Vec3(1e-3 * (10.0 + x_mm), 1e-3 * y, 0.0);
  };
}

}  // namespace palpate::test
