#include "server/physics/soft_rows.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <string>

#include "common/error.h"
#include "server/physics/sphere_tree_query.h"

namespace palpate {
namespace {
constexpr std::align_val_t kCacheLine{64};
}

std::unique_ptr<const SoftLeaves> SoftLeaves::Make(const ObjectForest& objects,
                                                   double coupling_stiffness) {
  auto soft = std::make_unique<SoftLeaves>();
  bool any = false;
  soft->leaves_.resize(static_cast<std::size_t>(objects.leaf_count()));
  for (int i = 0; i < objects.leaf_count(); ++i) {
    const Material& material = objects.MaterialOf(i);
    const double stiffness = material.stiffness;
    if (!(stiffness > 0.0)) {
      throw Error("materials: stiffness " + std::to_string(stiffness) + " N/m of object " +
                  std::to_string(objects.ObjectOf(i)) +
                  "; give a positive number, or none for a rigid material");
    }
    if (std::isinf(stiffness)) continue;
    const auto leaf = static_cast<std::size_t>(i);
    soft->leaves_[leaf] = {stiffness / coupling_stiffness,
                           CoreDepth(material, objects.leaves()[leaf].radius)};
    any = true;
  }
  if (!any) return nullptr;
  return soft;
}

void SoftRows::AlignedDelete::operator()(double* p) const {
  ::operator delete[](p, kCacheLine);
}

SoftRows::SoftRows(int rows) {
  // Whole batches of 16, and columns a cache line apart from a power of two (ContactRows).
  const std::size_t stride = ((static_cast<std::size_t>(rows) + 31) & ~15ul) + 8;
  storage_.reset(new (kCacheLine) double[8 * stride]());
  weight_ = storage_.get();
  rigid_b_ = weight_ + stride;
  for (std::size_t c = 0; c < 6; ++c) transformed_[c] = weight_ + (2 + c) * stride;
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

CompliantRows SoftRows::view(const ContactRows& rows) const {
  CompliantRows view{};
  view.rigid = rigid(rows);
  view.soft_b = rows.view().b;
  view.weight = weight_;
  std::copy(transformed_, transformed_ + 6, view.transformed);
  return view;
}

SoftContacts SoftRows::ContactsAt(const ContactRows& rows, const Vec3& v,
                                  const Vec3& phi) const noexcept {
  SoftContacts contacts;
  const int count = rows.count();
  for (int i = 0; i < count; ++i) {
    if (weight_[i] == 0.0) continue;
    const Vec3 n = rows.normal(i), arm = rows.lever_cross_normal(i);
    const double push = weight_[i] * (-rows.gap(i) - n.dot(v) - arm.dot(phi));
    if (!(push > 0.0)) continue;
    ++contacts.count;
    contacts.force += push * n;
    contacts.torque += push * arm;
    if (contacts.listed == kMaxActiveRows && !(push > contacts.push[kMaxActiveRows - 1])) continue;
    int at = contacts.listed < kMaxActiveRows ? contacts.listed++ : kMaxActiveRows - 1;
    for (; at > 0 && push > contacts.push[at - 1]; --at) {
      contacts.push[at] = contacts.push[at - 1];
      contacts.row[at] = contacts.row[at - 1];
    }
    contacts.push[at] = push;
    contacts.row[at] = i;
  }
  return contacts;
}

}  // namespace palpate
