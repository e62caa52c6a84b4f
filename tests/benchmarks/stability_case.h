#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "scenes/scene.h"
#include "server/physics/haptic_step.h"
#include "tests/benchmarks/overlap_oracle.h"

namespace palpate::bench {

/// Overlap that no hand or eye can notice, and that every case must keep wherever a pose without
/// any exists: ten times the encoder's step of the finest devices, a thousandth of a fine tool.
inline constexpr double kAllowedOverlap = 10e-6;  ///< [m]

/// What a case is given and what it finds.
struct CaseRun {
  long steps = 0;  ///< to make, about
  Features features;
  std::function<bool()> stopped;  ///< asked now and then; true ends the case with Interrupted
  std::function<void(long done)> progress;

  long done = 0;
  double figure = 0.0;       ///< in the case's unit
  long tunnelled = 0;        ///< steps with the tool where it could not have come
  long nonfinite = 0;        ///< steps whose pose or wrench is not finite
  double penetration = 0.0;  ///< deepest overlap [m], where a pose without any exists

  bool Goes() const { return done < steps; }
  void Worst(double value) { figure = value > figure ? value : figure; }
};
struct Interrupted {};

/// A hard case: a number, and the physical bound that it must hold.
struct StabilityCase {
  std::string name;
  std::string what;    ///< what the figure is
  std::string reason;  ///< why the bound is what it is
  double bound = 0.0;
  std::string unit;
  double share = 1.0;  ///< of the steps of all cases
  long least = 1000;   ///< steps without which it shows nothing
  std::function<void(CaseRun&)> run;
  /// What the case asks of the contact or friction model; it is left out where that is not given.
  std::function<bool(const Features&)> applies = [](const Features&) { return true; };
};

/// Whether the figure and the checks that every case shares hold.
bool Held(const StabilityCase& stability_case, const CaseRun& run);

/// Every hard case, in the order of presentation.
std::vector<StabilityCase> StabilityCases();
// Parts of it.
std::vector<StabilityCase> ContactCases();  ///< the step alone, in hard geometry
std::vector<StabilityCase> TouchCases();    ///< what a hand feels: noise, drift, friction, flatness
std::vector<StabilityCase> LoopCases();     ///< servo loop, arm and hand around the step

/// A box or a ball: bodies whose overlap is known in closed form.
struct Solid {
  enum class Kind { kBox, kBall };
  Kind kind = Kind::kBox;
  Vec3 half = Vec3::Zero();  ///< half of the sides, or the radius three times [m]
  std::size_t leaves = 1;    ///< of its sphere tree; a ball of one leaf is exactly that ball
  Pose X_WB = {};
};
Solid Box(const Vec3& sides, std::size_t leaves, const Pose& X_WB = {});
Solid Ball(double radius, std::size_t leaves = 1, const Pose& X_WB = {});
/// Depth of the overlap of two solids, 0 where they are apart: by separating axes, or by distance.
double OverlapOf(const Solid& A, const Pose& X_WA, const Solid& B, const Pose& X_WB);

/// A tool among fixed objects.  Every step is checked: by brute force over all pairs of leaves
/// where contact is between spheres, else by the closed form.
class Trial {
 public:
  Trial(CaseRun& run, const Solid& tool, const std::vector<Solid>& objects,
        double stiffness = 1000);
  /// The same with other features or material than the run's.
  Trial(CaseRun& run, const Solid& tool, const std::vector<Solid>& objects, double stiffness,
        const Features& features, const Material& material);

  void Start(const Pose& X_WG);
  /// One step.  Throws Interrupted where the run is to end.
  StepReport Step(const Pose& X_WH);
  StepReport StepTo(const Vec3& p_WH) { return Step(Pose{p_WH, Quat::Identity()}); }
  /// Counts and checks a step that was made elsewhere, with this trial's model.
  void Check(const Pose& X_WG, const Wrench& wrench);
  /// Overlap at a pose of the tool [m].
  double Overlap(const Pose& X_WG) const;

  const HapticModel& model() const { return *model_; }
  StepWorkspace& workspace() { return *workspace_; }
  StepState& state() { return state_; }
  /// False: no pose is free; overlap is left to the case.
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
