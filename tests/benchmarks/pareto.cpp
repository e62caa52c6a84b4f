// palpate-bench pareto: speed against error, for every scene, contact and friction model, and for
// the peers that are installed.
#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>

#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

#include "common/error.h"
#include "common/program/stop_signal.h"
#include "scenes/catalogue.h"
#include "scenes/shapes/shapes.h"
#include "tests/benchmarks/commands.h"
#include "tests/benchmarks/features.h"
#include "tests/benchmarks/overlap_oracle.h"
#include "tests/benchmarks/pareto_measure.h"
#include "tests/benchmarks/pareto_report.h"
#include "tests/benchmarks/pose_source.h"

namespace palpate::bench {
namespace {

struct ParetoOptions {
  std::string out;
  bool quick = false, only_peers = false;
  std::vector<std::string> peers;  // none named: all
  std::vector<std::string> scenes;
  std::string models;
  std::optional<int> repeats;  // 5, and 2 with --quick
};

constexpr const char* kPeerScene = "bunny-bunny";
constexpr const char* kContacts[] = {"spheres", "surface"};
constexpr const char* kFrictions[] = {"off", "chapter", "coulomb"};
// Triangles of the ball used for penetration: at most 1 um inside the true ball.
constexpr std::size_t kFineBall = 20480;

std::string PalpateWith(const std::string& contact) {
  return fmt::format("Palpate, {} contact", contact == "spheres" ? "sphere" : contact);
}

/// Of StepReports or PeerSteps.
std::vector<Pose> PosesOf(const auto& steps) {
  std::vector<Pose> poses;
  for (const auto& step : steps) poses.push_back(step.X_WG);
  return poses;
}
std::vector<Vec3> ForcesOf(const auto& steps) {
  std::vector<Vec3> forces;
  for (const auto& step : steps) forces.push_back(step.wrench.force);
  return forces;
}

/// Reports an error from the physics, a peer or a file as a line, without ending the run.
template <class Work>
void OrReason(std::string& not_available, Work measure) {
  try {
    measure();
  } catch (const Error& error) {
    not_available = error.what();
  }
}

class Pareto {
 public:
  explicit Pareto(const ParetoOptions& options) : options_(options) {
    const auto list = [](const char* option, const std::vector<std::string>& names) {
      return names.empty() ? "" : fmt::format(" {} {}", option, fmt::join(names, ","));
    };
    results_.command =
        fmt::format("palpate-bench {} --out DIR{}{}{}{}", options.only_peers ? "peers" : "pareto",
                    options.quick ? " --quick" : "", list("--peers", options.peers),
                    list("--scenes", options.scenes),
                    options.repeats ? fmt::format(" --repeats {}", *options.repeats) : "");
    results_.quick = options.quick;
    results_.only_peers = options.only_peers;
    results_.machine = ThisMachine();
    scenes_ = !options.scenes.empty() ? options.scenes
              : options.quick         ? std::vector<std::string>{"cube", "ellipsoid", kPeerScene}
                                      : CatalogueNames();
    // palpate-bench cut measures contact with their grids.
    for (const char* cut : {"calculus", "caries", "crown", "osteotomy"}) std::erase(scenes_, cut);
    for (const std::string& scene : scenes_) FindSceneFile(scene);  // complains before work is done
    ChoosePeers();
  }

  void Run() {
    if (!options_.only_peers) {
      PlanSlides();
      for (const std::string& scene : scenes_) PlanScene(scene);
    }
    PlanPeers();

    WritePareto(options_.out, results_);  // complains before work is done
    for (std::size_t i = 0; i < tasks_.size() && !stop_.stopped(); ++i) {
      Progress(fmt::format("{} of {}: {} ...", i + 1, tasks_.size(), tasks_[i].what));
      try {
        tasks_[i].run();
      } catch (const Stopped&) {
        break;
      }
      results_.complete = i + 1 == tasks_.size();
      WritePareto(options_.out, results_);
    }
    Progress("");
    if (!ReportPareto(options_.out, results_))
      fmt::print(stderr, "what is missing of the report pareto_report.py makes of its JSON\n");
    fmt::print(stderr, "{}{}/report.md\n",
               results_.complete ? "" : "ended early; so far: ", options_.out);
  }

