#include "scenes/error_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <spdlog/fmt/fmt.h>

#include "common/error.h"
#include "scenes/mesh/triangle.h"
#include "scenes/picture_canvas.h"
#include "scenes/picture_tile.h"
#include "scenes/tree/tree_error.h"
#include "scenes/tree/tree_mode.h"

namespace palpate {
namespace {

constexpr int kShownLevels = 3;
constexpr int kDecades = 3;  // of the scale, from its end to what counts as zero
constexpr std::size_t kSamples = 10007;

constexpr int kMargin = 16;
constexpr int kLine = 22;  // height of a line of text
constexpr int kHeading = 2 * kLine + kMargin;
constexpr int kTitle = 3 * kLine + kMargin;
constexpr int kBar = 26;
constexpr int kScale = kBar + 7 * kLine;

/// The colour where no sphere lies under the surface.
Colour BareColour() {
  return {0.55, 0.0, 0.6};
}

/// Blue below the mesh, red above it, pale on it; one hue for each decade.
Colour ColourAt(double place) {
  static const std::array<Colour, kDecades + 2> kAbove{
      Colour(0.9, 0.9, 0.87), Colour(1.0, 0.85, 0.35), Colour(1.0, 0.45, 0.05),
      Colour(0.8, 0.06, 0.03), Colour(0.25, 0.0, 0.01)};
  static const std::array<Colour, kDecades + 2> kBelow{
      Colour(0.9, 0.9, 0.87), Colour(0.45, 0.85, 0.9), Colour(0.1, 0.5, 0.95),
      Colour(0.03, 0.12, 0.75), Colour(0.0, 0.01, 0.2)};
  const auto& stops = place < 0.0 ? kBelow : kAbove;
  const double at = std::min(std::abs(place), 1.0) * (kDecades + 1);
  const auto stop = std::min(static_cast<std::size_t>(at), stops.size() - 2);
  return stops[stop] + (at - double(stop)) * (stops[stop + 1] - stops[stop]);
}

/// Returns the power of ten that includes all heights but the outermost hundredths.
double EndOfScale(const std::vector<UnionError>& errors) {
  double largest = 1e-7;
  for (const UnionError& e : errors) {
    largest = std::max({largest, -e.offset.p1, e.offset.p99});
  }
  return std::pow(10.0, std::ceil(std::log10(largest) - 1e-9));
}

std::string Title(int level, int levels, const UnionError& error) {
  return fmt::format("level {}, {}: {} sphere{}", level, level == levels ? "the leaves" : "bounds",
                     error.spheres, error.spheres == 1 ? "" : "s");
}

void DrawScale(Canvas& picture, int middle, int y, double largest, bool bare) {
  constexpr int kHalf = 400;
  for (int x = -kHalf; x <= kHalf; ++x) {
    picture.Fill(middle + x, y, 1, kBar, ColourAt(double(x) / kHalf));
  }
  const bool mm = largest > 1.5e-3;
  for (int decade = -kDecades - 1; decade <= kDecades + 1; ++decade) {
    const int x = middle + decade * kHalf / (kDecades + 1);
    picture.Fill(x, y + kBar, 1, 6, Colour::Zero());
    const double value =
        decade == 0 ? 0.0 : largest * std::pow(10.0, std::abs(decade) - kDecades - 1);
    picture.WriteCentred(
        decade == 0 ? "0" : fmt::format("{}{:g}", decade < 0 ? "-" : "+", (mm ? 1e3 : 1e6) * value),
        x, y + kBar + 10);
  }
  const int text = y + kBar + 10 + kLine;
  picture.WriteCentred(mm ? "mm" : "um", middle, text);
  picture.Write("inside: a tool sinks in", middle - kHalf, text);
  const std::string outside = "outside: it is stopped early";
  picture.Write(outside, middle + kHalf - int(outside.size()) * Canvas::kLetterWidth, text);
  int line = text + kLine + 8;
  if (bare) {
    picture.Fill(middle - kHalf, line, Canvas::kLetterHeight, Canvas::kLetterHeight, BareColour());
    picture.Write("no sphere under the surface at all", middle - kHalf + 24, line);
    line += kLine;
  }
  picture.Write("p1, p99: one place of 100 lies lower, one higher", middle - kHalf, line);
  picture.Write("bounds hold the leaves below them, and are not felt", middle - kHalf,
                line + kLine);
}

}  // namespace

double PlaceOnScale(double height, double largest) {
  const double decades = std::log10(std::max(std::abs(height) / largest, 1e-30)) + kDecades + 1;
  // The smallest decade is linear and begins at 0.
  const double smallest = largest * std::pow(10.0, -kDecades);
  const double place = decades >= 1.0 ? decades : std::abs(height) / smallest;
  return std::copysign(std::min(place / (kDecades + 1), 1.0), height);
}

void DrawError(const Body& body, std::optional<int> level, const std::string& png_file) {
  const int levels = body.tree.levels();
  if (level && (*level < 1 || *level > levels)) {
    throw UsageError(
        fmt::format("--level {}: {} has no such level; give 1 to {}", *level, body.name, levels));
  }
  const int first = level ? *level - 1 : std::max(0, levels - kShownLevels);
  const int end = level ? *level : levels;
  const std::vector<std::vector<Sphere>> balls = BallsByLevel(body.tree);
  const std::vector<UnionError> all = MeasureLevels(body.mesh, body.tree, kSamples);
  const std::vector<UnionError> errors(all.begin() + first, all.begin() + end);
  const double largest = EndOfScale(errors);

  const int width = std::max(end - first, 2) * Tile::kSide;
  Canvas picture(width, kHeading + Tile::kSide + kTitle + kScale);
  picture.Write(fmt::format("{}: how high the spheres lie over the mesh", body.name), kMargin,
                kMargin);
  const std::string mode(NameOf(body.tree.origin));
  picture.Write(fmt::format("{} triangles; tree: {}", body.mesh.triangles.size(), mode), kMargin,
                kMargin + kLine);
  const double furthest = BoxOf(body.mesh).diagonal().norm();
  bool bare = false;
  int x = (width - (end - first) * Tile::kSide) / 2;
  for (int l = first; l < end; ++l, x += Tile::kSide) {
    const SphereQuery query(balls[static_cast<std::size_t>(l)]);
    Tile tile(body.mesh);
    tile.Draw(body.mesh, Colour::Ones());
    tile.Paint(body.mesh, [&](const std::vector<SurfaceSample>& points) {
      std::vector<Colour> colours;
      for (const double height : OffsetsAt(points, query, furthest)) {
        bare = bare || std::isnan(height);
        colours.push_back(std::isnan(height) ? BareColour()
                                             : ColourAt(PlaceOnScale(height, largest)));
      }
      return colours;
    });
    picture.Place(tile, x, kHeading);
    const UnionError& e = all[static_cast<std::size_t>(l)];
    const bool mm = largest > 1.5e-3;
    const auto figure = [&](double height) {
      return mm ? fmt::format("{:.3f}", 1e3 * height) : fmt::format("{:.1f}", 1e6 * height);
    };
    const int below = kHeading + Tile::kSide + kMargin / 2;
    picture.Write(Title(l + 1, levels, e), x + kMargin, below);
    picture.Write(fmt::format("mean {} {}", figure(e.offset.mean), mm ? "mm" : "um"), x + kMargin,
                  below + kLine);
    picture.Write(fmt::format("p1 {}  p99 {} {}", figure(e.offset.p1), figure(e.offset.p99),
                              mm ? "mm" : "um"),
                  x + kMargin, below + 2 * kLine);
  }
  DrawScale(picture, width / 2, kHeading + Tile::kSide + kTitle + kMargin, largest, bare);
  picture.Save(png_file);
}

}  // namespace palpate
