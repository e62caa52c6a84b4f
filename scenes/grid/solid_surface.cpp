#include "scenes/grid/solid_surface.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>
#include <span>
#include <unordered_map>

#include <Eigen/LU>

namespace palpate {
namespace {

constexpr int kBlockSide = SparseField::kSide;
/// Points before and beyond a block that its triangles, and its neighbours' beside them, depend on.
/// The farthest corners of the latter are those of the cubes of eight cells at -4 and at 8;
/// gradients need one point more.
constexpr int kBefore = 5, kBehind = 4;
constexpr int kWide = kBefore + kBlockSide + kBehind, kPoints = kWide * kWide * kWide;
/// Cubes of eight cells in a row: the first begins one point before the first.
constexpr int kEights = (kWide + 1) / 2;
/// The deviation of a gradient's squared norm from 1 at which it is doubted.  It is rounding only
/// at a flat face, some h^2 / 3R^2 where a face has the radius R, and a half where two faces meet
/// at a right angle.
constexpr double kDoubt = 0.003;
/// The least weight of a doubtful plane, relative to a sure one.  With less, a
/// bur's surface ripples.
constexpr double kLeast = 0.1;
/// Two ends see the same face if the product of their normals is at least this (26 degrees): a ball
/// of radius 2.5 h.
constexpr double kSame = 0.9;
/// Weight of the pull to the mean of a cell's crossings, relative to all planes.  It fixes a vertex
/// that the planes leave free, and keeps it from a right-angled edge by 2 % of its way.
constexpr double kPull = 0.01;
/// The same for the one vertex of eight cells, which must stay on an edge of the solid's mesh
/// between faces that meet at a few degrees.
constexpr double kPullOfEight = 1e-4;
/// The largest distance of that vertex from any of their planes [h]; beyond it each cell gets its
/// own.  A ball of 27 h or more has one vertex for eight cells.
constexpr double kFlat = 0.05;
/// How far a vertex may lie outside its cell [h]: an edge may pass between two lattice lines, so
/// that only cells behind it are crossed.
constexpr double kBeyond = 1.0;

/// Bits 0 to 2 of a corner of a cell are its x, y and z.  Edge 4 d + n of a cell is parallel to
/// axis d; n holds the bits of its lower end on the next two axes.
constexpr int EdgeOf(int corner, int d) {
  return 4 * d + (corner >> (d + 1) % 3 & 1) + 2 * (corner >> (d + 2) % 3 & 1);
}
constexpr int LowerEnd(int edge) {
  const int d = edge / 4;
  return (edge & 1) << (d + 1) % 3 | (edge >> 1 & 1) << (d + 2) % 3;
}

/// For each set of solid corners and each edge of the cell, the sheet of the surface that crosses
/// the edge, or -1.  On a face that the surface crosses twice, each solid corner is cut off alone.
struct Sheets {
  int count = 0;
  std::array<std::int8_t, 12> of{};
};

constexpr std::array<Sheets, 256> MakeSheets() {
  std::array<Sheets, 256> all{};
  for (int solid = 0; solid < 256; ++solid) {
    const auto is_solid = [&](int corner) { return (solid >> corner & 1) != 0; };
    int sheet[12] = {};
    for (int e = 0; e < 12; ++e) {
      const bool crossed = is_solid(LowerEnd(e)) != is_solid(LowerEnd(e) | 1 << e / 4);
      sheet[e] = crossed ? e : -1;
    }
    const auto join = [&](int a, int b) {
      const int from = sheet[a], to = sheet[b];
      for (int& s : sheet) s = s == from ? to : s;
    };
    for (int face = 0; face < 6; ++face) {
      const int w = face / 2, u = (w + 1) % 3, v = (w + 2) % 3, base = (face & 1) << w;
      const int around[4] = {EdgeOf(base, u), EdgeOf(base | 1 << u, v), EdgeOf(base | 1 << v, u),
                             EdgeOf(base, v)};
      const int corners[4] = {base, base | 1 << u, base | 1 << u | 1 << v, base | 1 << v};
      int crossed = 0, last = -1;
      for (const int e : around) crossed += sheet[e] >= 0;
      for (int n = 0; n < 4; ++n) {
        if (crossed == 4 && is_solid(corners[n])) join(around[(n + 3) % 4], around[n]);
        if (crossed != 2 || sheet[around[n]] < 0) continue;
        if (last >= 0) join(last, around[n]);
        last = around[n];
      }
    }
    Sheets& sheets = all[static_cast<std::size_t>(solid)];
    int number[12] = {};
    for (int e = 0; e < 12; ++e) {
      if (sheet[e] == e) number[e] = sheets.count++;
    }
    for (int e = 0; e < 12; ++e) {
      sheets.of[static_cast<std::size_t>(e)] =
          static_cast<std::int8_t>(sheet[e] < 0 ? -1 : number[sheet[e]]);
    }
  }
  return all;
}
constexpr std::array<Sheets, 256> kSheets = MakeSheets();

/// For each set of solid corners, whether at most one sheet crosses the cell, and no face twice.
constexpr std::array<bool, 256> MakePlain() {
  std::array<bool, 256> plain{};
  for (int solid = 0; solid < 256; ++solid) {
    plain[static_cast<std::size_t>(solid)] = kSheets[static_cast<std::size_t>(solid)].count < 2;
    for (int face = 0; face < 6; ++face) {
      const int w = face / 2, u = 1 << (w + 1) % 3, v = 1 << (w + 2) % 3, base = (face & 1) << w;
      const auto is_solid = [&](int corner) { return (solid >> corner & 1) != 0; };
      if (is_solid(base) == is_solid(base | u | v) && is_solid(base | u) == is_solid(base | v) &&
          is_solid(base) != is_solid(base | u)) {
        plain[static_cast<std::size_t>(solid)] = false;
      }
    }
  }
  return plain;
}
constexpr std::array<bool, 256> kPlain = MakePlain();

/// For each of the 27 points of a cube of eight cells, a bit mask of those of the cube's corners
/// that are the ends of its edge, face or diagonal through the point.
constexpr std::array<int, 27> MakeCornersRound() {
  std::array<int, 27> all{};
  for (int n = 0; n < 27; ++n) {
    const int at[3] = {n % 3, n / 3 % 3, n / 9};
    for (int c = 0; c < 8; ++c) {
      bool is_round = true;
      for (int a = 0; a < 3; ++a) is_round = is_round && (at[a] == 1 || at[a] / 2 == (c >> a & 1));
      all[static_cast<std::size_t>(n)] |= int{is_round} << c;
    }
  }
  return all;
}
constexpr std::array<int, 27> kCornersRound = MakeCornersRound();
/// Offset of the next point along each axis, and the mask of points that have one.
constexpr int kNextOf27[3] = {1, 3, 9};
constexpr std::uint32_t kHasNext[3] = {0b011011011'011011011'011011011,
                                       0b000111111'000111111'000111111, (1u << 18) - 1};

/// A point of the block or its margin, counted from 0 in the margin's corner.
struct Place {
  int at[3];
  int index() const { return (at[2] * kWide + at[1]) * kWide + at[0]; }
  Place Moved(int axis, int by) const {
    Place p = *this;
    p.at[axis] += by;
    return p;
  }
  /// Returns a corner of the cell whose lowest point this is.
  Place Corner(int c) const { return {{at[0] + (c & 1), at[1] + (c >> 1 & 1), at[2] + (c >> 2)}}; }
  Vec3 From(const Place& p) const {
    return Vec3(at[0] - p.at[0], at[1] - p.at[1], at[2] - p.at[2]);
  }
};
constexpr int kPointStride[3] = {1, kWide, kWide* kWide};

/// Contours two fields round a block; lengths in [h].
class Contour {
 public:
  Contour(const SolidFields& fields, std::size_t block, SolidSurface& surface)
      : fields_of_(fields),
        grid_(fields.solid),
        surface_(surface),
        lattice_(fields.cut.lattice()),
        scale_(static_cast<float>(1.0 / lattice_.spacing)) {
    const std::array<int, 3> at = lattice_.BlockAt(block);
    for (std::size_t k = 0; k < 3; ++k) first_[k] = kBlockSide * at[k];
  }

