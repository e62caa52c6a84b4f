#include "server/physics/rows/mesh_contact.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <new>

#include "common/math/rotation.h"
#include "server/physics/limits.h"

namespace palpate {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

using namespace limits::mesh;

constexpr std::align_val_t kCacheLine{64};
constexpr std::int32_t kTag = static_cast<std::int32_t>(RowKind::kMeshes) << kRowKindShift;

LeafPair KeyOf(HullTree::Node tool, HullTree::Node object, int slot) {
  return {kTag | static_cast<std::int32_t>(HullTree::TriangleOf(tool) << 2 |
                                           static_cast<std::uint32_t>(slot)),
          static_cast<std::int32_t>(HullTree::TriangleOf(object))};
}

/// What a plane must separate a pair by before and after a sub-step, whose best plane separates it
/// by `distance` before (less than zero where it intersects).  A pair that is nearer than h may not
/// come nearer, but for rounding; and that only as long as the sum of roundings does no harm.
double LeastOld(double distance) {
  return distance > 0.0 ? std::min(kFree, 0.5 * distance) : distance - kRounding;
}
double LeastNew(double distance) {
  return distance > 0.5 * kFree ? std::min(kFree, distance) - kRounding : distance;
}

/// A pair of near_ whose plane does not hold at a trial, and the gap that is left along it: one
/// number, which is less where the gap is, so that sorting compares nothing else.  The index takes
/// the place of the gap's last bits.
std::int64_t DoubtOf(double gap, std::int32_t near) {
  auto bits = std::bit_cast<std::int64_t>(gap);
  bits ^= (bits >> 63) & std::numeric_limits<std::int64_t>::max();  // ordered as gaps are
  return (bits & ~static_cast<std::int64_t>(kMaxNear - 1)) | near;
}
std::int32_t NearOf(std::int64_t doubt) {
  return static_cast<std::int32_t>(doubt & static_cast<std::int64_t>(kMaxNear - 1));
}

bool AreTriangles(HullTree::Node tool, HullTree::Node object) {
  return HullTree::IsLeaf(tool) && HullTree::IsLeaf(object);
}

}  // namespace

MeshContact::MeshContact(const MeshWithTree& tool, const MeshWithTree& objects, int max_rows)
    : tool_(tool),
      objects_(objects),
      from_(Vec3::Zero(), Quat::Identity()),
      to_(Vec3::Zero(), Quat::Identity()),
      plane_storage_(new (kCacheLine) double[9 * (kMaxNear + 8)](),
                     [](double* p) { ::operator delete[](p, kCacheLine); }) {
  near_.reserve(kMaxNear);
  next_.resize(kMaxNear);
  seen_.resize(SeparationFront::kMaxSlots);
  found_.resize(SeparationFront::kMaxSlots + 8);
  doubts_.reserve(kMaxNear);
  deferred_.reserve(kMaxNear);
  constexpr std::size_t kStride = kMaxNear + 8;  // not a power of two, or columns share a cache set
  for (std::size_t c = 0; c < 6; ++c) planes_.along[c] = plane_storage_.get() + c * kStride;
  planes_.slack = plane_storage_.get() + 6 * kStride;
  planes_.radius = plane_storage_.get() + 7 * kStride;
  planes_.left = plane_storage_.get() + 8 * kStride;
  touches_.reserve(kMaxTouches);
  touch_of_row_.reserve(static_cast<std::size_t>(max_rows));
  regain_.resize(static_cast<std::size_t>(max_rows));
  released_.reserve(static_cast<std::size_t>(max_rows));
}

PatchPair MeshContact::PairOf(HullTree::Node tool, HullTree::Node object) const {
  return {tool_.tree, tool, tool_.radius, objects_.tree, object};
}

double MeshContact::Low(HullTree::Node tool, const Vec3& n, const ToolPose& at) const {
  return n.dot(at.p) - tool_.tree.Highest(tool, -(at.R.transpose() * n), *kernels_) - tool_.radius;
}

double MeshContact::High(HullTree::Node object, const Vec3& n) const {
  return objects_.tree.Highest(object, n, *kernels_);
}

double MeshContact::Gap(const NearPair& near, const Vec3& n, const ToolPose& at) const {
  return Low(near.tool, n, at) - High(near.object, n);
}

bool MeshContact::HoldsAlong(NearPair& near, const Vec3& n, double least_old, double least_new) {
  const double now = Gap(near, n, to_);
  if (!(now >= least_new)) return false;
  const double before = moved_ ? Gap(near, n, from_) : now;
  if (!(before >= least_old)) return false;
  SetPlane(near, n, before);
  next_[static_cast<std::size_t>(&near - near_.data())] = {n, now};
  return true;
}

Vec3 MeshContact::NormalAt(const Touch& touch, const Plane& plane, const ToolPose& at) const {
  switch (plane.of) {
    case Plane::Of::kTool:
      return at.R * plane.n;
    case Plane::Of::kEdges: {
      const auto a = HullTree::TriangleOf(touch.tool), b = HullTree::TriangleOf(touch.object);
      const int i = plane.tool_edge, j = plane.object_edge;
      const Vec3 ea = tool_.mesh.Corner(a, (i + 1) % 3) - tool_.mesh.Corner(a, i);
      const Vec3 eb = objects_.mesh.Corner(b, (j + 1) % 3) - objects_.mesh.Corner(b, j);
      return plane.sign * (at.R * ea).cross(eb).normalized();
    }
    default:
      return plane.n;
  }
}

/// What a pair may come nearer by between the ends of the trial: a plane of edges turns while the
/// contact moves, and the gap in between is less by a quarter of the one times the other at most.
double MeshContact::TurnLoss(const Plane& plane, const Touch& touch, const Vec3& n_old,
                             const Vec3& n_new) const {
  if (plane.of != Plane::Of::kEdges) return 0.0;
  const Vec3 lever = touch.nearest.p - from_.p;
  return 0.25 * (n_new - n_old).norm() * (v_ + phi_.cross(lever)).norm();
}

