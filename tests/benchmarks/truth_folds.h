#pragma once

#include <string_view>
#include <vector>

#include "tests/benchmarks/truth_judges.h"
#include "tests/support/planar_rest.h"
#include "tests/support/random.h"

namespace palpate::bench {

/// What lies in a fold:
///   ball   in a groove
///   wedge  a triangular prism as sharp as its groove: its flanks lie on both sides
///   edge   a square bar in a wider groove, an edge below: it touches the groove's bottom
///   box    a bar whose two lower edges lie on a groove's sides
///   peg    a prism of 3 to 12 equal sides in a hole that is 5 to 100 um wider on each side
///   prism  the same with 4 to 7 unequal sides
inline constexpr std::string_view kFolded[] = {"ball", "wedge", "edge", "box", "peg", "prism"};

/// A tool in a groove or in a hole along z, and the same in the plane.
struct Fold {
  Body tool, object;
  test::PlanarFit fit;
  double gap = 0.0;  ///< on each side of a peg in its hole [m]
};

/// @param rubs  whether it will slide with friction.
Fold MakeFold(std::string_view tessellation, std::string_view tool, bool rubs,
              test::Random& random);

/// Where a hand holds the tool's centroid, in the object's frame.
struct FoldSample {
  test::Vec2 at;
  double angle, z;
};

/// Without friction: the force has no part along z, and is what the plane's truth says.  `out um`
/// is how much nearer than the separation the tool came.
class FoldJudge {
 public:
  /// @param hand  at each step.
  FoldJudge(const Fold& fold, const Scene& scene, const std::vector<FoldSample>& hand);
  void See(std::size_t i, const StepReport& report);
  void Tell(Tally& tally) const;

 private:
  test::PlanarFit fit_;
  Vec3 centroid_;
  Pose X_BW_;
  SmoothJudge smooth_;
  double out_ = 0.0;
};

/// With friction along z: SteadyJudge, and what of the force lies across z is as without.
class FoldSlideJudge {
 public:
  FoldSlideJudge(SteadySlide slide, const Quat& start, std::vector<Vec3> across)
      : steady_from_(slide.steady),
        along_(slide.along),
        across_(std::move(across)),
        steady_(std::move(slide), start) {}
  void See(std::size_t i, const StepReport& report);
  void Tell(Tally& tally) const;

 private:
  std::size_t steady_from_;
  Vec3 along_;
  std::vector<Vec3> across_;  ///< [N], at each step
  SteadyJudge steady_;
  double off_ = 0.0;
};

}  // namespace palpate::bench