  /// Returns whether some points of the block, or the next after it, are solid and others free,
  /// judged by the table.
  bool MayCross() const {
    bool free = false, solid = false;
    for (int n = 0; n < 8; ++n) {
      const int b[3] = {n & 1, n >> 1 & 1, n >> 2};
      const std::int32_t of_solid = EntryAt(grid_.field(), b);
      const std::int32_t of_cut = EntryAt(CutAt(b), b);
      if (of_solid == SparseField::kAbove || of_cut == SparseField::kAbove) {
        free = true;
      } else if (of_solid == SparseField::kBelow && of_cut == SparseField::kBelow) {
        solid = true;
      } else {
        return true;
      }
    }
    return free && solid;
  }

  void Load() {
    for (int n = 0; n < 9; ++n) {
      const int y = n % 3 - 1, z = n / 3 - 1;
      for (const bool of_cut : {false, true}) LoadRows(y, z, of_cut);
    }
    for (int n = 0; n < kPoints; ++n) {
      solid_[n] = static_cast<std::uint8_t>((fields_[0][n] < 0.0f) & (fields_[1][n] < 0.0f));
    }
    // For cells that reach beyond the margin the result is wrong, but it is not used.
    constexpr int kLast = kPointStride[0] + kPointStride[1] + kPointStride[2];
    for (int n = 0; n < kPoints - kLast; ++n) {
      int corners = 0;
      for (int c = 0; c < 8; ++c) {
        corners |= solid_[n + (c & 1) + (c >> 1 & 1) * kPointStride[1] + (c >> 2) * kPointStride[2]]
                   << c;
      }
      corners_[n] = static_cast<std::uint8_t>(corners);
    }
    std::ranges::fill(eight_, kUnknown);
    std::ranges::fill(vertex_, kNone);
    std::ranges::fill(kept_number_, kNone);
  }

