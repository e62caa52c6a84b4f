// palpate-bench pareto: speed against error, for every scene, contact and friction model, and for
// the peers that are installed.
#include <algorithm>
#include <functional>
#include <memory>

#include <spdlog/fmt/fmt.h>

#include "common/error.h"
#include "common/stop_signal.h"
#include "scenes/catalogue.h"
#include "tests/benchmarks/commands.h"
#include "tests/benchmarks/features.h"
#include "tests/benchmarks/overlap_oracle.h"
#include "tests/benchmarks/pareto_measure.h"
#include "tests/benchmarks/pareto_report.h"
#include "tests/benchmarks/pose_source.h"

namespace palpate::bench {
namespace {

struct Options {
  std::string out;
  bool quick = false;
  std::string peers = "all";
  std::vector<std::string> scenes;
  std::string models;
  int repeats = 0;  // 0: 5, and 2 with --quick
};

constexpr const char* kPeerScene = "bunny-bunny";
constexpr const char* kContacts[] = {"spheres", "surface"};
constexpr const char* kFrictions[] = {"off", "chapter", "coulomb"};
// Of objects that have no friction of their own, as in chapter 2.5.6.
constexpr double kStaticFriction = 0.8, kDynamicFriction = 0.3;

/// One measurement of the run.
struct Task {
  std::string what;
  std::function<void()> run;
};

class Pareto {
 public:
  explicit Pareto(const Options& options) : options_(options) {
    results_.command = fmt::format(
        "palpate-bench pareto --out DIR{}{}{}", options.quick ? " --quick" : "",
        options.peers == "all" ? "" : " --peers " + options.peers,
        options.scenes.empty() ? "" : fmt::format(" --scenes {}", fmt::join(options.scenes, ",")));
    results_.quick = options.quick;
    results_.machine = ThisMachine();
    scenes_ = !options.scenes.empty() ? options.scenes
              : options.quick         ? std::vector<std::string>{"cube", "ellipsoid", kPeerScene}
                                      : CatalogueNames();
    for (const std::string& scene : scenes_) FindSceneFile(scene);  // complains before hours pass
    for (const PeerKind& kind : PeerKinds()) {
      if (Asked(kind.id)) results_.peers_asked.push_back(kind.id);
    }
  }

  void Run() {
    std::vector<Task> tasks;
    PlanSlides(tasks);
    for (const std::string& scene : scenes_) PlanScene(scene, tasks);
    tasks.push_back({"what features cost", [this] { MeasureFeatures(); }});
    PlanPeers(tasks);

    WritePareto(options_.out, results_);  // complains now where it cannot be written
    for (std::size_t i = 0; i < tasks.size(); ++i) {
      Progress(fmt::format("{} of {}: {} ...", i + 1, tasks.size(), tasks[i].what));
      try {
        tasks[i].run();
      } catch (const Stopped&) {
        break;
      }
      results_.complete = i + 1 == tasks.size();
      WritePareto(options_.out, results_);
      if (stop_.stopped()) break;
    }
    Progress("");
    fmt::print(stderr, "{}{}/report.md\n",
               results_.complete ? "" : "ended before its time; so far: ", options_.out);
  }

 private:
  bool Asked(const std::string& id) const {
    const std::string list = "," + options_.peers + ",";
    return options_.peers == "all" || list.find("," + id + ",") != std::string::npos;
  }
  int repeats() const { return options_.repeats > 0 ? options_.repeats : options_.quick ? 2 : 5; }
  int checks() const { return options_.quick ? 60 : 400; }
  std::vector<Pose> PathOf(const std::string& scene) const {
    std::vector<Pose> poses = ScriptPoses(scene, std::nullopt);
    // The beginning of a path: long enough to touch.
    if (options_.quick && poses.size() > 1500) poses.resize(1500);
    return poses;
  }

  // ---- scenes

  /// The scene that is being measured; only one is in memory.
  struct Loaded {
    Scene scene;
    std::vector<Pose> poses;
    std::unique_ptr<PathJudge> judge;
    std::unique_ptr<OverlapOracle> oracle;
  };

  /// Calls `measure` where it can; what the physics or the files refuse is a line in the report.
  template <class Work>
  static void OrReason(std::string& not_available, Work measure) {
    try {
      measure();
    } catch (const Error& error) {
      not_available = error.what();
    }
  }

  void PlanScene(const std::string& name, std::vector<Task>& tasks) {
    const std::size_t at = results_.scenes.size();
    results_.scenes.push_back({.scene = name});
    tasks.push_back({name, [this, name, at] {
                       SceneResult& result = results_.scenes[at];
                       loaded_.reset();
                       OrReason(result.not_available, [&] { Load(name, result); });
                     }});
    for (const char* contact : kContacts) {
      for (const char* friction : kFrictions) {
        tasks.push_back({fmt::format("{}, {} contact, friction {}", name, contact, friction),
                         [this, at, contact, friction] {
                           if (loaded_) MeasureModel(results_.scenes[at], contact, friction);
                         }});
      }
    }
  }

