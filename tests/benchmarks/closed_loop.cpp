// palpate-bench closed-loop: how stiff an object may be felt across a network, and how well.
#include <filesystem>
#include <fstream>

#include <spdlog/fmt/fmt.h>

#include "common/error.h"
#include "common/plot/svg_plot.h"
#include "devices/simulated/phantom_sheets.h"
#include "scenes/catalogue.h"
#include "scenes/pose_script.h"
#include "server/session/scene_model.h"
#include "tests/benchmarks/closed_loop_run.h"
#include "tests/benchmarks/commands.h"
#include "tests/benchmarks/delayed_slide.h"
#include "tests/benchmarks/figures.h"

namespace palpate::bench {
namespace {

struct Options {
  std::string device = "simulated", scene = "wall", local_model = "on", passivity = "on";
  ClosedLoopCase loop;
  bool slide = false;
  std::string json, out;
};

const double kDelays_ms[] = {0.0, 5.0, 10.0, 20.0};

/// The greatest stable stiffness at each delay, one way of closing the loop.
struct ZWidth {
  bool local_model, passivity;
  std::vector<double> stiffness;  ///< of kDelays_ms [N/m]
  std::string name() const {
    return fmt::format("local model {}, passivity controller {}", local_model ? "on" : "off",
                       passivity ? "on" : "off");
  }
};

std::vector<ZWidth> MeasureZWidth(const ClosedLoopScene& scene, const ClosedLoopCase& asked) {
  std::vector<ZWidth> widths;
  for (const bool passivity : {false, true}) {
    for (const bool local_model : {true, false}) {
      ZWidth& width = widths.emplace_back(ZWidth{local_model, passivity, {}});
      for (const double delay_ms : kDelays_ms) {
        Progress(fmt::format("{}: {:g} ms ...", width.name(), delay_ms));
        ClosedLoopCase c = asked;
        c.delay_ms = delay_ms;
        c.local_model = local_model;
        c.passivity = passivity;
        width.stiffness.push_back(MaxStableStiffness(scene, c));
      }
    }
  }
  Progress("");
  return widths;
}

std::vector<SlideErrors> MeasureSlides() {
  // Along the fixed bunny's back, where the scene's own script slides.
  const Scene scene = LoadScene("bunny-bunny");
  const HapticModel model = MakeModel(scene, scene.tools.front(), MakeObjects(scene));
  const PoseScript script = PoseScript::Load(ScriptFileBeside("bunny-bunny"));
  std::vector<Pose> way;
  for (double t = 1.1; t < 3.8; t += 1e-3) way.push_back(script.At(t));
  std::vector<SlideErrors> slides;
  for (const double delay_ms : kDelays_ms) {
    const DelayedSlide slide{0.1, static_cast<int>(delay_ms)};
    slides.push_back(MeasureDelayedSlide(model, AtSpeed(way, slide.speed_m_s), slide));
  }
  return slides;
}

nlohmann::ordered_json ToJson(const SlideError& error) {
  return {{"mean", error.mean}, {"p99", error.p99}, {"max", error.max}};
}

nlohmann::ordered_json ToJson(const std::vector<SlideErrors>& slides) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < slides.size(); ++i) {
    json.push_back({{"delay_ms", kDelays_ms[i]},
                    {"late", ToJson(slides[i].late)},
                    {"local", ToJson(slides[i].local)},
                    {"ticks", slides[i].ticks},
                    {"mean_force_N", slides[i].mean_force_N},
                    {"beyond_region", slides[i].beyond_region}});
  }
  return json;
}

void Print(const std::vector<SlideErrors>& slides) {
  fmt::print(stderr,
             "sliding on the bunny at 0.1 m/s, error of the force against the undelayed step's\n"
             "{:>8}  {:>24}  {:>24}\n",
             "delay", "late wrench, mean / max", "local model, mean / max");
  for (std::size_t i = 0; i < slides.size(); ++i) {
    const SlideErrors& s = slides[i];
    fmt::print(stderr, "{:>5g} ms  {:>13.1f} % / {:>5.1f} %  {:>13.1f} % / {:>5.1f} %\n",
               kDelays_ms[i], 100.0 * s.late.mean, 100.0 * s.late.max, 100.0 * s.local.mean,
               100.0 * s.local.max);
  }
}

