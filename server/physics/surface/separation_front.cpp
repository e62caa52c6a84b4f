#include "server/physics/surface/separation_front.h"

#include <cmath>
#include <limits>

#include "common/math/rotation.h"
#include "server/physics/limits.h"

namespace palpate {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
/// Pairs of siblings that NextMergeable examines in a call.
constexpr int kMergeScan = 2 * limits::mesh::kBatch;

constexpr SeparationFront::Eight kUnused{
    {kNever, kNever, kNever, kNever, kNever, kNever, kNever, kNever}};

}  // namespace

void SeparationFront::Reserve() {
  ReserveEach(kMaxSlots, pairs_, planes_, epoch_of_);
  ReserveEach(kMaxSlots / 2, gate_, unused_);
  expiry_.reserve(kMaxSlots / 8);
}

void SeparationFront::Restart(const MovingBody& a, std::span<const ContactBody> bodies,
                              const RelativePose& at, std::optional<HullTree::Node> for_solids,
                              std::int32_t frame) {
  Reserve();
  roots_ = static_cast<Index>(bodies.size());
  const std::size_t slots = RootSlots();
  pairs_.assign(slots, {0, 0, 0, -1, -1});
  planes_.assign(slots, PlaneRecord{});
  epoch_of_.assign(slots, 0);
  expiry_.assign((slots + 7) / 8, kUnused);
  gate_.assign(slots / 2, kNever);
  unused_.clear();
  path_ = 0.0;
  epoch_ = 0;
  epochs_[0] = {at.p, at.q, at.R};
  since_.fill(EpochMotion{});
  next_merged_ = 0;
  for (Index body = 0; body < roots_; ++body) {
    const ContactBody& b = bodies[static_cast<std::size_t>(body)];
    const HullTree& tree = b.shape->tree;
    const auto of_a = tree.IsOfBlocks() ? for_solids : a.tree.root();
    Put(body, a.tree, {of_a.value_or(a.tree.root()), tree.root(), body, -1, -1});
    Set(body, Vec3::UnitZ(), of_a && b.frame == frame ? -1.0 : kNever);
  }
}

void SeparationFront::Put(Index i, const HullTree& tree_a, const Pair& pair) {
  PlaneRecord& plane = planes_[static_cast<std::size_t>(i)];
  for (int c = 0; c < 3; ++c) plane.centre[c] = tree_a.Centre(pair.a)[c];
  plane.radius = tree_a.Radius(pair.a);
  pairs_[static_cast<std::size_t>(i)] = pair;
}

double SeparationFront::Move(const RelativePose& at, double reach) {
  const Epoch& before = now();
  const double angle = RotationLog(at.q * before.q.conjugate()).norm();
  const double path = (at.p - before.p).norm() + reach * angle;
  path_ += path;
  ++epoch_;
  epochs_[epoch_ % kPlaneEpochs] = {at.p, at.q, at.R};
  for (std::size_t e = 0; e < kPlaneEpochs; ++e) {
    const Epoch& then = epochs_[e];
    EpochMotion& motion = since_[e];
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) motion.row[r][c] = at.R(r, c) - then.R(r, c);
      motion.row[r][3] = at.p[r] - then.p[r];
    }
  }
  return path;
}

void SeparationFront::Refresh(const Kernels& kernels, const Index* slots, int count, int first,
                              const PlaneColumns& out) {
  const Mat3 R = now().R.transpose();  // Eigen's columns are the kernel's rows
  kernels.refresh_planes(planes_.data(), epoch_of_.data(), slots, count, since_.data(), R.data(),
                         first, out);
  for (int i = 0; i < count; ++i) {
    ExpiryOf(slots[i]) = path_ + out.slack[first + i];
  }
}

void SeparationFront::Set(Index i, const Vec3& n, double slack) {
  PlaneRecord& plane = planes_[static_cast<std::size_t>(i)];
  for (int c = 0; c < 3; ++c) plane.n[c] = n[c];
  plane.slack = slack;
  epoch_of_[static_cast<std::size_t>(i)] = epoch_;
  ExpiryOf(i) = path_ + slack;
}

SeparationFront::Index SeparationFront::Split(Index i, const HullTree& tree_a,
                                              const HullTree& tree_b, const Vec3& n, double slack) {
  Index child;
  if (!unused_.empty()) {
    child = unused_.back();
    unused_.pop_back();
  } else {
    if (pairs_.size() + 2 > kMaxSlots) return -1;
    child = static_cast<Index>(pairs_.size());
    pairs_.resize(pairs_.size() + 2);
    planes_.resize(pairs_.size());
    epoch_of_.resize(pairs_.size());
    gate_.resize(pairs_.size() / 2);
    if (8 * expiry_.size() < pairs_.size()) expiry_.push_back(kUnused);
  }
  Pair& whole = pairs_[static_cast<std::size_t>(i)];
  const bool of_a = tree_a.IsLarger(whole.a, tree_b, whole.b);
  for (int side = 0; side < 2; ++side) {
    const HullTree::Node a = of_a ? tree_a.inner(whole.a).child[side] : whole.a;
    const HullTree::Node b = of_a ? whole.b : tree_b.inner(whole.b).child[side];
    Put(child + side, tree_a, {a, b, whole.body, i, -1});
    Set(child + side, n, slack);
  }
  whole.child = child;
  planes_[static_cast<std::size_t>(i)].slack = GateOf(child) = path_;
  ExpiryOf(i) = GateOf(i) = kNever;
  return child;
}

