// palpate-bench truth: bodies whose right answer is known by construction, under seeded hands.
#include "tests/benchmarks/truth.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <memory>
#include <utility>

#include <spdlog/fmt/fmt.h>

#include "common/error.h"
#include "common/files/output.h"
#include "common/program/stop_signal.h"
#include "scenes/files/scene_bundle.h"
#include "server/physics/scene_model.h"
#include "tests/benchmarks/commands.h"
#include "tests/benchmarks/figures.h"
#include "tests/benchmarks/machine.h"
#include "tests/benchmarks/scene_run.h"

namespace palpate::bench {
namespace {

struct TruthOptions {
  std::string seeds = "1..1", only, json, scene_out, poses_out;
  bool list = false, million = false;
};

/// The three words of a name.
std::array<std::string, 3> Words(const std::string& name) {
  const std::size_t first = name.find('/'), second = name.find('/', first + 1);
  return {name.substr(0, first), name.substr(first + 1, second - first - 1),
          name.substr(second + 1)};
}

std::vector<TruthCase> Chosen(const TruthOptions& options) {
  std::vector<TruthCase> cases = FlatTruths();
  for (auto& more : {FoldTruths(), CurvedTruths(options.million)}) {
    cases.insert(cases.end(), more.begin(), more.end());
  }
  std::ranges::move(CutTruths(), std::back_inserter(cases));
  std::erase_if(cases,
                [&](const TruthCase& c) { return c.name.find(options.only) == std::string::npos; });
  if (cases.empty()) {
    throw UsageError("--only " + options.only + " is in no case's name; --list shows them, with " +
                     "--million those of a million triangles, too");
  }
  return cases;
}

std::string Header(const Tally& tally) {
  std::string line = fmt::format("{:<34}", "");
  for (const Tally::Figure& f : tally.figures()) {
    line += fmt::format(" {:>13}", f.name);
    if (f.kind != Tally::Kind::kCount) line += fmt::format(" {:>5}", "seed");
  }
  return line + "\n";
}

std::string Row(const std::string& name, const Tally& tally) {
  std::string line = fmt::format("{:<34}", name);
  for (const Tally::Figure& f : tally.figures()) {
    if (f.kind == Tally::Kind::kCount) {
      line += fmt::format(" {:>13.0f}", f.value);
    } else {
      line += fmt::format(" {:>13.3g} {:>5}", f.value, f.seed);
    }
  }
  return line + "\n";
}

Json ToJson(const std::string& name, const Tally& tally) {
  Json json{{"name", name}};
  for (const Tally::Figure& f : tally.figures()) {
    json[f.name] = f.value;
    if (f.kind != Tally::Kind::kCount) json[f.name + ", seed"] = f.seed;
  }
  return json;
}

/// Cases that have their first word, and one of the others or none, in common, taken together.
std::vector<std::pair<std::string, Tally>> Totals(
    const std::vector<std::pair<std::string, Tally>>& rows) {
  std::vector<std::pair<std::string, Tally>> totals;
  std::map<std::string, int> summed;
  const auto add = [&](const std::string& name, const Tally& tally) {
    ++summed[name];
    const auto same = [&](const auto& total) { return total.first == name; };
    auto at = std::find_if(totals.begin(), totals.end(), same);
    if (at == totals.end()) at = totals.insert(at, {name, Tally()});
    at->second.Merge(tally);
  };
  for (const auto& [name, tally] : rows) add(Words(name)[0] + "/" + Words(name)[1] + "/*", tally);
  for (const auto& [name, tally] : rows) add(Words(name)[0] + "/*/" + Words(name)[2], tally);
  for (const auto& [name, tally] : rows) add(Words(name)[0] + "/*/*", tally);
  // What sums up one case says nothing new.
  std::erase_if(totals, [&](const auto& total) { return summed[total.first] < 2; });
  return totals;
}

void Drive(const TruthHand& hand) {
  const HapticModel model =
      MakeModel(hand.scene, hand.scene.tools.front(), MakeObjects(hand.scene));
  StepWorkspace workspace(model);
  StepState state(model);
  state.X_WG = hand.X_WH.front();
  for (std::size_t i = 0; i < hand.X_WH.size(); ++i) {
    hand.see(i, HapticStep(model, hand.X_WH[i], state, workspace));
  }
}

/// Writes one hand for other commands.
void Write(const TruthOptions& options, const TruthHand& hand) {
  if (!options.scene_out.empty()) WriteFileAtomically(options.scene_out, PackScene(hand.scene));
  if (!options.poses_out.empty()) {
    WriteOutput("--poses-out", options.poses_out, PosesCsv(hand.X_WH));
  }
}

void Run(const TruthOptions& options) {
  const std::vector<TruthCase> cases = Chosen(options);
  if (options.list) {
    for (const TruthCase& c : cases) fmt::print("{}\n", c.name);
    return;
  }
  const auto [first, last] = SeedRange(options.seeds);
  if (!(options.scene_out + options.poses_out).empty()) {
    if (cases.size() > 1 || first < last) {
      throw UsageError("--scene-out and --poses-out are for one hand; give one case and one seed");
    }
    Write(options, cases.front().make(first));
  }
  StopSignal stop;
  std::vector<std::pair<std::string, Tally>> rows;
  for (const TruthCase& c : cases) {
    Tally tally;
    for (std::uint64_t seed = first; seed <= last && !stop.stopped(); ++seed) {
      Progress(fmt::format("{}, seed {} of {} ...", c.name, seed, options.seeds));
      const TruthHand hand = c.make(seed);
      Drive(hand);
      Tally of_hand(seed);
      hand.tell(of_hand);
      tally.Merge(of_hand);
    }
    Progress("");
    if (tally.figures().empty()) break;
    if (rows.empty() || Words(rows.back().first)[0] != Words(c.name)[0]) {
      fmt::print(stderr, "{}", Header(tally));
    }
    rows.emplace_back(c.name, tally);
    fmt::print(stderr, "{}", Row(c.name, tally));
  }
  const auto totals = Totals(rows);
  for (const auto& [name, tally] : totals) fmt::print(stderr, "{}", Row(name, tally));
  if (stop.stopped()) fmt::print(stderr, "interrupted: the figures above are not of all seeds\n");
  if (options.json.empty()) return;
  Json json{{"seeds", options.seeds},
            {"machine", bench::ToJson(ThisMachine())},
            {"complete", !stop.stopped()}};
  for (const auto& [name, tally] : rows) json["cases"].push_back(ToJson(name, tally));
  for (const auto& [name, tally] : totals) json["totals"].push_back(ToJson(name, tally));
  WriteJson(options.json, json);
}

}  // namespace

void AddTruth(const CommandLine& app) {
  auto options = std::make_shared<TruthOptions>();
  const CommandLine command = app.AddCommand(
      "truth",
      "bodies whose right answer is known, under hands from a seed\n"
      "Plates that are flat, however they are divided into triangles, under nine tools\n"
      "that press, tremble, slide and turn (flat); grooves and holes with such sides,\n"
      "and what fits into them (folds); meshes of smooth bodies (curved); bars, sheets\n"
      "and islands that burs go through, and out of which they must come, and a block\n"
      "that they mill while they tilt (cut).\n"
      "Prints for each body and tool how far the force is from the truth, and the seed\n"
      "of the worst hand.");
  command.Footer(
      "Examples:\n"
      "  palpate-bench truth --seeds 1..20 --json truth.json\n"
      "  palpate-bench truth --only cut/ --seeds 1..24\n"
      "  palpate-bench truth --only flat/needles/box --seeds 17..17 \\\n"
      "    --scene-out slide.bundle --poses-out slide.csv\n"
      "  palpate-bench cycle --scene slide.bundle --poses slide.csv");
  Add(command, "--seeds", options->seeds, "seeds A..B of the hands, tools and plates of each case");
  Add(command, "--only", options->only, "only cases with this in their name (see --list)");
  command.AddFlag("--list", options->list, "list the cases");
  command.AddFlag("--million", options->million,
                  "with curved bodies of a million triangles, some seconds each");
  Add(command, "--scene-out", options->scene_out,
      "write the scene of the one hand to this file, a bundle for 'cycle --scene'");
  Add(command, "--poses-out", options->poses_out,
      "write the poses of the one hand to this file, for 'cycle --poses'");
  AddJson(command, options->json);
  command.Run([options] { Run(*options); });
}

}  // namespace palpate::bench