  /// Takes the block's own triangles.
  void Take() {
    for (int k = kBefore; k < kBefore + kBlockSide; ++k) {
      for (int j = kBefore; j < kBefore + kBlockSide; ++j) {
        for (int i = kBefore; i < kBefore + kBlockSide; ++i) {
          const Place p{{i, j, k}};
          if (IsUniform(p)) continue;
          for (int d = 0; d < 3; ++d) {
            if (Crosses(p, d)) AddAcross(p, d);
          }
        }
      }
    }
  }

  /// Takes those triangles of the blocks round it that share a vertex with them.
  void TakeRim() {
    constexpr int first = kBefore - 2, last = kBefore + kBlockSide;
    const auto own = static_cast<std::int16_t>(surface_.vertices.size());
    for (int k = first; k <= last; ++k) {
      for (int j = first; j <= last; ++j) {
        for (int i = first; i <= last; ++i) {
          if (std::min({i, j, k}) >= kBefore && std::max({i, j, k}) < last) continue;
          const Place p{{i, j, k}};
          if (IsUniform(p)) continue;
          for (int d = 0; d < 3; ++d) {
            if (Crosses(p, d) && HasVertexBefore(own, p, d)) AddAcross(p, d);
          }
        }
      }
    }
  }

 private:
  /// Returns a block from its offset to the one that is taken.
  std::optional<std::size_t> BlockAt(const int b[3]) const {
    int at[3];
    for (int a = 0; a < 3; ++a) {
      at[a] = first_[a] / kBlockSide + b[a];
      if (at[a] < 0 || at[a] >= lattice_.blocks[static_cast<std::size_t>(a)]) return std::nullopt;
    }
    return fields_of_.cut.BlockIndex(at[0], at[1], at[2]);
  }
  std::int32_t EntryAt(const SparseField& field, const int b[3]) const {
    const auto block = BlockAt(b);
    return block ? field.entry(*block) : SparseField::kAbove;
  }
  const SparseField& CutAt(const int b[3]) const {
    const auto block = BlockAt(b);
    const bool is_later = block && fields_of_.later != nullptr &&
                          fields_of_.later->entry(*block) != SparseField::kBelow;
    return is_later ? *fields_of_.later : fields_of_.cut;
  }

  /// Loads, of three blocks in a row along x, the part inside the margin.
  void LoadRows(int y, int z, bool of_cut) {
    constexpr int kFirst[3] = {kBlockSide - kBefore, 0, 0},
                  kCount[3] = {kBefore, kBlockSide, kBehind};
    constexpr int kAt[3] = {0, kBefore, kBefore + kBlockSide};
    const float* from[3];
    float all[3];
    for (int n = 0; n < 3; ++n) {
      const int b[3] = {n - 1, y, z};
      const SparseField& field = of_cut ? CutAt(b) : grid_.field();
      const auto block = BlockAt(b);
      const std::int32_t entry = block ? field.entry(*block) : field.around();
      from[n] = entry >= 0 ? field.values(entry) + kFirst[n] : nullptr;
      all[n] = entry == SparseField::kBelow ? -field.band() : field.band();
    }
    for (int k = 0; k < kCount[z + 1]; ++k) {
      for (int j = 0; j < kCount[y + 1]; ++j) {
        float* const row = fields_[of_cut] + ((kAt[z + 1] + k) * kWide + kAt[y + 1] + j) * kWide;
        const int at = SparseField::PointIndex(0, kFirst[y + 1] + j, kFirst[z + 1] + k);
        Copy<kBefore>(from[0], at, all[0], row);
        Copy<kBlockSide>(from[1], at, all[1], row + kBefore);
        Copy<kBehind>(from[2], at, all[2], row + kBefore + kBlockSide);
      }
    }
  }

