#include "server/offer/generated_hand.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "common/math/random.h"
#include "scenes/mesh/mesh_query.h"
#include "server/physics/haptic_step.h"
#include "server/physics/start_pose.h"

namespace palpate {
namespace {

// In mm of an object of 10 mm to 1 m.
/// A hand is soft (135 N/m) and an arm has friction (0.2 N): a simulated one presses only if its
/// path leads deeper than 1.5 mm.
constexpr double kPress = 3.0;
constexpr double kSlideLeast = 2.0, kSlideMost = 40.0;
constexpr double kSlideShare = 0.2;  ///< of the objects' longest side
constexpr int kSlidePlaces = 4;      ///< the hand rests at each, so there are few
constexpr double kOutside = 10.0;    ///< where it begins if the tool touches at the start
constexpr double kStride = 0.1;      ///< motion of the hand in a cycle: 0.1 m/s
/// Stretch of the spring at which the tool counts as touching, and as pressed: something soft gives
/// way by most of a millimetre.
constexpr double kTouches = 0.01, kPushes = 0.02;

// Speeds in mm/s for such an object, and the shortest time of a movement [s].
constexpr double kComes = 40.0, kSlides = 15.0;
constexpr double kLeast_s = 0.5;
/// A station's session takes a moment to begin.  A hand that pressed earlier would be inside the
/// object when forces begin, and they would rise slowly on it.
constexpr double kWaits_s = 1.5;

constexpr int kSettle = 60;                 ///< cycles
constexpr std::size_t kToolSamples = 2000;  ///< vertices of the tool that are tried
                                            ///< for the nearest face

/// A pose at which the tool touches.
struct Touch {
  Vec3 p;       ///< origin of the hand's frame, at the surface, in W
  Vec3 normal;  ///< pointing out of the object
};

/// The vector from the tool's surface, at a pose, to the objects' nearest point.
struct Way {
  double distance = INFINITY;
  Vec3 along = Vec3::Zero();  ///< unit vector
};

class HandWalk {
 public:
  HandWalk(const Scene& scene, const Body& tool, const HapticModel& model, std::uint64_t seed)
      : scene_(scene), tool_(tool), model_(model), workspace_(model), state_(model), random_(seed) {
    Eigen::AlignedBox3d box;
    for (const Body& body : scene.objects) {
      for (const Vec3& v : body.mesh.vertices) box.extend(body.X_WB * v);
    }
    size_ = box.isEmpty() ? 0.0 : box.sizes().maxCoeff();
    scale_ = size_ < 0.01 ? size_ / 0.01 : size_ > 1.0 ? size_ : 1.0;
    // The walk needs the surfaces, not the drag on the hand.
    state_.friction.suspended = true;
    state_.effects = {};
  }

  std::optional<PoseScript> Make() {
    if (!(size_ > 0.0)) return std::nullopt;
    const Pose start = Outside();
    q_ = start.q;
    const Way way = NearestFace(start);
    if (!way.along.allFinite() || way.along.isZero(0.0)) return std::nullopt;
    state_.X_WG = state_.X_WH = hand_ = start;
    const std::optional<Touch> first = Approach(way);
    if (!first) return std::nullopt;
    const std::vector<Touch> slide = Slide(*first);
    return Script(start.p, *first, slide);
  }

 private:
  double Mm(double mm) const { return 1e-3 * scale_ * mm; }
  double PushOf(const StepReport& report) const {
    return report.wrench.force.norm() / model_.parameters().stiffness;
  }

  bool Free(const Pose& X) { return ResolveStart(model_, X, workspace_).depth == 0.0; }

  /// Returns where the scene places the tool, if it is free there; otherwise a place outside of
  /// what it is in.
  Pose Outside() {
    const StartPose placed = ResolveStart(model_, tool_.X_WB, workspace_);
    if (placed.depth == 0.0) return placed.X_WG;
    const Vec3 out = (placed.X_WG.p - tool_.X_WB.p).normalized();
    for (double mm = kOutside; mm > 0.1 * kOutside; mm *= 0.5) {
      const Pose away{placed.X_WG.p + Mm(mm) * out, placed.X_WG.q};
      if (Free(away)) return away;
    }
    return placed.X_WG;
  }

  /// Returns points of the tool's surface, in its frame.
  std::vector<Vec3> ToolPoints() const {
    if (model_.is_ball()) return {tool_.tree.centroid};  // felt as a ball
    const std::vector<Vec3>& all = tool_.mesh.vertices;
    std::vector<Vec3> some;
    const std::size_t stride = 1 + all.size() / kToolSamples;
    for (std::size_t i = 0; i < all.size(); i += stride) some.push_back(all[i]);
    return some;
  }

