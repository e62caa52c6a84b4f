#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "scenes/scene.h"
#include "server/physics/haptic_step.h"
#include "tests/benchmarks/overlap_oracle.h"

namespace palpate::bench {

/// Greatest overlap allowed in every case if a pose without overlap exists.  No hand or eye can
/// notice it: ten times the encoder step of the finest devices, a thousandth of a fine tool.
inline constexpr double kAllowedOverlap = 10e-6;  ///< [m]

inline constexpr double kMillimetre = 1e-3;  ///< [m]

/// The input and the results of a case.
struct CaseRun {
  long steps = 0;  ///< approximate number of steps to make
  Features features;
  std::function<bool()> stopped;  ///< called now and then; if true, the case ends with Interrupted
  std::function<void(long done)> progress;

  long done = 0;
  double figure = 0.0;       ///< in the case's unit
  long tunnelled = 0;        ///< steps with the tool in a place that it could not have reached
  long nonfinite = 0;        ///< steps whose pose or wrench is not finite
  double penetration = 0.0;  ///< deepest overlap [m], counted if a pose without overlap exists

  bool Goes() const { return done < steps; }
  void Worst(double value) { figure = value > figure ? value : figure; }
};
struct Interrupted {};

/// A hard case: a figure, and the physical bound that it must keep.
struct StabilityCase {
  std::string name;
  std::string what;    ///< meaning of the figure
  std::string reason;  ///< reason for the bound
  double bound = 0.0;
  std::string unit;
  double share = 1.0;  ///< relative share of the total number of steps
  long least = 1000;   ///< least number of steps for a meaningful result
  std::function<void(CaseRun&)> run;
  /// The contact or friction model that the case needs; without it the case is left out.
  std::function<bool(const Features&)> applies = [](const Features&) { return true; };
};

/// Returns whether the figure is within its bound and the checks common to all cases pass.
bool Held(const StabilityCase& stability_case, const CaseRun& run);

/// Returns all hard cases, in the order of presentation.
std::vector<StabilityCase> StabilityCases();
// Its parts:
std::vector<StabilityCase> ContactCases();  ///< the step alone, in hard geometry
std::vector<StabilityCase> TouchCases();    ///< what a hand feels: noise, drift, friction, flatness
std::vector<StabilityCase> LoopCases();     ///< servo loop, arm and hand around the step

/// A box or a ball, whose overlaps are known in closed form.
struct Solid {
  enum class Kind { kBox, kBall };
  Kind kind = Kind::kBox;
  Vec3 half = Vec3::Zero();  ///< half the sides, or three times the radius value [m]
  std::size_t leaves = 1;    ///< leaves of its sphere tree; with one leaf a ball is exact
  Pose X_WB = {};
};
Solid Box(const Vec3& sides, std::size_t leaves, const Pose& X_WB = {});
Solid Ball(double radius, std::size_t leaves = 1, const Pose& X_WB = {});
/// Returns the overlap's depth, by separating axes or by distance; 0 if the solids are apart.
double OverlapOf(const Solid& A, const Pose& X_WA, const Solid& B, const Pose& X_WB);

/// A tool among fixed objects.  Checks every step: by brute force over all pairs of leaves for
/// contact between spheres, else by the closed form.
class Trial {
 public:
  Trial(CaseRun& run, const Solid& tool, const std::vector<Solid>& objects,
        double stiffness = 1000);
  /// The same with features or a material that differ from the run's.
  Trial(CaseRun& run, const Solid& tool, const std::vector<Solid>& objects, double stiffness,
        const Features& features, const Material& material);

  void Start(const Pose& X_WG);
  /// Makes one step.  Throws Interrupted if the run is to end.
  StepReport Step(const Pose& X_WH);
  StepReport StepTo(const Vec3& p_WH) { return Step(Pose{p_WH, Quat::Identity()}); }
  /// Counts and checks a step made elsewhere with this trial's model.
  void Check(const Pose& X_WG, const Wrench& wrench);
  /// Returns the overlap at a pose of the tool [m].
  double Overlap(const Pose& X_WG) const;

  const HapticModel& model() const { return *model_; }
  StepWorkspace& workspace() { return *workspace_; }
  StepState& state() { return state_; }
  /// Sets whether a free pose exists; if not, the case itself checks the overlap.
  void ExpectFree(bool free) { expect_free_ = free; }

 private:
  CaseRun& run_;
  Solid tool_;
  std::vector<Solid> objects_;
  Scene scene_;
  std::unique_ptr<HapticModel> model_;
  std::unique_ptr<StepWorkspace> workspace_;
  std::unique_ptr<OverlapOracle> oracle_;
  StepState state_;
  bool expect_free_ = true;
};

}  // namespace palpate::bench
