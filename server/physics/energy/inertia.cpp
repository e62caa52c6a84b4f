#include "server/physics/energy/inertia.h"

#include <cmath>

#include "common/math/rotation.h"

namespace palpate {
namespace {

using Kind = BodyJoint::Kind;

Mat3 Cross(const Vec3& r) {
  Mat3 m;
  m << 0.0, -r.z(), r.y(), r.z(), 0.0, -r.x(), -r.y(), r.x(), 0.0;
  return m;
}

Mat3 In(const Quat& q, const Mat3& inertia) {
  const Mat3 R = q.toRotationMatrix();
  return R * inertia * R.transpose();
}

/// The inertia about the body's centre or its ball joint, where it is placed.
Mat3 InertiaOf(const FreeBody& body) {
  if (body.joint.kind != Kind::kBall) return body.inertia;
  const Mat3 r = Cross(body.centre - body.joint.point);
  return body.inertia - body.mass * r * r;
}

/// Returns the turn that an angular momentum makes in h: phi = h J^-1 L with J half-way, which
/// keeps the energy of a free turn to third order.
Vec3 TurnOf(const Mat3& inertia, const Quat& q, const Vec3& momentum, double h) {
  constexpr int kRounds = 8;  // each gains a factor of |phi|
  Vec3 phi = Vec3::Zero();
  for (int i = 0; i < kRounds; ++i) {
    const Quat middle = RotationExp(0.5 * phi) * q;
    phi = h * In(middle, inertia).inverse() * momentum;
  }
  return phi;
}

/// The rotation of a hinge nearest to q: q's twist about the axis.
Quat TwistOf(const Quat& q, const Vec3& axis) {
  const double along = q.vec().dot(axis);
  const Quat twist(q.w(), along * axis.x(), along * axis.y(), along * axis.z());
  return twist.squaredNorm() > 0.0 ? twist.normalized() : Quat::Identity();
}

/// Returns where a hinge or a slider is at X: a hinge past whole turns as it was at the last step.
double JointAt(const BodyJoint& joint, const Pose& X, const BodyState& last) {
  if (joint.kind == Kind::kSlider) return joint.axis.dot(X.p);
  const double angle = joint.axis.dot(RotationLog(TwistOf(X.q, joint.axis)));
  return angle + 2.0 * M_PI * std::round((last.joint - angle) / (2.0 * M_PI));
}

/// A body in a step from X.
struct At {
  At(const Inertia& of, const Pose& X, const BodyState& state, double step)
      : body(of.body),
        joint(of.body.joint),
        gravity(of.gravity),
        X_W(X),
        now(state),
        h(step),
        centre(X * of.body.centre),
        // Springs' point moves with the body; a hinge's and a ball's are fixed.
        r((joint.kind == Kind::kSprings ? X * joint.point : joint.point) - centre),
        J(In(X.q, body.inertia)) {}

  /// The mass of the joint's one motion: about the axis, or along it.
  double mass() const {
    if (joint.kind == Kind::kSlider) return body.mass;
    return joint.axis.dot(J * joint.axis) + body.mass * joint.axis.cross(r).squaredNorm();
  }
  double stiffness() const {
    return joint.kind == Kind::kSlider ? joint.stiffness : joint.torsional_stiffness;
  }
  double damping() const {
    return joint.kind == Kind::kSlider ? joint.damping : joint.torsional_damping;
  }
  /// What springs and damping add to the Hessian of a one motion, over 1/h^2.
  double yielding() const { return h * h * stiffness() + h * damping(); }
  /// The motion of the springs' point by [v; phi].
  Eigen::Matrix<double, 3, 6> PointRate() const {
    Eigen::Matrix<double, 3, 6> rate;
    rate << Mat3::Identity(), -Cross(r);
    return rate;
  }
  /// The Hessian of [v; phi], times h^2, of a body with six freedoms.
  Mat6 Hessian() const {
    Mat6 H = Mat6::Zero();
    H.topLeftCorner<3, 3>() = body.mass * Mat3::Identity();
    H.bottomRightCorner<3, 3>() = J;
    if (joint.kind != Kind::kSprings) return H;
    H += (h * h * joint.stiffness + h * joint.damping) * PointRate().transpose() * PointRate();
    H.bottomRightCorner<3, 3>() +=
        (h * h * joint.torsional_stiffness + h * joint.torsional_damping) * Mat3::Identity();
    return H;
  }

