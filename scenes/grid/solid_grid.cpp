#include "scenes/grid/solid_grid.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/error.h"
#include "scenes/mesh/figure.h"
#include "scenes/mesh/mesh_edges.h"
#include "scenes/mesh/mesh_query.h"

namespace palpate {
namespace {

constexpr double kLeastSpacing = 25e-6, kMostSpacing = 200e-6;
/// The lattice is offset from the mesh's box by this share of a spacing, so that faces at round
/// coordinates contain none of its points; empirical.
constexpr double kOffset = 0.382;

std::string MegaBytes(double bytes) {
  return Figure(bytes / (1 << 20), 3) + " MB";
}

void RefuseAbove(double bytes, const SolidGridOptions& options, const std::string& name) {
  if (bytes <= static_cast<double>(options.most_bytes)) return;
  // Nearly all of a grid is surface blocks, whose number is proportional to 1 / spacing^2.
  throw Error(name + ": a grid of " + Figure(1e6 * options.spacing, 3) + " um takes " +
              MegaBytes(bytes) + ", and may take " +
              MegaBytes(static_cast<double>(options.most_bytes)) +
              "; use a larger spacing, or a smaller body");
}

/// Returns the smallest lattice that contains the mesh and its band.
Lattice LatticeOf(const TriangleMesh& mesh, const SolidGridOptions& options,
                  const std::string& name) {
  const double h = options.spacing;
  if (!(h >= 0.999 * kLeastSpacing && h <= 1.001 * kMostSpacing)) {
    throw Error(name + ": a grid's spacing of " + Figure(1e6 * h, 3) +
                " um is not allowed; give 25 to 200 um");
  }
  CheckEncloses(mesh, name);
  Vec3 low = Vec3::Constant(1e300), high = -low;
  for (const auto& corners : mesh.triangles) {
    for (const std::uint32_t v : corners) {
      low = low.cwiseMin(mesh.vertices[v]);
      high = high.cwiseMax(mesh.vertices[v]);
    }
  }
  Lattice lattice;
  lattice.spacing = h;
  lattice.origin = low - Vec3::Constant((SolidGrid::kBandSpacings + 1 + kOffset) * h);
  double blocks = 1.0;
  for (int a = 0; a < 3; ++a) {
    const double points = (high[a] - lattice.origin[a]) / h + SolidGrid::kBandSpacings + 2;
    const double along = std::ceil(points / SparseField::kSide);
    blocks *= along;
    RefuseAbove(blocks * 2 * sizeof(std::int32_t), options, name);
    lattice.blocks[static_cast<std::size_t>(a)] = static_cast<int>(along);
  }
  // Needed temporarily: the lines along z (Crossings).
  const double lines = 64.0 * lattice.blocks[0] * lattice.blocks[1];
  RefuseAbove(lines * sizeof(std::size_t), options, name);
  return lattice;
}

/// The points or blocks of a lattice within `reach` of a box, from low to high, both included.
struct Range {
  int low[3], high[3];
  Range(const Lattice& lattice, int side, const Vec3& min, const Vec3& max) {
    for (int a = 0; a < 3; ++a) {
      const double step = lattice.spacing * side;
      const int last = lattice.blocks[static_cast<std::size_t>(a)] * SparseField::kSide / side - 1;
      low[a] = std::max(0, static_cast<int>(std::floor((min[a] - lattice.origin[a]) / step)));
      high[a] = std::min(last, static_cast<int>(std::floor((max[a] - lattice.origin[a]) / step)));
    }
  }
  template <class Visit>
  void Each(Visit visit) const {
    for (int k = low[2]; k <= high[2]; ++k) {
      for (int j = low[1]; j <= high[1]; ++j) {
        for (int i = low[0]; i <= high[0]; ++i) visit(i, j, k);
      }
    }
  }
};

struct Facet {
  Vec3 a, b, c;
  Facet(const TriangleMesh& mesh, std::size_t t)
      : a(mesh.vertices[mesh.triangles[t][0]]),
        b(mesh.vertices[mesh.triangles[t][1]]),
        c(mesh.vertices[mesh.triangles[t][2]]) {}
  Vec3 min() const { return a.cwiseMin(b).cwiseMin(c); }
  Vec3 max() const { return a.cwiseMax(b).cwiseMax(c); }
  double DistanceTo(const Vec3& p) const { return (NearestOnTriangle(p, a, b, c) - p).norm(); }
};

/// Calls visit(block, i, j, k) for each block with points within the band of a triangle.
template <class Visit>
void EachBlockBeside(const Facet& corners, const SparseField& field, Visit visit) {
  const Lattice& lattice = field.lattice();
  const Vec3 margin = Vec3::Constant(field.band());
  // From a block's centre to its farthest point: 3.5 spacings along each axis.
  const double reach = field.band() + 3.5 * std::sqrt(3.0) * lattice.spacing;
  Range(lattice, SparseField::kSide, corners.min() - margin - Vec3::Constant(lattice.spacing),
        corners.max() + margin)
      .Each([&](int i, int j, int k) {
        const Vec3 middle =
            lattice.Point(8 * i, 8 * j, 8 * k) + Vec3::Constant(3.5 * lattice.spacing);
        if (corners.DistanceTo(middle) <= reach) visit(field.BlockIndex(i, j, k), i, j, k);
      });
}

/// The points where lines along z through the lattice's points cross the mesh.  The side on which a
/// line passes an edge is decided for the edge, not for its triangles, and a line that meets an
/// edge is moved aside by an infinitely small (e, e^2) (Edelsbrunner & Muecke, ACM T. Graphics 9
/// (1990) 66-104).  So each line enters as often as it leaves.
class Crossings {
 public:
  Crossings(const TriangleMesh& mesh, const Lattice& lattice)
      : lattice_(lattice),
        columns_(static_cast<std::size_t>(lattice.blocks[0] * SparseField::kSide)) {
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const Facet corners(mesh, t);
      const Range range(lattice, 1, corners.min() - Vec3::Constant(lattice.spacing),
                        corners.max() + Vec3::Constant(lattice.spacing));
      for (int j = range.low[1]; j <= range.high[1]; ++j) {
        for (int i = range.low[0]; i <= range.high[0]; ++i) Cross(mesh, t, corners, i, j);
      }
    }
    std::sort(all_.begin(), all_.end(), [](const Crossing& a, const Crossing& b) {
      return a.line != b.line ? a.line < b.line : a.z < b.z;
    });
    begin_.assign(columns_ * static_cast<std::size_t>(lattice.blocks[1] * SparseField::kSide) + 1,
                  0);
    for (const Crossing& crossing : all_) ++begin_[crossing.line + 1];
    for (std::size_t n = 1; n < begin_.size(); ++n) begin_[n] += begin_[n - 1];
  }