/// As HoldsAlong, for a plane of a touch, which may move with the tool, and a pair that is
/// `distance` apart at the sub-step's beginning: the touch's own, or a neighbour.
bool MeshContact::HoldsAcross(NearPair& near, double distance, const Plane& plane,
                              const Touch& touch) {
  const double least_old = LeastOld(distance), least_new = LeastNew(distance);
  if (plane.of == Plane::Of::kObject) return HoldsAlong(near, plane.n, least_old, least_new);
  const Vec3 n_old = NormalAt(touch, plane, from_), n_new = NormalAt(touch, plane, to_);
  const double before = Gap(near, n_old, from_), now = Gap(near, n_new, to_);
  if (!(before >= least_old && now >= least_new)) return false;
  if (std::min(before, now) - TurnLoss(plane, touch, n_old, n_new) <
      0.5 * std::min(kFree, before)) {
    return false;
  }
  SetPlane(near, n_old, before);
  next_[static_cast<std::size_t>(&near - near_.data())] = {n_new, now};
  return true;
}

Vec3 MeshContact::NormalOf(const NearPair& near) const {
  const auto k = &near - near_.data();
  return {planes_.along[0][k], planes_.along[1][k], planes_.along[2][k]};
}

void MeshContact::SetPlane(NearPair& near, const Vec3& n, double slack) {
  const auto k = &near - near_.data();
  const Vec3 turned = (from_.R * tool_.tree.Centre(near.tool)).cross(n);
  for (int c = 0; c < 3; ++c) {
    planes_.along[c][k] = n[c];
    planes_.along[3 + c][k] = turned[c];
  }
  planes_.slack[k] = slack;
  near.replaced = true;
}

void MeshContact::AddNear(SeparationFront::Index index) {
  const SeparationFront::Pair& pair = front_->pair(index);
  near_.push_back({pair.tool, pair.object, index, -1, 0, false, false});
  seen_[static_cast<std::size_t>(index)] = substep_;
}

/// Gathers the pairs that a motion of such a length could bring together: once it is known, for a
/// trial is mostly far shorter than the sub-step may be.
void MeshContact::Cover(double translation, double rotation) {
  // Check allows for the rotation's second order, 1/2 |phi|^2 of a lever, beside the linear part.
  const double way = translation + rotation * tool_.mesh.reach() * (1.0 + 0.5 * rotation) + kFree;
  if (way <= covered_) return;
  covered_ = way;
  const int found = kernels_->find_below(front_->expiry(), static_cast<int>(front_->slots()),
                                         front_->way() + way, found_.data());
  int count = 0;
  for (int f = 0; f < found; ++f) {
    const SeparationFront::Index i = found_[static_cast<std::size_t>(f)];
    if (seen_[static_cast<std::size_t>(i)] == substep_) continue;
    found_[static_cast<std::size_t>(count++)] = i;
  }
  for (int done = 0; done < count; done += kBatch) {
    // Those that are not brought up to date any more are not known to be apart.
    full_ = IsExhausted() || near_.size() + kBatch > kMaxNear;
    if (full_) return;
    AddNear(found_.data() + done, std::min(kBatch, count - done), way);
  }
}

/// Adds those of some pairs of the front that a motion of such a length could bring together.  Most
/// could not: an expiry counts every motion as one against the plane.
void MeshContact::AddNear(const SeparationFront::Index* index, int count, double way) {
  for (int i = 0; i < count; ++i) {
    if (front_->IsKept(index[i])) continue;
    const SeparationFront::Pair& pair = front_->pair(index[i]);
    const Vec3 n = front_->Normal(index[i]);
    front_->Set(index[i], n, Low(pair.tool, n, from_) - High(pair.object, n));
  }
  const auto first = static_cast<int>(near_.size());
  front_->Refresh(*kernels_, index, count, first, planes_);
  refreshed_ += count;
  for (int i = 0; i < count; ++i) {
    if (planes_.slack[first + i] >= way) continue;
    const auto to = static_cast<int>(near_.size());
    for (double* along : planes_.along) along[to] = along[first + i];
    planes_.slack[to] = planes_.slack[first + i];
    planes_.radius[to] = planes_.radius[first + i];
    AddNear(index[i]);
  }
}

void MeshContact::Begin(const Kernels& kernels, SeparationFront& front, const ToolPose& from,
                        const LeafPair* active, int actives, std::int64_t most_looks,
                        ContactRows& rows) noexcept {
  tested_ = refreshed_ = 0;
  most_looks_ = most_looks;
  kernels_ = &kernels;
  front_ = &front;
  from_ = to_ = from;
  covered_ = 0.0;
  regains_ = true;
  trial_ = 0;
  if (++substep_ == 0) {
    std::fill(seen_.begin(), seen_.end(), 0u);
    substep_ = 1;
  }
  v_.setZero();
  phi_.setZero();
  moved_ = false;
  near_.clear();
  touches_.clear();
  touch_of_row_.clear();
  full_ = false;

  if (front.empty()) front.Restart(tool_.tree, objects_.tree, from);
  if (from.p != front.now().p || from.q.coeffs() != front.now().q.coeffs()) {  // the pose was set
    const double way = front.Move(from, tool_.mesh.reach());
    if (way > kSetFar) front.Restart(tool_.tree, objects_.tree, from);
  }

  // Opens the front as far as it must be to know the pairs that touched last.
  Cover(kTouching, 0.0);
  Check(Vec3::Zero(), Vec3::Zero(), rows);
  for (std::size_t k = 0; k < near_.size() && actives > 0; ++k) {
    NearPair& near = near_[k];
    if (near.split || !AreTriangles(near.tool, near.object)) continue;
    const LeafPair key = KeyOf(near.tool, near.object, 0);
    const bool was = std::any_of(active, active + actives, [&](const LeafPair& pair) {
      return (pair.tool & ~3) == key.tool && pair.object == key.object;
    });
    if (!was || touches_.size() == kMaxTouches) continue;
    Touch& touch = TouchOf(near);
    if (touch.distance <= 0.0 || touch.plane.of != Plane::Of::kNone) continue;
    touch.plane = ChoosePlane(near, touch);
    PutRows(near, true, rows);
  }
}

