#include "scenes/grid/sparse_field.h"

#include <algorithm>
#include <cmath>

namespace palpate {

SparseField::SparseField(const Lattice& lattice, float band, std::int32_t all)
    : lattice_(lattice), band_(band), all_(all), table_(lattice.block_count(), all) {}

float SparseField::At(int i, int j, int k) const noexcept {
  const int bi = i >> 3, bj = j >> 3, bk = k >> 3;
  if (bi < 0 || bj < 0 || bk < 0 || bi >= lattice_.blocks[0] || bj >= lattice_.blocks[1] ||
      bk >= lattice_.blocks[2]) {
    return ValueOf(all_, 0);
  }
  return ValueOf(table_[BlockIndex(bi, bj, bk)], PointIndex(i, j, k));
}

Lattice::Place Lattice::PlaceOf(const Vec3& p_B) const noexcept {
  const Vec3 at = (p_B - origin) / spacing;
  Place place;
  place.inside = false;
  for (int a = 0; a < 3; ++a) {
    // False, too, for a point that is not finite, which no integer could represent.
    if (!(at[a] >= 0.0 && at[a] < 8 * blocks[static_cast<std::size_t>(a)])) return place;
    place.c[a] = static_cast<int>(at[a]);
    place.u[a] = at[a] - place.c[a];
  }
  place.inside = true;
  place.block = static_cast<std::size_t>(
      ((place.c[2] >> 3) * blocks[1] + (place.c[1] >> 3)) * blocks[0] + (place.c[0] >> 3));
  return place;
}

bool SparseField::Cell(const Lattice::Place& at, double v[8]) const noexcept {
  if (!at.inside) {
    v[0] = ValueOf(all_, 0);
    return false;
  }
  const int x = at.c[0] & 7, y = at.c[1] & 7, z = at.c[2] & 7;
  if (x < 7 && y < 7 && z < 7) {
    const std::int32_t entry = table_[at.block];
    if (entry < 0) {
      v[0] = ValueOf(entry, 0);
      return false;
    }
    const float* first = values(entry) + PointIndex(x, y, z);
    for (int n = 0; n < 8; ++n) v[n] = first[(n & 1) + ((n & 2) << 2) + ((n & 4) << 4)];
    return true;
  }
  // Some of the eight points are in the next blocks, if there are any.
  const std::size_t stride[3] = {1, static_cast<std::size_t>(lattice_.blocks[0]),
                                 BlockIndex(0, 0, 1)};
  std::size_t next[3];
  int beyond = 0;
  for (int a = 0; a < 3; ++a) {
    const bool crosses = (at.c[a] & 7) == 7;
    next[a] = crosses ? stride[a] : 0;
    if (crosses && (at.c[a] >> 3) + 1 == lattice_.blocks[static_cast<std::size_t>(a)]) {
      beyond |= 1 << a;
    }
  }
  for (int n = 0; n < 8; ++n) {
    const int dx = n & 1, dy = n >> 1 & 1, dz = n >> 2;
    const std::size_t block =
        at.block + (dx ? next[0] : 0) + (dy ? next[1] : 0) + (dz ? next[2] : 0);
    v[n] = ValueOf((n & beyond) != 0 ? all_ : table_[block], PointIndex(x + dx, y + dy, z + dz));
  }
  return true;
}

double SparseField::Distance(const Lattice::Place& at) const noexcept {
  double v[8];
  if (!Cell(at, v)) return v[0];
  for (int a = 0, half = 4; a < 3; ++a, half /= 2) {
    for (int n = 0; n < half; ++n) v[n] = v[2 * n] + at.u[a] * (v[2 * n + 1] - v[2 * n]);
  }
  return v[0];
}

FieldSample SparseField::Sample(const Lattice::Place& at) const noexcept {
  double v[8];  // the index has the bits x, y, z
  if (!Cell(at, v)) return {v[0], Vec3::Zero()};
  const double* u = at.u;
  const auto mix = [](double a, double b, double t) { return a + t * (b - a); };
  double x[4], y[2];
  for (int n = 0; n < 4; ++n) x[n] = mix(v[2 * n], v[2 * n + 1], u[0]);
  for (int n = 0; n < 2; ++n) y[n] = mix(x[2 * n], x[2 * n + 1], u[1]);
  const auto along_x = [&](int n) { return v[2 * n + 1] - v[2 * n]; };
  const Vec3 gradient(
      mix(mix(along_x(0), along_x(1), u[1]), mix(along_x(2), along_x(3), u[1]), u[2]),
      mix(x[1] - x[0], x[3] - x[2], u[2]), y[1] - y[0]);
  return {mix(y[0], y[1], u[2]), gradient / lattice_.spacing};
}

void SparseField::Reserve(std::size_t blocks) {
  storage_.resize((stored_ + blocks) * kPoints);
  free_.reserve(stored_ + blocks);
  for (std::size_t b = stored_ + blocks; b > stored_; --b) {
    free_.push_back(static_cast<std::int32_t>(b - 1));
  }
  stored_ += blocks;
}

std::int32_t SparseField::Acquire(std::size_t block) noexcept {
  const std::int32_t entry = free_.back();
  free_.pop_back();
  std::fill_n(values(entry), kPoints, ValueOf(table_[block], 0));
  table_[block] = entry;
  return entry;
}

void SparseField::Release(std::size_t block, std::int32_t all) noexcept {
  free_.push_back(table_[block]);
  table_[block] = all;
}

void SparseField::Clear() noexcept {
  for (std::size_t block = 0; block < table_.size(); ++block) {
    if (table_[block] >= 0) free_.push_back(table_[block]);
    table_[block] = all_;
  }
}

}  // namespace palpate