  template <int count>
  static void Copy(const float* from, int at, float all, float* to) {
    if (from != nullptr) {
      std::copy_n(from + at, count, to);
    } else {
      std::fill_n(to, count, all);
    }
  }

  /// Returns a field's value at a point [h].
  float At(int field, int point) const { return scale_ * fields_[field][point]; }

  /// Returns the bit mask of the solid corners of the cell whose lowest point is p.
  int CornersOf(const Place& p) const { return corners_[p.index()]; }

  int SheetOf(const Place& cell, int edge) const {
    return kSheets[static_cast<std::size_t>(CornersOf(cell))].of[static_cast<std::size_t>(edge)];
  }

  /// Returns where max(phi_0, phi_c) crosses 0 on the edge from a point along d, 0 to 1, and the
  /// field that crosses there: by interpolation, the first to do so from the solid end.
  double Cross(const Place& lower, int d, int& field) const {
    const bool up = solid_[lower.index()] != 0;
    const int upper = lower.index() + kPointStride[d];
    const int solid = up ? lower.index() : upper, free = up ? upper : lower.index();
    double t = 2.0;
    for (int f = 0; f < 2; ++f) {
      const double a = At(f, solid), b = At(f, free);
      if (b < 0.0 || a / (a - b) >= t) continue;
      t = a / (a - b);
      field = f;
    }
    return up ? t : 1.0 - t;
  }

  /// The face that a point sees, `distance` away along -normal [h].
  struct Face {
    Vec3 normal;
    double distance;
    double weight;
  };

  /// A crossed edge, from a point along an axis.
  struct Edge {
    double t;      ///< place of the crossing, from its lower end, 0 to 1
    Face face[2];  ///< seen from the lower and from the upper end
    bool is_one;   ///< whether both see the same face, whose normal is that of face[0]
  };

  /// Returns the nearest face of a field's surface, as a point sees it by its distance and
  /// gradient, whose length is 1 if there is a face.  Takes central differences if their length is
  /// near 1; beside an edge, where the nearest face changes, the one-sided differences whose length
  /// is nearest to 1.  The normal has the gradient's length.
  /// Near a convex edge a solid point sees one of its faces, and a free one a plane through the
  /// edge; near a concave edge it is the other way round.
  Face FaceAt(int field, int at) const {
    const double here = At(field, at);
    const auto back_along = [&](int a) { return here - At(field, at - kPointStride[a]); };
    const auto ahead_along = [&](int a) { return At(field, at + kPointStride[a]) - here; };
    // Constructed at once: the processor stalls if numbers stored one by one are loaded in pairs.
    const Vec3 back(back_along(0), back_along(1), back_along(2));
    const Vec3 ahead(ahead_along(0), ahead_along(1), ahead_along(2));
    Vec3 best = 0.5 * (back + ahead);
    double off = std::abs(best.squaredNorm() - 1.0);
    for (int n = 0; n < 8 && off > kDoubt; ++n) {
      const Vec3 g(n & 1 ? ahead[0] : back[0], n & 2 ? ahead[1] : back[1],
                   n & 4 ? ahead[2] : back[2]);
      if (const double miss = std::abs(g.squaredNorm() - 1.0); miss < off) {
        off = miss;
        best = g;
      }
    }
    return {best, here, kLeast + 1.0 / (1.0 + off * off / (kDoubt * kDoubt))};
  }

  /// Returns a crossed edge.  Up to four cells need each, so recent ones are cached.
  const Edge& EdgeAt(const Place& lower, int d) {
    const int number = 3 * lower.index() + d;
    const auto slot = static_cast<std::size_t>(number) % kKept;
    Edge& edge = kept_[slot];
    if (kept_number_[slot] == number) return edge;
    kept_number_[slot] = static_cast<std::int16_t>(number);
    int field = 0;
    edge.t = Cross(lower, d, field);
    Face& one = edge.face[0] = FaceAt(field, lower.index());
    Face& other = edge.face[1] = FaceAt(field, lower.index() + kPointStride[d]);
    const double together = one.normal.dot(other.normal);
    edge.is_one =
        together > 0.0 && together * together >=
                              kSame * kSame * one.normal.squaredNorm() * other.normal.squaredNorm();
    if (edge.is_one) {
      one.normal = other.normal = (one.normal + other.normal).normalized();
      one.weight += other.weight;
    } else {
      one.normal.normalize();
      other.normal.normalize();
    }
    return edge;
  }

