#include "scenes/free_body.h"

#include <cmath>

#include <Eigen/Eigenvalues>

namespace palpate {

std::string BodyFault(const FreeBody& body) {
  if (!(body.mass >= 1e-6 && body.mass <= 1e3)) {
    return "has a mass of " + std::to_string(body.mass) + " kg; give 1 mg to 1,000 kg";
  }
  // Principal moments are positive, and none is greater than the other two together.
  if (!body.centre.allFinite() || !body.inertia.allFinite() ||
      !body.inertia.isApprox(body.inertia.transpose())) {
    return "has no inertia; give a closed mesh with a volume";
  }
  const Vec3 moments = Eigen::SelfAdjointEigenSolver<Mat3>(body.inertia).eigenvalues();
  if (!(moments[0] > 0.0) || !(moments[2] <= 1.000001 * (moments[0] + moments[1]))) {
    return "has an inertia that no solid has; give a closed mesh with a volume";
  }
  const BodyJoint& joint = body.joint;
  if (!joint.point.allFinite() || !(std::abs(joint.axis.norm() - 1.0) < 1e-9)) {
    return "has a joint without an axis; give a finite point, and a direction";
  }
  if (!(joint.low <= 0.0 && joint.high >= 0.0)) {
    return "is placed outside the limits of its joint; let them include 0";
  }
  for (const double spring :
       {joint.stiffness, joint.damping, joint.torsional_stiffness, joint.torsional_damping}) {
    if (!(spring >= 0.0 && std::isfinite(spring))) {
      return "has a spring that is not finite, or pushes away; give 0 or more";
    }
  }
  return "";
}

}  // namespace palpate