int MeshContact::Check(const Vec3& v, const Vec3& phi, ContactRows& rows) noexcept {
  const int apart_not = Look(v, phi, &rows);
  GiveDeferredRows(rows);
  return apart_not;
}

bool MeshContact::IsFree(const Vec3& v, const Vec3& phi) noexcept {
  return Look(v, phi, nullptr) == 0;
}

/// Check, but for rows of pairs out of their cones; without rows, of the first pair that is not
/// apart.
int MeshContact::Look(const Vec3& v, const Vec3& phi, ContactRows* rows) {
  v_ = v;
  phi_ = phi;
  moved_ = v != Vec3::Zero() || phi != Vec3::Zero();
  to_ = moved_ ? from_.Moved(v, phi) : from_;
  const double angle = phi.norm();
  // The rotation's second order is 1/2 |phi|^2 of a point's lever at most.
  const double bend = 0.5 * angle * angle * (tool_.mesh.reach() + tool_.radius);
  Cover(v.norm(), angle);
  const PlaneMotion motion{
      {v.x(), v.y(), v.z(), phi.x(), phi.y(), phi.z()}, angle, kFree, kFree + bend};
  ++trial_;
  doubts_.clear();
  deferred_.clear();
  touched_ = false;
  // Pairs that there was no room for are not known to be apart.
  int apart_not = full_ ? 1 : 0, collected = 0;
  for (;;) {
    // Those whose planes do not hold throughout the trial; patches that were split have added to
    // them.
    const auto all = static_cast<int>(near_.size());
    const int found = kernels_->find_used_up(planes_, collected, all, motion, found_.data());
    refreshed_ += found + (all - collected) / 8;
    collected = all;
    if (IsExhausted()) {
      apart_not += found + static_cast<int>(doubts_.size());
      break;
    }
    for (int f = 0; f < found; ++f) {
      const std::int32_t k = found_[static_cast<std::size_t>(f)];
      doubts_.push_back(DoubtOf(planes_.left[k], k));
      std::push_heap(doubts_.begin(), doubts_.end(), std::greater<>());
    }
    const int enough = rows != nullptr ? kEnough : 1;
    if (doubts_.empty() || (moved_ && apart_not >= enough)) break;
    // The deepest first.  With a good many rows the next trial is another one: the rest can wait.
    for (int i = 0; i < kBatch && !doubts_.empty() && !IsExhausted(); ++i) {
      if (moved_ && apart_not >= enough) break;
      std::pop_heap(doubts_.begin(), doubts_.end(), std::greater<>());
      const std::int32_t k = NearOf(doubts_.back());
      doubts_.pop_back();
      if (!LookCloser(k, rows)) ++apart_not;
    }
  }
  return apart_not;
}

/// Whether a pair is apart at the trial, whatever the front's own plane says.  Patches that no
/// plane separates are opened: their parts say.  Triangles that no plane separates get their rows;
/// the planes that may be those of a contact are few, and no other one is looked for.
bool MeshContact::LookCloser(std::int32_t k, ContactRows* rows) {
  NearPair& near = near_[static_cast<std::size_t>(k)];
  near.looked_at = trial_;
  if (IsExhausted()) return false;
  if (!AreTriangles(near.tool, near.object)) return IsSeparable(near) || Split(k);
  const bool has_plane =
      near.touch >= 0 &&
      touches_[static_cast<std::size_t>(near.touch)].plane.of != Plane::Of::kNone;
  // A ball's row goes along the smooth surface and not along the pair's plane: any plane will do.
  const bool apart =
      !has_plane &&
      (tool_.radius > 0.0 ? IsSeparable(near) : HoldsAlong(near, NormalOf(near), kFree, kFree));
  if (apart) return true;
  if (near.touch < 0 && touches_.size() == kMaxTouches) return false;
  ++tested_;
  if (TrianglesApart(near)) return true;
  if (!moved_ || rows == nullptr) return false;
  if (TouchOf(near).in_cone) {
    touched_ = GiveRows(near, *rows) || touched_;
  } else {
    deferred_.push_back(k);
  }
  return false;
}

bool MeshContact::GiveRows(NearPair& near, ContactRows& rows) {
  Touch& touch = TouchOf(near);
  if (touch.plane.of == Plane::Of::kNone) touch.plane = ChoosePlane(near, touch);
  return PutRows(near, false, rows);
}

/// Of pairs out of their cones a neighbour is nearer, and its rows mostly keep them apart too.  So
/// they get rows only at a trial that gave none to a pair within its cones.
void MeshContact::GiveDeferredRows(ContactRows& rows) {
  if (touched_) return;
  for (const std::int32_t k : deferred_) GiveRows(near_[static_cast<std::size_t>(k)], rows);
}

/// Whether a plane separates the hulls of two patches at the trial.
bool MeshContact::IsSeparable(NearPair& near) {
  SeparatingPlane plane;
  const bool found = FindPlane(PairOf(near.tool, near.object), {from_, to_}, NormalOf(near), kFree,
                               *kernels_, plane);
  tested_ += plane.tries;
  if (!found) return false;
  SetPlane(near, plane.n, plane.before);
  next_[static_cast<std::size_t>(&near - near_.data())] = {plane.n, plane.after};
  return true;
}