  std::uint64_t NumberOf(const Place& p, int which) const {
    std::uint64_t number = 0;
    for (int a = 2; a >= 0; --a) {
      const auto points = static_cast<std::uint64_t>(kBlockSide) *
                          static_cast<std::uint64_t>(lattice_.blocks[static_cast<std::size_t>(a)]);
      number = number * points + static_cast<std::uint64_t>(first_[a] + p.at[a] - kBefore);
    }
    return 7 * number + static_cast<std::uint64_t>(which);
  }

  std::uint32_t Add(const Vec3& at, std::uint64_t number) {
    surface_.vertices.push_back(at);
    surface_.numbers.push_back(number);
    return static_cast<std::uint32_t>(surface_.vertices.size() - 1);
  }
  Vec3 PointOf(const Place& p, const Vec3& beyond) const {
    return lattice_.Point(first_[0] + p.at[0] - kBefore, first_[1] + p.at[1] - kBefore,
                          first_[2] + p.at[2] - kBefore) +
           lattice_.spacing * beyond;
  }

  /// The planes that the crossings of a sheet see, relative to the lowest point of its
  /// cell or cells.
  struct Planes {
    struct Plane {
      Vec3 normal;
      double offset, weight;
    };
    std::array<Plane, 54> planes;  // a single cell has at most 24
    std::size_t count = 0;
    Vec3 crossings = Vec3::Zero();  ///< sum of the crossings
    int crossed = 0;

    void Add(const Vec3& lower, int d, const Edge& edge) {
      const Vec3 crossing = lower + edge.t * Vec3::Unit(d);
      crossings += crossing;
      ++crossed;
      const Face& face = edge.face[0];
      if (edge.is_one) {
        // If the face bends, the crossing is nearer to it than the tangent plane of either end.
        planes[count++] = {face.normal, face.normal.dot(crossing), face.weight};
        return;
      }
      for (int end = 0; end < 2; ++end) {
        const auto& [normal, distance, sure] = edge.face[end];
        planes[count++] = {normal, normal.dot(lower + end * Vec3::Unit(d)) - distance, sure};
      }
    }

    /// Returns the point where the planes meet, by least squares of the distances to them, starting
    /// from the mean of the crossings; at most `beyond` outside the cube.
    Vec3 Meet(double side, double beyond, double pull_to_middle) const {
      const Vec3 middle = crossings / crossed;
      Mat3 metric = Mat3::Zero();
      Vec3 pull = Vec3::Zero();
      double all = 0.0;
      for (const auto& [normal, offset, weight] : std::span(planes).first(count)) {
        metric += weight * normal * normal.transpose();
        pull += weight * (offset - normal.dot(middle)) * normal;
        all += weight;
      }
      metric.diagonal().array() += pull_to_middle * all;
      const Vec3 way = metric.inverse() * pull;
      double t = 1.0;
      for (int a = 0; a < 3; ++a) {
        const double room = way[a] > 0.0 ? side + beyond - middle[a] : middle[a] + beyond;
        if (std::abs(way[a]) > room) t = std::min(t, room / std::abs(way[a]));
      }
      return middle + t * way;
    }

    /// Returns whether one vertex represents all planes: their normals differ little, and it
    /// lies on all.
    bool AllHold(const Vec3& at) const {
      Vec3 mean = Vec3::Zero();
      for (const Plane& plane : std::span(planes).first(count)) mean += plane.normal;
      mean.normalize();
      return std::ranges::all_of(std::span(planes).first(count), [&](const Plane& plane) {
        return plane.normal.dot(mean) >= kSame &&
               std::abs(plane.normal.dot(at) - plane.offset) <= kFlat;
      });
    }
  };

  /// Returns the vertex of the cell's sheet that crosses one of its edges.
  std::uint32_t VertexOf(const Place& cell, int edge) {
    if (const std::int16_t of_eight = VertexOfEight(cell); of_eight >= 0) {
      return static_cast<std::uint32_t>(of_eight);
    }
    const Sheets& sheets = kSheets[static_cast<std::size_t>(CornersOf(cell))];
    const int sheet = sheets.of[static_cast<std::size_t>(edge)];
    std::int16_t& known = OfSheet(cell, sheet);
    if (known >= 0) return static_cast<std::uint32_t>(known);
    Planes planes;
    for (int e = 0; e < 12; ++e) {
      if (sheets.of[static_cast<std::size_t>(e)] != sheet) continue;
      const Place lower = cell.Corner(LowerEnd(e));
      planes.Add(lower.From(cell), e / 4, EdgeAt(lower, e / 4));
    }
    known = static_cast<std::int16_t>(
        Add(PointOf(cell, planes.Meet(1.0, kBeyond, kPull)), NumberOf(cell, sheet)));
    return static_cast<std::uint32_t>(known);
  }