  const FreeBody& body;
  const BodyJoint& joint;
  const Vec3& gravity;
  const Pose& X_W;
  const BodyState& now;
  double h;
  Vec3 centre, r;  ///< r: from the centre to the joint's point
  Mat3 J;
};

Pose Placed(const At& at, const Vec3& centre, const Quat& q) {
  return {centre - q * at.body.centre, q};
}
/// The pose of a hinge at an angle, and of a ball with a rotation.
Pose About(const BodyJoint& joint, const Quat& q) {
  return {joint.point - q * joint.point, q};
}

}  // namespace

double RotationLengthOf(const FreeBody& body) {
  return std::sqrt(body.inertia.trace() / (3.0 * body.mass));
}

Pose FreeMotion(const Inertia& inertia, const Pose& X, const BodyState& state, double h) noexcept {
  const At at(inertia, X, state, h);
  const double m = at.body.mass;
  const auto turned = [&](const Vec3& phi) { return Quat((RotationExp(phi) * X.q).normalized()); };
  switch (at.joint.kind) {
    case Kind::kHinge:
    case Kind::kSlider: {
      const bool turns = at.joint.kind == Kind::kHinge;
      const double push = turns ? at.joint.axis.dot((-at.r).cross(m * at.gravity))
                                : at.joint.axis.dot(m * at.gravity);
      const double step =
          (at.mass() * h * state.rate + h * h * (push - at.stiffness() * state.joint)) /
          (at.mass() + at.yielding());
      if (turns) return About(at.joint, TwistOf(turned(step * at.joint.axis), at.joint.axis));
      return {(state.joint + step) * at.joint.axis, Quat::Identity()};
    }
    case Kind::kBall: {
      const Mat3 at_rest = InertiaOf(at.body);
      const Vec3 torque = (-at.r).cross(m * at.gravity);
      const Vec3 kept = TurnOf(at_rest, X.q, state.momentum + h * torque, h);
      const Mat3 about = In(X.q, at_rest);
      const Mat3 H = about + at.h *
                                 (h * at.joint.torsional_stiffness + at.joint.torsional_damping) *
                                 Mat3::Identity();
      const Vec3 spring = h * h * at.joint.torsional_stiffness * RotationLog(X.q);
      return About(at.joint, turned(H.inverse() * (about * kept - spring)));
    }
    default:
      break;
  }
  Vec6 kept;
  kept << h * (state.v + h * at.gravity), TurnOf(at.body.inertia, X.q, state.momentum, h);
  if (at.joint.kind == Kind::kSprings) {
    Vec6 rest = Vec6::Zero();
    rest += h * h * at.joint.stiffness * at.PointRate().transpose() *
            (X * at.joint.point - at.joint.point);
    rest.tail<3>() += h * h * at.joint.torsional_stiffness * RotationLog(X.q);
    Vec6 push;
    push << m * kept.head<3>(), at.J * kept.tail<3>();
    kept = at.Hessian().llt().solve(push - rest);
  }
  return Placed(at, at.centre + kept.head<3>(), turned(kept.tail<3>()));
}

BodyMetric MetricAt(const Inertia& inertia, const Pose& X, const BodyState& state, double h,
                    double rho) noexcept {
  const At at(inertia, X, state, h);
  const double m = at.body.mass;
  BodyMetric metric{Mat6::Zero(), Mat6::Zero(), Vec6::Zero(), 0, {}, {}};
  // The freedom's direction in x, what reads it from x, and its Hessian over k.
  const auto one = [&](const Vec6& direction, const Vec6& reading) {
    const double root = std::sqrt((at.mass() + at.yielding()) / m);
    metric.B.col(0) = direction / root;
    metric.A.row(0) = root * reading.transpose();
    for (const double sign : {1.0, -1.0}) {
      const double end = sign > 0.0 ? at.joint.low : at.joint.high;
      if (!std::isfinite(end)) continue;
      metric.limit[metric.limits] = sign * reading;
      metric.bound[metric.limits++] = sign * (end - JointAt(at.joint, X, state));
    }
  };
  const auto lead_back = [&](const Pose& to) {
    metric.c << to * at.body.centre - at.centre, rho * RotationLog(to.q * X.q.conjugate());
  };
  Vec6 direction, reading;
  switch (at.joint.kind) {
    case Kind::kHinge: {
      const Vec3& axis = at.joint.axis;
      direction << axis.cross(-at.r), rho * axis;
      reading << Vec3::Zero(), axis / rho;
      one(direction, reading);
      lead_back(About(at.joint, TwistOf(X.q, axis)));
      break;
    }
    case Kind::kSlider:
      direction << at.joint.axis, Vec3::Zero();
      reading = direction;
      one(direction, reading);
      lead_back({X.p.dot(at.joint.axis) * at.joint.axis, Quat::Identity()});
      break;
    case Kind::kBall: {
      const double yields = h * (h * at.joint.torsional_stiffness + at.joint.torsional_damping);
      const Mat3 H = (In(X.q, InertiaOf(at.body)) + yields * Mat3::Identity()) / m;
      const Mat3 L = H.llt().matrixL();
      const Mat3 back = L.transpose().inverse();
      metric.B.topLeftCorner<3, 3>() = Cross(at.r) * back;  // phi x -r
      metric.B.bottomLeftCorner<3, 3>() = rho * back;
      metric.A.topRightCorner<3, 3>() = L.transpose() / rho;
      lead_back(About(at.joint, X.q));
      break;
    }
    default: {
      Mat6 H = at.Hessian() / m;
      H.rightCols<3>() /= rho;
      H.bottomRows<3>() /= rho;
      const Mat6 L = H.llt().matrixL();
      metric.A = L.transpose();
      metric.B = L.transpose().inverse();
    }
  }
  return metric;
}

void TakeVelocity(const Inertia& inertia, const Pose& from, const Pose& to, double h,
                  BodyState& state) noexcept {
  const FreeBody& body = inertia.body;
  const Vec3 phi = RotationLog(to.q * from.q.conjugate());
  state.v = (to * body.centre - from * body.centre) / h;
  if (body.joint.kind == Kind::kHinge || body.joint.kind == Kind::kSlider) {
    const double step = body.joint.kind == Kind::kHinge ? body.joint.axis.dot(phi)
                                                        : body.joint.axis.dot(to.p - from.p);
    state.joint += step;
    state.rate = step / h;
    return;
  }
  const Quat middle = RotationExp(0.5 * phi) * from.q;
  state.momentum = In(middle, InertiaOf(body)) * phi / h;
}

}  // namespace palpate
