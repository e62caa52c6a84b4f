#include "tests/support/hand_path.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <utility>

#include "common/error.h"
#include "common/math/rotation.h"
#include "tests/support/mesh_oracle.h"
#include "tests/support/random.h"

namespace palpate::test {
namespace {

constexpr double kStep = 1e-3;       // [s] between samples
constexpr double kQuickHand = 30.0;  // [m/s^2]

/// Returns the share of its path that a minimum-jerk move has covered at a share of its time.
double Gone(double u) {
  return u * u * u * (10.0 - 15.0 * u + 6.0 * u * u);
}

struct Bounds {
  Vec3 low = Vec3::Constant(INFINITY), high = Vec3::Constant(-INFINITY);
  void Add(const Vec3& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  Vec3 center() const { return 0.5 * (low + high); }
  double longest() const { return (high - low).maxCoeff(); }
};

/// Position of the tool's centre, and its rotation.
struct Place {
  Vec3 c = Vec3::Zero();
  Quat q = Quat::Identity();
};
Vec3 TurnFrom(const Quat& a, const Quat& b) {
  return RotationLog(b * a.conjugate());
}

/// A pose in which the tool touches, and the surface normal there.
struct Touch {
  Place place;
  Vec3 normal;   ///< from object to tool
  Vec3 on_tool;  ///< in W
};

/// A move from rest through given poses to rest.
struct Move {
  std::vector<Place> through;  ///< the first is where it begins
  double pace;                 ///< of the hand's speed
};

/// The curve of a move, parametrised by the share of its length.
class Curve {
 public:
  /// @param half_radius  length that stands for a rotation of one radian [m].
  Curve(const Move& move, double half_radius) : at_(move.through), along_(at_.size(), 0.0) {
    for (std::size_t i = 1; i < at_.size(); ++i) {
      const double v = (at_[i].c - at_[i - 1].c).norm();
      const double turn = half_radius * TurnFrom(at_[i - 1].q, at_[i].q).norm();
      along_[i] = along_[i - 1] + std::max(std::sqrt(v * v + turn * turn), 1e-12);
    }
    // Derivatives by length: approximately those of the parabola through three neighbours.
    for (std::size_t i = 0; i < at_.size(); ++i) {
      Speed speed{Vec3::Zero(), Vec3::Zero()};
      int sides = 0;
      for (const std::size_t k : {i, i + 1}) {
        if (k == 0 || k >= at_.size()) continue;
        const double length = along_[k] - along_[k - 1];
        speed.v += (at_[k].c - at_[k - 1].c) / length;
        speed.w += TurnFrom(at_[k - 1].q, at_[k].q) / length;
        ++sides;
      }
      speed.v /= std::max(1, sides);
      speed.w /= std::max(1, sides);
      speed_.push_back(speed);
    }
    // The greatest acceleration of the tool's centre if the whole move takes a second.
    constexpr int kLooks = 200;
    for (int i = 0; i < kLooks; ++i) {
      const auto at = [&](int k) { return At(Gone(static_cast<double>(k) / (kLooks + 1))).c; };
      const Vec3 bend = at(i) - 2.0 * at(i + 1) + at(i + 2);
      peak_ = std::max(peak_, bend.norm() * (kLooks + 1) * (kLooks + 1));
    }
  }
  double length() const { return along_.back(); }
  /// Returns the duration of the move [s] at a mean speed, with a limited acceleration.
  double Duration(double speed, double acceleration) const {
    return std::max(length() / speed, std::sqrt(peak_ / acceleration));
  }
  Place At(double share) const {
    const double s = std::clamp(share, 0.0, 1.0) * length();
    std::size_t k = 1;
    while (k + 1 < at_.size() && along_[k] < s) ++k;
    if (at_.size() < 2) return at_.front();
    const double span = along_[k] - along_[k - 1];
    const double u = std::clamp((s - along_[k - 1]) / span, 0.0, 1.0);
    // Cubic Hermite splines, relative to the previous pose.
    const double begin = u * (1.0 - u) * (1.0 - u) * span, value = u * u * (3.0 - 2.0 * u),
                 end = u * u * (u - 1.0) * span;
    const auto blend = [&](const Vec3& v0, const Vec3& way, const Vec3& v1) {
      return Vec3(begin * v0 + value * way + end * v1);
    };
    const Place &a = at_[k - 1], &b = at_[k];
    const Speed &at_a = speed_[k - 1], &at_b = speed_[k];
    const Vec3 turn = blend(at_a.w, TurnFrom(a.q, b.q), at_b.w);
    return {a.c + blend(at_a.v, b.c - a.c, at_b.v), (RotationExp(turn) * a.q).normalized()};
  }

