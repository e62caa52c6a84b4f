// palpate-bench hands: generated hands over any scene, judged like a path of cycle.
#include <algorithm>
#include <cstdint>
#include <tuple>
#include <utility>
#include <vector>

#include <spdlog/fmt/fmt.h>

#include "common/error.h"
#include "common/files/output.h"
#include "tests/benchmarks/commands.h"
#include "tests/benchmarks/cycle_report.h"
#include "tests/benchmarks/features.h"
#include "tests/benchmarks/figures.h"
#include "tests/benchmarks/scene_run.h"
#include "tests/support/hand_path.h"

namespace palpate::bench {
namespace {

struct HandsOptions {
  std::string scene = "bunny-bunny";
  std::string seeds;
  test::HandOptions hand;
  std::string poses_out;
  CycleOptions cycle{.repeats = 1, .settle_every = 100, .quarter_steps = true};
  FeatureOptions features;
  std::string models;
  std::string json;
};

/// Prints one line per seed, the worst first.
void RunSeeds(const HandsOptions& options, const Scene& scene) {
  struct Seed {
    std::uint64_t seed;
    test::ContactFigures figures;
    double depth() const {
      const auto& d = figures.depth;
      return d.empty() ? 0.0 : *std::max_element(d.begin(), d.end());
    }
    /// Seeds that broke an invariant come first.
    auto badness() const {
      return std::tuple(!figures.finite, figures.meeting > 0, figures.jumps.unexplained(),
                        figures.held.never, figures.force.notches.size(),
                        figures.steps - figures.arrived, depth());
    }
  };
  const auto [first, last] = SeedRange(options.seeds);
  std::vector<Seed> seeds;
  for (std::uint64_t seed = first; seed <= last; ++seed) {
    test::HandOptions hand = options.hand;
    hand.seed = seed;
    CycleOptions cycle = options.cycle;
    cycle.name = fmt::format("{}, seed {}", options.scene, seed);
    SceneRun run(scene, MakeHand(scene, hand));
    seeds.push_back({seed, MeasureContact(run, cycle)});
  }
  Progress("");
  std::stable_sort(seeds.begin(), seeds.end(),
                   [](const Seed& a, const Seed& b) { return a.badness() > b.badness(); });

  std::string out = fmt::format(
      "{}, contact {}, friction {}: hands of {} steps at {} m/s, the worst seed first\n"
      "  {:>6} {:>9} {:>9} {:>10} {:>6} {:>8} {:>7} {:>9} {:>9} {:>11} {:>8} {:>10} {:>11} {:>6}\n",
      options.scene, NameOf(scene.features.contact), NameOf(scene.features.friction),
      options.hand.steps, options.hand.speed, "seed", "meet, %", "deep, um", "arrived, %", "never",
      "notches", "ledges", "F rms, N", "jump, N", "unexplained", "4 kHz, %", "settled, %",
      "unborne, mN", "freed");
  Json rows = Json::array();
  for (const Seed& s : seeds) {
    const test::ContactFigures& f = s.figures;
    const double settled = static_cast<double>(f.settling.within_50ms) /
                           static_cast<double>(std::max<std::size_t>(1, f.settling.poses));
    out += fmt::format(
        "  {:>6} {:>9.2f} {:>9.3f} {:>10.2f} {:>6} {:>8} {:>7} {:>9.2f} {:>9.3f} {:>11} {:>8.2f} "
        "{:>10.1f} {:>11.3f} {:>6}\n",
        s.seed, 1e2 * f.meeting_fraction(), 1e6 * s.depth(), 1e2 * f.arrived_fraction(),
        f.held.never, f.force.notches.size(), f.force.ledges.size(), f.force_rms,
        f.force.largest_jump.size, f.jumps.unexplained(), 1e2 * f.force_4khz_rms_fraction,
        1e2 * settled, f.support.force.empty() ? 0.0 : 1e3 * std::ranges::max(f.support.force),
        f.support.freed);
    rows.push_back({{"seed", s.seed}});
    AddContact(f, options.cycle, nullptr, rows.back());
  }
  std::fputs(out.c_str(), stderr);
  if (!options.json.empty()) {
    WriteJson(options.json, {{"scene", options.scene},
                             {"contact", NameOf(scene.features.contact)},
                             {"friction", NameOf(scene.features.friction)},
                             {"speed_m_per_s", options.hand.speed},
                             {"press_mm", options.hand.press_mm},
                             {"steps", options.hand.steps},
                             {"seeds", rows}});
  }
}

void Run(HandsOptions& options) {
  Scene scene = LoadForBench(options.scene, options.models, options.features.contact_model());
  options.features.ApplyTo(scene);
  if (!options.seeds.empty()) {
    RunSeeds(options, scene);
    return;
  }
  options.cycle.name = fmt::format("{}, seed {}", options.scene, options.hand.seed);
  Progress(options.cycle.name + ": making the hand ...");
  std::vector<Pose> poses = MakeHand(scene, options.hand);
  if (!options.poses_out.empty()) WriteOutput("--poses-out", options.poses_out, PosesCsv(poses));
  SceneRun run(std::move(scene), std::move(poses));
  Json json = ReportCycle(run, options.cycle);
  json["scene"] = options.scene;
  json["seed"] = options.hand.seed;
  json["speed_m_per_s"] = options.hand.speed;
  json["press_mm"] = options.hand.press_mm;
  if (!options.json.empty()) WriteJson(options.json, json);
}

}  // namespace

void AddHands(const CommandLine& app) {
  auto options = std::make_shared<HandsOptions>();
  const CommandLine command = app.AddCommand(
      "hands",
      "the figures of cycle for hand paths generated from a seed\n"
      "The hand approaches from a random direction, presses, slides, turns, squeezes,\n"
      "taps and leaves.  Also reports whether the tool settles when the hand rests, and\n"
      "how the force at 4 kHz differs from that at 1 kHz.");
  command.Footer(
      "Examples:\n"
      "  palpate-bench hands --scene bunny-bunny --seed 7 --speed 0.1 --steps 20000\n"
      "  palpate-bench hands --scene pipes --seeds 1..20 --speed 0.3 --steps 5000");
  Add(command, "--scene", options->scene,
      "name in the catalogue, scene file, or bodies with sharp edges generated from a seed: "
      "sharp-combs:7, sharp-gears:7, sharp-plates:7, sharp-dice:7, sharp-gear-comb:7 or "
      "sharp-terraces-ball:7");
  Add(command, "--seed", options->hand.seed, "seed of the hand's path");
  Add(command, "--seeds", options->seeds,
      "seeds A..B: one line for each, the worst first; no times")
      .Excludes(command.Find("--seed"));
  Add(command, "--speed", options->hand.speed, "mean speed of the hand, in m/s").Range(0.001, 5.0);
  Add(command, "--steps", options->hand.steps, "number of steps, one per millisecond").Positive();
  Add(command, "--press-mm", options->hand.press_mm,
      "largest depth to which it presses, in mm; the least is half of that")
      .Range(0.01, 100.0);
  Add(command, "--poses-out", options->poses_out,
      "write the hand's poses to this file, for 'cycle --poses'");
  options->cycle.AddTo(command);
  options->features.AddTo(command);
  AddModels(command, options->models);
  AddJson(command, options->json);
  command.Run([options] { Run(*options); });
}

}  // namespace palpate::bench
