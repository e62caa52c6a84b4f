#pragma once

#include <memory>
#include <vector>

#include "tests/benchmarks/truth.h"
#include "tests/support/curved_bodies.h"

namespace palpate::bench {

/// A tool on a curved body.
struct CurvedTool {
  bool is_ball;
  bool is_wide;      ///< its foot is wider than a triangle, so that it touches with its face alone
  double height;     ///< of the centroid over the foot; a ball's radius [m]
  double stiffness;  ///< k_t [N/m]
  double torsional;  ///< k_r [N m/rad]
  double slack;      ///< by how much it may be nearer to a mesh than the separation [m]
};

/// How far the rest of a tool on the mesh may be from that on the smooth surface.
struct CurvedBound {
  double angle;  ///< of the force to the normal [rad]
  double size;   ///< of the force [N]
  double turn;   ///< of the tool [rad]
};

/// Returns the bounds for a hand at a depth below the smooth surface's rest (truth_curved.cpp
/// derives them).
CurvedBound BoundOf(const test::CurvedBody& body, const CurvedTool& tool, double depth);

/// Judges forces without friction against the smooth truth: along the normal, the stiffness times
/// the depth, and no torque.  `over` is what exceeds the bounds.
class CurvedJudge {
 public:
  struct Sample {
    Vec3 normal;   ///< in W
    double depth;  ///< of the hand below where the tool rests [m]
    CurvedBound bound;
  };
  CurvedJudge(const CurvedTool& tool, double shallow, std::vector<Sample> samples)
      : tool_(tool), shallow_(shallow), samples_(std::move(samples)) {}
  void See(std::size_t i, const StepReport& report);
  void Tell(Tally& tally) const;

 private:
  CurvedTool tool_;
  double shallow_;  ///< less deep a direction is not judged [m]
  std::vector<Sample> samples_;
  double angle_ = 0.0, angle_over_ = 0.0, size_ = 0.0, size_over_ = 0.0, torque_ = 0.0,
         torque_over_ = 0.0;
  int cycles_ = 0, late_ = 0, faults_ = 0;
};

/// Judges sliding with friction: mu_d of the load.  The load of a foot that is wider than a
/// triangle is along the foot's normal.  That of a ball is the sum of its contacts', and must be
/// within the angle of a triangle to the normal of the smooth surface where it touches.
class CurvedSlideJudge {
 public:
  CurvedSlideJudge(std::shared_ptr<const test::CurvedBody> body, const CurvedTool& tool,
                   const Pose& X_WB, double bound, std::size_t steady)
      : body_(std::move(body)), tool_(tool), X_WB_(X_WB), bound_(bound), steady_(steady) {}
  void See(std::size_t i, const StepReport& report);
  void Tell(Tally& tally) const;

 private:
  std::shared_ptr<const test::CurvedBody> body_;
  CurvedTool tool_;
  Pose X_WB_;
  double bound_;  ///< of the angle of a ball's load to the normal [rad]
  std::size_t steady_;
  double least_ = INFINITY, most_ = 0.0, over_ = 0.0;
  int judged_ = 0, off_ = 0, late_ = 0, unsolved_ = 0, yielded_ = 0;
};

}  // namespace palpate::bench