 private:
  struct Speed {
    Vec3 v, w;
  };
  std::vector<Place> at_;
  std::vector<double> along_;
  std::vector<Speed> speed_;
  double peak_ = 0.0;
};

class HandMaker {
 public:
  HandMaker(const Scene& scene, const HandOptions& options)
      : scene_(scene), options_(options), oracle_(scene), random_(options.seed) {
    const Body& tool = scene.tools.front();
    Bounds of_tool;
    if (tool.tree.leaves() == 1) {
      const Vec3 center(tool.tree.leaf_x[0], tool.tree.leaf_y[0], tool.tree.leaf_z[0]);
      tool_radius_ = tool.tree.leaf_radius[0];
      of_tool.Add(center - Vec3::Constant(tool_radius_));
      of_tool.Add(center + Vec3::Constant(tool_radius_));
    } else {
      for (const Vec3& v : tool.mesh.vertices) of_tool.Add(v);
      for (const Vec3& v : tool.mesh.vertices) {
        tool_radius_ = std::max(tool_radius_, (v - of_tool.center()).norm());
      }
    }
    middle_ = of_tool.center();
    Bounds of_objects;
    for (const Body& body : scene.objects) {
      for (const Vec3& v : body.mesh.vertices) of_objects.Add(body.X_WB * v);
      triangles_ += body.mesh.triangles.size();
    }
    if (triangles_ == 0) throw Error("hands: the scene's objects have no triangles to touch");
    scene_middle_ = of_objects.center();
    scene_radius_ = 0.5 * (of_objects.high - of_objects.low).norm();
    size_ = std::min(of_tool.longest(), of_objects.longest());
    scale_ = size_ < 0.01 ? size_ / 0.01 : size_ > 1.0 ? size_ : 1.0;
  }

  std::vector<Pose> Make() {
    const double wanted = options_.speed * kStep * static_cast<double>(options_.steps);
    while (length_ < 1.05 * wanted || moves_.empty()) Visit();
    return Sample(wanted);
  }

 private:
  double Mm(double mm) const { return 1e-3 * scale_ * mm; }
  double MmBetween(double low, double high) { return Mm(random_.Uniform(low, high)); }
  double Press() { return MmBetween(0.5 * options_.press_mm, options_.press_mm); }
  double HalfRadius() const { return 0.5 * tool_radius_; }
  Pose PoseOf(const Place& place) const { return {place.c - place.q * middle_, place.q}; }
  bool Free(const Place& place) const { return !oracle_.Meet(PoseOf(place)); }

  void Go(std::vector<Place> through, double pace) {
    through.insert(through.begin(), here_);
    here_ = through.back();
    moves_.push_back({std::move(through), pace});
    length_ += Curve(moves_.back(), HalfRadius()).length();
  }

  /// Moves in a direction from a free pose to the first touch, at most `reach` away.
  std::optional<Touch> Advance(Place place, const Vec3& along, double reach) const {
    const double near = Mm(0.001);
    double gone = 0.0;
    for (int i = 0; i < 400 && gone <= reach; ++i) {
      const MeshOracle::Gap gap = oracle_.Distance(PoseOf(place));
      if (gap.distance == 0.0) return std::nullopt;
      if (gap.distance < near) {
        return Touch{place, (gap.on_tool - gap.on_object).normalized(), gap.on_tool};
      }
      place.c += gap.distance * along;
      gone += gap.distance;
    }
    return std::nullopt;
  }

  /// Returns the touch below a pose: moves along the normal until the tool is free, and back down.
  std::optional<Touch> TouchBelow(const Place& place, const Vec3& normal) const {
    for (double lift = Mm(4.0); lift <= Mm(33.0); lift *= 2.0) {
      const Place raised{place.c + lift * normal, place.q};
      if (Free(raised)) return Advance(raised, -normal, lift + Mm(12.0));
    }
    return std::nullopt;
  }

  Place Pressed(const Touch& touch, double depth) const {
    return {touch.place.c - depth * touch.normal, touch.place.q};
  }

  Vec3 PlaceOnObjects() {
    auto at = static_cast<std::size_t>(random_.Bits() % triangles_);
    for (const Body& body : scene_.objects) {
      if (at < body.mesh.triangles.size()) return body.X_WB * MiddleOf(body.mesh, at);
      at -= body.mesh.triangles.size();
    }
    return scene_middle_;
  }
  static Vec3 MiddleOf(const TriangleMesh& mesh, std::size_t triangle) {
    const auto& t = mesh.triangles[triangle];
    return (mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]) / 3.0;
  }

