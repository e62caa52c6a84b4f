#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/math/pose.h"

namespace palpate {

/// A path that a hand follows, given by keyframes of the haptic tool's pose X_WH, joined by
/// minimum-jerk segments (Flash & Hogan, J. Neuroscience 5 (1985) 1688-1703); rotations follow the
/// shortest arc.  Scripts are small JSON files beside the scenes (scenes/catalogue/README.md).
class PoseScript {
 public:
  struct Key {
    double t = 0.0;  ///< [s], strictly increasing from 0
    Pose X_WH;
    std::string label;  ///< what the hand does from here on: "approach", "slide", ...
  };

  /// Throws Error (file, line, field, remedy).
  static PoseScript Load(const std::string& file);
  /// `file` is only named in messages.
  static PoseScript Parse(std::string_view text, const std::string& file);
  explicit PoseScript(std::vector<Key> keys);

  double duration() const { return keys_.back().t; }
  const std::vector<Key>& keys() const { return keys_; }
  /// Returns the pose at t, held beyond both ends.  Deterministic; no allocation.
  Pose At(double t) const noexcept;
  /// Returns the label of the segment that contains t.
  const std::string& LabelAt(double t) const noexcept;

 private:
  std::vector<Key> keys_;
};

}  // namespace palpate
