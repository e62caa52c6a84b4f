#include "tests/benchmarks/cycle_report.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <spdlog/fmt/fmt.h>

#include "common/files/output.h"
#include "server/physics/simd/kernels.h"
#include "tests/benchmarks/features.h"
#include "tests/benchmarks/figures.h"
#include "tests/benchmarks/overlap_oracle.h"
#include "tests/benchmarks/step_trace.h"

namespace palpate::bench {
namespace {

/// Makes one pass with timed stages; the timing itself takes time.
void StagedPass(SceneRun& run, BestOf stage[4]) {
  StepState state = run.Start();
  std::vector<double> us[4];
  for (const Pose& X_WH : run.poses()) {
    StageTimes times;
    HapticStep(run.model(), X_WH, state, run.workspace(), &times);
    const std::int64_t ns[4] = {times.prediction, times.rows, times.solve, times.response};
    for (int s = 0; s < 4; ++s) us[s].push_back(1e-3 * static_cast<double>(ns[s]));
  }
  for (int s = 0; s < 4; ++s) stage[s].Add(us[s]);
}

/// Adds the figures of contact, which do not depend on the model, to a table and a JSON object.
class ContactReport {
 public:
  ContactReport(Table* table, Json& json) : table_(table), json_(json) {}

  void Add(const test::ContactFigures& f) {
    const auto checked = static_cast<double>(std::max<std::size_t>(1, f.depth.size()));
    const auto over_1um = static_cast<double>(
        std::count_if(f.depth.begin(), f.depth.end(), [](double m) { return m > 1e-6; }));
    Group("meshes in each other", "um", 1e6, f.depth, json_["mesh_penetration_um"]);
    json_["mesh_penetration_um"]["share_over_1um"] = over_1um / checked;
    json_["mesh_intersecting_fraction"] = f.meeting_fraction();
    json_["arrived_fraction"] = f.arrived_fraction();
    Group("lag where far", "mm", 1e3, f.lag, json_["lag_mm"]);
    Group("force error", "N", 1.0, f.force_error, json_["force_error_N"]);
    Group("force error, arrived", "N", 1.0, f.arrived_error, json_["force_error_arrived_N"]);
    json_["unconverged"] = f.unconverged;
    json_["force_rms_N"] = f.force_rms;
    json_["mean_speed_m_per_s"] = f.mean_speed;
    json_["finite"] = f.finite;
    Line("meshes meet", fmt::format("at {:.2f} % of the poses, deeper than 1 um at {:.2f} %",
                                    1e2 * f.meeting_fraction(), 1e2 * over_1um / checked));
    Line("arrived",
         fmt::format("{:.2f} % of the steps; {} of {} answers had not ended after 200 more",
                     1e2 * f.arrived_fraction(), f.unconverged, f.force_error.size()));
    Line("hand, force",
         fmt::format("{:.3f} m/s on average, {:.2f} N rms", f.mean_speed, f.force_rms));
    AddArrivals(f);
    AddForce(f.force);
    AddJumps(f);
  }
  void AddSupport(const test::SupportFigures& s, int every) {
    json_["friction_cycles"] = {{"unsolved", s.friction_unsolved}, {"yielded", s.friction_yielded}};
    json_["support"] = {{"every", every},
                        {"judged", s.force.size()},
                        {"worst_step", s.worst_step},
                        {"soft", s.soft},
                        {"not_judged_for", s.not_judged_for}};
    json_["nudged"] = {{"places", s.nudged},
                       {"freed", s.freed},
                       {"freed_unnudged", s.freed_unnudged},
                       {"freed_of_stiction", s.freed_of_stiction},
                       {"first_freed_step", s.first_freed}};
    Line("friction's cycles",
         fmt::format("{} unsolved, {} yielded", s.friction_unsolved, s.friction_yielded));
    if (every == 0 || !s.not_judged_for.empty()) {
      Line("unsupported force",
           "not judged: " + (every == 0 ? std::string("--judge-every 0") : s.not_judged_for));
      return;
    }
    Json in_milli;  // the table has three digits
    Group("unsupported force", "mN", 1e3, s.force, in_milli);
    Group("unsupported torque", "mN m", 1e3, s.torque, in_milli);
    json_["unsupported_force_N"] = ToJson(PercentilesOf(s.force));
    json_["unsupported_torque_Nm"] = ToJson(PercentilesOf(s.torque));
    Line("judged", fmt::format("{} arrived cycles, every {}. step tried (worst: step {}); {} more "
                               "touch soft bodies or leaves",
                               s.force.size(), every, s.worst_step, s.soft));
    Line("nudged",
         fmt::format("{} of {} places freed (first: step {}), {} of these also if held, "
                     "{} held by static friction alone",
                     s.freed, s.nudged, s.first_freed, s.freed_unnudged, s.freed_of_stiction));
  }
  void AddSettling(const test::ContactFigures::Settling& s) {
    const auto share = [&](std::size_t n) {
      return static_cast<double>(n) / static_cast<double>(std::max<std::size_t>(1, s.poses));
    };
    json_["settle"] = {{"poses", s.poses},
                       {"within_10ms", share(s.within_10ms)},
                       {"within_50ms", share(s.within_50ms)},
                       {"never", s.never},
                       {"limit_cycle_mm", 1e3 * s.cycle_m},
                       {"limit_cycle_N", s.cycle_N}};
    Line("hand still", fmt::format("settled within 10 ms {:.2f} %, 50 ms {:.2f} % of {}; {} never, "
                                   "up to {:.4f} mm, {:.3f} N",
                                   1e2 * share(s.within_10ms), 1e2 * share(s.within_50ms), s.poses,
                                   s.never, 1e3 * s.cycle_m, s.cycle_N));
  }
  void AddQuarters(double fraction) {
    json_["force_4khz_rms_fraction"] = fraction;
    Line("force at 4 kHz", fmt::format("differs by {:.2f} % of its rms", 1e2 * fraction));
  }