bool MeshContact::Split(std::int32_t k) {
  NearPair& near = near_[static_cast<std::size_t>(k)];
  if (near_.size() + 2 > kMaxNear) return false;
  const Vec3 n = NormalOf(near);
  const double slack = planes_.slack[k];
  const SeparationFront::Index child =
      front_->Split(near.index, tool_.tree, objects_.tree, n, slack);
  if (child < 0) return false;
  // Its own plane now holds at every trial: its children are looked at in its place.
  near.split = true;
  for (int side = 0; side < 2; ++side) {
    AddNear(child + side);
    planes_.radius[near_.size() - 1] = front_->plane(child + side).radius;
    SetPlane(near_.back(), n, slack);
    near_.back().replaced = false;
  }
  planes_.slack[k] = kInfinity;
  return true;
}

MeshContact::Corners MeshContact::CornersAt(HullTree::Node tool, HullTree::Node object,
                                            const ToolPose& at) const {
  Corners corners;
  for (int c = 0; c < 3; ++c) {
    corners.a[c] = at.R * tool_.mesh.Corner(HullTree::TriangleOf(tool), c) + at.p;
    corners.b[c] = objects_.mesh.Corner(HullTree::TriangleOf(object), c);
  }
  return corners;
}

bool MeshContact::InCone(const NearPair& near, const NearestPoints& nearest, const Vec3& u,
                         const ToolPose& at) const {
  const auto holds = [](const ContactMesh& mesh, HullTree::Node node, Feature of, const Vec3& n) {
    const ContactMesh::Triangle& t = mesh.triangles()[HullTree::TriangleOf(node)];
    if (of.kind == Feature::kEdge) return mesh.EdgeConeHolds(t.edge[of.index], n);
    if (of.kind == Feature::kVertex) return mesh.VertexConeHolds(t.vertex[of.index], n);
    return true;
  };
  return holds(objects_.mesh, near.object, nearest.of_q, u) &&
         holds(tool_.mesh, near.tool, nearest.of_p, -(at.R.transpose() * u));
}

MeshContact::Touch& MeshContact::TouchOf(NearPair& near) {
  if (near.touch >= 0) return touches_[static_cast<std::size_t>(near.touch)];
  near.touch = static_cast<std::int32_t>(touches_.size());
  Touch& touch = touches_.emplace_back();
  touch.tool = near.tool;
  touch.object = near.object;
  touch.row[0] = touch.row[1] = touch.row[2] = -1;
  touch.retracted = touch.relinearised = false;
  const Corners corners = CornersAt(near.tool, near.object, from_);
  touch.nearest = NearestOfTriangles(corners.a, corners.b);
  const double length = std::sqrt(touch.nearest.squared);
  touch.distance = -kInfinity;
  if (length > 0.0) {
    touch.u = (touch.nearest.p - touch.nearest.q) / length;
    touch.distance = Gap(near, touch.u, from_);
  }
  touch.in_cone = touch.distance > 0.0 && InCone(near, touch.nearest, touch.u, from_);
  if (touch.distance > 0.0) return touch;
  // They intersect: the direction in which they do so least.
  const auto consider = [&](const Vec3& axis) {
    const double axis_length = axis.norm();
    if (!(axis_length > 0.0)) return;
    for (const double sign : {1.0, -1.0}) {
      const Vec3 n = sign / axis_length * axis;
      const double gap = Gap(near, n, from_);
      if (gap <= touch.distance) continue;
      touch.distance = gap;
      touch.u = n;
    }
  };
  const Vec3* a = corners.a;
  const Vec3* b = corners.b;
  consider((b[1] - b[0]).cross(b[2] - b[0]));
  consider((a[1] - a[0]).cross(a[2] - a[0]));
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      consider((a[(i + 1) % 3] - a[i]).cross(b[(j + 1) % 3] - b[j]));
    }
  }
  return touch;
}

bool MeshContact::TrianglesApart(NearPair& near) {
  const Touch& touch = TouchOf(near);
  const auto across = [&](const Plane& plane) {
    return HoldsAcross(near, touch.distance, plane, touch);
  };
  if (touch.plane.of != Plane::Of::kNone && across(touch.plane)) return true;
  const double least_old = LeastOld(touch.distance), least_new = LeastNew(touch.distance);
  const auto holds = [&](const Vec3& n) { return HoldsAlong(near, n, least_old, least_new); };
  if (holds(touch.u) || holds(NormalOf(near))) return true;
  bool held = false;
  ForEachFace(near, touch.nearest, [&](const Plane& plane) { held = held || across(plane); });
  if (held || !moved_) return held;
  const Corners corners = CornersAt(near.tool, near.object, to_);
  const NearestPoints nearest = NearestOfTriangles(corners.a, corners.b);
  if (nearest.squared > 0.0 && holds((nearest.p - nearest.q) / std::sqrt(nearest.squared))) {
    return true;
  }
  if (!touch.in_cone) return NeighbourHolds(near, touch.distance);
  return touch.plane.of == Plane::Of::kNone && across(ChoosePlane(near, touch));
}

/// Whether the plane of a contact keeps this pair apart too, which is out of its cones: it hinders
/// nothing that the contact does not.
bool MeshContact::NeighbourHolds(NearPair& near, double distance) {
  return std::any_of(touches_.begin(), touches_.end(), [&](const Touch& touch) {
    return touch.in_cone && touch.plane.of != Plane::Of::kNone &&
           HoldsAcross(near, distance, touch.plane, touch);
  });
}