  /// Returns the vertex of a cell's sheet, or kNone.
  std::int16_t& OfSheet(const Place& cell, int sheet) {
    if (sheet == 0) return vertex_[cell.index()];
    if (!has_sheets_) std::fill_n(&sheet_[0][0], 3 * kPoints, kNone);
    has_sheets_ = true;
    return sheet_[cell.index()][sheet - 1];
  }

  static std::size_t EightOf(const Place& cell) {
    std::size_t eight = 0;
    for (int a = 2; a >= 0; --a) {
      eight = eight * kEights + static_cast<std::size_t>((cell.at[a] + 1) / 2);
    }
    return eight;
  }

  /// Returns the vertex that a cell shares with the seven others of its cube, if the surface
  /// crosses the cube as a plane does; else kAlone.
  std::int16_t VertexOfEight(const Place& cell) {
    std::int16_t& known = eight_[EightOf(cell)];
    if (known != kUnknown) return known;
    known = kAlone;
    Place first = cell;
    for (int& at : first.at) at = (at + 1) / 2 * 2 - 1;
    const std::uint32_t solid = PointsOfEight(first);
    if (!IsPlain(first, solid)) return known;
    Planes planes;
    std::optional<std::uint8_t> material;
    // Points that differ from the next one along an axis.
    std::uint32_t crossed[3], any = 0;
    for (int d = 0; d < 3; ++d) {
      any |= crossed[d] = (solid ^ solid >> kNextOf27[d]) & kHasNext[d];
    }
    for (; any != 0; any &= any - 1) {
      const int n = std::countr_zero(any);
      const Place lower = OfEight(first, n);
      for (int d = 0; d < 3; ++d) {
        if ((crossed[d] >> n & 1) == 0) continue;
        const Edge& edge = EdgeAt(lower, d);
        const std::uint8_t behind = MaterialAt(solid_[lower.index()] ? lower : lower.Moved(d, 1));
        if (!edge.is_one || material.value_or(behind) != behind) return known;
        material = behind;
        planes.Add(lower.From(first), d, edge);
      }
    }
    const Vec3 at = planes.Meet(2.0, 0.0, kPullOfEight);
    if (!planes.AllHold(at)) return known;
    return known = static_cast<std::int16_t>(Add(PointOf(first, at), NumberOf(first, 0)));
  }

  /// Returns whether the surface in a cube of eight cells has the topology of that in one cell
  /// of twice the side (Ju et al., sec. 4.1): each point between has the sign of one of the
  /// corners round it.
  bool IsPlain(const Place& first, std::uint32_t solid) const {
    const int corners = CornersOfEight(solid);
    if (!kPlain[static_cast<std::size_t>(corners)]) return false;
    for (int c = 0; c < 8; ++c) {
      if (!kPlain[static_cast<std::size_t>(CornersOf(first.Corner(c)))]) return false;
    }
    for (std::size_t n = 0; n < 27; ++n) {
      if ((((solid >> n & 1) != 0 ? corners : ~corners) & kCornersRound[n]) == 0) return false;
    }
    return true;
  }

  /// Returns the bit mask of the solid points among the 27 of a cube of eight cells.
  std::uint32_t PointsOfEight(const Place& first) const {
    std::uint32_t solid = 0;
    for (int n = 0; n < 27; ++n) {
      const int at = first.index() + n % 3 + n / 3 % 3 * kPointStride[1] + n / 9 * kPointStride[2];
      solid |= std::uint32_t{solid_[at]} << n;
    }
    return solid;
  }
  static Place OfEight(const Place& first, int n) {
    return {{first.at[0] + n % 3, first.at[1] + n / 3 % 3, first.at[2] + n / 9}};
  }
  static int CornersOfEight(std::uint32_t solid) {
    int corners = 0;
    for (int c = 0; c < 8; ++c) {
      const int n = 2 * (c & 1) + 6 * (c >> 1 & 1) + 18 * (c >> 2);
      corners |= static_cast<int>(solid >> n & 1) << c;
    }
    return corners;
  }