  Way NearestFace(const Pose& X_WT) const {
    Way best;
    const std::vector<Vec3> points = ToolPoints();
    for (const Body& body : scene_.objects) {
      if (body.mesh.triangles.empty()) continue;
      const MeshQuery query(body.mesh);
      const Pose X_BT = body.X_WB.Inverse() * X_WT;
      for (const Vec3& point : points) {
        const Vec3 at = X_BT * point;
        const MeshQuery::Hit hit = query.Nearest(at, best.distance);
        if (hit.triangle == MeshQuery::kNone || !(hit.distance > 0.0)) continue;
        best = {hit.distance, body.X_WB.q * ((hit.point - at) / hit.distance)};
      }
    }
    return best;
  }

  StepReport MoveTo(const Vec3& p) {
    const Vec3 way = p - hand_.p;
    const int cycles = std::max(1, static_cast<int>(std::ceil(way.norm() / Mm(kStride))));
    StepReport report;
    for (int i = 1; i <= cycles + kSettle; ++i) {
      const double share = std::min(1.0, static_cast<double>(i) / cycles);
      report = HapticStep(model_, {hand_.p + share * way, q_}, state_, workspace_);
    }
    hand_.p = p;
    return report;
  }

  /// Moves straight on until something pushes back, then presses.
  std::optional<Touch> Approach(const Way& way) {
    const double reach = way.distance + size_ + Mm(kOutside);
    const Vec3 from = hand_.p;
    for (double gone = 0.0; gone < reach; gone += Mm(kStride)) {
      hand_.p = from + gone * way.along;
      const StepReport report = HapticStep(model_, hand_, state_, workspace_);
      if (PushOf(report) > Mm(kTouches)) return Press(report);
    }
    return std::nullopt;
  }

  /// Presses along the normal of the push, and again along the one that it then has.
  std::optional<Touch> Press(const StepReport& touching) {
    Touch touch = TouchOf(touching);
    const StepReport pressed = MoveTo(touch.p - Mm(kPress) * touch.normal);
    if (PushOf(pressed) < Mm(kPushes)) return std::nullopt;
    return touch;
  }

  /// The hand does not turn with the graphic tool, so the place of its centroid counts.
  Touch TouchOf(const StepReport& report) const {
    const Vec3& c = model_.reference();
    return {report.X_WG * c - q_ * c, report.wrench.force.normalized()};
  }

  /// Returns further touching poses, one after the other; ends where there is nothing to press on.
  std::vector<Touch> Slide(const Touch& first) {
    const double length =
        std::clamp(kSlideShare * size_, Mm(kSlideLeast), Mm(kSlideMost)) / kSlidePlaces;
    std::vector<Touch> places;
    Touch at = first;
    Vec3 along = random_.Direction();
    for (int i = 0; i < kSlidePlaces; ++i) {
      along -= along.dot(at.normal) * at.normal;
      if (along.norm() < 0.1) along = at.normal.unitOrthogonal();
      along.normalize();
      const StepReport report = MoveTo(at.p + length * along - Mm(kPress) * at.normal);
      if (PushOf(report) < Mm(kPushes)) break;  // over an edge
      at = TouchOf(report);
      MoveTo(Pressed(at));
      places.push_back(at);
    }
    return places;
  }

  Vec3 Pressed(const Touch& touch) const { return touch.p - Mm(kPress) * touch.normal; }

  PoseScript Script(const Vec3& start, const Touch& first, const std::vector<Touch>& slide) const {
    std::vector<PoseScript::Key> keys{{0.0, {start, q_}, "wait"},
                                      {kWaits_s, {start, q_}, "approach"}};
    const auto go = [&](const Vec3& p, double speed, const char* then) {
      const double time = (p - keys.back().X_WH.p).norm() / Mm(speed);
      keys.push_back({keys.back().t + std::max(kLeast_s, time), {p, q_}, then});
    };
    go(first.p, kComes, "press");
    go(Pressed(first), kSlides, slide.empty() ? "lift" : "slide");
    for (const Touch& touch : slide) go(Pressed(touch), kSlides, "slide");
    for (std::size_t i = slide.size(); i-- > 1;) go(Pressed(slide[i - 1]), kSlides, "slide");
    if (!slide.empty()) go(Pressed(first), kSlides, "lift");
    go(first.p, kSlides, "lift");
    go(start, kComes, "lift");
    return PoseScript(std::move(keys));
  }

  const Scene& scene_;
  const Body& tool_;
  const HapticModel& model_;
  StepWorkspace workspace_;
  StepState state_;
  Random random_;
  double size_ = 0.0, scale_ = 1.0;
  Quat q_ = Quat::Identity();
  Pose hand_;
};

}  // namespace

std::optional<PoseScript> MakeHandFor(const Scene& scene, const Body& tool,
                                      const HapticModel& model, std::uint64_t seed) {
  return HandWalk(scene, tool, model, seed).Make();
}

}  // namespace palpate