/// Calls visit(plane) for the faces that meet at the nearest points, of either mesh, turned to look
/// from object to tool.
template <class Visit>
void MeshContact::ForEachFace(const NearPair& near, const NearestPoints& nearest,
                              Visit visit) const {
  const auto each = [&](const ContactMesh& mesh, HullTree::Node node, Feature of, auto use) {
    const std::uint32_t own = HullTree::TriangleOf(node);
    const ContactMesh::Triangle& t = mesh.triangles()[own];
    if (of.kind == Feature::kFace) {
      use(t.normal);
    } else {
      const auto faces = of.kind == Feature::kEdge ? mesh.FacesAtEdge(t.edge[of.index])
                                                   : mesh.FacesAtVertex(t.vertex[of.index]);
      for (std::uint32_t face : faces) use(mesh.triangles()[face].normal);
    }
  };
  const Vec3 away = nearest.p - nearest.q;
  each(objects_.mesh, near.object, nearest.of_q, [&](const Vec3& n) {
    if (n == Vec3::Zero()) return;
    Plane plane;
    plane.of = Plane::Of::kObject;
    plane.n = n.dot(away) < 0.0 ? Vec3(-n) : n;
    visit(plane);
  });
  each(tool_.mesh, near.tool, nearest.of_p, [&](const Vec3& n) {
    if (n == Vec3::Zero()) return;
    Plane plane;
    plane.of = Plane::Of::kTool;
    plane.n = (from_.R * n).dot(away) < 0.0 ? Vec3(-n) : n;
    visit(plane);
  });
}

MeshContact::Plane MeshContact::ChoosePlane(const NearPair& near, const Touch& touch) const {
  const Feature a = touch.nearest.of_p, b = touch.nearest.of_q;
  Plane plane;
  plane.of = Plane::Of::kObject;
  plane.n = touch.u;
  if (touch.distance <= 0.0) return plane;
  if (!touch.in_cone) {
    // The touch is a neighbour's: its face, where that separates this pair as well.
    const double least = LeastNew(touch.distance);
    double best = -kInfinity;
    ForEachFace(near, touch.nearest, [&](const Plane& face) {
      if (!(Gap(near, NormalAt(touch, face, from_), from_) >= least)) return;
      const double gap = Gap(near, NormalAt(touch, face, to_), to_);
      if (gap <= best) return;
      best = gap;
      plane = face;
    });
    if (best > -kInfinity) return plane;
  }
  if (b.kind == Feature::kVertex && a.kind != Feature::kVertex) {
    plane.of = Plane::Of::kTool;
    plane.n = from_.R.transpose() * touch.u;
  } else if (a.kind == Feature::kEdge && b.kind == Feature::kEdge) {
    const auto edge = [](const ContactMesh& mesh, HullTree::Node node, int i) -> Vec3 {
      const std::uint32_t t = HullTree::TriangleOf(node);
      return mesh.Corner(t, (i + 1) % 3) - mesh.Corner(t, i);
    };
    const Vec3 ea = from_.R * edge(tool_.mesh, near.tool, a.index);
    const Vec3 eb = edge(objects_.mesh, near.object, b.index);
    const Vec3 across = ea.cross(eb);
    if (across.squaredNorm() > kParallel * kParallel * ea.squaredNorm() * eb.squaredNorm()) {
      plane.of = Plane::Of::kEdges;
      plane.tool_edge = a.index;
      plane.object_edge = b.index;
      plane.sign = across.dot(touch.u) < 0.0 ? -1.0 : 1.0;
    }
  }
  return plane;
}

/// How the gap along a plane of crossing edges grows by a rotation at the trial, exactly: what is
/// lowest of the tool moves, and n turns with the tool's edge, while that and what is highest of
/// the object are d apart.  With w = (d - n (n . d)) / ((ea x eb) . n), that is
///   (x - p) x n + ea x (eb x w).
/// Where the edges themselves are nearest it is l x n, with l the lever of the place where they
/// cross.  At a trial that turns far a corner has come past them, and that lever is not its own: in
/// a peg's hole such a row shut the tool's own place out by 150 um.
Vec3 MeshContact::EdgesTurning(const Touch& touch, const Vec3& n) const {
  const Corners corners = CornersAt(touch.tool, touch.object, to_);
  // Where a corner is but as near as the edges, the touch is theirs.
  const auto farthest = [](const Vec3* corner, int edge, const Vec3& way) {
    Vec3 best = corner[edge];
    for (int c = 0; c < 3; ++c) {
      if (way.dot(corner[c] - best) > kWitness) best = corner[c];
    }
    return best;
  };
  const int i = touch.plane.tool_edge, j = touch.plane.object_edge;
  const Vec3 lowest = farthest(corners.a, i, -n);
  const Vec3 d = lowest - farthest(corners.b, j, n);
  const Vec3 ea = corners.a[(i + 1) % 3] - corners.a[i];
  const Vec3 eb = corners.b[(j + 1) % 3] - corners.b[j];
  const Vec3 w = (d - n.dot(d) * n) / ea.cross(eb).dot(n);
  return (lowest - to_.p).cross(n) + ea.cross(eb.cross(w));
}

/// The normal of a ball's row: that of the smooth surface that the mesh approximates.  The
/// right-hand side is that of the triangles, which the ball may not enter.
Vec3 MeshContact::SmoothedRow(const NearPair& near, const Vec3& n) const {
  if (tool_.radius == 0.0) return n;
  const Corners corners = CornersAt(near.tool, near.object, to_);
  const NearestPoints nearest = NearestOfTriangles(corners.a, corners.b);
  return objects_.mesh.SmoothNormal(HullTree::TriangleOf(near.object), nearest.q, n);
}

/// What a row asks for of a pair that has `before`.
double MeshContact::Asked(double before) const {
  return std::min(kSeparation, before + (regains_ ? kRegain : 0.0));
}

bool MeshContact::GiveUpRegain(ContactRows& rows) noexcept {
  if (!regains_) return false;
  regains_ = false;
  for (int row = 0; row < rows.count(); ++row) {
    const auto r = static_cast<std::size_t>(row);
    if (r < touch_of_row_.size() && touch_of_row_[r] >= 0)
      rows.SetGap(row, rows.gap(row) + regain_[r]);
  }
  return true;
}

