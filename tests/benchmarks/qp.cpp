// palpate-bench qp: the solver alone, on the problems of a scene's path or of a file.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <fstream>
#include <optional>

#include <spdlog/fmt/fmt.h>

#include "common/error.h"
#include "server/physics/rows/contact_prediction.h"
#include "server/physics/rows/contact_rows.h"
#include "server/physics/simd/kernels.h"
#include "server/physics/solve/response.h"
#include "tests/benchmarks/commands.h"
#include "tests/benchmarks/figures.h"
#include "tests/benchmarks/machine.h"
#include "tests/benchmarks/pose_source.h"
#include "tests/benchmarks/scene_run.h"

namespace palpate::bench {
namespace {

struct QpOptions {
  std::string dump, load, scene, models, json;
  std::optional<int> steps;
  int repeats = 20;
  int min_rows = 0, max_rows = 1 << 20;
};

/// min 1/2 |x - target|^2 subject to A x >= b; A row by row, as in the file.
struct Problem {
  double target[6];
  std::vector<double> A, b;
  std::vector<int> guess;  ///< rows that were active one step earlier
  int rows() const { return static_cast<int>(b.size()); }
};

// Little-endian: "PQP1", uint32 count; per problem uint32 m, double target[6], A[m][6], b[m].
constexpr char kMagic[4] = {'P', 'Q', 'P', '1'};
constexpr std::uint32_t kMaxRows = 1u << 24;

void WriteProblems(const std::string& file, const std::vector<Problem>& problems) {
  std::ofstream out(file, std::ios::binary);
  const auto put = [&](const void* data, std::size_t n) {
    out.write(static_cast<const char*>(data), static_cast<std::streamsize>(n));
  };
  const auto count = static_cast<std::uint32_t>(problems.size());
  put(kMagic, 4);
  put(&count, 4);
  for (const Problem& problem : problems) {
    const auto m = static_cast<std::uint32_t>(problem.rows());
    put(&m, 4);
    put(problem.target, sizeof(problem.target));
    put(problem.A.data(), problem.A.size() * sizeof(double));
    put(problem.b.data(), problem.b.size() * sizeof(double));
  }
  out.close();
  if (!out) throw Error(file + ": cannot be written; give --dump a file in a folder you may write");
}

std::vector<Problem> ReadProblems(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw Error(file + ": cannot be opened; make one with qp --dump");
  const auto get = [&](void* data, std::size_t n, const std::string& what) {
    if (!in.read(static_cast<char*>(data), static_cast<std::streamsize>(n))) {
      throw Error(file + ": ends within " + what + "; dump it again");
    }
  };
  char magic[4];
  std::uint32_t count = 0;
  get(magic, 4, "the magic number");
  if (std::memcmp(magic, kMagic, 4) != 0) {
    throw Error(file + ": is no file of QPs (it does not begin with PQP1)");
  }
  get(&count, 4, "the count");
  std::vector<Problem> problems;
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::string where = "problem " + std::to_string(i);
    Problem problem;
    std::uint32_t m = 0;
    get(&m, 4, where);
    if (m > kMaxRows) throw Error(file + ": " + where + ": " + std::to_string(m) + " rows");
    get(problem.target, sizeof(problem.target), where);
    problem.A.resize(6 * static_cast<std::size_t>(m));
    problem.b.resize(m);
    get(problem.A.data(), problem.A.size() * sizeof(double), where);
    get(problem.b.data(), problem.b.size() * sizeof(double), where);
    double sum = 0.0;
    for (const double v : problem.A) sum += v;
    for (const double v : problem.b) sum += v;
    for (const double v : problem.target) sum += v;
    if (!std::isfinite(sum)) throw Error(file + ": " + where + ": has values that are not finite");
    problems.push_back(std::move(problem));
  }
  return problems;
}

/// The problem of each step of a scene's path, with the rows of the widest bounds, and the rows
/// that were active in the previous step.
std::vector<Problem> ProblemsOf(const QpOptions& options) {
  Scene scene = LoadForBench(options.scene, options.models, ContactModel::kSpheres);
  scene.features = {.contact = ContactModel::kSpheres};
  SceneRun run(std::move(scene), ScriptPoses(options.scene, options.steps));
  const HapticModel& model = run.model();
  if (model.is_ball()) {
    throw Error("qp: the tool of scene '" + options.scene +
                "' is a single sphere with 3 degrees of freedom; choose a scene with 6");
  }
  ContactPrediction prediction(model);
  ContactRows rows(model.parameters().max_rows, model.rotation_length());
  const StepBounds widest{model.parameters().widest_step, model.parameters().max_rotation};
  StepState state = run.Start();
  std::vector<Problem> problems;
  for (const Pose& X_WH : run.poses()) {
    const Vec3& c = model.tool().reference;
    const Vec3 p_G = state.X_WG * c;
    prediction.Predict(model, ActiveKernels(), state.X_WG.q.toRotationMatrix(), p_G, {widest}, rows,
                       nullptr);
    const Target target = TargetOf(p_G, state.X_WG.q, X_WH * c, X_WH.q);
    const QpRows view = rows.view();
    if (view.count >= std::max(1, options.min_rows) && view.count <= options.max_rows) {
      Problem problem;
      const Vec3 turn = model.rotation_length() * target.phi;
      for (int i = 0; i < 3; ++i) {
        problem.target[i] = target.v[i];
        problem.target[3 + i] = turn[i];
      }
      for (int r = 0; r < view.count; ++r) {
        for (int i = 0; i < 6; ++i) problem.A.push_back(view.a[i][r]);
        problem.b.push_back(view.b[r]);
      }
      int guess[kMaxActiveRows];
      const int guesses = rows.Find(state.active, guess);
      problem.guess.assign(guess, guess + guesses);
      problems.push_back(std::move(problem));
    }
    HapticStep(model, X_WH, state, run.workspace());
  }
  return problems;
}

/// A problem stored by columns.  All problems use the same storage, so that rows have just been
/// written when the solver begins, as in a step.
class RowColumns {
 public:
  explicit RowColumns(int max_rows)
      : stride_(static_cast<std::size_t>((max_rows + 15) & ~15) + 8),  // as ContactRows
        storage_(7 * stride_ + 8) {
    const auto address = reinterpret_cast<std::uintptr_t>(storage_.data());
    base_ = storage_.data() + (64 - address % 64) % 64 / sizeof(double);
    for (std::size_t c = 0; c < 6; ++c) rows_.a[c] = base_ + c * stride_;
    rows_.b = base_ + 6 * stride_;
  }

