#include "server/physics/contact/near_pairs.h"

#include <algorithm>

namespace palpate {

using namespace limits::mesh;

NearPairs::NearPairs(int queries)
    : after_(std::min(RoomForNear(queries), SeparationFront::kMaxSlots)),
      storage_(9, after_.size()) {
  pairs_.reserve(after_.size());
  seen_.resize(SeparationFront::kMaxSlots);
  found_.resize(SeparationFront::kMaxSlots + 8);
  for (std::size_t c = 0; c < 6; ++c) planes_.along[c] = storage_[c];
  planes_.slack = storage_[6];
  planes_.radius = storage_[7];
  planes_.left = storage_[8];
}

void NearPairs::Begin(const MeshPair& meshes, SeparationFront& front, const RelativePose& from) {
  meshes_ = &meshes;
  front_ = &front;
  from_ = from;
  covered_ = 0.0;
  full_ = false;
  pairs_.clear();
  if (++substep_ == 0) {
    std::fill(seen_.begin(), seen_.end(), 0u);
    substep_ = 1;
  }
  const auto was_set_far = [&] {
    const bool is_there = from.p == front.now().p && from.q.coeffs() == front.now().q.coeffs();
    return !is_there && front.Move(from, meshes.a.mesh.reach()) > kSetFar;
  };
  if (front.empty() || was_set_far()) {
    front.Restart(meshes.a, meshes.b, from, meshes.ForSolids(), meshes.frame);
  }
}

void NearPairs::Cover(double translation, double rotation, Queries& queries) {
  // A candidate needs room for the rotation's second order, 1/2 |phi|^2 of a lever, in addition
  // to the linear part.
  const double reach = meshes_->a.mesh.reach();
  const double path =
      translation + rotation * reach * (1.0 + 0.5 * rotation) + meshes_->margins.free;
  if (path <= covered_) return;
  covered_ = path;
  const int found = meshes_->kernels->find_below(
      front_->expiry(), static_cast<int>(front_->slots()), front_->path() + path, found_.data());
  int count = 0;
  for (int f = 0; f < found; ++f) {
    const SeparationFront::Index i = found_[static_cast<std::size_t>(f)];
    if (seen_[static_cast<std::size_t>(i)] == substep_) continue;
    found_[static_cast<std::size_t>(count++)] = i;
  }
  for (int done = 0; done < count; done += kBatch) {
    // Pairs that are not refreshed any more are not known to be separate.
    full_ = queries.AreSpent() || pairs_.size() + kBatch > after_.size();
    if (full_) return;
    Add(found_.data() + done, std::min(kBatch, count - done), path, queries);
  }
}

void NearPairs::Add(SeparationFront::Index in_front) {
  pairs_.push_back({in_front});
  seen_[static_cast<std::size_t>(in_front)] = substep_;
}

/// Adds those of the given pairs of the front that a motion of this length could bring together.
/// Most of them could not: an expiry counts every motion as one against the plane.
void NearPairs::Add(const SeparationFront::Index* in_front, int count, double path,
                    Queries& queries) {
  for (int i = 0; i < count; ++i) {
    if (front_->IsKept(in_front[i])) continue;
    const SeparationFront::Pair& pair = front_->pair(in_front[i]);
    const Vec3 n = front_->Normal(in_front[i]);
    front_->Set(in_front[i], n, meshes_->Gap(meshes_->NodesOf(pair), n, from_));
  }
  const Index first = size();
  front_->Refresh(*meshes_->kernels, in_front, count, first, planes_);
  queries.refreshed += count;
  Index kept[kBatch], near = 0;
  for (int i = 0; i < count; ++i) {
    kept[near] = i;
    near += planes_.slack[first + i] < path ? 1 : 0;
  }
  const auto keep = [&](double* column) {
    for (Index i = 0; i < near; ++i) column[first + i] = column[first + kept[i]];
  };
  for (double* along : planes_.along) keep(along);
  keep(planes_.slack);
  keep(planes_.radius);
  for (Index i = 0; i < near; ++i) Add(in_front[kept[i]]);
}

std::span<const NearPairs::Index> NearPairs::FindUsedUp(Index first, const PlaneMotion& motion,
                                                        Queries& queries) {
  const int found = meshes_->kernels->find_used_up(planes_, first, size(), motion, found_.data());
  queries.refreshed += found + (size() - first) / 8;
  return {found_.data(), static_cast<std::size_t>(found)};
}

void NearPairs::SetPlane(Index k, const Vec3& n, double slack) {
  const HullTree::Node a = front_->pair((*this)[k].in_front).a;
  const Vec3 turned = (from_.R * meshes_->a.tree.Centre(a)).cross(n);
  for (int c = 0; c < 3; ++c) {
    planes_.along[c][k] = n[c];
    planes_.along[3 + c][k] = turned[c];
  }
  planes_.slack[k] = slack;
}

void NearPairs::SetPlanes(Index k, const Vec3& n_before, double before, const Vec3& n_after,
                          double after) {
  SetPlane(k, n_before, before);
  (*this)[k].replaced = true;
  after_[static_cast<std::size_t>(k)] = {n_after, after};
}

/// Makes its own plane hold at every candidate, because its children are examined instead.
void NearPairs::Close(Index k) {
  (*this)[k].split = true;
  planes_.slack[k] = kInfinity;
}

void NearPairs::AddChild(SeparationFront::Index in_front, double radius, const Vec3& n,
                         double slack) {
  planes_.radius[size()] = radius;
  Add(in_front);
  SetPlane(size() - 1, n, slack);
}

bool NearPairs::Split(Index k, Queries& queries) {
  if (pairs_.size() + 2 > after_.size()) return false;
  const NodesOfPair nodes = Nodes(k);
  const std::int32_t block = nodes.shape->tree.BlockOf(nodes.b);
  if (block >= 0 && !meshes_->a.tree.IsLarger(nodes.a, nodes.shape->tree, nodes.b)) {
    return Enter(k, block, queries);
  }
  const Vec3 n = Normal(k);
  const double slack = planes_.slack[k];
  const SeparationFront::Index child =
      front_->Split((*this)[k].in_front, meshes_->a.tree, nodes.shape->tree, n, slack);
  if (child < 0) return false;
  Close(k);
  for (int side = 0; side < 2; ++side) {
    AddChild(child + side, front_->plane(child + side).radius, n, slack);
  }
  return true;
}

bool NearPairs::Enter(Index k, std::int32_t block, Queries& queries) {
  const NodesOfPair nodes = Nodes(k);
  SolidBodies& solids = *meshes_->solids;
  if (solids.empty()) return false;
  const SolidBodies::Taken taken = solids.Take({nodes.number, nodes.b, block}, *front_);
  if (taken.made) queries.tested += kQueriesOfBlock;
  if (taken.body < 0) return false;
  const SeparationFront::Index i = (*this)[k].in_front;
  const Vec3 n = Normal(k);
  const double slack = planes_.slack[k], radius = planes_.radius[k];
  front_->Set(i, n, slack);
  Close(k);
  if (solids.IsNothing(taken.body)) {
    front_->Enter(i, taken.body, std::nullopt);
    return true;
  }
  front_->Enter(i, taken.body, solids.Body(taken.body).shape.tree.root());
  AddChild(i, radius, n, slack);
  return true;
}

void NearPairs::Accept(const Motion& motion, std::int32_t candidate) {
  // A pair that was not examined closely keeps the front's plane.
  for (Index k = 0; k < size(); ++k) {
    const Pair& pair = (*this)[k];
    if (!pair.split && pair.replaced) front_->Set(pair.in_front, Normal(k), planes_.slack[k]);
  }
  if (motion.moves) {
    front_->Move(motion.to, meshes_->a.mesh.reach());
    // The motion's second order is not in `left`.
    const double bend = 0.5 * motion.phi.squaredNorm() * meshes_->Reach();
    for (Index k = 0; k < size(); ++k) {
      const Pair& pair = (*this)[k];
      const Plane& after = after_[static_cast<std::size_t>(k)];
      if (pair.split) continue;
      if (pair.examined_in == candidate) {
        front_->Set(pair.in_front, after.n, after.slack);
      } else {
        front_->Expire(pair.in_front, planes_.left[k] - bend);
      }
    }
  }
}

void NearPairs::Merge(const RelativePose& at, Queries& queries) {
  for (int i = 0; i < kBatch; ++i) {
    SeparationFront::Index index = front_->NextMergeable();
    if (index < 0) return;
    // A pair that has been merged may now be merged with its sibling.
    for (; index >= 0 && front_->IsMergeable(index); index = front_->pair(index).parent) {
      const SeparationFront::Pair& pair = front_->pair(index);
      ++queries.tested;
      Vec3 n;
      double gap = -kInfinity;
      for (int side = 0; side < 2; ++side) {
        const Vec3 along = front_->Normal(pair.child + side);
        const double here = meshes_->Gap(meshes_->NodesOf(pair), along, at);
        if (here > gap) n = along;
        gap = std::max(here, gap);
      }
      if (!(gap >= meshes_->margins.touching)) {
        front_->RetryAfter(index, meshes_->margins.touching - gap);
        break;
      }
      front_->Merge(index, n, gap);
    }
  }
}

}  // namespace palpate
