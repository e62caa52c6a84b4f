#include "server/physics/solve/energies.h"

#include <algorithm>
#include <limits>

namespace palpate {
namespace {

std::size_t MostCutRows(const HapticModel& model) {
  return model.cuts() ? model.bur_samples().size() * model.solids().size() : 0;
}

/// The rows of a model's bur in its solids.
class BurInSolids final : public CutRows {
 public:
  explicit BurInSolids(const HapticModel& model)
      : CutRows(static_cast<int>(MostCutRows(model))), model_(model) {}

  void Begin(const EnergyStart& start) noexcept override {
    // No row turns a ball.
    const double rotation_length =
        model_.is_ball() ? std::numeric_limits<double>::infinity() : model_.rotation_length();
    const CutTool tool{model_.bur_samples(),          start.X_WT,      start.X_WT.p,
                       model_.parameters().stiffness, rotation_length, model_.cutting()->period};
    Clear();
    for (std::size_t i = 0; i < start.cuts.size(); ++i) {
      const CutSolid& solid = model_.solids()[i];
      AddSolid(tool, start.cuts[i], solid.X_WB, solid.materials, start.reach);
    }
  }

 private:
  const HapticModel& model_;
};

}  // namespace

Energies::Energies(const HapticModel& model)
    : model_(&model),
      solver_(static_cast<std::size_t>(model.parameters().max_rows) + 16, MostCutRows(model)) {
  if (model.yields()) all_.emplace_back(std::unique_ptr<Energy>(soft_ = new SoftRows(model)));
  if (model.cuts()) {
    all_.emplace_back(std::unique_ptr<Energy>(bur_ = new BurInSolids(model)));
    for (const CutSolid& solid : model.solids()) {
      bur_step_ = std::min(bur_step_, 0.5 * solid.grid->field().band());
    }
  }
  acting_.reserve(all_.size());
}

double Energies::FractionWithin(const Vec3& p_G, const Quat& q_WG, const Vec3& v,
                                const Vec3& phi) const noexcept {
  if (bur_ == nullptr) return 1.0;
  const Cutting& cutting = *model_->cutting();
  const double reach = cutting.bur.reach();
  // A hand that tilts a bur about its tip moves it little, however long the handle is.
  const Vec3 lever = q_WG * (cutting.X_TB.p - model_->reference());
  const double advance = (v + phi.cross(lever)).norm() + reach * phi.norm();
  if (advance <= bur_step_) return 1.0;
  for (const CutSolid& solid : model_->solids()) {
    const Lattice& lattice = solid.grid->field().lattice();
    const Vec3 bur = solid.X_WB.Inverse() * (p_G + lever);
    const Vec3 off = (lattice.origin - bur).cwiseMax(bur - lattice.End()).cwiseMax(0.0);
    if (off.norm() <= reach + advance) return bur_step_ / advance;
  }
  return 1.0;
}

void Energies::Begin(const EnergyStart& start) noexcept {
  for (const auto& energy : all_) energy->Begin(start);
}

void Energies::Collect(const ContactRows& rows, QpRows& rigid) noexcept {
  acting_.clear();
  for (const auto& energy : all_) {
    if (energy->Collect(rows, rigid)) acting_.push_back(energy.get());
  }
}

QpResult Energies::Solve(const Kernels& kernels, const double* t, const QpRows& rigid,
                         std::span<const int> guess) noexcept {
  // Starts from where the tool is: what overlaps there mostly still does after the step.
  constexpr double start[6] = {};
  return solver_.Solve(kernels, t, rigid, acting_, start, guess);
}

bool Energies::pushes() const noexcept {
  return std::ranges::any_of(acting_, [](const Energy* energy) { return energy->pushing > 0; });
}

Vec6 Energies::force() const noexcept {
  Vec6 sum = Vec6::Zero();
  for (const Energy* energy : acting_) sum += energy->force;
  return sum;
}

int Energies::Cut(const Vec3& p_G, const Quat& q_WG, const Vec3& v, const Vec3& phi,
                  std::span<CutField> cuts) noexcept {
  int queries = 0;
  if (bur_ == nullptr || bur_->count() == 0) return queries;
  const Cutting& cutting = *model_->cutting();
  const Vec3 lever = q_WG * (cutting.X_TB.p - model_->reference());
  const Pose X_WB{p_G + lever, q_WG * cutting.X_TB.q};
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    const Pose X_SW = model_->solids()[i].X_WB.Inverse();
    queries +=
        cuts[i].Remove(cutting.bur, X_SW * X_WB, X_SW.q * Vec3(v + phi.cross(lever))).queries;
  }
  return queries;
}

}  // namespace palpate