/// The rows of a pair's plane, which are exact at the trial in value and in direction.  Returns how
/// many there are.
int MeshContact::RowsOf(const NearPair& near, const Touch& touch, PlaneRow (&of)[3]) const {
  const Plane& plane = touch.plane;
  const Vec3 n_old = NormalAt(touch, plane, from_), n_new = NormalAt(touch, plane, to_);
  // phi grows on the left of a rotation by phi: w . J_l(phi) dphi, with J_l = 1 + 1/2 [phi]x.
  const auto by_phi = [&](const Vec3& w) -> Vec3 { return w - 0.5 * phi_.cross(w); };
  if (plane.of == Plane::Of::kEdges) {
    const Vec3 lever = to_.R * (from_.R.transpose() * (touch.nearest.p - from_.p));
    const double before = Gap(near, n_old, from_), now = Gap(near, n_new, to_);
    const double loss = TurnLoss(plane, touch, n_old, n_new);
    const bool holds = std::min(before, now) - loss >= 0.5 * std::min(kFree, before);
    of[0] = {3,
             n_new,
             lever - tool_.radius * n_new,
             by_phi(EdgesTurning(touch, n_new)),
             before,
             holds ? now : std::min(now, LeastNew(touch.distance)) - loss};
    return 1;
  }
  const Corners old = CornersAt(near.tool, near.object, from_),
                now = CornersAt(near.tool, near.object, to_);
  const bool of_tool = plane.of == Plane::Of::kObject;
  const double plane_old = of_tool ? High(near.object, n_old) : Low(near.tool, n_old, from_);
  const double plane_new = of_tool ? plane_old : Low(near.tool, n_new, to_);
  const Vec3 along = SmoothedRow(near, n_new);
  const Vec3 down = of_tool ? Vec3(tool_.radius * n_new) : Vec3::Zero();
  const double sign = of_tool ? 1.0 : -1.0;
  const int corners = of_tool && tool_.radius > 0.0 ? 1 : 3;
  for (int c = 0; c < corners; ++c) {
    const Vec3 &corner_old = of_tool ? old.a[c] : old.b[c],
               &corner_new = of_tool ? now.a[c] : now.b[c];
    of[c] = {c,
             along,
             corner_old - from_.p - down,
             by_phi((corner_new - to_.p - down).cross(along)),
             sign * (n_old.dot(corner_old - down) - plane_old),
             sign * (n_new.dot(corner_new - down) - plane_new)};
  }
  return corners;
}

/// Adds or mends a row: a . x >= what it asks for at the trial, where the gap is `now`.
void MeshContact::SetRow(const NearPair& near, const PlaneRow& of, ContactRows& rows) {
  Touch& touch = touches_[static_cast<std::size_t>(near.touch)];
  int& row = touch.row[of.slot % 3];
  if (row < 0) {
    if (rows.count() >= rows.max_rows()) return;
    row = rows.count();
    rows.AddRow(of.n, of.lever, of.before, KeyOf(near.tool, near.object, of.slot));
    touch_of_row_.resize(static_cast<std::size_t>(rows.count()), -1);
    touch_of_row_[static_cast<std::size_t>(row)] = near.touch;
  }
  const double before = Gap(near, NormalAt(touch, touch.plane, from_), from_);
  const double asked = Asked(before);
  rows.SetRow(row, of.n, of.lever, of.by_turning,
              of.now - asked - of.n.dot(v_) - of.by_turning.dot(phi_));
  regain_[static_cast<std::size_t>(row)] = asked - std::min(kSeparation, before);
}

/// Puts the rows of a pair's plane: `all` those of the corners that touch, else those of the
/// corners that the trial leaves too low.
bool MeshContact::PutRows(const NearPair& near, bool all, ContactRows& rows) {
  const Touch& touch = touches_[static_cast<std::size_t>(near.touch)];
  PlaneRow of[3];
  const int count = RowsOf(near, touch, of);
  const double touching =
      kWitnessRatio * Gap(near, NormalAt(touch, touch.plane, from_), from_) + kWitness;
  const double least = LeastNew(touch.distance);
  bool put = false;
  for (int i = 0; i < count; ++i) {
    if (all ? of[i].before > touching : of[i].now >= least) continue;
    SetRow(near, of[i], rows);
    put = true;
  }
  return put;
}

MeshContact::NearPair& MeshContact::PairOf(const Touch& touch) {
  const auto index = static_cast<std::int32_t>(&touch - touches_.data());
  return *std::find_if(near_.begin(), near_.end(),
                       [&](const NearPair& near) { return near.touch == index; });
}

/// Takes a pair's rows out.
void MeshContact::TakeOut(Touch& touch, ContactRows& rows) {
  for (int& row : touch.row) {
    if (row >= 0) rows.Loosen(row);
    row = -1;
  }
}

/// A ball's row goes along the smooth surface's normal where the ball comes to, not where it was:
/// true where that is another direction, which the force would feel.  A crease is not smooth: the
/// ball goes straight past it, and round it in the next sub-steps (Turned).
bool MeshContact::TurnSmoothed(const NearPair& near, const Touch& touch, int row,
                               const NearestPoints& nearest, const Vec3& u, ContactRows& rows) {
  if (tool_.radius == 0.0) return false;
  const Vec3 along = objects_.mesh.SmoothNormal(HullTree::TriangleOf(near.object), nearest.q, u);
  if (along == u || (along - rows.normal(row)).norm() <= kTurned) return false;
  const double now = std::sqrt(nearest.squared) - tool_.radius;
  const double asked = Asked(touch.distance);
  rows.SetRow(row, along, rows.lever(row), now - asked - along.dot(v_));
  return true;
}

