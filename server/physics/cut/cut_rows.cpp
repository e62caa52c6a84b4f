#include "server/physics/cut/cut_rows.h"

#include <algorithm>

#include "server/physics/limits.h"

namespace palpate {
namespace {

/// Returns how far ahead along n the material begins; a value beyond the band if there is none.
/// A point that seems free is evaluated from a point ahead (drawing: README.md).
double GapAhead(const CutField& cut, const Vec3& p, const Vec3& n) {
  const double here = cut.Distance(p);
  if (here <= 0.0) return 0.0;
  if (here >= cut.field().band()) return here;
  const double s = limits::cutting::kAhead * cut.field().lattice().spacing;
  const FieldSample ahead = cut.Sample(p + s * n);
  const double nears = -ahead.gradient.dot(n), gap = ahead.distance + s * nears;
  if (gap <= 0.0) return 0.0;
  return nears > 0.0 ? gap / nears : 1e300;
}

}  // namespace

CutRows::CutRows(int samples)
    : capacity_(samples),
      columns_(kColumns, static_cast<std::size_t>(samples)),
      slides_(static_cast<std::size_t>(samples)) {
  for (std::size_t c = 0; c < 6; ++c) yielding.rows.a[c] = columns_[c];
  yielding.rows.b = columns_[kB];
  yielding.weight = columns_[kViscous];
  yielding.threshold = columns_[kThreshold];
  yielding.push = columns_[kPush];
}

void CutRows::Set(std::size_t row, const std::array<double, 6>& a, double b, double threshold,
                  double viscous, double area) noexcept {
  for (std::size_t c = 0; c < 6; ++c) columns_[c][row] = a[c];
  columns_[kB][row] = b;
  columns_[kThreshold][row] = threshold;
  columns_[kViscous][row] = viscous;
  columns_[kArea][row] = area;
}

void CutRows::Add(const std::array<double, 6>& a, double b, double threshold, double viscous,
                  double area) noexcept {
  int& count = yielding.rows.count;
  if (count == capacity_) return;
  slides_[static_cast<std::size_t>(count)].friction = 0.0;
  Set(static_cast<std::size_t>(count++), a, b, threshold, viscous, area);
  // As in QpRows.
  for (auto i = static_cast<std::size_t>(count); i % 16 != 0; ++i)
    Set(i, {}, -1e300, 0.0, 0.0, 0.0);
}

void CutRows::AddSolid(const CutTool& tool, const CutField& cut, const Pose& X_WB,
                       std::span<const Material> materials, double reach) noexcept {
  const Mat3 R_WT = tool.X_WT.q.toRotationMatrix();
  const Pose X_BW = X_WB.Inverse();
  const Mat3 R_BW = X_BW.q.toRotationMatrix();
  const double band = cut.field().band();
  for (const BurSample& sample : tool.samples) {
    if (count() == capacity_) return;
    const Vec3 p_W = R_WT * sample.point + tool.X_WT.p, n_W = R_WT * sample.normal;
    const Vec3 p_B = R_BW * p_W + X_BW.p, n_B = R_BW * n_W;
    const double gap = GapAhead(cut, p_B, n_B);
    if (gap >= band || gap > reach) continue;
    // The material whose volume will be removed, by the same point of the lattice.
    const Material& material = materials[cut.solid().Material(p_B)];
    const Vec3 turn = (p_W - tool.reference).cross(n_W) / tool.rotation_length;
    const double share = sample.area / tool.stiffness;
    Add({-n_W.x(), -n_W.y(), -n_W.z(), -turn.x(), -turn.y(), -turn.z()}, -gap,
        share * (sample.cuts ? material.cutting_pressure : limits::cutting::kUncut),
        sample.cuts ? share * material.cutting_viscosity / tool.dt : 0.0, sample.area);
    if (material.cutting_friction == 0.0 || sample.slide.isZero(0.0)) continue;
    const Vec3 along = R_WT * sample.slide;
    slides_[static_cast<std::size_t>(count() - 1)] = {
        material.cutting_friction, along,
        (p_W - tool.reference).cross(along) / tool.rotation_length};
  }
}

Vec6 CutRows::Drag() const noexcept {
  Vec6 drag = Vec6::Zero();
  for (int i = 0; i < count(); ++i) {
    const Slide& slide = slides_[static_cast<std::size_t>(i)];
    if (slide.friction == 0.0) continue;
    drag.head<3>() -= slide.friction * yielding.push[i] * slide.along;
    drag.tail<3>() -= slide.friction * yielding.push[i] * slide.turn;
  }
  return drag;
}

}  // namespace palpate