 private:
  struct Task {
    std::string what;
    std::function<void()> run;  ///< throws Stopped
  };
  void Plan(std::string what, std::function<void()> run) {
    tasks_.push_back({std::move(what), std::move(run)});
  }

  int repeats() const { return options_.repeats.value_or(options_.quick ? 2 : 5); }
  int checks() const { return options_.quick ? 100 : 2000; }
  std::vector<Pose> PathOf(const std::string& scene) const {
    std::vector<Pose> poses = ScriptPoses(scene, std::nullopt);
    // The beginning of a path is long enough to touch.
    if (options_.quick && poses.size() > 1500) poses.resize(1500);
    return poses;
  }

  void ChoosePeers() {
    const auto has = [&](const char* name) {
      return std::find(options_.peers.begin(), options_.peers.end(), name) != options_.peers.end();
    };
    std::vector<std::string> known{"all", "none"};
    std::vector<std::string> loaded;
    results_.peers_known = PeerKinds();
    for (const std::string& name : options_.peers) {
      if (!name.ends_with(".so")) continue;
      known.push_back(name);
      for (const PeerKind& kind : PeersOf(name)) {
        loaded.push_back(kind.id);
        results_.peers_known.push_back(kind);
      }
    }
    for (const PeerKind& kind : results_.peers_known) {
      known.push_back(kind.id);
      const bool from_file = std::find(loaded.begin(), loaded.end(), kind.id) != loaded.end();
      if (!options_.peers.empty() && !has("all") && !has(kind.id.c_str()) && !from_file) continue;
      results_.peers_asked.push_back(kind.id);
      if (kind.installed()) {
        peers_.push_back(kind);
      } else {
        fmt::print(stderr, "{} is left out: it {}\n", kind.name, HowToInstall(kind));
      }
    }
    for (const std::string& name : options_.peers) {
      if (std::find(known.begin(), known.end(), name) != known.end()) continue;
      throw UsageError(
          fmt::format("pareto: --peers {} is not one of {}", name, fmt::join(known, ", ")));
    }
    if (options_.only_peers && peers_.empty() && !has("none")) {
      throw Error(
          "peers: there is none to measure; install one as said above, or give --peers FILE.so");
    }
  }

  // ---- the force of a sliding ball

  void PlanSlides() {
    const std::size_t own = SlidingExperiment{}.triangles;
    for (const char* contact : kContacts) {
      for (const std::size_t spheres : {64, 512, 4096}) PlanSlide("cube", spheres, 12, contact);
      for (const std::size_t spheres : {8, 64, 512}) PlanSlide("ellipsoid", spheres, own, contact);
    }
    for (const std::size_t triangles : {kFewTriangles, kManyTriangles}) {
      PlanSlide("ellipsoid", 512, triangles, "surface");
    }
  }

  void PlanSlide(const std::string& object, std::size_t spheres, std::size_t triangles,
                 const std::string& contact) {
    // Curved surfaces and balanced trees of many spheres take seconds to make.
    const bool costly =
        spheres == 4096 || (object == "ellipsoid" && (spheres < 512 || contact == "surface"));
    if (options_.quick && costly) return;
    Plan(fmt::format("force on {} of {} spheres, {} contact", object, spheres, contact), [=, this] {
      SlideResult result;
      result.object = object;
      result.spheres = spheres;
      result.triangles = triangles;
      result.contact = contact;
      result.friction = "off";
      OrReason(result.not_available, [&] {
        const SlidingForce force =
            MeasureSlidingForce({.object = object,
                                 .triangles = triangles,
                                 .features = FeatureOptions{contact, "off"}.features(),
                                 .repeats = repeats()},
                                spheres);
        result.slide = force.errors.magnitude;
        result.speed = {PercentilesOf(force.step_us.best()), PercentilesOf(force.step_us.all())};
      });
      results_.slides.push_back(result);
    });
  }

  // ---- scenes

  void PlanScene(const std::string& name) {
    const std::size_t at = results_.scenes.size();
    results_.scenes.push_back({.scene = name});
    Plan(name, [this, name, at] {
      SceneResult& result = results_.scenes[at];
      loaded_.reset();
      OrReason(result.not_available, [&] { Load(name); });
      if (!loaded_) return;
      const Body& tool = loaded_->scene.tools.front();
      result.tool_spheres = tool.tree.leaves();
      result.triangles = tool.mesh.triangles.size();
      for (const Body& object : loaded_->scene.objects) {
        result.object_spheres += object.tree.leaves();
        result.triangles += object.mesh.triangles.size();
      }
      result.steps = loaded_->poses.size();
      const Features& features = loaded_->scene.features;
      result.yields = features.compliance;
    });
    for (const char* contact : kContacts) {
      for (const char* friction : kFrictions) {
        Plan(fmt::format("{}, {} contact, friction {}", name, contact, friction),
             [this, at, contact, friction] {
               if (loaded_) results_.scenes[at].runs.push_back(MeasureModel(contact, friction));
             });
      }
    }
  }

