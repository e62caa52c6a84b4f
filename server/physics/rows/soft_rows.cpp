#include "server/physics/rows/soft_rows.h"

#include <algorithm>
#include <cmath>

namespace palpate {

bool SoftRows::Collect(const ContactRows& rows, QpRows& rigid) noexcept {
  any_ = false;
  const ObjectForest& objects = model_.objects();
  yielding = {rows.view(), columns_[kWeight], nullptr, columns_[kPush]};
  double *weight = columns_[kWeight], *rigid_b = columns_[kRigidB];
  const int count = rows.count();
  for (int i = 0; i < count; ++i) {
    weight[i] = 0.0;
    rigid_b[i] = -rows.gap(i);
    const ContactId& id = rows.id(i);
    if (!id.IsOfLeaves()) continue;
    const Material& material = objects.MaterialOf(id.b);
    if (std::isinf(material.stiffness)) continue;
    const double radius = objects.leaves[static_cast<std::size_t>(id.b)].radius;
    weight[i] = material.stiffness / model_.parameters().stiffness;
    rigid_b[i] -= CoreDepth(material, radius);
    any_ = true;
  }
  for (int i = count; i % 16 != 0; ++i) {
    weight[i] = 0.0;
    rigid_b[i] = -1e300;
  }
  if (any_) rigid.b = rigid_b;
  return any_;
}

SoftContacts SoftRows::Contacts() const noexcept {
  SoftContacts contacts;
  contacts.count = pushing;
  const int count = pushing == 0 ? 0 : yielding.rows.count;
  const double* pushes = columns_[kPush];
  double least = 0.0;  // what a row must exceed to be listed
  for (int i = 0; i < count; ++i) {
    const double push = pushes[i];
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