  /// Returns a free pose above a touch that a straight path reaches from outside the scene.
  /// @param near  prefers a touch near this pose; null: anywhere.
  std::pair<Place, Touch> Approach(const Place* near) {
    const TriangleMesh& mesh = scene_.tools.front().mesh;
    std::optional<std::pair<Place, Touch>> best;
    double best_length = INFINITY;
    int found = 0;
    for (int tries = 0; tries < 200 && found < (near != nullptr ? 3 : 1); ++tries) {
      const Vec3 from = random_.Direction();
      Quat q = random_.Rotation();
      if (near != nullptr)
        q = RotationExp(random_.Uniform(0.0, 1.5) * random_.Direction()) * near->q;
      const Vec3 on_tool =
          mesh.triangles.empty()
              ? middle_
              : MiddleOf(mesh, static_cast<std::size_t>(random_.Bits() % mesh.triangles.size()));
      const Vec3 aim = PlaceOnObjects() - q * (on_tool - middle_);
      // Outside: no part of the tool is in the ball round the objects.
      const double away = 2.0 * (scene_radius_ + tool_radius_);
      const Place outside{aim + away * from, q};
      const std::optional<Touch> touch = Advance(outside, -from, 2.0 * away);
      // At a grazing touch the hand would press past the object.
      if (!touch || touch->normal.dot(from) < 0.3) continue;
      ++found;
      const Place above{touch->place.c + std::min(Mm(20.0), away) * from, q};
      const double length = near == nullptr ? 0.0 : (above.c - near->c).norm();
      if (length < best_length) {
        best_length = length;
        best = {above, *touch};
      }
    }
    if (!best) throw Error("hands: no place of the objects that the tool could come to was found");
    return *best;
  }

  /// Moves through free space, around obstacles.
  void Travel(const Place& to) {
    const auto clear = [&](const Place& a, const Place& b) {
      constexpr int kLooks = 12;
      const Vec3 turn = TurnFrom(a.q, b.q);
      for (int i = 1; i < kLooks; ++i) {
        const double share = static_cast<double>(i) / kLooks;
        if (!Free({a.c + share * (b.c - a.c), RotationExp(share * turn) * a.q})) return false;
      }
      return true;
    };
    if (clear(here_, to)) {
      Go({to}, 3.0);
      return;
    }
    const Quat half = RotationExp(0.5 * TurnFrom(here_.q, to.q)) * here_.q;
    const Vec3 middle = 0.5 * (here_.c + to.c);
    Vec3 out = middle - scene_middle_;
    out = out.norm() > Mm(1.0) ? Vec3(out.normalized()) : random_.Direction();
    const double step = 0.25 * (scene_radius_ + tool_radius_);
    for (int i = 1; i <= 8; ++i) {
      const Place over{middle + i * step * out, half};
      if (!Free(over) || ((!clear(here_, over) || !clear(over, to)) && i < 8)) continue;
      Go({over, to}, 3.0);
      return;
    }
    Go({to}, 3.0);  // a hand may also miss the way, and pass through objects
  }

  // ---- the actions of a hand in contact

  void Slide(Touch& touch, double depth) {
    Vec3 along = random_.Direction();
    const double length = std::clamp(random_.Uniform(0.05, 0.25) * size_, Mm(4.0), Mm(40.0));
    const int places = std::max(2, static_cast<int>(length / Mm(4.0)));
    std::vector<Place> through;
    for (int i = 0; i < places; ++i) {
      along -= along.dot(touch.normal) * touch.normal;
      if (along.norm() < 0.1) break;
      along.normalize();
      const Place next{touch.place.c + length / places * along, touch.place.q};
      const std::optional<Touch> found = TouchBelow(next, touch.normal);
      if (!found) {
        // Slides over an edge and on through the air.
        through.push_back({next.c - depth * touch.normal, next.q});
        break;
      }
      touch = *found;
      through.push_back(Pressed(touch, depth));
    }
    if (!through.empty()) Go(through, 1.0);
  }

  void Turn(Touch& touch, double depth) {
    const Vec3 axis = random_.Direction();
    const double angle = random_.Uniform(0.15, 0.7);  // up to 40 degrees
    const int places = std::max(2, static_cast<int>(angle / 0.1));
    std::vector<Place> through;
    for (int i = 0; i < places; ++i) {
      const Quat turn = RotationExp(angle / places * axis);
      const Place next{touch.on_tool + turn * (touch.place.c - touch.on_tool),
                       (turn * touch.place.q).normalized()};
      const std::optional<Touch> found = TouchBelow(next, touch.normal);
      if (!found) break;
      touch = *found;
      through.push_back(Pressed(touch, depth));
    }
    if (!through.empty()) Go(through, 1.0);
  }

