#include "server/physics/solve/energies.h"

#include <algorithm>
#include <limits>

namespace palpate {
namespace {

std::size_t MostCutRows(const HapticModel& model) {
  return model.cuts() ? model.bur_samples().size() * model.solids().size() : 0;
}

}  // namespace

Energies::Energies(const HapticModel& model)
    : model_(&model),
      solver_(static_cast<std::size_t>(model.parameters().max_rows) + 16, MostCutRows(model)) {
  if (model.yields()) soft_.emplace(model.parameters().max_rows);
  if (model.cuts()) cut_.emplace(static_cast<int>(MostCutRows(model)));
}

StepBounds Energies::Narrow(StepBounds bounds, const Vec3& p_G, const Quat& q_WG) const noexcept {
  if (!cut_) return bounds;
  const double lever = model_->bur_lever();
  for (const CutSolid& solid : model_->solids()) {
    const Lattice& lattice = solid.grid->field().lattice();
    const Pose& X_TB = model_->cutting()->X_TB;
    const Vec3 bur = solid.X_WB.Inverse() * (p_G + q_WG * (X_TB.p - model_->reference()));
    const Vec3 off = (lattice.origin - bur).cwiseMax(bur - lattice.End()).cwiseMax(0.0);
    const double way = bounds.translation + bounds.rotation * lever;
    if (off.norm() > model_->cutting()->bur.reach() + way) continue;
    const double most = 0.5 * solid.grid->field().band();
    bounds = {std::min(bounds.translation, most), std::min(bounds.rotation, most / lever)};
  }
  return bounds;
}

void Energies::Begin(const Vec3& p_G, const Quat& q_WG, std::span<const CutField> cuts,
                     double reach) noexcept {
  if (!cut_) return;
  const StepParameters& spring = model_->parameters();
  // No row turns a ball.
  const double rotation_length =
      model_->is_ball() ? std::numeric_limits<double>::infinity() : model_->rotation_length();
  const CutTool tool{model_->bur_samples(), {p_G, q_WG},     p_G,
                     spring.stiffness,      rotation_length, model_->cutting()->period};
  cut_->Clear();
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    const CutSolid& solid = model_->solids()[i];
    cut_->AddSolid(tool, cuts[i], solid.X_WB, solid.materials, reach);
  }
}

void Energies::Collect(const ContactRows& rows, QpRows& rigid) noexcept {
  acting_ = 0;
  if (soft_) {
    soft_->Set(model_->objects(), model_->parameters().stiffness, rows);
    if (soft_->any()) {
      rigid = soft_->rigid();
      energies_[acting_++] = &*soft_;
    }
  }
  if (cut_ && cut_->count() > 0) energies_[acting_++] = &*cut_;
}

QpResult Energies::Solve(const Kernels& kernels, const double* t, const QpRows& rigid,
                         std::span<const int> guess) noexcept {
  // Starts from where the tool is: what overlaps there mostly still does after the step.
  constexpr double start[6] = {};
  return solver_.Solve(kernels, t, rigid, {energies_.data(), acting_}, start, guess);
}

bool Energies::pushes() const noexcept {
  return (soft() != nullptr && soft_->pushing > 0) || bur_pushes();
}

Vec6 Energies::force() const noexcept {
  Vec6 sum = Vec6::Zero();
  for (std::size_t i = 0; i < acting_; ++i) sum += energies_[i]->force;
  return sum;
}

int Energies::Cut(const Vec3& p_G, const Quat& q_WG, const Vec3& v, const Vec3& phi,
                  std::span<CutField> cuts) noexcept {
  int looks = 0;
  if (!cut_ || cut_->count() == 0) return looks;
  const Cutting& cutting = *model_->cutting();
  const Vec3 lever = q_WG * (cutting.X_TB.p - model_->reference());
  const Pose X_WB{p_G + lever, q_WG * cutting.X_TB.q};
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    const Pose X_SW = model_->solids()[i].X_WB.Inverse();
    looks += cuts[i].Remove(cutting.bur, X_SW * X_WB, X_SW.q * Vec3(v + phi.cross(lever))).looks;
  }
  return looks;
}

}  // namespace palpate