  /// Returns whether the mesh winds round the point.
  bool Inside(int i, int j, int k) const {
    const std::size_t line = LineOf(i, j);
    const double z = lattice_.Point(i, j, k).z();
    int winding = 0;
    for (std::size_t n = begin_[line]; n < begin_[line + 1] && all_[n].z < z; ++n) {
      winding += all_[n].enters;
    }
    return winding > 0;
  }

 private:
  struct Crossing {
    std::size_t line;
    int enters;  ///< 1 if the line, going up, enters the solid there; -1 if it leaves
    double z;
  };

  std::size_t LineOf(int i, int j) const {
    return static_cast<std::size_t>(j) * columns_ + static_cast<std::size_t>(i);
  }

  /// Returns twice the signed area of p and an edge, seen from above; 0 for an edge along z.
  static double Side(const TriangleMesh& mesh, std::uint32_t from, std::uint32_t to, double x,
                     double y, int& sign) {
    const bool turn = from > to;
    const Vec3& a = mesh.vertices[turn ? to : from];
    const Vec3& b = mesh.vertices[turn ? from : to];
    const double dx = b.x() - a.x(), dy = b.y() - a.y();
    const double area = dx * (y - a.y()) - dy * (x - a.x());
    const double decides = area != 0.0 ? area : dy != 0.0 ? -dy : dx;
    sign = (decides > 0.0) - (decides < 0.0);
    if (turn) sign = -sign;
    return turn ? -area : area;
  }