  void Squeeze(const Touch& touch, double depth) {
    // Moves to one side, against what is there, and to and fro.
    Vec3 side = random_.Direction();
    side -= side.dot(touch.normal) * touch.normal;
    const Place pressed = Pressed(touch, depth);
    std::vector<Place> through;
    const int places = 3 + random_.Below(5);
    for (int i = 0; i < places; ++i) {
      const Vec3 offset =
          MmBetween(0.0, 6.0) * side + random_.InCube(Mm(1.0)) - MmBetween(0.0, 2.0) * touch.normal;
      const Quat turn = RotationExp(random_.Uniform(0.0, 0.12) * random_.Direction());
      through.push_back({pressed.c + offset, (turn * pressed.q).normalized()});
    }
    through.push_back(pressed);
    Go(through, 0.7);
  }

  void Tap(const Touch& touch) {
    const int taps = 2 + random_.Below(3);
    for (int i = 0; i < taps; ++i) {
      Go({{touch.place.c + MmBetween(3.0, 8.0) * touch.normal, touch.place.q}}, 1.5);
      Go({Pressed(touch, Press())}, 1.5);
    }
  }

  void Leave(const Touch& touch) {
    double way = 0.0;
    for (const double mm : {2.0, 5.0, 10.0, 20.0}) {
      if (!Free({touch.place.c + Mm(mm) * touch.normal, touch.place.q})) break;
      way = Mm(mm);
    }
    Go({{touch.place.c + way * touch.normal, touch.place.q}}, 1.0);
  }

  /// One visit, from approach to leave.
  void Visit() {
    const bool anywhere = random_.Uniform(0.0, 1.0) < 0.3;
    const auto [above, first] = Approach(anywhere || moves_.empty() ? nullptr : &here_);
    if (moves_.empty()) {
      here_ = above;  // start of the hand
    } else {
      Travel(above);
    }
    Touch touch = first;
    double depth = Press();
    Go({touch.place, Pressed(touch, depth)}, 1.0);
    const int actions = 5 + random_.Below(6);
    for (int i = 0; i < actions; ++i) {
      depth = Press();
      switch (random_.Below(4)) {
        case 0:
          Slide(touch, depth);
          break;
        case 1:
          Turn(touch, depth);
          break;
        case 2:
          Squeeze(touch, depth);
          break;
        default:
          Tap(touch);
      }
    }
    Leave(touch);
  }

  std::vector<Pose> Sample(double wanted) const {
    std::vector<Curve> curves;
    for (const Move& move : moves_) curves.emplace_back(move, HalfRadius());
    // The speed at which the wanted length takes the wanted time, which compensates for slow moves.
    double acceleration = kQuickHand;
    const auto time_at = [&](double pace) {
      double time = 0.0, left = wanted;
      for (std::size_t i = 0; i < curves.size() && left > 0.0; ++i) {
        const double share = std::min(1.0, left / curves[i].length());
        time += share * curves[i].Duration(pace * moves_[i].pace * options_.speed, acceleration);
        left -= curves[i].length();
      }
      return time;
    };
    const double wanted_time = kStep * static_cast<double>(options_.steps);
    double low = 0.1, high = 8.0;
    while (time_at(high) > wanted_time) acceleration *= 1.25;
    for (int i = 0; i < 60; ++i) {
      const double pace = 0.5 * (low + high);
      (time_at(pace) > wanted_time ? low : high) = pace;
    }
    std::vector<Pose> poses;
    double begun = 0.0;
    std::size_t at = 0;
    for (int i = 0; i < options_.steps; ++i) {
      const double time = kStep * i;
      const auto duration = [&] {
        return curves[at].Duration(high * moves_[at].pace * options_.speed, acceleration);
      };
      while (at + 1 < curves.size() && time - begun >= duration()) {
        begun += duration();
        ++at;
      }
      const double u = std::clamp((time - begun) / duration(), 0.0, 1.0);
      poses.push_back(PoseOf(curves[at].At(Gone(u))));
    }
    return poses;
  }

  const Scene& scene_;
  const HandOptions options_;
  const MeshOracle oracle_;
  Random random_;
  Vec3 middle_, scene_middle_;
  double tool_radius_ = 0.0, scene_radius_ = 0.0, size_ = 0.0, scale_ = 1.0;
  std::size_t triangles_ = 0;
  Place here_;
  std::vector<Move> moves_;
  double length_ = 0.0;
};

}  // namespace

std::vector<Pose> MakeHand(const Scene& scene, const HandOptions& options) {
  if (options.steps < 1 || !(options.speed > 0.0) || !(options.press_mm > 0.0)) {
    throw Error("hands: give a speed, a depth to press and a number of steps above 0");
  }
  return HandMaker(scene, options).Make();
}

}  // namespace palpate::test
