// palpate-bench limiter: what can be got out of a device's limiter by force, and the energy at its
// port with and without the passivity controller.
#include <chrono>

#include <spdlog/fmt/fmt.h>

#include "common/error.h"
#include "devices/simulated/phantom_sheets.h"
#include "tests/benchmarks/commands.h"
#include "tests/benchmarks/figures.h"
#include "tests/support/limiter_adversary.h"
#include "tests/support/port_loop.h"
#include "tests/support/uncontrolled_limiter.h"

namespace palpate::bench {
namespace {

struct Options {
  std::uint64_t inputs = 10'000'000;
  std::uint64_t seed = 1;
  std::string json;
};

/// An ordinary second of contact, over and over: a spring that is pressed and let go.
double CostPerCall_ns(const WrenchLimits& limits) {
  constexpr int kCalls = 2'000'000;
  WrenchLimiter limiter(limits);
  limiter.SetStiffness(1000.0);
  limiter.Enable(true);
  LimiterInput in;
  in.silence_s = in.age_s = in.dt_s = 1e-3;
  double sum = 0.0;
  const auto began = std::chrono::steady_clock::now();
  for (int i = 0; i < kCalls; ++i) {
    const double phase = (i % 1000) * 1e-3;
    in.X_WH.p.z() = -0.003 * 4.0 * phase * (1.0 - phase);
    in.wanted.force = Vec3(0.1, 0.2, -1000.0 * in.X_WH.p.z());
    in.wanted.torque = Vec3(0.01, -0.02, 0.005);
    sum += limiter.Limit(in).wrench().force.z();
  }
  const std::chrono::duration<double, std::nano> took = std::chrono::steady_clock::now() - began;
  return sum > 0.0 ? took.count() / kCalls : 0.0;  // the sum is used, so nothing is left out
}

Json PortEnergy(const WrenchLimits& limits) {
  auto rows = Json::Array();
  fmt::print(stderr,
             "\nenergy that a hand is given at a wall of 1000 N/m, 10 % lost, 10 s [mJ]\n"
             "{:>8} {:>12} {:>12} {:>14} {:>14} {:>14}\n",
             "delay ms", "without", "with", "highest with", "by true way", "force change");
  for (const int delay_ms : {0, 1, 2, 5, 10, 20}) {
    test::PortLoopCase c;
    c.delay_ms = delay_ms;
    c.loss = 0.1;
    test::UncontrolledLimiter without(limits);
    const test::PortLoopFigures active = RunPortLoop(without, c);
    WrenchLimiter with(limits);
    with.SetStiffness(c.stiffness_N_per_m);
    const test::PortLoopFigures figures = RunPortLoop(with, c);
    const double change = figures.rms_change_N / figures.rms_wanted_N;
    fmt::print(stderr, "{:>8} {:>12.3f} {:>12.3f} {:>14.4f} {:>14.4f} {:>12.1f} %\n", delay_ms,
               1e3 * active.generated_J, 1e3 * figures.generated_J, 1e3 * figures.most_generated_J,
               1e3 * figures.true_most_generated_J, 100.0 * change);
    rows.push_back({{"delay_ms", delay_ms},
                    {"without_J", active.generated_J},
                    {"with_J", figures.generated_J},
                    {"with_highest_J", figures.most_generated_J},
                    {"with_true_highest_J", figures.true_most_generated_J},
                    {"force_change_rms", change}});
  }
  return rows;
}

void Run(const Options& options) {
  const WrenchLimits limits = WrenchLimits::Of(PhantomPremium30().info);
  test::LimiterAdversary adversary(limits, options.seed);
  const auto began = std::chrono::steady_clock::now();
  const test::LimiterTally t = adversary.Run(options.inputs, [&](std::uint64_t done) {
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - began;
    Progress(fmt::format("{:.0f} % of {} inputs, {:.0f} s ...",
                         100.0 * static_cast<double>(done) / static_cast<double>(options.inputs),
                         options.inputs, took.count()));
  });
  Progress("");
  const double call_ns = CostPerCall_ns(limits);
  const LimiterCounts& c = t.counts;
  fmt::print(stderr,
             "{} inputs: {} outputs not finite\n"
             "worst over its limit: force {:.9f}, torque {:.9f}, change of force {:.9f}, of torque "
             "{:.9f}\n"
             "stages, of {} calls that went on: not finite {}, clamped {}, slewed {}, braked {}, "
             "warm {}, faded {} ({} fades), disabled {}\n"
             "{:.0f} ns per call in contact\n",
             t.inputs, t.nonfinite, t.force, t.torque, t.force_slew, t.torque_slew, c.calls,
             c.nonfinite, c.clamped, c.slewed, c.braked, c.warm, c.faded, c.fades, c.disabled,
             call_ns);
  const Json json{{"device", PhantomPremium30().info.model},
                  {"inputs", t.inputs},
                  {"nonfinite_outputs", t.nonfinite},
                  {"force_over_limit", t.force},
                  {"torque_over_limit", t.torque},
                  {"force_slew_over_limit", t.force_slew},
                  {"torque_slew_over_limit", t.torque_slew},
                  {"counts",
                   {{"calls", c.calls},
                    {"nonfinite", c.nonfinite},
                    {"clamped", c.clamped},
                    {"slewed", c.slewed},
                    {"braked", c.braked},
                    {"warm", c.warm},
                    {"faded", c.faded},
                    {"fades", c.fades},
                    {"disabled", c.disabled}}},
                  {"call_ns", call_ns},
                  {"held", t.nonfinite == 0 && t.worst() <= 1.0},
                  {"energy", PortEnergy(limits)}};
  if (!options.json.empty()) WriteJson(options.json, json);
  if (t.nonfinite > 0 || t.worst() > 1.0) throw Error("limiter: it let more through than it may");
}

}  // namespace

void AddLimiter(const CommandLine& app) {
  auto options = std::make_shared<Options>();
  const CommandLine command =
      app.AddCommand("limiter",
                     "Tries to get more out of a device's limiter than it may let through, and "
                     "measures the energy\n"
                     "at its port with and without the passivity controller.\n"
                     "Exits with 1 where a limit did not hold.\n"
                     "Example: palpate-bench limiter --inputs 100000000 --json limiter.json");
  Add(command, "--inputs", options->inputs, "Wrenches, poses and times to try").Positive();
  Add(command, "--seed", options->seed, "Of what is tried");
  AddJson(command, options->json);
  command.Run([options] { Run(*options); });
}

}  // namespace palpate::bench