  void Load(const std::string& name) {
    auto loaded = std::make_unique<Loaded>();
    loaded->name = name;
    loaded->scene = LoadForBench(name, options_.models);
    loaded->of_spheres = LoadForBench(name, options_.models, ContactModel::kSpheres);
    loaded->poses = PathOf(name);
    loaded->judge = std::make_unique<PathJudge>(loaded->scene, loaded->poses, checks(), stop_);
    loaded->oracle =
        std::make_unique<OverlapOracle>(loaded->of_spheres.tools.front().tree,
                                        loaded->of_spheres.objects, loaded->of_spheres.features);
    loaded_ = std::move(loaded);
  }

  ModelRun MeasureModel(const std::string& contact, const std::string& friction) {
    ModelRun model;
    model.contact = contact;
    model.friction = friction;
    OrReason(model.not_available, [&] {
      Scene scene = contact == "spheres" ? loaded_->of_spheres : loaded_->scene;
      FeatureOptions{contact, friction}.ApplyTo(scene);
      SceneRun run(std::move(scene), loaded_->poses);
      const TimedRun timed = TimeRun(run, repeats(), stop_);
      model.speed = timed.speed;
      model.path = loaded_->judge->Judge(PosesOf(timed.steps), ForcesOf(timed.steps));
      if (contact == "spheres") model.sphere_overlap_um = 1e6 * SphereOverlap(timed.steps);
    });
    return model;
  }

  /// Deepest overlap of the spheres, at the steps that are checked [m].
  double SphereOverlap(const std::vector<StepReport>& steps) const {
    double deepest = 0.0;
    for (std::size_t i = 0; i < steps.size(); i += loaded_->judge->every()) {
      deepest = std::max(deepest, loaded_->oracle->At(steps[i].X_WG).depth);
    }
    return deepest;
  }

  // ---- peers

  void PlanPeers() {
    if (peers_.empty() && !options_.only_peers) return;
    results_.peer_scene = kPeerScene;
    Plan("the peers' scene", [this] {
      if (!loaded_ || loaded_->name != kPeerScene) Load(kPeerScene);
      results_.peer_steps = loaded_->poses.size();
    });
    for (const char* contact : kContacts) {
      Plan(fmt::format("the peers' path, {} contact", contact), [this, contact] {
        PeerRun run;
        run.name = PalpateWith(contact);
        OrReason(run.not_available, [&] {
          Scene scene = loaded_->scene;
          scene.features = FeatureOptions{contact, "off"}.features();
          SceneRun palpate(std::move(scene), loaded_->poses);
          const TimedRun timed = TimeRun(palpate, repeats(), stop_);
          run.speed = timed.speed;
          run.path = loaded_->judge->Judge(PosesOf(timed.steps), ForcesOf(timed.steps));
        });
        results_.peer_path.push_back(run);
      });
    }
    for (const PeerKind& kind : peers_) {
      Plan("the peers' path, " + kind.name,
           [this, &kind] { results_.peer_path.push_back(MeasurePeer(kind)); });
    }
    for (const char* object : {"cube", "ellipsoid"}) {
      Plan(fmt::format("the peers' slide, {}", object),
           [this, object] { MeasurePeerSlide({.object = object}); });
    }
  }

  PeerRun MeasurePeer(const PeerKind& kind) const {
    PeerRun run;
    run.id = kind.id;
    run.name = kind.name + (kind.convex ? " (hulls)" : "");
    OrReason(run.not_available, [&] {
      const TimedPeer timed =
          TimePeer(kind, ForPeers(loaded_->scene), loaded_->poses, std::min(repeats(), 3), stop_);
      run.speed = timed.speed;
      run.path = loaded_->judge->Judge(PosesOf(timed.steps), ForcesOf(timed.steps));
    });
    return run;
  }

