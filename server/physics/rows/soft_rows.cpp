#include "server/physics/rows/soft_rows.h"

#include <algorithm>
#include <new>

namespace palpate {
namespace {
constexpr std::align_val_t kCacheLine{64};
}

void SoftRows::AlignedDelete::operator()(double* p) const {
  ::operator delete[](p, kCacheLine);
}

SoftRows::SoftRows(int rows, double rho) : rho_(rho) {
  // Whole batches of 16, and columns a cache line apart from a power of two (ContactRows).
  const std::size_t stride = ((static_cast<std::size_t>(rows) + 31) & ~15ul) + 8;
  storage_.reset(new (kCacheLine) double[9 * stride]());
  weight_ = storage_.get();
  rigid_b_ = weight_ + stride;
  for (std::size_t c = 0; c < 6; ++c) transformed_[c] = weight_ + (2 + c) * stride;
  push_ = weight_ + 8 * stride;
}

void SoftRows::Set(const SoftLeaves& leaves, const ContactRows& rows) noexcept {
  any_ = false;
  const int count = rows.count();
  for (int i = 0; i < count; ++i) {
    const SoftLeaves::Leaf& leaf = leaves.of(rows.pair(i));
    weight_[i] = leaf.weight;
    rigid_b_[i] = -rows.gap(i) - leaf.depth;
    any_ |= leaf.weight > 0.0;
  }
  for (int i = count; i % 16 != 0; ++i) {
    weight_[i] = 0.0;
    rigid_b_[i] = -1e300;
  }
}

QpRows SoftRows::rigid(const ContactRows& rows) const {
  QpRows rigid = rows.view();
  rigid.b = rigid_b_;
  return rigid;
}

CompliantRows SoftRows::view(const ContactRows& rows) {
  CompliantRows view{};
  view.rigid = rigid(rows);
  view.soft_b = rows.view().b;
  view.weight = weight_;
  std::copy(transformed_, transformed_ + 6, view.transformed);
  view.push = push_;
  view.pull = pull_;
  view.pushing = &pushing_;
  return view;
}

SoftContacts SoftRows::Contacts(const ContactRows& rows) const noexcept {
  SoftContacts contacts;
  contacts.count = pushing_;
  contacts.force = Vec3(pull_[0], pull_[1], pull_[2]);
  contacts.torque = rho_ * Vec3(pull_[3], pull_[4], pull_[5]);
  const int count = pushing_ == 0 ? 0 : rows.count();
  double least = 0.0;  // what a row must exceed to be listed
  for (int i = 0; i < count; ++i) {
    const double push = push_[i];
    if (!(push > least)) continue;
    int at = contacts.listed < kMaxActiveRows ? contacts.listed++ : kMaxActiveRows - 1;
    for (; at > 0 && push > contacts.push[at - 1]; --at) {
      contacts.push[at] = contacts.push[at - 1];
      contacts.row[at] = contacts.row[at - 1];
    }
    contacts.push[at] = push;
    contacts.row[at] = i;
    if (contacts.listed == kMaxActiveRows) least = contacts.push[kMaxActiveRows - 1];
  }
  return contacts;
}

}  // namespace palpate