Mat3 MeshContact::CurvatureOf(int row) const noexcept {
  const auto r = static_cast<std::size_t>(row);
  if (tool_.radius == 0.0 || r >= touch_of_row_.size() || touch_of_row_[r] < 0) return Mat3::Zero();
  const Touch& touch = touches_[static_cast<std::size_t>(touch_of_row_[r])];
  const Feature of = touch.nearest.of_q;
  if (!touch.in_cone || of.kind == Feature::kFace) return Mat3::Zero();
  const ContactMesh& mesh = objects_.mesh;
  const std::uint32_t triangle = HullTree::TriangleOf(touch.object);
  const ContactMesh::Triangle& t = mesh.triangles()[triangle];
  const auto faces = of.kind == Feature::kEdge ? mesh.FacesAtEdge(t.edge[of.index])
                                               : mesh.FacesAtVertex(t.vertex[of.index]);
  const Vec3& u = touch.u;
  const bool flat = std::all_of(faces.begin(), faces.end(), [&](std::uint32_t face) {
    return mesh.triangles()[face].normal.cross(u).norm() <= kTurned;
  });
  if (flat || mesh.SmoothNormal(triangle, touch.nearest.q, u) != u) return Mat3::Zero();
  const double length = std::sqrt(touch.nearest.squared);
  if (of.kind == Feature::kVertex) return (Mat3::Identity() - u * u.transpose()) / length;
  const Vec3 edge = mesh.Corner(triangle, (of.index + 1) % 3) - mesh.Corner(triangle, of.index);
  const Vec3 across = edge.cross(u).normalized();
  return across * across.transpose() / length;
}

double MeshContact::Turned(const int* active, int actives, const ContactRows& rows) const noexcept {
  if (actives == 0) return 0.0;
  // The direction in which it touches is that of the nearest triangle: of one that it touches, but
  // for what a straight way is off an arc.
  const double touching = kTouching + 0.5 * v_.squaredNorm() / tool_.radius;
  double nearest = kInfinity;
  Vec3 u = Vec3::Zero();
  bool smooth = false;
  for (std::size_t k = 0; k < near_.size(); ++k) {
    const NearPair& near = near_[k];
    const bool may_touch = planes_.left[k] <= touching;
    if (!may_touch || near.split || !AreTriangles(near.tool, near.object)) continue;
    const Corners corners = CornersAt(near.tool, near.object, to_);
    const NearestPoints points = NearestOfTriangles(corners.a, corners.b);
    if (!(points.squared > 0.0 && points.squared < nearest)) continue;
    nearest = points.squared;
    u = (points.p - points.q) / std::sqrt(nearest);
    smooth = objects_.mesh.SmoothNormal(HullTree::TriangleOf(near.object), points.q, u) != u;
  }
  double least = kInfinity, most = 0.0;
  for (int i = 0; i < actives; ++i) {
    least = std::min(least, (u - rows.normal(active[i])).norm());
    most = std::max(most, (CurvatureOf(active[i]) * v_).norm());
  }
  // Where it is smooth, Retract has turned the rows.
  return smooth || !(nearest < kInfinity) ? most : std::max(least, most);
}

/// The touch whose row this is; null of leaves, and where the pair intersects.
MeshContact::Touch* MeshContact::TouchOfRow(int row) {
  const auto r = static_cast<std::size_t>(row);
  if (r >= touch_of_row_.size() || touch_of_row_[r] < 0) return nullptr;
  Touch& touch = touches_[static_cast<std::size_t>(touch_of_row_[r])];
  return touch.distance > 0.0 ? &touch : nullptr;
}

/// Calls mend(row, touch) for the active rows at the trial, and returns how many it changed.  Pairs
/// that meet at one corner have the same row each, and the QP takes one of them: where it changes
/// that, it is called for the others too, or they would come one a trial.
template <class Mend>
int MeshContact::MendRows(const int* active, int actives, const ContactRows& rows, Mend mend) {
  int changed = 0;
  const auto mend_row = [&](int row) {
    Touch* touch = TouchOfRow(row);
    return touch != nullptr && mend(row, *touch);
  };
  for (int i = 0; i < actives; ++i) changed += mend_row(active[i]) ? 1 : 0;
  if (changed == 0 || tool_.radius > 0.0) return changed;
  for (int row = 0; row < rows.count(); ++row) {
    if (rows.Left(row, v_, phi_) <= kWitness) mend_row(row);
  }
  return changed;
}

int MeshContact::Relinearise(const int* active, int actives, ContactRows& rows) noexcept {
  return MendRows(active, actives, rows, [&](int row, Touch& touch) {
    if (touch.relinearised) return false;
    const NearPair& near = PairOf(touch);
    PlaneRow of[3];
    const int count = RowsOf(near, touch, of);
    for (int k = 0; k < count; ++k) {
      if (touch.row[of[k].slot % 3] != row) continue;
      if (rows.Turned(row, of[k].n, of[k].by_turning) <= kTurned) return false;
      SetRow(near, of[k], rows);
      touch.relinearised = true;
    }
    return touch.relinearised;
  });
}

int MeshContact::Release(const int* active, int actives, ContactRows& rows) noexcept {
  released_.clear();
  return MendRows(active, actives, rows, [&](int row, Touch& touch) {
    // The pair is farther apart at the trial than its row says.
    const Corners corners = CornersAt(touch.tool, touch.object, to_);
    const double apart = std::sqrt(NearestOfTriangles(corners.a, corners.b).squared);
    const double gap = rows.Left(row, v_, phi_) + kSeparation;
    if (apart - tool_.radius <= kWitnessRatio * gap + kWitness) return false;
    for (int slot = 0; slot < 3; ++slot) {
      const int of = touch.row[slot];
      if (of >= 0) released_.push_back({&touch, slot, of, rows.gap(of)});
    }
    TakeOut(touch, rows);
    return true;
  });
}

void MeshContact::PutBack(ContactRows& rows) noexcept {
  for (const Released& released : released_) {
    int& row = released.touch->row[released.slot];
    if (row >= 0) rows.Loosen(row);  // of the trial that is given up
    row = released.row;
    rows.SetGap(row, released.gap);
  }
}

int MeshContact::Retract(const int* active, int actives, ContactRows& rows) noexcept {
  return MendRows(active, actives, rows, [&](int row, Touch& touch) {
    return !touch.retracted && Retract(row, touch, rows);
  });
}