  /// Measures all peers over one object with the same triangles.
  void MeasurePeerSlide(const SlidingExperiment& experiment) {
    const SlidingPath path = bench::PathOf(experiment);
    const std::size_t spheres = options_.quick ? 512 : 4096;
    Scene scene = SlidingScene(experiment, spheres);
    scene.tools.front().mesh = MakeSphere(kSlidingBallRadius, kFineBall);
    std::vector<Pose> hand;
    for (const Vec3& p : path.hand) hand.push_back({p});
    const PathJudge judge(scene, hand, checks(), stop_);
    const auto add = [&](PeerRun run, const auto& measure) {
      run.object = experiment.object;
      OrReason(run.not_available, [&] {
        const auto [speed, steps] = measure();
        run.speed = speed;
        run.slide = ForceErrors(path, ForcesOf(steps)).magnitude;
        run.path = judge.Judge(PosesOf(steps), ForcesOf(steps));
      });
      results_.peer_slide.push_back(run);
    };
    for (const char* contact : kContacts) {
      PeerRun run;
      run.name = fmt::format("{}, {} spheres", PalpateWith(contact), spheres);
      add(run, [&] {
        scene.features = FeatureOptions{contact, "off"}.features();
        SceneRun palpate(scene, hand);
        return TimeRun(palpate, repeats(), stop_);
      });
    }
    for (const PeerKind& kind : peers_) {
      PeerRun run;
      run.id = kind.id;
      run.name = kind.name;
      add(run, [&] { return TimePeer(kind, ForPeers(scene), hand, repeats(), stop_); });
    }
  }

  /// The scene that is being measured; only one is in memory.
  struct Loaded {
    std::string name;
    Scene scene, of_spheres;  ///< as the scene says, and with the trees of sphere contact
    std::vector<Pose> poses;
    std::unique_ptr<PathJudge> judge;
    std::unique_ptr<OverlapOracle> oracle;
  };

  const ParetoOptions& options_;
  StopSignal stop_;
  std::vector<std::string> scenes_;
  std::vector<PeerKind> peers_;  ///< asked for and installed
  std::vector<Task> tasks_;
  ParetoResults results_;
  std::unique_ptr<Loaded> loaded_;
};

void AddPeerOptions(const CommandLine& command, ParetoOptions& options) {
  Add(command, "--out", options.out, "folder for the results, created if it does not exist")
      .Required();
  Add(command, "--peers", options.peers,
      "all (the default), none, or some of bullet,ode,mujoco separated by commas; also a library\n"
      "of your own, FILE.so (tests/benchmarks/peers/peer.h)");
  Add(command, "--repeats", options.repeats, "number of identical runs; default: 5, with --quick 2")
      .Positive();
  AddModels(command, options.models);
}

}  // namespace

void AddPeers(const CommandLine& app) {
  auto options = std::make_shared<ParetoOptions>();
  options->only_peers = true;
  const CommandLine command = app.AddCommand(
      "peers",
      "compare Palpate with other libraries on the same meshes and hand\n"
      "For each installed library: penetration, time of a step, and force, also\n"
      "compared with the analytic solution.  Writes report.md, peers.svg, peers.csv and\n"
      "peers.json.");
  command.Footer("Example: palpate-bench peers --out build/peers");
  command.AddFlag("--quick", options->quick,
                  "measure only the beginning of the path, with few repeats");
  AddPeerOptions(command, *options);
  command.Run([options] { Pareto(*options).Run(); });
}

void AddPareto(const CommandLine& app) {
  auto options = std::make_shared<ParetoOptions>();
  const CommandLine command =
      app.AddCommand("pareto",
                     "speed against error of all scenes, contact and friction models, and peers\n"
                     "Writes pareto.json after each measurement; at the end, also on Ctrl-C,\n"
                     "report.md, pareto.csv and pareto.svg.  Pictures need matplotlib\n"
                     "(python3-matplotlib).");
  command.Footer("Example: palpate-bench pareto --out build/pareto --peers bullet,ode");
  command.AddFlag("--quick", options->quick,
                  "measure few scenes, with short paths and few repeats");
  AddPeerOptions(command, *options);
  Add(command, "--scenes", options->scenes,
      "names in the catalogue or scene files, separated by commas; default: the whole catalogue");
  command.Run([options] { Pareto(*options).Run(); });
}

}  // namespace palpate::bench