 private:
  void Line(const std::string& name, const std::string& text) {
    if (table_ != nullptr) table_->Line(name, text);
  }
  void Group(const char* name, const char* unit, double scale, std::vector<double> values,
             Json& out) {
    for (double& value : values) value *= scale;
    const Percentiles p = PercentilesOf(std::move(values));
    if (table_ != nullptr) table_->Row(name, unit, p);
    out = ToJson(p);
  }
  void AddArrivals(const test::ContactFigures& f) {
    const std::size_t not_arrived = f.steps - f.arrived;
    const test::ContactFigures::Held& held = f.held;
    json_["not_arrived"] = not_arrived;
    json_["not_arrived_fraction"] = 1.0 - f.arrived_fraction();
    json_["not_arrived_run_max"] = f.longest_behind;
    json_["never_arrived"] = held.never;
    json_["never_arriving"] = {{"tried", held.tried},
                               {"count", held.never},
                               {"without_force", held.without_force},
                               {"stuck", held.stuck},
                               {"others_steps_p50", held.median()}};
    Json& late = json_["never_arriving"]["others_force_error_N"];
    Group("late force error", "N", 1.0, held.force_error, late);
    Line("not arrived",
         fmt::format(
             "{} steps, up to {} in a row; held still, {} {} never arrive in {} more ({} without a "
             "force, {} of these for good), half of the others in {}",
             not_arrived, f.longest_behind, held.never,
             held.tried == not_arrived ? std::string("of them")
                                       : fmt::format("of {} of them, evenly spread,", held.tried),
             test::ContactFigures::kHeldSteps, held.without_force, held.stuck, held.median()));
  }
  void AddForce(const test::ForceShape& shape) {
    const auto change = [](const test::ForceChange& c) {
      return Json{{"force_N", c.size}, {"step", c.step}};
    };
    const test::ForceNotch deepest = Deepest(shape.notches), longest = Longest(shape.notches);
    const test::ForceChange ledge = Largest(shape.ledges), passing = Largest(shape.passing);
    const std::size_t longest_ms = shape.notches.empty() ? 0 : longest.steps();
    json_["notches"] = shape.notches.size();
    json_["notch"] = {{"deepest_N", deepest.depth()},
                      {"deepest_step", deepest.begin},
                      {"longest_ms", longest_ms},
                      {"longest_step", longest.begin}};
    json_["ledges"] = shape.ledges.size();
    json_["ledge_force_N_max"] = ledge.size;
    json_["largest_ledge"] = change(ledge);
    json_["largest_jump"] = change(shape.largest_jump);
    json_["passing"] = shape.passing.size();
    json_["largest_passing"] = change(passing);
    Line("notches",
         shape.notches.empty()
             ? "none"
             : fmt::format(
                   "{}, the deepest from {:.3f} to {:.3f} N (step {}), the longest {} ms (step {})",
                   shape.notches.size(), deepest.before, deepest.least, deepest.begin, longest_ms,
                   longest.begin));
    Line("ledges beside them",
         fmt::format("{} up to {:.3f} N (step {}); {} changes that pass, up to {:.3f} N (step {})",
                     shape.ledges.size(), ledge.size, ledge.step, shape.passing.size(),
                     passing.size, passing.step));
  }
  void AddJumps(const test::ContactFigures& f) {
    const test::ContactFigures::Jumps& jumps = f.jumps;
    Json& out = json_["jump"];
    out = {{"force_N_max", f.force.largest_jump.size}, {"torque_Nm_max", jumps.torque_max}};
    Line("greatest jump",
         fmt::format("{:.3f} N, {:.4f} N m; unexplained {}; {} of a tool that was behind",
                     f.force.largest_jump.size, jumps.torque_max, jumps.unexplained(),
                     jumps.behind));
    out["unexplained"] = jumps.unexplained();
    out["behind"] = jumps.behind;
    for (int c = 1; c < test::kJumpCauses; ++c) {
      const auto i = static_cast<std::size_t>(c);
      const char* name = NameOf(static_cast<test::JumpCause>(c));
      out["causes"][name] = {
          {"count", jumps.count[i]}, {"force_N_max", jumps.force[i]}, {"step", jumps.step[i]}};
      if (jumps.count[i] == 0) continue;
      Line(std::string("  ") + name,
           fmt::format("{} over {} N, up to {:.3f} N (step {})", jumps.count[i], test::kJump,
                       jumps.force[i], jumps.step[i]));
    }
  }

