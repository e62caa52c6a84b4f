#include "server/physics/rows/surface_prediction.h"

#include <algorithm>
#include <cmath>

#include "server/physics/stage_clock.h"

namespace palpate {
namespace {

/// A point whose reach is beyond this times that of the patch's own points is left to the other
/// side's.  The tool's points come first, so that every touch is somebody's: where a tool's point
/// is too coarse, its patch is at least as coarse, and the object's point fine enough.
constexpr double kToolCoarser = 1.5, kObjectCoarser = 1.0;
/// Creases that cross at less than this sine meet along their length: their ends do.
constexpr double kParallel = 0.05;
/// How far a direction may leave the cone of the directions in which a crease can touch.
constexpr double kConeSlack = 0.02;

/// Row between two creases, where they can touch.
struct CreaseRow {
  Vec3 normal, lever;
  double gap;
};

/// Whether n, a unit vector towards the tool, leads away from the object's two faces and into the
/// tool's.
bool IsOutward(const Vec3& n, const CreaseSegment& tool, const CreaseSegment& object,
               const Mat3& R_WG) {
  return n.dot(object.t0) <= kConeSlack && n.dot(object.t1) <= kConeSlack &&
         n.dot(R_WG * tool.t0) >= -kConeSlack && n.dot(R_WG * tool.t1) >= -kConeSlack;
}

/// Calls add(row) for the rows of two creases: where they cross, or, of two that run beside each
/// other, at the ends of either along the other.
template <class Add>
void CreaseRows(const CreaseSegment& tool, const CreaseSegment& object, const Mat3& R_WG,
                const Vec3& p_W, const Add& add) {
  const Vec3 a = R_WG * tool.a, da = R_WG * tool.d;
  const Vec3& db = object.d;
  const Vec3 across = da.cross(db), r = a + p_W - object.a;
  const double across2 = across.squaredNorm(), aa = da.squaredNorm(), bb = db.squaredNorm();
  if (!(across2 > kParallel * kParallel * aa * bb)) {
    const auto beside = [&](double s, double t) {
      if (!(s >= 0.0 && s <= 1.0 && t >= 0.0 && t <= 1.0)) return;
      const Vec3 away = r + s * da - t * db;
      const double gap = away.norm();
      // Of two that touch, the direction between their faces.
      const Vec3 n = gap > 1e-9 ? Vec3(away / gap) : Vec3(-(object.t0 + object.t1).normalized());
      if (IsOutward(n, tool, object, R_WG)) add(CreaseRow{n, a + s * da, gap});
    };
    for (const double s : {0.0, 1.0}) beside(s, (r + s * da).dot(db) / bb);
    for (const double t : {0.0, 1.0}) beside((t * db - r).dot(da) / aa, t);
    return;
  }
  const double s = -across.dot(r.cross(db)) / across2, t = -across.dot(r.cross(da)) / across2;
  constexpr double kEnd = 0.01;
  if (!(s >= -kEnd && s <= 1.0 + kEnd && t >= -kEnd && t <= 1.0 + kEnd)) return;
  Vec3 n = across / std::sqrt(across2);
  if (!IsOutward(n, tool, object, R_WG)) {
    n = -n;
    if (!IsOutward(n, tool, object, R_WG)) return;
  }
  const Vec3 lever = a + s * da;
  const double gap = (lever + p_W - object.a - t * db).dot(n);
  if (gap * gap > 0.01 * std::min(aa, bb) && gap < 0.0) return;  // not of these two
  add(CreaseRow{n, lever, gap});
}

std::optional<CreaseRow> BallRow(const Vec3& centre, double radius, const CreaseSegment& object,
                                 const Vec3& p_W) {
  const Vec3 r = centre - object.a;
  const double t = std::clamp(r.dot(object.d) / object.d.squaredNorm(), 0.0, 1.0);
  const Vec3 away = r - t * object.d;
  const double distance = away.norm();
  if (!(distance > 0.5 * radius)) return std::nullopt;
  const Vec3 n = away / distance;
  if (n.dot(object.t0) > kConeSlack || n.dot(object.t1) > kConeSlack) return std::nullopt;
  return CreaseRow{n, centre - p_W - radius * n, distance - radius};
}

}  // namespace

SurfacePrediction::SurfacePrediction(const ToolSurface& tool, const ObjectSurfaces& objects)
    : tool_(tool), objects_(objects), near_(PairQuery::kMaxBatch) {
  if (tool.point_tree && objects.patch_forest) {
    point_on_patch_.emplace(*tool.point_tree, *objects.patch_forest);
  }
  if (tool.patch_tree && objects.point_forest) {
    patch_on_point_.emplace(*tool.patch_tree, *objects.point_forest);
  }
  if (tool.crease_tree && objects.crease_forest) {
    creases_.emplace(*tool.crease_tree, *objects.crease_forest);
  }
}

std::int64_t SurfacePrediction::tested() const {
  std::int64_t sum = candidates_;
  for (const auto* query : {&point_on_patch_, &patch_on_point_, &creases_}) {
    if (query->has_value()) sum += (*query)->tested();
  }
  return sum;
}

void SurfacePrediction::Predict(const Kernels& kernels, const Mat3& R_WG, const Vec3& p_W,
                                const StepBounds& bounds, double max_depth, double recovery,
                                int degrees_of_freedom, double rho, ContactRows& rows,
                                StageTimes* times) noexcept {
  StageClock clock(times);
  const int first_row = rows.count();
  SurfaceFrames frames{};
  frames.radius = tool_.radius;
  frames.max_translation = bounds.translation;
  // With 3 degrees of freedom a rotation moves no point of the ball's surface that matters.
  frames.max_rotation = degrees_of_freedom == 6 ? bounds.rotation : 0.0;
  frames.inverse_rho = 1.0 / rho;
  frames.max_depth = max_depth;
  frames.facing = std::isfinite(max_depth) ? 0.0 : 4.0;
  frames.max_lever = tool_.max_lever;
  const auto put = [](double* to, const auto& m) {
    for (int r = 0; r < m.rows(); ++r) {
      for (int c = 0; c < m.cols(); ++c) to[r * m.cols() + c] = m(r, c);
    }
  };
  const auto run = [&](PairQuery& query, RowKind kind) {
    const bool of_tool = kind == RowKind::kPointOnPatch;
    const SurfacePoint* points = (of_tool ? tool_.points : objects_.points).data();
    const SurfacePatch* patches = (of_tool ? objects_.patches : tool_.patches).data();
    const PatchDisc* discs = (of_tool ? objects_.discs : tool_.discs).data();
    const int first = rows.count();
    query.Run(kernels, R_WG, p_W, bounds, [&](const NodePair* pairs, int count) {
      clock.Lap(&StageTimes::prediction);
      candidates_ += count;
      const int near = kernels.near_patches(points, discs, frames, pairs, count, near_.data());
      rows.AddSurface(kernels, points, patches, frames, near_.data(), near,
                      static_cast<std::int32_t>(kind) << kRowKindShift);
      clock.Lap(&StageTimes::rows);
      return true;
    });
    if (tool_.radius > 0.0) return;  // a ball beside a crease has a foot on one of its sides alone
    rows.KeepNearest(first, of_tool, discs, of_tool ? objects_.patch_object.data() : nullptr);
  };
  if (point_on_patch_) {
    put(frames.M, R_WG);
    put(frames.o, p_W);
    put(frames.Q, Mat3(Mat3::Identity()));
    put(frames.c, Vec3(-p_W));
    frames.side = 1.0;
    frames.coarser = kToolCoarser;
    run(*point_on_patch_, RowKind::kPointOnPatch);
  }
  if (patch_on_point_) {
    put(frames.M, Mat3(R_WG.transpose()));
    put(frames.o, Vec3(-(R_WG.transpose() * p_W)));
    put(frames.Q, R_WG);
    put(frames.c, Vec3(Vec3::Zero()));
    frames.side = -1.0;
    frames.coarser = kObjectCoarser;
    run(*patch_on_point_, RowKind::kPatchOnPoint);
  }
  if (creases_) {
    const bool ball = tool_.radius > 0.0;
    const RowKind kind = ball ? RowKind::kBallOnCrease : RowKind::kCreases;
    const std::int32_t tag = static_cast<std::int32_t>(kind) << kRowKindShift;
    creases_->Run(kernels, R_WG, p_W, bounds, [&](const NodePair* pairs, int count) {
      clock.Lap(&StageTimes::prediction);
      for (int i = 0; i < count; ++i) {
        const CreaseSegment& object = objects_.creases[static_cast<std::size_t>(pairs[i].object)];
        const auto add = [&](const CreaseRow& row) {
          const double reach = frames.max_translation + frames.max_rotation * row.lever.norm();
          if (row.gap > reach) return;
          rows.AddRow(row.normal, row.lever, row.gap, {pairs[i].tool + tag, pairs[i].object});
        };
        if (!ball) {
          CreaseRows(tool_.creases[static_cast<std::size_t>(pairs[i].tool)], object, R_WG, p_W,
                     add);
        } else if (const auto row = BallRow(p_W, tool_.radius, object, p_W)) {
          add(*row);
        }
      }
      clock.Lap(&StageTimes::rows);
      return true;
    });
  }
  if (tool_.radius == 0.0) rows.SoftenRecovery(first_row, recovery);
  clock.Lap(&StageTimes::prediction);
}

}  // namespace palpate
