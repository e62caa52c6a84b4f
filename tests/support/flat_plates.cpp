#include "tests/support/flat_plates.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <utility>
#include <vector>

#include "common/error.h"
#include "tests/support/random.h"

namespace palpate::test {
namespace {

using Corners = std::array<std::uint32_t, 3>;

/// A triangulated square of the plane; points are (z, x), so that x, y and z turn as usual.
struct Top {
  struct Point {
    double z, x;
  };
  std::vector<Point> points;
  std::vector<Corners> triangles;

  std::uint32_t Add(double z, double x) {
    points.push_back({z, x});
    return static_cast<std::uint32_t>(points.size() - 1);
  }
  /// Returns twice the signed area, positive if counter-clockwise seen from +y.
  double Area(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
    const Point &A = points[a], &B = points[b], &C = points[c];
    return (B.z - A.z) * (C.x - A.x) - (B.x - A.x) * (C.z - A.z);
  }
};

/// Closes a top to a plate, by the same triangles below and walls at the rim.
TriangleMesh Closed(const Top& top) {
  TriangleMesh plate;
  const auto n = static_cast<std::uint32_t>(top.points.size());
  for (const double y : {0.0, -kPlateThickness}) {
    for (const Top::Point& p : top.points) plate.vertices.push_back({p.x, y, p.z});
  }
  const auto at_rim = [&](std::uint32_t a, std::uint32_t b) {
    const Top::Point &A = top.points[a], &B = top.points[b];
    return (A.x == B.x && std::abs(A.x) == kPlateHalf) ||
           (A.z == B.z && std::abs(A.z) == kPlateHalf);
  };
  for (const auto& [a, b, c] : top.triangles) {
    plate.triangles.push_back({a, b, c});
    plate.triangles.push_back({a + n, c + n, b + n});
    for (const auto& [p, q] : {std::pair(a, b), std::pair(b, c), std::pair(c, a)}) {
      if (!at_rim(p, q)) continue;
      plate.triangles.push_back({p, p + n, q + n});
      plate.triangles.push_back({p, q + n, q});
    }
  }
  return plate;
}

std::vector<double> Equal(int parts, double low, double high) {
  std::vector<double> lines;
  for (int i = 0; i < parts; ++i) lines.push_back(low + (high - low) * i / parts);
  lines.push_back(high);
  return lines;
}

/// Lines from rim to rim, whose distances are spread evenly over the decades from 1 nm to 10 mm.
std::vector<double> AcrossDecades(Random& random) {
  std::vector<double> lines{-kPlateHalf};
  for (;;) {
    const double next = lines.back() + std::pow(10.0, random.Uniform(-9.0, -2.0));
    if (next > kPlateHalf - 1e-9) break;
    lines.push_back(next);
  }
  lines.push_back(kPlateHalf);
  return lines;
}

/// Lines that grow apart from a point within 5 mm of the middle, each distance `ratio` times the
/// last, from 1 nm to 10 mm.
std::vector<double> GradedLines(Random& random) {
  const double from = random.Uniform(-0.005, 0.005), ratio = random.Uniform(1.5, 10.0);
  std::vector<double> lines{-kPlateHalf, from, kPlateHalf};
  for (const double side : {-1.0, 1.0}) {
    double at = from;
    for (double step = 1e-9;; step = std::min(0.01, step * ratio)) {
      at += side * step;
      if (std::abs(at) > kPlateHalf - 1e-4) break;
      lines.push_back(at);
    }
  }
  std::sort(lines.begin(), lines.end());
  return lines;
}

/// Adds a grid; `falls(i, j)` says which diagonal a cell has.
template <class Falls>
void AddGrid(Top& top, const std::vector<double>& z, const std::vector<double>& x, Falls falls) {
  const auto first = static_cast<std::uint32_t>(top.points.size());
  for (const double at_z : z) {
    for (const double at_x : x) top.Add(at_z, at_x);
  }
  const auto at = [&](std::size_t i, std::size_t j) {
    return first + static_cast<std::uint32_t>(i * x.size() + j);
  };
  for (std::size_t i = 0; i + 1 < z.size(); ++i) {
    for (std::size_t j = 0; j + 1 < x.size(); ++j) {
      const std::uint32_t a = at(i, j), b = at(i + 1, j), c = at(i + 1, j + 1), d = at(i, j + 1);
      if (falls(i, j)) {
        top.triangles.insert(top.triangles.end(), {{a, b, d}, {b, c, d}});
      } else {
        top.triangles.insert(top.triangles.end(), {{a, b, c}, {a, c, d}});
      }
    }
  }
}
bool Rises(std::size_t, std::size_t) {
  return false;
}
std::vector<double> Sides() {
  return Equal(1, -kPlateHalf, kPlateHalf);
}

Top Diagonals(Random& random) {
  const int cells = 5 + random.Below(56);
  const std::vector<double> lines = Equal(cells, -kPlateHalf, kPlateHalf);
  Top top;
  AddGrid(top, lines, lines, [&](std::size_t, std::size_t) { return random.Below(2) == 0; });
  // By less than a quarter of a cell: no quadrangle loses its shape.
  const double most = 0.24 * 2.0 * kPlateHalf / cells;
  for (Top::Point& p : top.points) {
    const double dz = random.Uniform(-most, most), dx = random.Uniform(-most, most);
    if (std::abs(p.z) != kPlateHalf) p.z += dz;
    if (std::abs(p.x) != kPlateHalf) p.x += dx;
  }
  return top;
}

Top Fan(Random& random) {
  Top top;
  const double z = random.Uniform(-0.01, 0.01), x = random.Uniform(-0.01, 0.01);
  const std::uint32_t middle = top.Add(z, x);
  const int per_side = 3 + random.Below(73);
  for (int side = 0; side < 4; ++side) {
    for (int i = 0; i < per_side; ++i) {
      const double s = kPlateHalf * (2.0 * i / per_side - 1.0);
      if (side == 0) top.Add(s, -kPlateHalf);
      if (side == 1) top.Add(kPlateHalf, s);
      if (side == 2) top.Add(-s, kPlateHalf);
      if (side == 3) top.Add(-kPlateHalf, -s);
    }
  }
  const std::uint32_t rim = static_cast<std::uint32_t>(4 * per_side);
  for (std::uint32_t i = 0; i < rim; ++i) {
    top.triangles.push_back({middle, 1 + i, 1 + (i + 1) % rim});
  }
  return top;
}

/// Divides a triangle in three at a point.
void Split(Top& top, std::size_t triangle, const Top::Point& at) {
  const auto [a, b, c] = top.triangles[triangle];
  const std::uint32_t p = top.Add(at.z, at.x);
  top.triangles[triangle] = {a, b, p};
  top.triangles.push_back({b, c, p});
  top.triangles.push_back({c, a, p});
}

Top Splits(Random& random) {
  Top top;
  AddGrid(top, Sides(), Sides(), Rises);
  const int count = 20 + random.Below(600);
  for (int i = 0; i < count; ++i) {
    const auto t = static_cast<std::size_t>(random.Below(static_cast<int>(top.triangles.size())));
    double weight[3];
    for (double& w : weight) w = random.Uniform(0.05, 1.0);
    Top::Point at{0.0, 0.0};
    double longest = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
      const Top::Point &p = top.points[top.triangles[t][k]],
                       &next = top.points[top.triangles[t][(k + 1) % 3]];
      const double share = weight[k] / (weight[0] + weight[1] + weight[2]);
      at.z += share * p.z;
      at.x += share * p.x;
      longest = std::max(longest, std::hypot(next.z - p.z, next.x - p.x));
    }
    // No triangle lower than a few nanometres: in it the point's rounding would count.
    const auto& [a, b, c] = top.triangles[t];
    if (top.Area(a, b, c) < 1e-7 * longest) continue;
    Split(top, t, at);
  }
  return top;
}

/// Exchanges diagonals until no triangle's circle holds another point (Lawson 1977).
void MakeDelaunay(Top& top) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> of_edge;
  const auto enter = [&](std::size_t t) {
    const auto& [a, b, c] = top.triangles[t];
    of_edge[{a, b}] = of_edge[{b, c}] = of_edge[{c, a}] = t;
  };
  for (std::size_t t = 0; t < top.triangles.size(); ++t) enter(t);
  const auto across = [&](std::size_t t, std::uint32_t a, std::uint32_t b) {
    for (const std::uint32_t v : top.triangles[t]) {
      if (v != a && v != b) return v;
    }
    return a;
  };
  const auto angle = [&](std::uint32_t at, std::uint32_t a, std::uint32_t b) {
    const Top::Point &P = top.points[at], &A = top.points[a], &B = top.points[b];
    return std::atan2(std::abs(top.Area(at, a, b)),
                      (A.z - P.z) * (B.z - P.z) + (A.x - P.x) * (B.x - P.x));
  };
  for (bool flipped = true; flipped;) {
    flipped = false;
    const auto edges = of_edge;
    for (const auto& entry : edges) {
      const auto [a, b] = entry.first;
      const auto one = of_edge.find({a, b}), other = of_edge.find({b, a});
      if (a > b || one == of_edge.end() || other == of_edge.end()) continue;
      const std::size_t s = one->second, t = other->second;
      const std::uint32_t c = across(s, a, b), d = across(t, a, b);
      if (angle(c, a, b) + angle(d, a, b) <= M_PI + 1e-9) continue;
      if (!(top.Area(a, d, c) > 0.0) || !(top.Area(d, b, c) > 0.0)) continue;
      of_edge.erase(one);
      of_edge.erase({b, a});
      top.triangles[s] = {a, d, c};
      top.triangles[t] = {d, b, c};
      enter(s);
      enter(t);
      flipped = true;
    }
  }
}