void SeparationFront::Merge(Index i, const Vec3& n, double slack) {
  Pair& pair = pairs_[static_cast<std::size_t>(i)];
  for (int side = 0; side < 2; ++side) {
    ExpiryOf(pair.child + side) = kNever;
    pairs_[static_cast<std::size_t>(pair.child + side)].parent = -1;
  }
  unused_.push_back(pair.child);
  GateOf(pair.child) = kNever;
  pair.child = -1;
  if (pair.parent >= 0) SetGate(pair.parent);
  Set(i, n, slack);
}

void SeparationFront::Enter(Index i, std::int32_t body, std::optional<HullTree::Node> root) {
  Pair& pair = pairs_[static_cast<std::size_t>(i)];
  pair.body = body;
  if (root) {
    pair.b = *root;
  } else {
    Set(i, Normal(i), kNever);
  }
}

void SeparationFront::CloseBelow(Index i) {
  const Index child = pair(i).child;
  if (child < 0) return;
  CloseBelow(child);
  CloseBelow(child + 1);
  Merge(i, Normal(i), -1.0);
}

SeparationFront::Index SeparationFront::NextMergeable() {
  for (int i = 0; i < kMergeScan; ++i) {
    next_merged_ += 2;
    if (static_cast<std::size_t>(next_merged_) >= pairs_.size()) {
      next_merged_ = 0;
      return -1;
    }
    if (GateOf(next_merged_) > path_) continue;
    return pair(next_merged_).parent;
  }
  return -1;
}

bool SeparationFront::IsSound(const MovingBody& a, std::span<const ContactBody> b) const {
  const std::size_t count = slots();
  if (count == 0) return true;  // it restarts
  if (roots_ < 0 || static_cast<std::size_t>(roots_) != b.size() || count > kMaxSlots ||
      count < RootSlots() || count % 2 != 0 || planes_.size() != count ||
      epoch_of_.size() != count || expiry_.size() != (count + 7) / 8 || gate_.size() != count / 2 ||
      next_merged_ < 0 || next_merged_ % 2 != 0 ||
      static_cast<std::size_t>(next_merged_) >= count || !(path_ >= 0.0)) {
    return false;
  }
  // What NextMergeable and the search for expired planes must not meet.
  const auto never = [&](Index i) {
    return expiry_[static_cast<std::size_t>(i) / 8].v[static_cast<std::size_t>(i) % 8] == kNever;
  };
  std::vector<bool> seen(count);
  std::vector<Index> open;
  const auto see = [&](Index i, Index parent) {
    const Pair& at = pair(i);
    const PlaneRecord& plane = planes_[static_cast<std::size_t>(i)];
    seen[static_cast<std::size_t>(i)] = true;
    if (at.parent != parent || at.body < 0 || at.body >= roots_ || !a.tree.Has(at.a) ||
        !b[static_cast<std::size_t>(at.body)].shape->tree.Has(at.b) ||
        (parent < 0 ? at.body != i : at.body != pair(parent).body) || std::isnan(plane.slack) ||
        plane.radius != a.tree.Radius(at.a)) {
      return false;
    }
    if (at.child >= 0) open.push_back(i);
    return at.child < 0 || never(i);
  };
  const auto is_pair_of_slots = [&](Index first) {
    return first >= 0 && first % 2 == 0 && static_cast<std::size_t>(first) >= RootSlots() &&
           static_cast<std::size_t>(first) < count && !seen[static_cast<std::size_t>(first)];
  };
  std::size_t pairs = RootSlots();
  for (Index root = 0; root < roots_; ++root) {
    if (!see(root, -1)) return false;
  }
  while (!open.empty()) {
    const Index at = open.back(), child = pair(at).child;
    open.pop_back();
    if (!is_pair_of_slots(child) || !see(child, at) || !see(child + 1, at)) return false;
    const double gate = IsMergeable(at) ? planes_[static_cast<std::size_t>(at)].slack : kNever;
    if (gate_[static_cast<std::size_t>(child) / 2] != gate) return false;
    pairs += 2;
  }
  for (const Index first : unused_) {
    if (!is_pair_of_slots(first) || !never(first) || !never(first + 1) ||
        gate_[static_cast<std::size_t>(first) / 2] != kNever) {
      return false;
    }
    seen[static_cast<std::size_t>(first)] = true;
    pairs += 2;
  }
  return pairs == count;
}

}  // namespace palpate