void WriteReport(const Options& options, const std::vector<ZWidth>& widths,
                 const std::vector<SlideErrors>& slides) {
  const std::filesystem::path folder = options.out;
  std::filesystem::create_directories(folder);
  Plot plot;
  plot.title = "Stiffest stable contact against delay";
  plot.subtitle = fmt::format("{}, hand {}, jitter {:g} ms, loss {:g}", options.scene,
                              options.loop.hand, options.loop.jitter_ms, options.loop.loss);
  plot.x.title = "Delay, there and back [ms]";
  plot.y.title = "Stiffness [N/m]";
  plot.y.log = true;
  for (const ZWidth& width : widths) {
    plot.series.push_back({width.name(),
                           {std::begin(kDelays_ms), std::end(kDelays_ms)},
                           width.stiffness,
                           PlotSeries::Style::kLineAndPoints});
  }
  WriteSvg((folder / "z_width.svg").string(), {plot});

  const PublishedHand& hand = PublishedHandOf(options.loop.hand);
  std::string text = fmt::format(
      "# A contact across a network\n\n![Z-width](z_width.svg)\n\n"
      "Scene `{}`, device `{}`, hand `{}` ({}), jitter {:g} ms, loss {:g} each way. Delays are "
      "there and back; a reply is never there before the tick after its pose.\n\n"
      "Greatest stiffness [N/m] up to which the loop comes to rest after a tap, that is, moves by "
      "no more than two steps of the encoder in the last of {:g} s. {:.0f} is the most that is "
      "tried: beyond 2 f / q, dry friction over the encoder's step, quantisation alone feeds the "
      "hand (Diolaiti, Niemeyer, Barbagli & Salisbury, IEEE T. Robotics 22 (2006) 256-268).\n\n"
      "| |",
      options.scene, options.device, hand.name, hand.source, options.loop.jitter_ms,
      options.loop.loss, kClosedLoopWatch_s, kStiffest);
  for (const double delay_ms : kDelays_ms) text += fmt::format(" {:g} ms |", delay_ms);
  text += "\n|---|";
  for (std::size_t i = 0; i < std::size(kDelays_ms); ++i) text += "---:|";
  for (const ZWidth& width : widths) {
    text += "\n| " + width.name() + " |";
    for (const double stiffness : width.stiffness) text += fmt::format(" {:.0f} |", stiffness);
  }
  text +=
      "\n\n## Sliding\n\nA hand slides on the bunny at 0.1 m/s: error of the force against that of "
      "a server which answers at once, of that force.\n\n"
      "| delay [ms] | late wrench, mean | p99 | max | local model, mean | p99 | max |\n"
      "|---:|---:|---:|---:|---:|---:|---:|\n";
  for (std::size_t i = 0; i < slides.size(); ++i) {
    const SlideErrors& s = slides[i];
    text +=
        fmt::format("| {:g} | {:.1f} % | {:.1f} % | {:.1f} % | {:.1f} % | {:.1f} % | {:.1f} % |\n",
                    kDelays_ms[i], 100 * s.late.mean, 100 * s.late.p99, 100 * s.late.max,
                    100 * s.local.mean, 100 * s.local.p99, 100 * s.local.max);
  }
  std::ofstream file(folder / "report.md");
  file << text;
  if (!file.flush()) throw Error("closed-loop: cannot write " + (folder / "report.md").string());
}