Top Delaunay(Random& random) {
  Top top;
  AddGrid(top, Sides(), Sides(), Rises);
  const int count = 10 + random.Below(800);
  for (int i = 0; i < count; ++i) {
    const double z = random.Uniform(-kPlateHalf, kPlateHalf),
                 x = random.Uniform(-kPlateHalf, kPlateHalf);
    const std::uint32_t p = top.Add(z, x);
    const auto holds = [&](const Corners& t) {
      return top.Area(t[0], t[1], p) > 1e-12 && top.Area(t[1], t[2], p) > 1e-12 &&
             top.Area(t[2], t[0], p) > 1e-12;
    };
    const auto found = std::find_if(top.triangles.begin(), top.triangles.end(), holds);
    top.points.pop_back();
    if (found == top.triangles.end()) continue;  // on an edge
    Split(top, static_cast<std::size_t>(found - top.triangles.begin()), {z, x});
  }
  MakeDelaunay(top);
  return top;
}

Top TJunctions(Random& random) {
  Top top;
  const std::vector<double> lines = Equal(2 + random.Below(7), -kPlateHalf, kPlateHalf);
  for (std::size_t i = 0; i + 1 < lines.size(); ++i) {
    for (std::size_t j = 0; j + 1 < lines.size(); ++j) {
      const int parts = 1 + random.Below(12);
      AddGrid(top, Equal(parts, lines[i], lines[i + 1]), Equal(parts, lines[j], lines[j + 1]),
              Rises);
    }
  }
  return top;
}