  void Cross(const TriangleMesh& mesh, std::size_t t, const Facet& corners, int i, int j) {
    const Vec3 p = lattice_.Point(i, j, 0);
    const auto& [a, b, c] = mesh.triangles[t];
    int s, sign;
    const double of_c = Side(mesh, a, b, p.x(), p.y(), sign);
    const double of_a = Side(mesh, b, c, p.x(), p.y(), s);
    if (s == 0 || s != sign) return;
    const double of_b = Side(mesh, c, a, p.x(), p.y(), s);
    const double sum = of_a + of_b + of_c;
    if (s != sign || sum == 0.0) return;
    const double z = (of_a * corners.a.z() + of_b * corners.b.z() + of_c * corners.c.z()) / sum;
    all_.push_back({LineOf(i, j), -sign, std::clamp(z, corners.min().z(), corners.max().z())});
  }

  Lattice lattice_;
  std::size_t columns_;
  std::vector<Crossing> all_;
  std::vector<std::size_t> begin_;
};

}  // namespace

SolidGrid::SolidGrid(const TriangleMesh& mesh, const SolidGridOptions& options,
                     const std::string& name)
    : field_(LatticeOf(mesh, options, name), static_cast<float>(kBandSpacings * options.spacing),
             SparseField::kAbove) {
  const Lattice& lattice = field_.lattice();
  std::vector<std::uint8_t> beside(lattice.block_count(), 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    EachBlockBeside(Facet(mesh, t), field_,
                    [&](std::size_t block, int, int, int) { beside[block] = 1; });
  }
  const auto stored = static_cast<std::size_t>(std::count(beside.begin(), beside.end(), 1));
  RefuseAbove(static_cast<double>(SparseField::BytesOf(beside.size(), stored) +
                                  beside.size() * sizeof(std::int32_t)),
              options, name);
  field_.Reserve(stored);
  for (std::size_t block = 0; block < beside.size(); ++block) {
    if (beside[block]) field_.Acquire(block);
  }
  // The distance, at every point within the band.
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Facet corners(mesh, t);
    const Vec3 margin = Vec3::Constant(field_.band());
    Range near(lattice, 1, corners.min() - margin, corners.max() + margin);
    EachBlockBeside(corners, field_, [&](std::size_t block, int bi, int bj, int bk) {
      float* values = field_.values(field_.entry(block));
      Range here = near;
      const int first[3] = {8 * bi, 8 * bj, 8 * bk};
      for (int a = 0; a < 3; ++a) {
        here.low[a] = std::max(here.low[a], first[a]);
        here.high[a] = std::min(here.high[a], first[a] + 7);
      }
      here.Each([&](int i, int j, int k) {
        float& value = values[SparseField::PointIndex(i, j, k)];
        value = std::min(value, static_cast<float>(corners.DistanceTo(lattice.Point(i, j, k))));
      });
    });
  }
  // The sign.
  const Crossings crossings(mesh, lattice);
  Range(lattice, SparseField::kSide, lattice.origin,
        lattice.Point(8 * lattice.blocks[0], 8 * lattice.blocks[1], 8 * lattice.blocks[2]))
      .Each([&](int bi, int bj, int bk) {
        const std::size_t block = field_.BlockIndex(bi, bj, bk);
        if (const std::int32_t entry = field_.entry(block); entry >= 0) {
          float* values = field_.values(entry);
          for (int n = 0; n < SparseField::kPoints; ++n) {
            if (crossings.Inside(8 * bi + (n & 7), 8 * bj + (n >> 3 & 7), 8 * bk + (n >> 6))) {
              values[n] = -values[n];
            }
          }
        } else if (crossings.Inside(8 * bi, 8 * bj, 8 * bk)) {
          field_.Fill(block, SparseField::kBelow);
        }
        solid_blocks_ += field_.entry(block) != SparseField::kAbove;
      });
  TakeMaterials(options, name);
}

