#include "server/physics/rows/contact_rows.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace palpate {

ContactRows::ContactRows(int max_rows, int max_batch, int degrees_of_freedom, double rho)
    : max_rows_(max_rows),
      room_(max_rows / 2),
      rho_(rho),
      storage_(10, static_cast<std::size_t>(max_rows + room_ + max_batch + 16)),
      ids_(static_cast<std::size_t>(max_rows + room_ + max_batch + 31)),
      gaps_(ids_.size()) {
  columns_.unknowns = degrees_of_freedom;
  for (std::size_t c = 0; c < 6; ++c) columns_.a[c] = storage_[c];
  columns_.b = storage_[6];
  for (std::size_t c = 0; c < 3; ++c) columns_.lever[c] = storage_[7 + c];
  columns_.id = ids_.data();
}

void ContactRows::Add(const Kernels& kernels, const LeafSphere* tool, const LeafSphere* object,
                      const Mat3& R_WG, const Vec3& p_W, const NodePair* pairs,
                      int count) noexcept {
  const Mat3 R = R_WG.transpose();  // Eigen's columns are the kernel's rows
  kernels.build_rows(tool, object, R.data(), p_W.data(), 1.0 / rho_, pairs, count, count_,
                     columns_);
  count_ += count;
  Limit(count);
}

void ContactRows::AddRow(const Vec3& normal, const Vec3& lever, double gap,
                         const ContactId& id) noexcept {
  SetRow(count_, normal, lever, lever.cross(normal), gap);
  columns_.id[count_] = id;
  ++count_;
  Limit(1);
}

void ContactRows::SetRow(int row, const Vec3& normal, const Vec3& lever, const Vec3& by_turning,
                         double gap) noexcept {
  const Vec3 turned = by_turning / rho_;
  for (int c = 0; c < 3; ++c) {
    columns_.a[c][row] = normal[c];
    if (columns_.unknowns == 6) columns_.a[3 + c][row] = turned[c];
    columns_.lever[c][row] = lever[c];
  }
  columns_.b[row] = -gap;
}

// Choosing the tightest rows after every batch would cost a sort of all rows each time, 100 ms if a
// peg's hole brings a million pairs within reach.  So rows first gather in some extra room.  Once
// max_rows are known, any row no tighter than the loosest of them is dropped at once.  A choice by
// (gap, order) does not depend on when it is made, so the rows are the same.
void ContactRows::Limit(int added) noexcept {
  if (overflowed_) DropLooser(count_ - added);
  if (count_ > max_rows_ + room_) KeepTightest();
}

void ContactRows::DropLooser(int from) noexcept {
  int kept = from;
  for (int i = from; i < count_; ++i) {
    if (columns_.b[i] > loosest_) Move(i, kept++);
  }
  count_ = kept;
}

void ContactRows::Move(int from, int to) noexcept {
  for (int c = 0; c < columns_.unknowns; ++c) columns_.a[c][to] = columns_.a[c][from];
  for (double* column : columns_.lever) column[to] = column[from];
  columns_.b[to] = columns_.b[from];
  columns_.id[to] = columns_.id[from];
}

// Keeps the tightest rows by (gap, order), in their order.  Only the gaps are partitioned, as
// plain numbers; one pass then keeps all rows tighter than the loosest that stays, and the first
// of those equal to it.
void ContactRows::KeepTightest() noexcept {
  overflowed_ = true;
  const double* b = columns_.b;
  std::copy(b, b + count_, gaps_.begin());
  const auto last = gaps_.begin() + max_rows_ - 1;
  std::nth_element(gaps_.begin(), last, gaps_.begin() + count_, std::greater<>());
  loosest_ = *last;
  auto equals = std::count(gaps_.begin(), last + 1, loosest_);
  int kept = 0;
  for (int i = 0; i < count_; ++i) {
    if (b[i] > loosest_ || (b[i] == loosest_ && equals-- > 0)) Move(i, kept++);
  }
  count_ = kept;
}

void ContactRows::Finish() noexcept {
  if (count_ > max_rows_) KeepTightest();
  for (int i = count_; i % 16 != 0; ++i) {
    for (int c = 0; c < columns_.unknowns; ++c) columns_.a[c][i] = 0.0;
    columns_.b[i] = -1e300;
  }
}

Vec3 ContactRows::LeverOf(int row, std::span<const LeafSphere> tool, const Mat3& R_WG) const {
  if (!id(row).IsOfLeaves()) return lever(row);
  const LeafSphere& leaf = tool[static_cast<std::size_t>(id(row).tool)];
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
  if (columns_.unknowns == 3) return Vec3::Zero();
  return rho_ * Vec3(columns_.a[3][row], columns_.a[4][row], columns_.a[5][row]);
}

double ContactRows::Turned(int row, const Vec3& n, const Vec3& by_turning) const {
  return std::hypot(
      (n - normal(row)).norm(),
      columns_.unknowns == 3 ? 0.0 : (by_turning - lever_cross_normal(row)).norm() / rho_);
}

int ContactRows::Find(std::span<const ContactId> ids, int* row) const noexcept {
  int found = 0;
  const std::span<const ContactId> mine(columns_.id, static_cast<std::size_t>(count_));
  for (const ContactId& id : ids) {
    const auto at = std::ranges::find(mine, id);
    if (at != mine.end()) row[found++] = static_cast<int>(at - mine.begin());
  }
  return found;
}

}  // namespace palpate