Top Unwelded(const Top& top) {
  Top soup;
  for (const Corners& t : top.triangles) {
    Corners own{};
    for (std::size_t k = 0; k < 3; ++k) own[k] = soup.Add(top.points[t[k]].z, top.points[t[k]].x);
    soup.triangles.push_back(own);
  }
  return soup;
}

Top TopOf(std::string_view tessellation, Random& random) {
  Top top;
  if (tessellation == "quad") {
    AddGrid(top, Sides(), Sides(), Rises);
  } else if (tessellation == "strips") {
    AddGrid(top, Sides(), Equal(3 + random.Below(118), -kPlateHalf, kPlateHalf), Rises);
  } else if (tessellation == "grid") {
    const std::vector<double> lines = Equal(5 + random.Below(56), -kPlateHalf, kPlateHalf);
    AddGrid(top, lines, lines, Rises);
  } else if (tessellation == "needles") {
    AddGrid(top, Sides(), AcrossDecades(random), Rises);
  } else if (tessellation == "graded") {
    const std::vector<double> z = GradedLines(random);
    AddGrid(top, z, GradedLines(random), Rises);
  } else if (tessellation == "diagonals") {
    top = Diagonals(random);
  } else if (tessellation == "fan") {
    top = Fan(random);
  } else if (tessellation == "splits") {
    top = Splits(random);
  } else if (tessellation == "delaunay") {
    top = Delaunay(random);
  } else if (tessellation == "t-junctions") {
    top = TJunctions(random);
  } else if (tessellation == "soup") {
    top = Unwelded(Diagonals(random));
  } else {
    throw Error("no tessellation is called '" + std::string(tessellation) + "'");
  }
  return top;
}

}  // namespace

TriangleMesh MakePlate(std::string_view tessellation, std::uint64_t seed) {
  Random random(seed);
  return Closed(TopOf(tessellation, random));
}

}  // namespace palpate::test