  void Load(const std::string& name, SceneResult& result) {
    auto loaded = std::make_unique<Loaded>();
    loaded->scene = LoadForBench(name, options_.models);
    loaded->poses = PathOf(name);
    loaded->judge = std::make_unique<PathJudge>(loaded->scene, loaded->poses, checks(), stop_);
    const Body& tool = loaded->scene.tools.front();
    loaded->oracle = std::make_unique<OverlapOracle>(tool.tree, loaded->scene.objects);
    result.tool_spheres = tool.tree.leaves();
    result.triangles = tool.mesh.triangles.size();
    for (Body& object : loaded->scene.objects) {
      result.object_spheres += object.tree.leaves();
      result.triangles += object.mesh.triangles.size();
      GiveFriction(object);
    }
    result.steps = loaded->poses.size();
    loaded_ = std::move(loaded);
  }

  static void GiveFriction(Body& object) {
    for (Material& material : object.materials) {
      if (material.static_friction > 0.0) continue;
      material.static_friction = kStaticFriction;
      material.dynamic_friction = kDynamicFriction;
    }
  }

  void MeasureModel(SceneResult& result, const std::string& contact, const std::string& friction) {
    ModelRun model;
    model.contact = contact;
    model.friction = friction;
    OrReason(model.not_available, [&] {
      Features features = loaded_->scene.features;
      const Features models = FeatureOptions{contact, friction}.features();
      features.contact = models.contact;
      features.friction = models.friction;
      SceneRun run(loaded_->scene, loaded_->poses, features);
      const TimedRun timed = TimeRun(run, repeats(), stop_);
      model.speed = timed.speed;
      Judge(timed.reports, *loaded_->judge, model);
      if (contact == "spheres") {
        double deepest = 0.0;
        for (std::size_t i = 0; i < timed.reports.size(); i += loaded_->judge->every()) {
          deepest = std::max(deepest, loaded_->oracle->At(timed.reports[i].X_WG).depth);
        }
        model.sphere_overlap_um = 1e6 * deepest;
      }
    });
    result.runs.push_back(model);
  }

  static void Judge(const std::vector<StepReport>& reports, const PathJudge& judge,
                    Measured& measured) {
    std::vector<Pose> poses;
    std::vector<Vec3> forces;
    for (const StepReport& report : reports) {
      poses.push_back(report.X_WG);
      forces.push_back(report.wrench.force);
    }
    measured.path = judge.Judge(poses, forces);
  }

  // ---- what features cost

  void MeasureFeatures() {
    struct Variant {
      const char* name;
      Features features;
      bool materials = true;
    };
    const auto spheres = ContactModel::kSpheres;
    const std::vector<Variant> variants = {
        {"bare: sphere contact", {spheres}, false},
        {"all of the below undeclared", {spheres}},
        {"surface contact", {ContactModel::kSurface}},
        {"friction, chapter", {spheres, FrictionModel::kChapter}},
        {"friction, Coulomb", {spheres, FrictionModel::kCoulomb}},
        {"compliance, 20 kN/m", {spheres, FrictionModel::kOff, true}},
        {"removal, nothing vanishing", {spheres, FrictionModel::kOff, false, true}},
        {"surface contact and friction, Coulomb",
         {ContactModel::kSurface, FrictionModel::kCoulomb}},
        {"all", {ContactModel::kSurface, FrictionModel::kCoulomb, true, true}}};
    const std::string name = std::find(scenes_.begin(), scenes_.end(), kPeerScene) != scenes_.end()
                                 ? kPeerScene
                                 : scenes_.front();
    results_.feature_scene = name;
    std::vector<FeatureCost> costs(variants.size());
    std::vector<std::unique_ptr<SceneRun>> runs(variants.size());
    std::vector<BestOf> best(variants.size());
    for (std::size_t v = 0; v < variants.size(); ++v) {
      costs[v].feature = variants[v].name;
      OrReason(costs[v].not_available, [&] {
        Scene scene = LoadForBench(name, options_.models);
        for (Body& object : scene.objects) {
          for (Material& material : object.materials) {
            material = {};
            if (variants[v].materials) material = {2e4, kStaticFriction, kDynamicFriction, 1e9};
          }
        }
        runs[v] = std::make_unique<SceneRun>(std::move(scene), PathOf(name), variants[v].features);
      });
    }
    for (int r = 0; r < repeats(); ++r) {
      for (std::size_t v = 0; v < variants.size(); ++v) {
        if (stop_.stopped()) throw Stopped{};
        if (runs[v]) best[v].Add(runs[v]->Time());
      }
    }
    for (std::size_t v = 0; v < variants.size(); ++v) {
      costs[v].speed = {PercentilesOf(best[v].best()), PercentilesOf(best[v].all())};
      const Percentiles &with = costs[v].speed.best, &bare = costs.front().speed.best;
      if (!runs[v] || !runs.front()) continue;
      costs[v].ratio_p50 = with.p50 / bare.p50;
      costs[v].ratio_p999 = with.p999 / bare.p999;
    }
    results_.features = std::move(costs);
  }

