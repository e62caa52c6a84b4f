#include "scenes/grid/cut_field.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "common/error.h"
#include "scenes/grid/bur_sweep.h"
#include "scenes/mesh/figure.h"

namespace palpate {
namespace {

constexpr int kSide = SparseField::kSide;
constexpr int kRows = kSide * kSide;
/// A distance beyond which no stored bound lasts: every row is examined again [m].
constexpr double kFar = 1e3;
/// Cost of a row of another bur, in rows of a ball: measured.
constexpr int kQueriesOfRow = 3;
/// Bound of the rounding of distances: they are floats, of points within some 10 mm of the bur [m].
constexpr double kRounding = 1e-8;
/// Columns of a voxel, to compute its share: a Fibonacci lattice (Niederreiter & Sloan, J. Comp.
/// Appl. Math. 51 (1994) 57-70), in which no two columns are in line with an axis, as most faces
/// of solids are.
constexpr int kColumns = 377, kStride = 233;
/// A plane farther from a voxel's centre than half its diagonal does not cross it.
constexpr double kHalfDiagonal = 0.8660254037844386;

/// The half-space a + g . u < 0 that represents a field in a voxel, u in [-1/2, 1/2]^3.
struct HalfSpace {
  double a;
  Vec3 g;
};

const HalfSpace kAll{-1.0, Vec3::Zero()};

/// Computes the half-space from a point and its six neighbours.  The field's mean over the voxel is
/// its value plus 1/24 of the second differences, exact to third order.  So the voxels of a sphere
/// add up to its volume, though each is cut by a plane.
HalfSpace PlaneOf(const SparseField& field, int i, int j, int k, double value) {
  const double h = field.lattice().spacing;
  // The point's block is stored, so read it without the table.
  const float* at = field.values(field.entry(field.BlockIndex(i >> 3, j >> 3, k >> 3))) +
                    SparseField::PointIndex(i, j, k);
  const auto before = [&](int c, int stride, int x, int y, int z) -> double {
    return (c & 7) != 0 ? at[-stride] : field.At(x, y, z);
  };
  const auto after = [&](int c, int stride, int x, int y, int z) -> double {
    return (c & 7) != 7 ? at[stride] : field.At(x, y, z);
  };
  const double x0 = before(i, 1, i - 1, j, k), x1 = after(i, 1, i + 1, j, k);
  const double y0 = before(j, 8, i, j - 1, k), y1 = after(j, 8, i, j + 1, k);
  const double z0 = before(k, 64, i, j, k - 1), z1 = after(k, 64, i, j, k + 1);
  const double bend = x0 + x1 + y0 + y1 + z0 + z1 - 6.0 * value;
  return {(value + bend / 24.0) / h, Vec3(x1 - x0, y1 - y0, z1 - z0) / (2.0 * h)};
}

/// Positions of the columns in a voxel's cross-section, from -1/2 to 1/2 each way.
constexpr std::array<std::array<double, 2>, kColumns> kAcross = [] {
  std::array<std::array<double, 2>, kColumns> across{};
  for (int n = 0; n < kColumns; ++n) {
    across[static_cast<std::size_t>(n)] = {(n + 0.5) / kColumns - 0.5,
                                           (n * kStride % kColumns + 0.5) / kColumns - 0.5};
  }
  return across;
}();

/// Returns the volume of the unit voxel inside a half-space, and inside another if there is one.
/// Exact along columns, which are parallel to the axis that the first normal is nearest to.
double ShareIn(const HalfSpace& q, const HalfSpace& other) {
  int w = 0;
  const double steepest = q.g.cwiseAbs().maxCoeff(&w);
  if (!(steepest > 0.0)) return q.a < 0.0 ? 1.0 : 0.0;
  const int u = (w + 1) % 3, v = (w + 2) % 3;
  double sum = 0.0;
  for (const auto& [a, b] : kAcross) {
    double low = -0.5, high = 0.5;
    for (const HalfSpace* half : {&q, &other}) {
      const double base = half->a + a * half->g[u] + b * half->g[v], slope = half->g[w];
      if (slope > 0.0) {
        high = std::min(high, -base / slope);
      } else if (slope < 0.0) {
        low = std::max(low, -base / slope);
      } else if (base >= 0.0) {
        high = low;
      }
    }
    sum += std::max(0.0, high - low);
  }
  return sum / kColumns;
}

}  // namespace

std::size_t CutField::BytesOf(const SolidGrid& solid, std::size_t blocks) {
  const std::size_t table = solid.field().lattice().block_count();
  return SparseField::BytesOf(table, blocks) + kChanges * sizeof(std::uint32_t) +
         blocks * kRows * sizeof(double) + table * 2 * sizeof(std::uint32_t) + table / 8 +
         blocks * sizeof(Touched);
}

CutField::CutField(const SolidGrid& solid, std::size_t most_bytes, const std::string& name,
                   std::size_t blocks)
    : solid_(&solid),
      field_(solid.field().lattice(), solid.field().band(), SparseField::kBelow),
      waiting_(solid.field().lattice().block_count()),
      waits_(waiting_.size()),
      changed_at_(waiting_.size()),
      changed_(kChanges) {
  if (blocks == 0) blocks = solid.solid_blocks();
  if (const std::size_t bytes = BytesOf(solid, blocks); bytes > most_bytes) {
    throw Error(name + ": cutting at " + Figure(1e6 * field_.lattice().spacing, 3) + " um takes " +
                Figure(double(bytes) / (1 << 20), 3) + " MB, but the limit is " +
                Figure(double(most_bytes) / (1 << 20), 3) +
                " MB; use a larger spacing, a smaller body, or fewer blocks to cut");
  }
  field_.Reserve(blocks);
  still_.resize(blocks * kRows);
  touched_.reserve(blocks);
}

std::size_t CutField::bytes() const {
  return BytesOf(*solid_, still_.size() / kRows);
}

void CutField::Wait(std::size_t block) noexcept {
  Note(block);
  if (waits_[block]) return;
  waits_[block] = true;
  waiting_[(first_waiting_ + waiting_count_++) % waiting_.size()] =
      static_cast<std::uint32_t>(block);
}

bool CutField::TakeChanged(std::size_t& block) noexcept {
  if (waiting_count_ == 0) return false;
  block = waiting_[first_waiting_];
  waits_[block] = false;
  first_waiting_ = (first_waiting_ + 1) % waiting_.size();
  --waiting_count_;
  return true;
}

void CutField::MakeWhole() noexcept {
  field_.Clear();
  ++changes_;
  for (std::uint32_t& at : changed_at_) at = at == 0 ? 0 : changes_;
  std::fill(waits_.begin(), waits_.end(), false);
  first_waiting_ = waiting_count_ = 0;
  gone_ = kFar;  // so that each row is examined, wherever the bur is
}

FieldSample CutField::Sample(const Vec3& p_B) const noexcept {
  const Lattice::Place at = field_.lattice().PlaceOf(p_B);
  const FieldSample solid = solid_->field().Sample(at), cut = field_.Sample(at);
  return cut.distance > solid.distance ? cut : solid;
}

double CutField::UncutShareOf(int i, int j, int k) const noexcept {
  const SparseField& solid = solid_->field();
  const double value = solid.At(i, j, k), clear = kHalfDiagonal * solid.lattice().spacing;
  if (std::abs(value) > clear) return value < 0.0 ? 1.0 : 0.0;
  return ShareIn(PlaneOf(solid, i, j, k, value), kAll);
}

double CutField::ShareOf(int i, int j, int k) const noexcept {
  const double value = field_.At(i, j, k), clear = kHalfDiagonal * field_.lattice().spacing;
  if (value > clear) return 0.0;
  if (value < -clear) return UncutShareOf(i, j, k);
  const SparseField& solid = solid_->field();
  const double uncut = solid.At(i, j, k);
  if (uncut > clear) return 0.0;
  const HalfSpace plane = PlaneOf(field_, i, j, k, value);
  return ShareIn(plane, uncut < -clear ? kAll : PlaneOf(solid, i, j, k, uncut));
}

double CutField::Left(int i, int j, int k) const noexcept {
  const Lattice& lattice = field_.lattice();
  for (int a = 0; a < 3; ++a) {
    const int c = a == 0 ? i : a == 1 ? j : k;
    if (c < 0 || c >= kSide * lattice.blocks[static_cast<std::size_t>(a)]) return 0.0;
  }
  const std::int32_t entry = field_.entry(field_.BlockIndex(i >> 3, j >> 3, k >> 3));
  if (entry == SparseField::kAbove) return 0.0;
  if (entry == SparseField::kBelow) return UncutShareOf(i, j, k);
  return ShareOf(i, j, k);
}

std::array<double, SolidGrid::kMaterials> CutField::VolumeLeft() const {
  std::array<double, SolidGrid::kMaterials> left{};
  const Lattice& lattice = field_.lattice();
  for (std::size_t block = 0; block < lattice.block_count(); ++block) {
    const std::array<int, 3> at = lattice.BlockAt(block);
    for (int n = 0; n < SparseField::kPoints; ++n) {
      left[solid_->MaterialOf(block, n)] +=
          Left(8 * at[0] + (n & 7), 8 * at[1] + (n >> 3 & 7), 8 * at[2] + (n >> 6));
    }
  }
  for (double& volume : left) volume *= lattice.spacing * lattice.spacing * lattice.spacing;
  return left;
}

void CutField::Store(std::size_t block) noexcept {
  const std::int32_t entry = field_.Acquire(block);
  std::fill_n(still_.data() + static_cast<std::size_t>(entry) * kRows, kRows, 0.0);
}

bool CutField::TakeStorage(const int low[3], const int high[3], const BurSweep& sweep,
                           const Pose& X_TB) noexcept {
  const Lattice& lattice = field_.lattice();
  // From a block's centre to its farthest point, and the band beyond the bur.
  const double reach = field_.band() + 3.5 * std::sqrt(3.0) * lattice.spacing;
  const Vec3 apart = X_TB.q * (kSide * lattice.spacing * Vec3::UnitX());
  BurSweep::Row distance;
  std::size_t wanted = 0;
  for (int k = low[2]; k <= high[2]; ++k) {
    for (int j = low[1]; j <= high[1]; ++j) {
      for (int i = low[0]; i <= high[0]; ++i) {
        const int n = (i - low[0]) % BurSweep::kRow;
        if (n == 0) {
          sweep.Distances(X_TB * (lattice.Point(kSide * i, kSide * j, kSide * k) +
                                  Vec3::Constant(3.5 * lattice.spacing)),
                          apart, static_cast<float>(reach), distance);
        }
        const std::size_t block = field_.BlockIndex(i, j, k);
        if (field_.entry(block) == SparseField::kAbove ||
            solid_->field().entry(block) == SparseField::kAbove ||
            distance[static_cast<std::size_t>(n)] > reach) {
          continue;
        }
        const bool stored = field_.entry(block) >= 0;
        if (!stored && ++wanted > field_.free_blocks()) return false;
        touched_.push_back({block, {i, j, k}});
      }
    }
  }
  for (const Touched& touched : touched_) {
    if (field_.entry(touched.block) < 0) Store(touched.block);
  }
  return true;
}

/// Returns a bound of the distance that any point of the bur has gone since the end of
/// the last step.
double CutField::GoneSince(const Bur& bur, const Pose& X_BT) const noexcept {
  if (!(bur == bur_)) return kFar;
  // In a turn by an angle t, points move by 2 sin(t/2) of their lever, and quaternions
  // by 2 sin(t/4).
  const double turn = (X_BT.q.coeffs() - end_.q.coeffs()).norm();
  return (X_BT.p - end_.p).norm() + 2.0 * turn * bur.reach();
}

/// A point with the value v, at a distance d from the bur at a step's end, cannot change before the
/// bur has gone d + v farther.  So rows behind the bur, and far ahead of it, are skipped.
bool CutField::Raise(const Touched& touched, const BurSweep& sweep, const Pose& X_TB) noexcept {
  const Lattice& lattice = field_.lattice();
  const Mat3 R_TB = X_TB.q.toRotationMatrix();
  const Vec3 first = X_TB * lattice.Point(8 * touched.at[0], 8 * touched.at[1], 8 * touched.at[2]);
  const Vec3 along = lattice.spacing * R_TB.col(0);
  const std::int32_t entry = field_.entry(touched.block);
  float* values = field_.values(entry);
  double* still = still_.data() + static_cast<std::size_t>(entry) * kRows;
  // The rows to examine, one bit each, because a branch per row is hard to predict.
  std::uint64_t rows = 0;
  for (int row = 0; row < kRows; ++row) rows |= std::uint64_t{gone_ > still[row]} << row;
  queries_ += std::popcount(rows) * (sweep.IsOfBall() ? 1 : kQueriesOfRow);
  bool changed = false;
  for (; rows != 0; rows &= rows - 1) {
    const int row = std::countr_zero(rows);
    const Vec3 from =
        first + lattice.spacing * (row % kSide * R_TB.col(1) + row / kSide * R_TB.col(2));
    const BurSweep::Raised raised = sweep.Raise(from, along, field_.band(), values + row * kSide);
    changed = changed || raised.any;
    still[row] = gone_ + std::min(double{raised.room}, kFar) - kRounding;
  }
  return changed;
}

/// Takes the storage of a block that is free throughout.
void CutField::ReleaseIfClear(std::size_t block) noexcept {
  const float* values = field_.values(field_.entry(block));
  if (std::all_of(values, values + SparseField::kPoints,
                  [&](float v) { return v >= field_.band(); })) {
    field_.Release(block, SparseField::kAbove);
  }
}

CutAway CutField::Remove(const Bur& bur, const Pose& X_BT, const Vec3& step_B) noexcept {
  CutAway removal;
  touched_.clear();
  const Lattice& lattice = field_.lattice();
  const Pose X_TB = X_BT.Inverse();
  const BurSweep sweep(bur, X_TB.q * step_B);
  // The box of both ends of the bur's axis, for any direction, and of its way.
  const Vec3 z = X_BT.q * Vec3::UnitZ();
  const Vec3 margin = Vec3::Constant(field_.band() + bur.radius());
  const double bottom = std::min(0.0, bur.low() + bur.radius());
  const double top = std::max(0.0, bur.high() - bur.radius());
  const Vec3 a = X_BT.p + bottom * z, b = X_BT.p + top * z;
  const Vec3 zero = Vec3::Zero();
  const Vec3 min = a.cwiseMin(b) + step_B.cwiseMin(zero) - margin - lattice.origin;
  const Vec3 max = a.cwiseMax(b) + step_B.cwiseMax(zero) + margin - lattice.origin;
  int low[3], high[3];
  for (int d = 0; d < 3; ++d) {
    const double blocks = lattice.blocks[static_cast<std::size_t>(d)];
    const double block = kSide * lattice.spacing;
    // Also if a number is not finite: nothing is removed.
    if (!(max[d] >= 0.0 && min[d] < blocks * block)) return removal;
    low[d] = static_cast<int>(std::max(0.0, min[d] / block));
    high[d] = static_cast<int>(std::min(blocks - 1.0, max[d] / block));
  }
  if (!TakeStorage(low, high, sweep, X_TB)) {
    touched_.clear();
    removal.full = true;
    return removal;
  }
  // Bounds the way to the step's end, and so to any point of the step.
  gone_ += GoneSince(bur, X_BT) + step_B.norm();
  bur_ = bur;
  end_ = {X_BT.p + step_B, X_BT.q};
  queries_ = 0;
  for (const Touched& touched : touched_) {
    if (!Raise(touched, sweep, X_TB)) continue;
    Wait(touched.block);
    ReleaseIfClear(touched.block);
  }
  removal.queries = queries_;
  return removal;
}

bool CutField::Merge(std::size_t block, const float* points) noexcept {
  if (field_.entry(block) == SparseField::kAbove) return false;
  if (field_.entry(block) < 0) Store(block);
  float* const values = field_.values(field_.entry(block));
  bool changed = false;
  for (int n = 0; n < SparseField::kPoints; ++n) {
    const float value = points != nullptr ? points[n] : field_.band();
    changed = changed || value > values[n];
    values[n] = std::max(values[n], value);
  }
  ReleaseIfClear(block);
  if (changed) Note(block);
  return changed;
}

}  // namespace palpate
