#include "server/physics/surface/separation_front.h"

#include <cmath>
#include <limits>

#include "common/math/rotation.h"

namespace palpate {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
/// Pairs of siblings that NextMergeable looks at in a call.  Taken.
constexpr int kMergeScan = 64;

}  // namespace

ToolPose ToolPose::Moved(const Vec3& v, const Vec3& phi) const {
  return {p + v, (RotationExp(phi) * q).normalized()};
}

namespace {

constexpr SeparationFront::Eight kUnused{
    {kNever, kNever, kNever, kNever, kNever, kNever, kNever, kNever}};

}  // namespace

void SeparationFront::Reserve() {
  pairs_.reserve(kMaxSlots);
  expiry_.reserve(kMaxSlots / 8);
  unused_.reserve(kMaxSlots / 2);
}

void SeparationFront::Restart(const BoxTree& tool, const BoxTree& objects, const ToolPose& at) {
  Reserve();
  pairs_.assign(2, Pair{});
  expiry_.assign(1, kUnused);
  unused_.clear();
  way_ = 0.0;
  epoch_ = 0;
  epochs_[0] = {at.p, at.q, at.R, 0.0};
  next_merged_ = 0;
  size_ = 1;
  Put(0, tool, tool.root(), objects.root(), -1);
  Set(0, Vec3::UnitZ(), -1.0);
}

void SeparationFront::Put(Index i, const BoxTree& tool, BoxTree::Node of_tool,
                          BoxTree::Node of_object, Index parent) {
  Pair& pair = pairs_[static_cast<std::size_t>(i)];
  const Vec3& centre = tool.Centre(of_tool);
  for (int c = 0; c < 3; ++c) pair.centre[c] = static_cast<float>(centre[c]);
  // The centre's rounding to float, 6e-8 of it, and the radius' own.
  pair.radius = static_cast<float>(tool.Radius(of_tool) * (1.0 + 1e-6) + 1e-6 * centre.norm());
  pair.farthest = static_cast<float>(1.000001 * (centre.norm() + static_cast<double>(pair.radius)));
  pair.tool = of_tool;
  pair.object = of_object;
  pair.parent = parent;
  pair.child = -1;
}

void SeparationFront::Move(const ToolPose& at, double reach) {
  const Epoch& before = now();
  const double angle = RotationLog(at.q * before.q.conjugate()).norm();
  const double turned = before.turned + angle;
  way_ += (at.p - before.p).norm() + reach * angle;
  ++epoch_;
  epochs_[epoch_ % kEpochs] = {at.p, at.q, at.R, turned};
}

bool SeparationFront::SlackNow(const Pair& pair, double& slack) const {
  if (epoch_ - pair.epoch >= kEpochs) return false;
  const Epoch &then = epochs_[pair.epoch % kEpochs], &here = now();
  const Vec3 centre = pair.Centre();
  const Vec3 moved = here.R * centre + here.p - (then.R * centre + then.p);
  slack = pair.slack + pair.Normal().dot(moved) -
          (here.turned - then.turned) * static_cast<double>(pair.radius);
  return true;
}

void SeparationFront::Set(Index i, const Vec3& n, double slack) {
  Pair& pair = pairs_[static_cast<std::size_t>(i)];
  for (int c = 0; c < 3; ++c) pair.n[c] = n[c];
  pair.slack = slack;
  pair.epoch = epoch_;
  ExpiryOf(i) = way_ + slack;
}

SeparationFront::Index SeparationFront::Split(Index i, const BoxTree& tool, const BoxTree& objects,
                                              const Vec3& n, double slack) {
  Index child;
  if (!unused_.empty()) {
    child = unused_.back();
    unused_.pop_back();
  } else {
    if (pairs_.size() + 2 > kMaxSlots) return -1;
    child = static_cast<Index>(pairs_.size());
    pairs_.resize(pairs_.size() + 2);
    if (8 * expiry_.size() < pairs_.size()) expiry_.push_back(kUnused);
  }
  Pair& whole = pairs_[static_cast<std::size_t>(i)];
  const bool of_tool = tool.Size(whole.tool) >= objects.Size(whole.object);
  for (int side = 0; side < 2; ++side) {
    const BoxTree::Node a = of_tool ? tool.box(whole.tool).child[side] : whole.tool;
    const BoxTree::Node b = of_tool ? whole.object : objects.box(whole.object).child[side];
    Put(child + side, tool, a, b, i);
    Set(child + side, n, slack);
  }
  whole.child = child;
  whole.slack = way_;
  ExpiryOf(i) = kNever;
  ++size_;
  return child;
}

void SeparationFront::Merge(Index i, const Vec3& n, double slack) {
  Pair& pair = pairs_[static_cast<std::size_t>(i)];
  for (int side = 0; side < 2; ++side) {
    ExpiryOf(pair.child + side) = kNever;
    pairs_[static_cast<std::size_t>(pair.child + side)].parent = -1;
  }
  unused_.push_back(pair.child);
  pair.child = -1;
  --size_;
  Set(i, n, slack);
}

SeparationFront::Index SeparationFront::NextMergeable() {
  for (int i = 0; i < kMergeScan; ++i) {
    next_merged_ += 2;
    if (static_cast<std::size_t>(next_merged_) >= pairs_.size()) {
      next_merged_ = 0;
      return -1;
    }
    const Pair& first = pairs_[static_cast<std::size_t>(next_merged_)];
    if (first.parent < 0 || pair(first.parent).slack > way_ || !IsMergeable(first.parent)) continue;
    return first.parent;
  }
  return -1;
}

}  // namespace palpate