  void PlanSlides(std::vector<Task>&) {}
  void PlanPeers(std::vector<Task>& tasks) {
    if (results_.peers_asked.empty()) return;
    results_.peer_scene = kPeerScene;
    tasks.push_back({"peers' scene", [this] {
                       if (loaded_ && loaded_->scene.name == kPeerScene) return;
                       SceneResult ignored;
                       Load(kPeerScene, ignored);
                     }});
    for (const char* contact : kContacts) {
      tasks.push_back(
          {fmt::format("peers' path: Palpate, {} contact", contact), [this, contact] {
             PeerRun one;
             one.name = fmt::format("Palpate, {} contact",
                                    std::string(contact) == "spheres" ? "sphere" : contact);
             OrReason(one.not_available, [&] {
               SceneRun run(loaded_->scene, loaded_->poses, FeatureOptions{contact}.features());
               const TimedRun timed = TimeRun(run, repeats(), stop_);
               one.speed = timed.speed;
               Judge(timed.reports, *loaded_->judge, one);
               free_poses_.clear();
               for (const StepReport& report : timed.reports) {
                 free_poses_.push_back(report.X_WG);
               }
             });
             results_.peer_path.push_back(one);
           }});
    }
    for (const PeerKind& kind : PeerKinds()) {
      if (!kind.installed() || !Asked(kind.id)) continue;
      tasks.push_back({fmt::format("peers' path: {}", kind.name), [this, &kind] {
                         results_.peer_steps = loaded_->poses.size();
                         results_.peer_path.push_back(MeasurePeer(kind, {}, loaded_->poses.size()));
                       }});
    }
    if (options_.quick) return;
    for (const PeerKind& kind : PeerKinds()) {
      if (!kind.installed() || !Asked(kind.id) || !kind.responds) continue;
      for (const PeerSettings& settings : {PeerSettings{0.1, 1}, PeerSettings{0.1, 4},
                                           PeerSettings{0.02, 1}, PeerSettings{1.0, 1}}) {
        tasks.push_back({fmt::format("{} set otherwise", kind.name), [this, &kind, settings] {
                           PeerRun run = MeasurePeer(kind, settings, 4000);
                           run.name =
                               fmt::format("{}, {} kg, {} sub-step{}", kind.name, settings.mass,
                                           settings.substeps, settings.substeps > 1 ? "s" : "");
                           results_.peer_variants.push_back(run);
                         }});
      }
    }
  }

  PeerRun MeasurePeer(const PeerKind& kind, const PeerSettings& settings, std::size_t steps) const {
    PeerRun run;
    run.id = kind.id;
    run.name = kind.name;
    OrReason(run.not_available, [&] {
      const std::span<const Pose> hand(loaded_->poses.data(),
                                       std::min(steps, loaded_->poses.size()));
      // One that only measures is asked where Palpate's tool is.
      const std::span<const Pose> X = kind.responds ? hand : std::span<const Pose>(free_poses_);
      const TimedPeer timed =
          TimePeer(kind, ForPeers(loaded_->scene), X, settings, std::min(repeats(), 3), stop_);
      run.speed = timed.speed;
      if (!kind.responds) {
        run.distance_min_um = INFINITY;
        for (const PeerStep& step : timed.steps) {
          run.distance_min_um = std::min(*run.distance_min_um, 1e6 * step.distance.value());
        }
        return;
      }
      std::vector<Pose> poses;
      std::vector<Vec3> forces;
      for (const PeerStep& step : timed.steps) {
        poses.push_back(step.X_WG);
        forces.push_back(step.wrench.force);
      }
      run.path = loaded_->judge->Judge(poses, forces);
    });
    return run;
  }

  const Options& options_;
  StopSignal stop_;
  std::vector<std::string> scenes_;
  ParetoResults results_;
  std::unique_ptr<Loaded> loaded_;
  std::vector<Pose> free_poses_;  ///< where Palpate's tool went on the peers' path
};

}  // namespace

void AddPareto(CLI::App& app) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "pareto",
      "Speed against error of every scene, contact and friction model, and of the peers that are\n"
      "installed: report.md, pareto.svg and pareto.json.  Written anew after each measurement, so\n"
      "that Ctrl-C keeps what there is.\n"
      "Example: palpate-bench pareto --out build/pareto");
  command->add_option("--out", options->out, "Folder to write to; made where it is missing")
      ->required();
  command->add_flag("--quick", options->quick, "Few scenes, short paths, few repeats");
  command
      ->add_option("--peers", options->peers,
                   "all, none, or some of bullet,ode,fcl,mujoco with commas")
      ->capture_default_str();
  command
      ->add_option("--scenes", options->scenes,
                   "Catalogue names or scene files (default: the whole catalogue)")
      ->delimiter(',');
  command->add_option("--repeats", options->repeats, "Identical runs (default: 5; quick: 2)")
      ->check(CLI::PositiveNumber);
  command->add_option("--models", options->models, "Folder of models that are not packaged");
  command->callback([options] { Pareto(*options).Run(); });
}

}  // namespace palpate::bench