  std::uint32_t CrossingOf(const Place& lower, int d) {
    if (!has_crossings_) std::fill_n(&crossing_[0][0], 3 * kPoints, kNone);
    has_crossings_ = true;
    std::int16_t& known = crossing_[lower.index()][d];
    if (known >= 0) return static_cast<std::uint32_t>(known);
    const Vec3 place = PointOf(lower, EdgeAt(lower, d).t * Vec3::Unit(d));
    known = static_cast<std::int16_t>(Add(place, NumberOf(lower, 4 + d)));
    return static_cast<std::uint32_t>(known);
  }

  void AddTriangle(std::uint32_t a, std::uint32_t b, std::uint32_t c, bool turned,
                   std::uint8_t material) {
    if (turned) std::swap(b, c);
    surface_.triangles.push_back({a, b, c});
    surface_.materials.push_back(material);
  }

  bool IsUniform(const Place& p) const { return CornersOf(p) == 0 || CornersOf(p) == 255; }
  bool Crosses(const Place& p, int d) const {
    return solid_[p.index()] != solid_[p.index() + kPointStride[d]];
  }

  /// Returns whether one of the four cells round an edge has a vertex with a lower number.
  bool HasVertexBefore(std::int16_t number, const Place& p, int d) const {
    const int u = (d + 1) % 3, v = (d + 2) % 3;
    const auto is_before = [&](std::int16_t vertex) { return vertex >= 0 && vertex < number; };
    for (const Place& cell : {p, p.Moved(u, -1), p.Moved(u, -1).Moved(v, -1), p.Moved(v, -1)}) {
      if (is_before(eight_[EightOf(cell)])) return true;
      if (is_before(vertex_[cell.index()])) return true;
      if (has_sheets_ && std::ranges::any_of(sheet_[cell.index()], is_before)) return true;
    }
    return false;
  }

  /// If neighbouring cells share a vertex, adds one triangle or none, and returns true.
  bool AddWhereCellsAreOne(const std::uint32_t (&c)[4], bool turned, std::uint8_t material) {
    for (int n = 0; n < 4; ++n) {
      const std::uint32_t one = c[n], second = c[(n + 2) % 4], third = c[(n + 3) % 4];
      if (one != c[(n + 1) % 4]) continue;
      if (second != third) AddTriangle(one, second, third, turned, material);
      return true;
    }
    return false;
  }

  /// Adds the triangles across the edge from a point along d.  Seen from the edge's upper end:
  ///
  ///        v                    c1 ____ c0     of four cells' vertices; where two sheets
  ///        |    cell 1 | cell 0   |   /|       would share the edge c0 c1, through the
  ///        |   --------+--------  |  / |       crossings p of this edge and q of another
  ///        |    cell 2 | cell 3   | /  |       of the face between the cells:
  ///        +----> u             c2 ---- c3     p c0 q here, and q c1 p from there
  void AddAcross(const Place& p, int d) {
    const int u = (d + 1) % 3, v = (d + 2) % 3;
    const bool up = solid_[p.index()] != 0;
    const Place cells[4] = {p, p.Moved(u, -1), p.Moved(u, -1).Moved(v, -1), p.Moved(v, -1)};
    const int edges[4] = {4 * d, 4 * d + 1, 4 * d + 3, 4 * d + 2};
    const Place solid = up ? p : p.Moved(d, 1);
    const std::uint8_t material = MaterialAt(solid);
    std::uint32_t c[4];
    bool shared[4], any = false;
    for (int n = 0; n < 4; ++n) c[n] = VertexOf(cells[n], edges[n]);
    for (int n = 0; n < 4; ++n) {
      // The face between this cell and the next continues along v, -u, -v, u.
      const int axis = n % 2 == 0 ? v : u, by = n == 0 || n == 3 ? 1 : -1;
      const Place other = p.Moved(axis, by);
      const int lower = other.index(), upper = lower + kPointStride[d];
      shared[n] = false;
      if ((solid_[lower] != 0) == up || (solid_[upper] != 0) != up) continue;  // not crossed twice
      const int flip = axis == u ? 1 : 2;
      const int next = (n + 1) % 4;
      shared[n] = SheetOf(cells[n], edges[n]) == SheetOf(cells[n], edges[n] ^ flip) &&
                  SheetOf(cells[next], edges[next]) == SheetOf(cells[next], edges[next] ^ flip);
      any = any || shared[n];
    }
    if (!any) {
      if (AddWhereCellsAreOne(c, !up, material)) return;
      // Choose the diagonal with which both triangles face the way of the crossing's normal.
      const Vec3 normal = (up ? 1.0 : -1.0) * EdgeAt(p, d).face[up ? 0 : 1].normal;
      const auto facing = [&](int i, int j, int k) {
        const Vec3& a = surface_.vertices[c[i]];
        return (surface_.vertices[c[j]] - a).cross(surface_.vertices[c[k]] - a).dot(normal);
      };
      const int n =
          std::min(facing(1, 2, 3), facing(1, 3, 0)) > std::min(facing(0, 1, 2), facing(0, 2, 3))
              ? 1
              : 0;
      AddTriangle(c[n], c[n + 1], c[n + 2], !up, material);
      AddTriangle(c[n], c[n + 2], c[(n + 3) % 4], !up, material);
      return;
    }
    const std::uint32_t here = CrossingOf(p, d);
    for (int n = 0; n < 4; ++n) {
      const int next = (n + 1) % 4;
      if (!shared[n]) {
        if (c[n] != c[next]) AddTriangle(here, c[n], c[next], !up, material);
        continue;
      }
      const int axis = n % 2 == 0 ? v : u;
      const bool ahead = n == 0 || n == 3;
      const std::uint32_t q = CrossingOf(ahead ? solid : solid.Moved(axis, -1), axis);
      // Of the two vertices, the one that comes before q, seen from the free side.
      AddTriangle(here, up ? c[n] : c[next], q, false, material);
    }
  }