bool MeshContact::Retract(int row, Touch& touch, ContactRows& rows) {
  NearPair& near = PairOf(touch);
  const Corners corners = CornersAt(near.tool, near.object, to_);
  const NearestPoints nearest = NearestOfTriangles(corners.a, corners.b);
  if (!(nearest.squared > 0.0)) return false;
  const double length = std::sqrt(nearest.squared);
  const Vec3 u = (nearest.p - nearest.q) / length;
  // The row's own point, at the trial.
  const double gap = rows.Left(row, v_, phi_) + kSeparation;
  if (InCone(near, nearest, u, to_) && gap <= kWitnessRatio * (length - tool_.radius) + kWitness) {
    return TurnSmoothed(near, touch, row, nearest, u, rows);
  }
  const Plane other = OtherPlane(near, touch, nearest, u);
  if (other.of == Plane::Of::kNone) return false;
  TakeOut(touch, rows);
  touch.plane = other;
  touch.retracted = true;
  return true;
}

/// The plane that a pair has most room along at the trial, of those that keep it apart at the
/// sub-step's beginning too; none where there is no other one.
MeshContact::Plane MeshContact::OtherPlane(const NearPair& near, const Touch& touch,
                                           const NearestPoints& nearest, const Vec3& u) const {
  Plane other;
  constexpr double kEnoughRoom = kSeparation - kWitness;
  double best = kEnoughRoom;
  const auto consider = [&](const Plane& plane) {
    if (plane.of == touch.plane.of && plane.n == touch.plane.n) return;
    if (!(Gap(near, NormalAt(touch, plane, from_), from_) > kEnoughRoom)) return;
    const double gap = Gap(near, NormalAt(touch, plane, to_), to_);
    if (gap <= best) return;
    best = gap;
    other = plane;
  };
  ForEachFace(near, touch.nearest, consider);
  ForEachFace(near, nearest, consider);
  for (const Vec3& n : {touch.u, u}) {
    Plane plane;
    plane.of = Plane::Of::kObject;
    plane.n = n;
    consider(plane);
    plane.of = Plane::Of::kTool;
    plane.n = from_.R.transpose() * n;
    consider(plane);
  }
  return other;
}

/// Merges pairs of the front that one plane keeps apart as a whole, with some room: one of the two
/// that keep their parts apart.  Where neither does, the pair is tried again when the tool has gone
/// as far as the better one lacks: no gap changes faster.
void MeshContact::Merge() {
  for (int i = 0; i < kBatch; ++i) {
    SeparationFront::Index index = front_->NextMergeable();
    if (index < 0) return;
    // A pair that has been merged may now be merged with its sibling.
    for (; index >= 0 && front_->IsMergeable(index); index = front_->pair(index).parent) {
      const SeparationFront::Pair& pair = front_->pair(index);
      ++tested_;
      Vec3 n;
      double gap = -kInfinity;
      for (int side = 0; side < 2; ++side) {
        const Vec3 along = front_->Normal(pair.child + side);
        const double here = Low(pair.tool, along, to_) - High(pair.object, along);
        if (here > gap) n = along;
        gap = std::max(here, gap);
      }
      if (!(gap >= kTouching)) {
        front_->RetryAfter(index, kTouching - gap);
        break;
      }
      front_->Merge(index, n, gap);
    }
  }
}

void MeshContact::RelineariseAtStart(ContactRows& rows) noexcept {
  Stay();
  for (const NearPair& near : near_) {
    if (near.split || near.touch < 0) continue;
    const Touch& touch = touches_[static_cast<std::size_t>(near.touch)];
    if (touch.plane.of == Plane::Of::kNone) continue;
    PlaneRow of[3];
    const int count = RowsOf(near, touch, of);
    for (int i = 0; i < count; ++i) {
      const int row = touch.row[of[i].slot % 3];
      if (row < 0) continue;
      SetRow(near, of[i], rows);
      rows.SetGap(row, std::max(rows.gap(row), 0.0));
    }
  }
}

void MeshContact::Stay() noexcept {
  to_ = from_;
  v_.setZero();
  phi_.setZero();
  moved_ = false;
}

void MeshContact::Accept() noexcept {
  // A pair that no closer look was taken at keeps the plane that the front has.
  for (const NearPair& near : near_) {
    if (!near.split && near.replaced) {
      front_->Set(near.index, NormalOf(near), planes_.slack[&near - near_.data()]);
    }
  }
  if (moved_) {
    front_->Move(to_, tool_.mesh.reach());
    for (std::size_t k = 0; k < near_.size(); ++k) {
      const NearPair& near = near_[k];
      if (near.looked_at == trial_ && !near.split)
        front_->Set(near.index, next_[k].n, next_[k].slack);
    }
  }
  Merge();
}

bool MeshContact::IsFree(const ToolPose& at) const {
  std::vector<std::pair<HullTree::Node, HullTree::Node>> left{
      {tool_.tree.root(), objects_.tree.root()}};
  while (!left.empty()) {
    const auto [tool, object] = left.back();
    left.pop_back();
    SeparatingPlane plane;
    if (FindPlane(PairOf(tool, object), {at, at}, Vec3::UnitZ(), kRounding, *kernels_, plane)) {
      continue;
    }
    if (AreTriangles(tool, object)) {
      const Corners corners = CornersAt(tool, object, at);
      const NearestPoints nearest = NearestOfTriangles(corners.a, corners.b);
      const double length = std::sqrt(nearest.squared);
      if (!(length > 0.0)) return false;
      const Vec3 n = (nearest.p - nearest.q) / length;
      if (!(Low(tool, n, at) - High(object, n) > kRounding)) {
        return false;
      }
    } else if (tool_.tree.IsLarger(tool, objects_.tree, object)) {
      for (HullTree::Node child : tool_.tree.inner(tool).child) left.emplace_back(child, object);
    } else {
      for (HullTree::Node child : objects_.tree.inner(object).child) left.emplace_back(tool, child);
    }
  }
  return true;
}

}  // namespace palpate
