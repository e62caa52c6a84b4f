#pragma once

#include <limits>
#include <string>

#include "common/math/pose.h"

namespace palpate {

/// What holds a body to the world.  Points and directions are in W, where the body is placed.
struct BodyJoint {
  enum class Kind {
    kFree,     ///< nothing
    kHinge,    ///< it turns about an axis
    kSlider,   ///< it slides along an axis
    kBall,     ///< it turns about a point
    kSprings,  ///< six springs about a point, as of a periodontal ligament
  };
  Kind kind = Kind::kFree;
  Vec3 point = Vec3::Zero();  ///< on the hinge's axis, or of the ball or the springs [m]
  Vec3 axis = Vec3::UnitZ();  ///< unit
  // Of a hinge [rad] or a slider [m], from where the body is placed:
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  // Hinge, ball: [N m/rad], [N m s/rad].  Slider: [N/m], [N s/m].  Springs: both.
  double stiffness = 0.0, damping = 0.0;                      ///< of translation
  double torsional_stiffness = 0.0, torsional_damping = 0.0;  ///< of rotation
};

/// A rigid body that nothing but its mass, its joint and what touches it moves.
struct FreeBody {
  double mass = 0.0;                ///< [kg]
  Vec3 centre = Vec3::Zero();       ///< of mass, in W where it is placed [m]
  Mat3 inertia = Mat3::Identity();  ///< about the centre, by the axes of W there [kg m^2]
  BodyJoint joint{};
};

/// Returns what is wrong with a body, with a remedy; empty: nothing.
std::string BodyFault(const FreeBody& body);

}  // namespace palpate