  std::uint8_t MaterialAt(const Place& p) const {
    const int i = first_[0] + p.at[0] - kBefore, j = first_[1] + p.at[1] - kBefore,
              k = first_[2] + p.at[2] - kBefore;
    return grid_.MaterialOf(fields_of_.cut.BlockIndex(i >> 3, j >> 3, k >> 3),
                            SparseField::PointIndex(i, j, k));
  }

  static constexpr std::int16_t kNone = -1, kUnknown = -2, kAlone = -1;

  const SolidFields fields_of_;
  const SolidGrid& grid_;
  SolidSurface& surface_;
  const Lattice& lattice_;
  const float scale_;
  int first_[3];
  float fields_[2][kPoints];
  std::uint8_t solid_[kPoints], corners_[kPoints];
  std::array<std::int16_t, static_cast<std::size_t>(kEights* kEights* kEights)> eight_;
  std::int16_t vertex_[kPoints];                     ///< of a cell's first sheet, or kNone
  bool has_sheets_ = false, has_crossings_ = false;  ///< if false, the next two are not set
  std::int16_t sheet_[kPoints][3];                   ///< of its other sheets
  std::int16_t crossing_[kPoints][3];                ///< of an edge, or kNone
  static constexpr std::size_t kKept = 512;
  Edge kept_[kKept];
  /// 3 times the index of the lower end, plus the axis; or kNone
  std::int16_t kept_number_[kKept];
};

}  // namespace

void SolidSurface::Clear() {
  vertices.clear();
  numbers.clear();
  triangles.clear();
  materials.clear();
}

void TakeSurface(const SolidGrid& solid, const SparseField& cut, std::size_t block,
                 SolidSurface& surface) {
  surface.Clear();
  Contour contour({solid, cut}, block, surface);
  if (!contour.MayCross()) return;
  contour.Load();
  contour.Take();
}

std::size_t TakeSurfaceAndRim(const SolidFields& fields, std::size_t block, SolidSurface& surface) {
  surface.Clear();
  Contour contour(fields, block, surface);
  if (!contour.MayCross()) return 0;
  contour.Load();
  contour.Take();
  const std::size_t own = surface.triangles.size();
  if (own > 0) contour.TakeRim();
  return own;
}

SolidSurface WholeSurface(const CutField& cut) {
  SolidSurface all, one;
  std::unordered_map<std::uint64_t, std::uint32_t> known;
  for (std::size_t block = 0; block < cut.field().lattice().block_count(); ++block) {
    TakeSurface(cut.solid(), cut.field(), block, one);
    std::vector<std::uint32_t> at(one.vertices.size());
    for (std::size_t n = 0; n < at.size(); ++n) {
      const auto [place, fresh] =
          known.try_emplace(one.numbers[n], static_cast<std::uint32_t>(all.vertices.size()));
      at[n] = place->second;
      if (!fresh) continue;
      all.vertices.push_back(one.vertices[n]);
      all.numbers.push_back(one.numbers[n]);
    }
    for (const auto& [a, b, c] : one.triangles) all.triangles.push_back({at[a], at[b], at[c]});
    all.materials.insert(all.materials.end(), one.materials.begin(), one.materials.end());
  }
  return all;
}

}  // namespace palpate