  Table* table_;
  Json& json_;
};

}  // namespace

void CycleOptions::AddTo(const CommandLine& command) {
  AddRepeats(command, repeats);
  Add(command, "--check-every", check_every,
      "check penetration and converged force only at every n-th step")
      .Positive();
  Add(command, "--settle-every", settle_every,
      "hold the hand still at every n-th step and check whether the tool settles; 0: never")
      .NotNegative();
  Add(command, "--judge-every", judge_every,
      "judge at every n-th step whether contacts bear the tool, and nudge it; 0: never")
      .NotNegative();
  Add(command, "--trace", trace,
      "write poses and wrench of every step to this file (CSV); -: standard output");
}

test::ContactFigures MeasureContact(SceneRun& run, const CycleOptions& options) {
  const StepState start = run.Start();
  const test::ContactPath path{run.scene(), run.model(), run.workspace(), start, run.poses()};
  test::ContactChecks checks{.oracle_every = options.check_every,
                             .converge_every = options.check_every,
                             .settle_every = options.settle_every,
                             .judge_every = options.judge_every,
                             .hold_far = true,
                             .quarter_steps = options.quarter_steps};
  checks.progress = [&](std::string_view what, double share) {
    Progress(fmt::format("{}: {}, {:.0f} % ...", options.name, what, 1e2 * share));
  };
  return test::MeasureContact(path, checks);
}

void AddContact(const test::ContactFigures& figures, const CycleOptions& options, Table* table,
                Json& json) {
  ContactReport report(table, json);
  report.Add(figures);
  report.AddSupport(figures.support, options.judge_every);
  if (options.settle_every > 0) report.AddSettling(figures.settling);
  if (options.quarter_steps) report.AddQuarters(figures.force_4khz_rms_fraction);
}

Json ReportCycle(SceneRun& run, const CycleOptions& options) {
  const std::size_t steps = run.poses().size();
  BestOf step, stage[4];
  std::vector<StepReport> reports;
  for (int r = 0; r < options.repeats; ++r) {
    Progress(fmt::format("{}: repeat {} of {} ...", options.name, r + 1, options.repeats));
    step.Add(run.Time(r == 0 ? &reports : nullptr));
    StagedPass(run, stage);
  }

  // Everything else comes from the reports and from an oracle that does not use the trees.
  OverlapOracle oracle(run.tool().tree, run.scene().objects, run.scene().features);
  const test::ContactFigures contact = MeasureContact(run, options);
  // Sphere contact is between leaves, surface contact between meshes.
  const bool surface = run.scene().features.contact == ContactModel::kSurface;
  std::vector<double> predicted, conventional, penetration, truncation, iterations, newton;
  int unsolved = 0, jammed = 0, far = 0, yielded = 0, rubs_unsolved = 0;
  for (std::size_t i = 0; i < steps; ++i) {
    const StepReport& report = reports[i];
    predicted.push_back(report.diagnostics.predicted_pairs);
    truncation.push_back(1e6 * report.diagnostics.truncation);
    iterations.push_back(report.diagnostics.qp_iterations);
    unsolved += (report.faults & kFaultUnsolved) != 0;
    jammed += (report.faults & kFaultJammed) != 0;
    far += (report.faults & kFaultTargetFar) != 0;
    newton.push_back(report.diagnostics.friction_iterations);
    yielded += report.diagnostics.friction_yielded;
    rubs_unsolved += report.diagnostics.friction_unsolved;
    if (i % static_cast<std::size_t>(options.check_every) == 0) {
      if (i % 500 == 0) {
        Progress(fmt::format("{}: checking step {} of {} ...", options.name, i, steps));
      }
      penetration.push_back(
          1e6 * (surface ? contact.depth[penetration.size()] : oracle.At(report.X_WG).depth));
      conventional.push_back(static_cast<double>(oracle.At(run.poses()[i]).pairs));
    }
  }
  Progress("");

  const Percentiles best = PercentilesOf(step.best()), raw = PercentilesOf(step.all());
  const Features& features = run.scene().features;
  const char* stage_name[4] = {"prediction", "rows", "solve", "response"};
  Table table(fmt::format(
      "{}, contact {}, friction {}: {} tool spheres, {} object spheres, {} steps, best of {} ({})",
      options.name, NameOf(features.contact), NameOf(features.friction), run.tool().tree.leaves(),
      run.object_spheres(), steps, options.repeats, ActiveKernels().name));
  Json json{{"scene", options.name},
            {"contact", NameOf(features.contact)},
            {"friction", NameOf(features.friction)},
            {"tool_spheres", run.tool().tree.leaves()},
            {"object_spheres", run.object_spheres()},
            {"steps", steps},
            {"repeats", options.repeats},
            {"simd", ActiveKernels().name},
            {"best_step_us", ToJson(best)},
            {"raw_step_us", ToJson(raw)}};
  table.Row("step, best", "us", best);
  table.Row("step, raw", "us", raw);
  for (int s = 0; s < 4; ++s) {
    const Percentiles p = PercentilesOf(stage[s].best());
    table.Row(std::string("  ") + stage_name[s] + ", best", "us", p);
    json["best_stage_us"][stage_name[s]] = ToJson(p);
  }
  const auto add = [&](const char* name, const char* unit, std::vector<double> values, Json& out) {
    const Percentiles p = PercentilesOf(std::move(values));
    table.Row(name, unit, p);
    out = ToJson(p);
  };
  add("pairs, predicted", "", std::move(predicted), json["pairs"]["predicted"]);
  add("pairs, conventional", "", std::move(conventional), json["pairs"]["conventional"]);
  add("penetration", "um", std::move(penetration), json["penetration_um"]);
  add("truncation, bound", "um", std::move(truncation), json["truncation_um"]);
  add("QP iterations", "", std::move(iterations), json["qp"]["iterations"]);
  json["qp"]["unsolved"] = unsolved;
  if (features.friction == FrictionModel::kCoulomb) {
    Json& rubs = json["friction_solver"];
    add("friction's Newton steps", "", std::move(newton), rubs["iterations"]);
    rubs["yielded"] = yielded;
    rubs["unsolved"] = rubs_unsolved;
    table.Line("contacts that yielded",
               fmt::format("{} (friction unsolved {})", yielded, rubs_unsolved));
  }
  AddContact(contact, options, &table, json);
  json["steps_jammed"] = jammed;
  json["steps_target_far"] = far;
  table.Line("QPs unsolved",
             fmt::format("{} (jammed steps {}, target far {})", unsolved, jammed, far));
  table.Print();
  if (!options.trace.empty()) {
    WriteOutput("--trace", options.trace, StepTrace(run.poses(), reports, step.best()));
  }
  return json;
}

}  // namespace palpate::bench
