// palpate-bench closed-loop: the stiffness that can be rendered across a network.
#include <algorithm>
#include <filesystem>

#include <spdlog/fmt/fmt.h>

#include "common/files/output.h"
#include "devices/simulated/phantom_sheets.h"
#include "tests/benchmarks/closed_loop_run.h"
#include "tests/benchmarks/commands.h"
#include "tests/benchmarks/figures.h"

namespace palpate::bench {
namespace {

struct ClosedLoopOptions {
  std::string device = "simulated", scene = "wall", local_model = "on", passivity = "on";
  ClosedLoopCase loop;
  std::string json, out;
};

const std::vector<double> kDelays_ms{0.0, 5.0, 10.0, 20.0};

constexpr std::size_t kCurves = 4;  // local model and passivity controller, each on and off

/// The results of one configuration of the loop, at each of kDelays_ms.
struct Curve {
  bool local_model, passivity;
  std::vector<ZWidth> width = {};
  std::vector<ClosedLoopFigures> asked = {};  ///< at the stiffness that was asked for
  std::string name() const {
    return fmt::format("local model {}, passivity controller {}", local_model ? "on" : "off",
                       passivity ? "on" : "off");
  }
};

/// @param one_more  called with the results so far after each curve.
template <class OneMore>
std::vector<Curve> MeasureCurves(const ClosedLoopScene& scene, const ClosedLoopCase& asked,
                                 OneMore one_more) {
  std::vector<Curve> curves;
  for (const bool passivity : {false, true}) {
    for (const bool local_model : {true, false}) {
      Curve& curve = curves.emplace_back(Curve{local_model, passivity});
      for (const double delay_ms : kDelays_ms) {
        Progress(fmt::format("{}: {:g} ms ...", curve.name(), delay_ms));
        ClosedLoopCase c = asked;
        c.delay_ms = delay_ms;
        c.local_model = local_model;
        c.passivity = passivity;
        curve.width.push_back(MeasureZWidth(scene, c));
        curve.asked.push_back(RunClosedLoop(scene, c));
      }
      one_more(curves);
    }
  }
  Progress("");
  return curves;
}

/// One figure for each of kDelays_ms.
template <class Rows, class Figure>
std::vector<double> Each(const Rows& rows, Figure figure) {
  std::vector<double> values;
  for (const auto& row : rows) values.push_back(row.*figure);
  return values;
}

Json ToJson(const Curve& c, double stiffness_N_per_m) {
  Json stable = Json::array();
  for (const ClosedLoopFigures& figures : c.asked) stable.push_back(figures.stable);
  return {{"local_model", c.local_model},
          {"passivity", c.passivity},
          {"delay_ms", kDelays_ms},
          {"max_stable_stiffness_N_per_m", Each(c.width, &ZWidth::stiffness_N_per_m)},
          {"felt_stiffness_N_per_m", Each(c.width, &ZWidth::felt_N_per_m)},
          {"stiffness_N_per_m", stiffness_N_per_m},
          {"stable", stable},
          {"energy_J", Each(c.asked, &ClosedLoopFigures::energy_J)},
          {"energy_end_J", Each(c.asked, &ClosedLoopFigures::energy_end_J)},
          {"energy_seen_J", Each(c.asked, &ClosedLoopFigures::energy_seen_J)},
          {"limit_cycle_mm", Each(c.asked, &ClosedLoopFigures::limit_cycle_mm)},
          {"limit_cycle_deg", Each(c.asked, &ClosedLoopFigures::limit_cycle_deg)},
          {"rendered", Each(c.asked, &ClosedLoopFigures::rendered)}};
}

std::string TableOf(const std::vector<Curve>& curves, double stiffness_N_per_m) {
  std::string heads, rules;
  for (const double delay_ms : kDelays_ms) {
    heads += fmt::format(" {:g} ms |", delay_ms);
    rules += "---:|";
  }
  std::string text =
      "Stiffest stable coupling [N/m]; in brackets the most that the hand is held by, where that "
      "is less.\n\n| |" +
      heads + "\n|---|" + rules;
  for (const Curve& curve : curves) {
    text += "\n| " + curve.name() + " |";
    for (const ZWidth& width : curve.width) {
      text += fmt::format(" {:.0f}", width.stiffness_N_per_m);
      if (width.felt_N_per_m < 0.99 * width.stiffness_N_per_m) {
        text += fmt::format(" ({:.0f})", width.felt_N_per_m);
      }
      text += " |";
    }
  }
  text += fmt::format(
      "\n\nAt {:g} N/m: energy that the hand was given at the most [mJ] / limit cycle [mm].\n\n"
      "| |{}\n|---|{}",
      stiffness_N_per_m, heads, rules);
  for (const Curve& curve : curves) {
    text += "\n| " + curve.name() + " |";
    for (const ClosedLoopFigures& figures : curve.asked) {
      text += fmt::format(" {:.3f} / {:.3f} |", 1e3 * figures.energy_J, figures.limit_cycle_mm);
    }
  }
  return text + "\n";
}

/// Writes the results so far, so that an interrupted run keeps its measurements.
void WriteReport(const ClosedLoopOptions& options, const std::vector<Curve>& curves) {
  const std::filesystem::path folder = options.out;
  const bool all = curves.size() == kCurves;

  const PublishedHand& hand = PublishedHandOf(options.loop.hand);
  const PhantomSheet arm = PhantomSheetOf(options.loop.arm);
  WriteOutput(
      "--out", (folder / "report.md").string(),
      fmt::format(
          "# A contact across a network\n\n{}Scene `{}`, arm `{}`, hand `{}` ({}), jitter {:g} ms, "
          "loss {:g} each way, seed {}. Delays are there and back; a reply is never there before "
          "the tick after its pose.\n\n"
          "Stable is what comes to rest after a tap: in the last {:g} of {:g} s the handle moves "
          "and turns by no more than two steps of its encoders. At most {:.0f} N/m are tried. "
          "Beyond 2 f / q, dry friction over the encoder's step, for this arm {:.0f} N/m, "
          "quantisation alone feeds the hand (Diolaiti, Niemeyer, Barbagli & Salisbury, IEEE T. "
          "Robotics 22 (2006) 256-268). The torsional spring goes with the other.\n\n{}",
          all ? "" : "**Not all is measured: the run goes on, or was ended.**\n\n", options.scene,
          options.loop.arm, hand.name, hand.source, options.loop.jitter_ms, options.loop.loss,
          options.loop.seed, kClosedLoopCycle_s, kClosedLoopWatch_s, kStiffest,
          2.0 * arm.dynamics.coulomb_force_N / arm.info.position_resolution_m,
          TableOf(curves, options.loop.stiffness_N_per_m)));
}

void Run(ClosedLoopOptions options) {
  if (options.device != "simulated") options.loop.arm = options.device;
  options.loop.local_model = options.local_model == "on";
  options.loop.passivity = options.passivity == "on";
  if (!options.out.empty()) std::filesystem::create_directories(options.out);
  const ClosedLoopScene scene = MakeClosedLoopScene(options.scene);
  const ClosedLoopFigures figures = RunClosedLoop(scene, options.loop);
  const ZWidth width = MeasureZWidth(scene, options.loop);
  fmt::print(stderr,
             "{} at {:g} N/m, {:g} ms of delay: {}\n"
             "  limit cycle            {:.3f} mm, {:.4f} deg\n"
             "  energy given           {:.3g} J at the most, {:.3g} J in the end; by the encoders "
             "{:.3g} J at the most\n"
             "  force                  {:.2f} N, {:.0f} % of what the station asked for\n"
             "  max stable stiffness   {:.0f} N/m{}; the hand is held by {:.0f} N/m at the most\n",
             options.scene, options.loop.stiffness_N_per_m, options.loop.delay_ms,
             figures.stable ? "stable" : "NOT STABLE", figures.limit_cycle_mm,
             figures.limit_cycle_deg, figures.energy_J, figures.energy_end_J, figures.energy_seen_J,
             figures.mean_force_N, 100.0 * figures.rendered, width.stiffness_N_per_m,
             width.stiffness_N_per_m >= kStiffest ? ", the most that is tried" : "",
             width.felt_N_per_m);
  Json json{{"device", options.device},
            {"scene", options.scene},
            {"hand", options.loop.hand},
            {"hand_source", PublishedHandOf(options.loop.hand).source},
            {"delay_ms", options.loop.delay_ms},
            {"jitter_ms", options.loop.jitter_ms},
            {"loss", options.loop.loss},
            {"seed", options.loop.seed},
            {"local_model", options.loop.local_model},
            {"passivity", options.loop.passivity},
            {"stiffness_N_per_m", options.loop.stiffness_N_per_m},
            {"stable", figures.stable},
            {"energy_J", figures.energy_J},
            {"energy_end_J", figures.energy_end_J},
            {"energy_seen_J", figures.energy_seen_J},
            {"limit_cycle_mm", figures.limit_cycle_mm},
            {"limit_cycle_deg", figures.limit_cycle_deg},
            {"mean_force_N", figures.mean_force_N},
            {"rendered", figures.rendered},
            {"beyond_region", figures.beyond_region},
            {"max_stable_stiffness_N_per_m", width.stiffness_N_per_m},
            {"felt_stiffness_N_per_m", width.felt_N_per_m}};
  if (!options.out.empty()) {
    const std::vector<Curve> curves = MeasureCurves(
        scene, options.loop, [&](const std::vector<Curve>& some) { WriteReport(options, some); });
    fmt::print(stderr, "\n{}", TableOf(curves, options.loop.stiffness_N_per_m));
    for (const Curve& curve : curves) {
      json["z_width"].push_back(ToJson(curve, options.loop.stiffness_N_per_m));
    }
  }
  if (!options.json.empty()) WriteJson(options.json, json);
}

}  // namespace

void AddClosedLoop(const CommandLine& app) {
  auto options = std::make_shared<ClosedLoopOptions>();
  ClosedLoopCase& loop = options->loop;
  const CommandLine command = app.AddCommand(
      "closed-loop",
      "stability, energy and stiffness of a contact across a delayed link\n"
      "Simulates arm, hand, station with its limiter, link and server in virtual time.\n"
      "Reports whether a contact comes to rest, how much energy the hand receives, and\n"
      "the largest stable stiffness.  --out measures these for each delay, with and\n"
      "without the local model and the passivity controller, and updates the report\n"
      "after each one.  On an idle core it takes half a minute for the wall, three to\n"
      "four for the bunny.");
  command.Footer("Example: palpate-bench closed-loop --delay-ms 10 --local-model on --out report");
  std::string hands;
  std::vector<std::string> devices{"simulated"};
  for (const PhantomSheet& sheet : PhantomSheets()) devices.emplace_back(sheet.name);
  for (const PublishedHand& hand : PublishedHands()) hands += " " + hand.name;
  Add(command, "--device", options->device,
      "arm, as given to palpate-station --model; simulated: the default one")
      .OneOf(devices);
  Add(command, "--delay-ms", loop.delay_ms, "round-trip delay").Range(0.0, 200.0);
  Add(command, "--jitter-ms", loop.jitter_ms, "random additional delay, up to this")
      .Range(0.0, 200.0);
  Add(command, "--loss", loop.loss, "fraction of the samples lost, each way").Range(0.0, 1.0);
  Add(command, "--local-model", options->local_model, "use the station's local contact model")
      .OneOf({"on", "off"});
  Add(command, "--passivity", options->passivity, "use the limiter's energy stage")
      .OneOf({"on", "off"});
  Add(command, "--stiffness", loop.stiffness_N_per_m,
      "of the coupling, in N/m; the torsional stiffness scales with it")
      .Range(1.0, kStiffest);
  Add(command, "--hand", loop.hand, "published model of a hand:" + hands);
  Add(command, "--scene", options->scene,
      "wall: a ball on a plate; bunny: bunny-bunny, pressed on the back")
      .OneOf({"wall", "bunny"});
  Add(command, "--seed", loop.seed, "random seed of the link");
  AddJson(command, options->json);
  Add(command, "--out", options->out,
      "folder for report.md: stiffness, energy and limit cycle against delay, for each "
      "combination of local model and passivity controller; also added to --json");
  command.Run([options] { Run(*options); });
}

}  // namespace palpate::bench