  const QpRows& Write(const Problem& problem) {
    const int m = problem.rows();
    for (int r = 0; r < m; ++r) {
      for (int c = 0; c < 6; ++c) At(c)[r] = problem.A[static_cast<std::size_t>(6 * r + c)];
      At(6)[r] = problem.b[static_cast<std::size_t>(r)];
    }
    for (int r = m; r % 16 != 0; ++r) {
      for (int c = 0; c < 6; ++c) At(c)[r] = 0.0;
      At(6)[r] = -1e300;
    }
    rows_.count = m;
    return rows_;
  }

 private:
  double* At(int column) { return base_ + static_cast<std::size_t>(column) * stride_; }

  std::size_t stride_;
  std::vector<double> storage_;
  double* base_;
  QpRows rows_{};
};

/// Largest violation of the optimality conditions, from the file's numbers and in their units.
double KktResidual(const Problem& problem, const QpResult& result) {
  double worst = 0.0, sum = 0.0;
  double gradient[6];
  for (int i = 0; i < 6; ++i) gradient[i] = result.x[i] - problem.target[i];
  const auto value = [&](int r) {
    double v = result.slack - problem.b[static_cast<std::size_t>(r)];
    for (int i = 0; i < 6; ++i) v += problem.A[static_cast<std::size_t>(6 * r + i)] * result.x[i];
    return v;
  };
  for (int j = 0; j < result.active; ++j) {
    const double u = result.multiplier[j];
    worst = std::max({worst, -u, std::abs(u * value(result.row[j]))});
    sum += u;
    for (int i = 0; i < 6; ++i) {
      gradient[i] -= u * problem.A[static_cast<std::size_t>(6 * result.row[j] + i)];
    }
  }
  for (const double g : gradient) worst = std::max(worst, std::abs(g));
  for (int r = 0; r < problem.rows(); ++r) worst = std::max(worst, -value(r));
  if (result.status == QpStatus::kRelaxed) {
    worst = std::max(worst, std::abs(result.slack - kJamCompliance * sum));
  }
  return worst;
}

void Measure(const QpOptions& options, std::vector<Problem>& problems, bool warm_from_step) {
  std::erase_if(problems, [&](const Problem& problem) {
    return problem.rows() < options.min_rows || problem.rows() > options.max_rows;
  });
  if (problems.empty()) {
    throw Error("qp: no problem has between " + std::to_string(options.min_rows) + " and " +
                std::to_string(options.max_rows) + " rows; widen --min-rows and --max-rows");
  }
  int most_rows = 0;
  for (const Problem& problem : problems) most_rows = std::max(most_rows, problem.rows());
  RowColumns columns(most_rows);
  std::vector<double> row_counts, iterations;
  double residual = 0.0;
  int unsolved = 0, relaxed = 0;
  for (Problem& problem : problems) {
    const QpRows& rows = columns.Write(problem);
    const QpResult result = ActiveKernels().solve(problem.target, rows, nullptr, 0);
    residual = std::max(residual, KktResidual(problem, result));
    unsolved += result.status == QpStatus::kIterationLimit;
    relaxed += result.status == QpStatus::kRelaxed;
    row_counts.push_back(problem.rows());
    iterations.push_back(result.iterations);
    if (!warm_from_step) problem.guess.assign(result.row, result.row + result.active);
    const QpResult warm = ActiveKernels().solve(problem.target, rows, problem.guess.data(),
                                                static_cast<int>(problem.guess.size()));
    residual = std::max(residual, KktResidual(problem, warm));
  }
  BestOf cold_us, warm_us;
  double sink = 0.0;
  for (int r = 0; r < options.repeats; ++r) {
    for (const bool warm : {false, true}) {
      std::vector<double> us;
      for (std::size_t i = 0; i < problems.size(); ++i) {
        const Problem& problem = problems[i];
        const QpRows& rows = columns.Write(problem);
        const auto begin = std::chrono::steady_clock::now();
        const QpResult result =
            ActiveKernels().solve(problem.target, rows, problem.guess.data(),
                                  warm ? static_cast<int>(problem.guess.size()) : 0);
        const auto end = std::chrono::steady_clock::now();
        sink += result.x[0];
        us.push_back(std::chrono::duration<double, std::micro>(end - begin).count());
      }
      (warm ? warm_us : cold_us).Add(us);
    }
  }
  if (!std::isfinite(sink)) throw Error("qp: a solution is not finite");

  const Percentiles cold = PercentilesOf(cold_us.best()), warm = PercentilesOf(warm_us.best());
  const Percentiles rows = PercentilesOf(row_counts);
  Table table(fmt::format("{} QPs, best of {} ({})", problems.size(), options.repeats,
                          ActiveKernels().name));
  table.Row("cold", "us", cold);
  table.Row(warm_from_step ? "warm, last step's rows" : "warm, own rows", "us", warm);
  table.Row("rows", "", rows);
  table.Row("iterations, cold", "", PercentilesOf(iterations));
  table.Line("KKT residual, max", fmt::format("{:.3g}", residual));
  table.Line("unsolved", fmt::format("{} ({} contradictory, relaxed)", unsolved, relaxed));
  table.Print();
  if (!options.json.empty()) {
    WriteJson(options.json, {{"source", warm_from_step ? options.scene : options.load},
                             {"repeats", options.repeats},
                             {"machine", ToJson(ThisMachine())},
                             {"problems", problems.size()},
                             {"best_us", ToJson(cold)},
                             {"best_warm_us", ToJson(warm)},
                             {"raw_us", ToJson(PercentilesOf(cold_us.all()))},
                             {"rows", ToJson(rows)},
                             {"kkt_residual_max", residual},
                             {"unsolved", unsolved},
                             {"relaxed", relaxed}});
  }
}

void Run(const QpOptions& options) {
  if (!options.load.empty()) {
    if (!options.dump.empty() || !options.scene.empty()) {
      throw UsageError("qp: --load excludes --scene and --dump; use --dump with --scene");
    }
    std::vector<Problem> problems = ReadProblems(options.load);
    Measure(options, problems, false);
    return;
  }
  if (options.scene.empty()) throw UsageError("qp: give --scene NAME or --load FILE");
  std::vector<Problem> problems = ProblemsOf(options);
  if (!options.dump.empty()) {
    WriteProblems(options.dump, problems);
    fmt::print(stderr, "{}: {} problems\n", options.dump, problems.size());
    return;
  }
  Measure(options, problems, true);
}

}  // namespace

void AddQp(const CommandLine& app) {
  auto options = std::make_shared<QpOptions>();
  const CommandLine command =
      app.AddCommand("qp",
                     "time and optimality of the QP solver alone\n"
                     "The problems are those of a scene's path, or of a file.");
  command.Footer("Example: palpate-bench qp --scene bunny-bunny --min-rows 200 --max-rows 500");
  Add(command, "--scene", options->scene, "use the problems of this scene's path");
  Add(command, "--dump", options->dump, "write the problems to this file instead of solving them");
  Add(command, "--load", options->load, "use the problems of this file (format: PQP1)");
  AddPathSteps(command, options->steps);
  Add(command, "--min-rows", options->min_rows, "skip problems with fewer rows");
  Add(command, "--max-rows", options->max_rows, "skip problems with more rows");
  AddRepeats(command, options->repeats);
  AddModels(command, options->models);
  AddJson(command, options->json);
  command.Run([options] { Run(*options); });
}

}  // namespace palpate::bench
