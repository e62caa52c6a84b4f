#pragma once

#include "common/math/pose.h"
#include "common/math/rotation.h"

namespace palpate {

/// The pose of the graphic tool: its reference point in W, and its orientation.
struct ToolPose {
  Vec3 p;
  Quat q;
  Mat3 R;
  ToolPose(const Vec3& position, const Quat& orientation)
      : p(position), q(orientation), R(orientation.toRotationMatrix()) {}
  /// Returns the pose after the step [v; phi].
  ToolPose Moved(const Vec3& v, const Vec3& phi) const {
    return {p + v, (RotationExp(phi) * q).normalized()};
  }
};

}  // namespace palpate