void Run(Options options) {
  if (options.device != "simulated") options.loop.arm = PhantomSheetOf(options.device).name;
  options.loop.local_model = options.local_model == "on";
  options.loop.passivity = options.passivity == "on";
  const ClosedLoopScene scene = MakeClosedLoopScene(options.scene);
  const ClosedLoopFigures figures = RunClosedLoop(scene, options.loop);
  const double stiffest = MaxStableStiffness(scene, options.loop);
  fmt::print(stderr,
             "{} at {:g} N/m, {:g} ms of delay: {}\n"
             "  limit cycle            {:.3f} mm\n"
             "  energy given           {:.3g} J\n"
             "  force                  {:.2f} N\n"
             "  max stable stiffness   {:.0f} N/m{}\n",
             options.scene, options.loop.stiffness_N_per_m, options.loop.delay_ms,
             figures.stable ? "stable" : "NOT STABLE", figures.limit_cycle_mm, figures.energy_J,
             figures.mean_force_N, stiffest,
             stiffest >= kStiffest ? ", the most that is tried" : "");
  nlohmann::ordered_json json{{"device", options.device},
                              {"scene", options.scene},
                              {"hand", options.loop.hand},
                              {"delay_ms", options.loop.delay_ms},
                              {"jitter_ms", options.loop.jitter_ms},
                              {"loss", options.loop.loss},
                              {"local_model", options.loop.local_model},
                              {"passivity", options.loop.passivity},
                              {"stiffness_N_per_m", options.loop.stiffness_N_per_m},
                              {"stable", figures.stable},
                              {"energy_J", figures.energy_J},
                              {"limit_cycle_mm", figures.limit_cycle_mm},
                              {"mean_force_N", figures.mean_force_N},
                              {"beyond_region", figures.beyond_region},
                              {"max_stable_stiffness_N_per_m", stiffest}};
  if (options.slide || !options.out.empty()) {
    const std::vector<SlideErrors> slides = MeasureSlides();
    Print(slides);
    json["slide"] = ToJson(slides);
    if (!options.out.empty()) {
      const std::vector<ZWidth> widths = MeasureZWidth(scene, options.loop);
      for (const ZWidth& width : widths) {
        json["z_width"].push_back({{"local_model", width.local_model},
                                   {"passivity", width.passivity},
                                   {"delay_ms", kDelays_ms},
                                   {"max_stable_stiffness_N_per_m", width.stiffness}});
      }
      WriteReport(options, widths, slides);
    }
  }
  if (!options.json.empty()) WriteJson(options.json, json);
}

}  // namespace

void AddClosedLoop(CLI::App& app) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "closed-loop",
      "A simulated arm and hand, the station's loop and limiter, a link and the server's loop, in\n"
      "virtual time: does a contact come to rest, how much energy does the hand get, and how "
      "stiff\n"
      "may it be?\n"
      "Example: palpate-bench closed-loop --delay-ms 10 --local-model on --out closed-loop");
  const auto on_off = CLI::IsMember({"on", "off"});
  std::string hands;
  for (const PublishedHand& hand : PublishedHands()) hands += " " + hand.name;
  command
      ->add_option("--device", options->device,
                   "the simulated arm, as palpate-station's --model; simulated: its default")
      ->capture_default_str();
  command->add_option("--delay-ms", options->loop.delay_ms, "Delay there and back")
      ->check(CLI::Range(0.0, 200.0))
      ->capture_default_str();
  command->add_option("--jitter-ms", options->loop.jitter_ms, "Further delay, from 0 to this")
      ->check(CLI::Range(0.0, 200.0))
      ->capture_default_str();
  command->add_option("--loss", options->loop.loss, "Share of the samples that is lost, each way")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  command->add_option("--local-model", options->local_model, "The station's local contact model")
      ->check(on_off)
      ->capture_default_str();
  command->add_option("--passivity", options->passivity, "The limiter's energy stage")
      ->check(on_off)
      ->capture_default_str();
  command->add_option("--stiffness", options->loop.stiffness_N_per_m, "Of the coupling, in N/m")
      ->check(CLI::Range(1.0, kStiffest))
      ->capture_default_str();
  command->add_option("--hand", options->loop.hand, "Whose hand:" + hands)->capture_default_str();
  command->add_option("--scene", options->scene, "wall or bunny")
      ->check(CLI::IsMember({"wall", "bunny"}))
      ->capture_default_str();
  command->add_flag("--slide", options->slide, "Also the force's error while sliding on the bunny");
  command->add_option("--json", options->json, "Write one JSON object to FILE (- is stdout)");
  command->add_option("--out", options->out,
                      "Write DIR/report.md and DIR/z_width.svg: stiffness against delay");
  command->callback([options] { Run(*options); });
}

}  // namespace palpate::bench
