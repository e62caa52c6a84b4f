#include "server/physics/rows/contact_rows.h"

#include <algorithm>
#include <cmath>

#include "common/math/elementary.h"

namespace palpate {

ContactRows::ContactRows(int max_rows, double rho, bool turns, bool with_others)
    : max_rows_(max_rows),
      turns_(turns),
      rho_(rho),
      storage_(10, static_cast<std::size_t>(max_rows + 16)),
      ids_(static_cast<std::size_t>(max_rows + 16)),
      others_(with_others ? static_cast<std::size_t>(max_rows) : 0) {
  for (std::size_t c = 0; c < 6; ++c) columns_.a[c] = storage_[c];
  columns_.b = storage_[6];
  for (std::size_t c = 0; c < 3; ++c) columns_.lever[c] = storage_[7 + c];
  columns_.id = ids_.data();
}

bool ContactRows::Add(const Kernels& kernels, const LeafSphere* tool, const LeafSphere* object,
                      const Mat3& R_WG, const Vec3& p_W, const NodePair* pairs,
                      int count) noexcept {
  if (count_ + count > max_rows_) return false;
  const Mat3 R = R_WG.transpose();  // Eigen's columns are the kernel's rows
  kernels.build_rows(tool, object, R.data(), p_W.data(), 1.0 / rho_, pairs, count, count_,
                     columns_);
  count_ += count;
  return true;
}

void ContactRows::AddRow(const Vec3& normal, const Vec3& lever, double gap,
                         const ContactId& id) noexcept {
  SetRow(count_, normal, lever, lever.cross(normal), gap);
  columns_.id[count_] = id;
  ++count_;
}

void ContactRows::SetRow(int row, const Vec3& normal, const Vec3& lever, const Vec3& by_rotation,
                         double gap) noexcept {
  const Vec3 turned = turns_ ? Vec3(by_rotation / rho_) : Vec3::Zero();
  for (int c = 0; c < 3; ++c) {
    columns_.a[c][row] = normal[c];
    columns_.a[3 + c][row] = turned[c];
    columns_.lever[c][row] = lever[c];
  }
  columns_.b[row] = -gap;
}

void ContactRows::Finish() noexcept {
  for (int i = count_; i % 16 != 0; ++i) {
    for (double* column : columns_.a) column[i] = 0.0;
    columns_.b[i] = kLoose;
  }
}

Vec3 ContactRows::LeverOf(int row, std::span<const LeafSphere> tool, const Mat3& R_WG) const {
  if (!id(row).IsOfLeaves()) return lever(row);
  const LeafSphere& leaf = tool[static_cast<std::size_t>(id(row).a)];
  return R_WG * Vec3(leaf.x, leaf.y, leaf.z) - leaf.radius * normal(row);
}

QpRows ContactRows::view() const {
  QpRows rows{};
  std::copy(columns_.a, columns_.a + 6, rows.a);
  rows.b = columns_.b;
  rows.count = count_;
  return rows;
}

Vec3 ContactRows::lever_cross_normal(int row) const {
  return rho_ * Vec3(columns_.a[3][row], columns_.a[4][row], columns_.a[5][row]);
}

double ContactRows::AngleTo(int row, const Vec3& n, const Vec3& by_rotation) const {
  return Length((n - normal(row)).norm(), (by_rotation - lever_cross_normal(row)).norm() / rho_);
}

double ContactRows::AngleTo(int row, const Other& to) const {
  return Length((to.v - other(row).v).norm(), (to.phi - other(row).phi).norm() / rho_);
}

int ContactRows::Find(std::span<const ContactId> ids, int* row) const noexcept {
  int found = 0;
  const std::span<const ContactId> mine(columns_.id, static_cast<std::size_t>(count_));
  for (const ContactId& id : ids) {
    // Between leaves the body is always the same.
    const auto at = std::ranges::find_if(mine, [&](const ContactId& other) {
      return other.a == id.a && other == id && !IsLoose(static_cast<int>(&other - columns_.id));
    });
    if (at != mine.end()) row[found++] = static_cast<int>(at - mine.begin());
  }
  return found;
}

}  // namespace palpate