void SolidGrid::TakeMaterials(const SolidGridOptions& options, const std::string& name) {
  const Lattice& lattice = field_.lattice();
  material_.assign(lattice.block_count(), -1);
  if (!options.material) return;
  std::vector<std::uint8_t> here(SparseField::kPoints);
  for (std::size_t block = 0; block < material_.size(); ++block) {
    if (field_.entry(block) == SparseField::kAbove) continue;
    const auto x = static_cast<std::size_t>(lattice.blocks[0]);
    const auto y = static_cast<std::size_t>(lattice.blocks[1]);
    const int bi = static_cast<int>(block % x), bj = static_cast<int>(block / x % y),
              bk = static_cast<int>(block / x / y);
    for (int n = 0; n < SparseField::kPoints; ++n) {
      const Vec3 p = lattice.Point(8 * bi + (n & 7), 8 * bj + (n >> 3 & 7), 8 * bk + (n >> 6));
      here[static_cast<std::size_t>(n)] = options.material(p);
      if (here[static_cast<std::size_t>(n)] >= kMaterials) {
        throw Error(name + ": material " + std::to_string(here[static_cast<std::size_t>(n)]) +
                    " is not allowed; a grid has 0 to " + std::to_string(kMaterials - 1));
      }
    }
    material_[block] = -1 - here[0];
    if (std::all_of(here.begin(), here.end(), [&](std::uint8_t m) { return m == here[0]; })) {
      continue;
    }
    RefuseAbove(static_cast<double>(bytes() + SparseField::kPoints), options, name);
    material_[block] = static_cast<std::int32_t>(mixed_.size() / SparseField::kPoints);
    mixed_.insert(mixed_.end(), here.begin(), here.end());
  }
}

std::uint8_t SolidGrid::Material(const Vec3& p_B) const noexcept {
  const Lattice& lattice = field_.lattice();
  const Vec3 at = (p_B - lattice.origin) / lattice.spacing + Vec3::Constant(0.5);
  int c[3];
  for (int a = 0; a < 3; ++a) {
    if (!(at[a] >= 0.0 && at[a] < 8 * lattice.blocks[static_cast<std::size_t>(a)])) return 0;
    c[a] = static_cast<int>(at[a]);
  }
  return MaterialOf(field_.BlockIndex(c[0] >> 3, c[1] >> 3, c[2] >> 3),
                    SparseField::PointIndex(c[0], c[1], c[2]));
}

void CheckEncloses(const TriangleMesh& mesh, const std::string& name) {
  if (mesh.triangles.empty()) {
    throw Error(name + ": the mesh has no triangle; give a closed one");
  }
  if (const std::size_t open = OpenEdges(mesh).size(); open > 0) {
    throw Error(name + ": the mesh is open at " + std::to_string(open) +
                " edges, so it encloses no solid; close its holes in a mesh editor, or give it a "
                "thickness (\"thickness_mm\" in a scene file)");
  }
  double volume = 0.0;
  for (const auto& [i, j, k] : mesh.triangles) {
    volume += mesh.vertices[i].dot(mesh.vertices[j].cross(mesh.vertices[k])) / 6.0;
  }
  if (!(volume > 0.0)) {  // false, too, if a vertex is not finite
    throw Error(name +
                ": the mesh encloses no volume, or a negative one; flip its triangles to be "
                "counter-clockwise "
                "seen from outside");
  }
}

std::shared_ptr<const SolidGrid> MakeSolidGrid(const Body& body) {
  if (body.materials.size() > SolidGrid::kMaterials) {
    throw Error(body.name + ": a body that burs cut has " + std::to_string(SolidGrid::kMaterials) +
                " materials at most, but this one has " + std::to_string(body.materials.size()));
  }
  SolidGridOptions options{.spacing = body.grid->spacing, .most_bytes = kMostGridBytes};
  const std::vector<MaterialRegion>& regions = body.grid->regions;
  const Lattice lattice = LatticeOf(body.mesh, options, body.name);
  std::vector<std::optional<Crossings>> windings(regions.size());  // for regions that are meshes
  for (std::size_t r = 0; r < regions.size(); ++r) {
    if (regions[r].mesh.triangles.empty()) continue;
    CheckEncloses(regions[r].mesh, body.name + ": region " + std::to_string(r));
    windings[r].emplace(regions[r].mesh, lattice);
  }
  options.material = [&](const Vec3& p_B) {
    // Called only for points of the lattice.
    const Eigen::Vector3i at =
        ((p_B - lattice.origin) / lattice.spacing).array().round().cast<int>();
    std::uint8_t material = 0;
    for (std::size_t r = 0; r < regions.size(); ++r) {
      if (windings[r] ? windings[r]->Inside(at.x(), at.y(), at.z()) : regions[r].Holds(p_B)) {
        material = regions[r].material;
      }
    }
    return material;
  };
  return std::make_shared<const SolidGrid>(body.mesh, options, body.name);
}

}  // namespace palpate
