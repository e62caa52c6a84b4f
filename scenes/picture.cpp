#include "scenes/picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string_view>
#include <vector>

#include <png.h>

#include "common/error.h"

namespace palpate {
namespace {

constexpr int kTile = 480;        // side of one picture [pixels]
constexpr int kOversampling = 2;  // each way, averaged away in the end
constexpr int kFine = kTile * kOversampling;
constexpr double kFill = 0.78;  // of a tile's side: the mesh's diameter

using Colour = Eigen::Array3d;  ///< linear, 0 to 1

/// One picture, seen by a distant eye: x to the right, y down, z towards the eye.
class Tile {
 public:
  /// @param centre, radius  ball round the mesh [m].
  Tile(const Vec3& centre, double radius)
      : centre_(centre),
        scale_(0.5 * kFill * kFine / radius),
        depth_(kFine * kFine, -std::numeric_limits<double>::infinity()),
        colour_(kFine * kFine) {
    for (int y = 0; y < kFine; ++y) {
      const Colour sky = Colour(0.93, 0.95, 0.97) - 0.18 * y / kFine;
      std::fill_n(colour_.begin() + y * kFine, kFine, sky);
    }
    const Vec3 to_eye = Vec3(0.45, 0.3, 1.0).normalized();
    const Vec3 right = Vec3::UnitY().cross(to_eye).normalized();
    view_ << right.transpose(), to_eye.cross(right).transpose(), to_eye.transpose();
  }

  void Draw(const TriangleMesh& mesh, const Colour& colour) {
    std::vector<Vec3> normals(mesh.vertices.size(), Vec3::Zero());
    for (const auto& [i, j, k] : mesh.triangles) {
      const Vec3& a = mesh.vertices[i];
      const Vec3 n = (mesh.vertices[j] - a).cross(mesh.vertices[k] - a);
      for (std::uint32_t v : {i, j, k}) normals[v] += n;
    }
    for (const auto& triangle : mesh.triangles) {
      std::array<Vec3, 3> p;
      std::array<Vec3, 3> n;
      const Vec3& a = mesh.vertices[triangle[0]];
      const Vec3 facet =
          (mesh.vertices[triangle[1]] - a).cross(mesh.vertices[triangle[2]] - a).normalized();
      for (int c = 0; c < 3; ++c) {
        p[c] = ToPixels(mesh.vertices[triangle[c]]);
        // Smooth where the surface is, sharp at edges of more than about 40 degrees.
        const Vec3 smooth = normals[triangle[c]].normalized();
        n[c] = view_ * (smooth.dot(facet) > 0.77 ? smooth : facet);
      }
      DrawTriangle(p, n, colour);
    }
  }

  void DrawSphere(const Vec3& centre, double radius, const Colour& colour) {
    const Vec3 c = ToPixels(centre);
    const double r = radius * scale_;
    const auto [x0, x1] = Span(c.x() - r, c.x() + r);
    const auto [y0, y1] = Span(c.y() - r, c.y() + r);
    for (int y = y0; y <= y1; ++y) {
      for (int x = x0; x <= x1; ++x) {
        const double dx = x + 0.5 - c.x();
        const double dy = y + 0.5 - c.y();
        const double dz2 = r * r - dx * dx - dy * dy;
        if (dz2 < 0.0) continue;
        const double dz = std::sqrt(dz2);
        Put(x, y, c.z() + dz, Vec3(dx, -dy, dz) / r, colour);
      }
    }
  }

  /// Darkens what lies in hollows: the share of points around that stand nearer to the eye.
  void ShadeHollows() {
    std::vector<double> light(colour_.size(), 1.0);
    for (int y = 0; y < kFine; ++y) {
      for (int x = 0; x < kFine; ++x) {
        const double z = depth_[y * kFine + x];
        if (!std::isfinite(z)) continue;
        double hidden = 0.0;
        for (int k = 0; k < 24; ++k) {
          // A spiral of the golden angle, 2.4 rad.
          const double reach = 0.045 * kFine * std::sqrt((k + 0.5) / 24.0);
          const int sx = x + static_cast<int>(reach * std::cos(2.4 * k));
          const int sy = y + static_cast<int>(reach * std::sin(2.4 * k));
          if (sx < 0 || sy < 0 || sx >= kFine || sy >= kFine) continue;
          const double above = depth_[sy * kFine + sx] - z - 0.3 * reach;
          if (above > 0.0 && above < 4.0 * reach + 20.0) hidden += 1.0;
        }
        light[y * kFine + x] = 1.0 - 0.55 * hidden / 24.0;
      }
    }
    for (std::size_t i = 0; i < light.size(); ++i) colour_[i] *= light[i];
  }

  Colour At(int x, int y) const {
    Colour sum = Colour::Zero();
    for (int dy = 0; dy < kOversampling; ++dy) {
      for (int dx = 0; dx < kOversampling; ++dx) {
        sum += colour_[(y * kOversampling + dy) * kFine + x * kOversampling + dx];
      }
    }
    return sum / (kOversampling * kOversampling);
  }

 private:
  Vec3 ToPixels(const Vec3& p) const {
    const Vec3 v = scale_ * (view_ * (p - centre_));
    return {0.5 * kFine + v.x(), 0.5 * kFine - v.y(), v.z()};
  }

  static std::pair<int, int> Span(double low, double high) {
    return {std::clamp(static_cast<int>(low), 0, kFine),
            std::clamp(static_cast<int>(high), -1, kFine - 1)};
  }

  void DrawTriangle(const std::array<Vec3, 3>& p, const std::array<Vec3, 3>& n,
                    const Colour& colour) {
    const auto [x0, x1] =
        Span(std::min({p[0].x(), p[1].x(), p[2].x()}), std::max({p[0].x(), p[1].x(), p[2].x()}));
    const auto [y0, y1] =
        Span(std::min({p[0].y(), p[1].y(), p[2].y()}), std::max({p[0].y(), p[1].y(), p[2].y()}));
    const auto cross = [](const Vec3& a, const Vec3& b, double x, double y) {
      return (b.x() - a.x()) * (y - a.y()) - (b.y() - a.y()) * (x - a.x());
    };
    const double area = cross(p[0], p[1], p[2].x(), p[2].y());
    if (area == 0.0) return;
    for (int y = y0; y <= y1; ++y) {
      for (int x = x0; x <= x1; ++x) {
        const double u = cross(p[1], p[2], x + 0.5, y + 0.5) / area;
        const double v = cross(p[2], p[0], x + 0.5, y + 0.5) / area;
        const double w = 1.0 - u - v;
        if (u < 0.0 || v < 0.0 || w < 0.0) continue;
        Vec3 normal = (u * n[0] + v * n[1] + w * n[2]).normalized();
        if (normal.z() < 0.0) normal = -normal;  // the back of an open mesh
        Put(x, y, u * p[0].z() + v * p[1].z() + w * p[2].z(), normal, colour);
      }
    }
  }

  void Put(int x, int y, double z, const Vec3& normal, const Colour& colour) {
    double& depth = depth_[y * kFine + x];
    if (z <= depth) return;
    depth = z;
    static const Vec3 kKey = Vec3(-0.5, 0.65, 0.6).normalized();
    static const Vec3 kShine = (kKey + Vec3::UnitZ()).normalized();
    const double key = std::max(0.0, normal.dot(kKey));
    const double sky = 0.5 + 0.5 * normal.y();
    const double shine = std::pow(std::max(0.0, normal.dot(kShine)), 40.0);
    colour_[y * kFine + x] = colour * (0.22 + 0.28 * sky + 0.62 * key) + 0.12 * shine;
  }

  Vec3 centre_;
  double scale_;  ///< pixels per metre
  Mat3 view_;
  std::vector<double> depth_;
  std::vector<Colour> colour_;
};

/// Colours of neighbours differ: hues step by the golden ratio.
Colour ColourOf(std::size_t index) {
  const double hue = std::fmod(0.08 + 0.618033988749895 * static_cast<double>(index), 1.0);
  Colour c;
  for (int k = 0; k < 3; ++k) {
    const double at = std::abs(std::fmod(hue + k / 3.0, 1.0) * 6.0 - 3.0) - 1.0;
    c[k] = 0.42 + 0.5 * std::clamp(at, 0.0, 1.0);
  }
  return c;
}

class Picture {
 public:
  Picture(int columns, int rows)
      : width_(columns * kTile), pixels_(3 * std::size_t(width_) * rows * kTile) {
    height_ = rows * kTile;
  }

  void Place(const Tile& tile, int column, int row, const std::string& label) {
    for (int y = 0; y < kTile; ++y) {
      for (int x = 0; x < kTile; ++x) {
        Set(column * kTile + x, row * kTile + y, tile.At(x, y));
      }
    }
    Write(label, column * kTile + 16, row * kTile + kTile - 30);
  }

  void Save(const std::string& file) const {
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.width = width_;
    image.height = height_;
    image.format = PNG_FORMAT_RGB;
    if (!png_image_write_to_file(&image, file.c_str(), 0, pixels_.data(), 0, nullptr)) {
      throw Error(file + ": cannot be written (" + image.message + "); check the folder");
    }
  }

 private:
  void Set(int x, int y, const Colour& colour) {
    for (int k = 0; k < 3; ++k) {
      pixels_[3 * (std::size_t(y) * width_ + x) + k] =
          static_cast<std::uint8_t>(255.0 * std::sqrt(std::clamp(colour[k], 0.0, 1.0)) + 0.5);
    }
  }

  /// Capitals and figures of 5 x 7 dots, two pixels a dot.
  void Write(std::string_view text, int x, int y) {
    // Five bits a row, top row first.
    static constexpr std::string_view kLetters = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZ-";
    static constexpr std::uint8_t kDots[][7] = {
        {14, 17, 19, 21, 25, 17, 14}, {4, 12, 4, 4, 4, 4, 14},      {14, 17, 1, 2, 4, 8, 31},
        {31, 2, 4, 2, 1, 17, 14},     {2, 6, 10, 18, 31, 2, 2},     {31, 16, 30, 1, 1, 17, 14},
        {6, 8, 16, 30, 17, 17, 14},   {31, 1, 2, 4, 8, 8, 8},       {14, 17, 17, 14, 17, 17, 14},
        {14, 17, 17, 15, 1, 2, 12},   {14, 17, 17, 31, 17, 17, 17}, {30, 17, 17, 30, 17, 17, 30},
        {14, 17, 16, 16, 16, 17, 14}, {28, 18, 17, 17, 17, 18, 28}, {31, 16, 16, 30, 16, 16, 31},
        {31, 16, 16, 30, 16, 16, 16}, {14, 17, 16, 23, 17, 17, 15}, {17, 17, 17, 31, 17, 17, 17},
        {14, 4, 4, 4, 4, 4, 14},      {7, 2, 2, 2, 2, 18, 12},      {17, 18, 20, 24, 20, 18, 17},
        {16, 16, 16, 16, 16, 16, 31}, {17, 27, 21, 21, 17, 17, 17}, {17, 17, 25, 21, 19, 17, 17},
        {14, 17, 17, 17, 17, 17, 14}, {30, 17, 17, 30, 16, 16, 16}, {14, 17, 17, 17, 21, 18, 13},
        {30, 17, 17, 30, 20, 18, 17}, {15, 16, 16, 14, 1, 1, 30},   {31, 4, 4, 4, 4, 4, 4},
        {17, 17, 17, 17, 17, 17, 14}, {17, 17, 17, 17, 17, 10, 4},  {17, 17, 17, 21, 21, 21, 10},
        {17, 17, 10, 4, 10, 17, 17},  {17, 17, 17, 10, 4, 4, 4},    {31, 1, 2, 4, 8, 16, 31},
        {0, 0, 0, 31, 0, 0, 0}};
    for (char c : text) {
      const std::size_t letter = kLetters.find(c >= 'a' && c <= 'z' ? char(c - 'a' + 'A') : c);
      for (int dot = 0; letter != kLetters.npos && dot < 35 * 4; ++dot) {
        const int column = dot % 10;
        const int row = dot / 10;
        const int px = x + column;
        if (px >= width_ || !(kDots[letter][row / 2] >> (4 - column / 2) & 1)) continue;
        Set(px, y + row, Colour(0.05, 0.07, 0.1));
      }
      x += 12;
    }
  }

  int width_, height_;
  std::vector<std::uint8_t> pixels_;
};

bool SameShape(const Body& a, const Body& b) {
  return a.mesh.triangles == b.mesh.triangles && a.mesh.vertices == b.mesh.vertices &&
         a.tree.leaf_radius == b.tree.leaf_radius;
}

}  // namespace

void DrawScene(const Scene& scene, std::optional<int> level, const std::string& png_file) {
  std::vector<const Body*> bodies;
  int levels = 0;
  for (const auto* list : {&scene.tools, &scene.objects}) {
    for (const Body& body : *list) {
      if (std::any_of(bodies.begin(), bodies.end(),
                      [&](const Body* other) { return SameShape(*other, body); })) {
        continue;
      }
      bodies.push_back(&body);
      levels = std::max(levels, body.tree.levels());
    }
  }
  if (level && (*level < 1 || *level > levels)) {
    throw UsageError("--level " + std::to_string(*level) + ": there is no such level; give 1 to " +
                     std::to_string(levels));
  }
  Picture picture(level ? 2 : 1 + levels, static_cast<int>(bodies.size()));
  for (int row = 0; row < static_cast<int>(bodies.size()); ++row) {
    const Body& body = *bodies[row];
    Vec3 low = body.mesh.vertices.front();
    Vec3 high = low;
    for (const Vec3& v : body.mesh.vertices) {
      low = low.cwiseMin(v);
      high = high.cwiseMax(v);
    }
    const Vec3 centre = 0.5 * (low + high);
    const double radius = 0.5 * (high - low).norm() * 0.85;
    Tile mesh(centre, radius);
    mesh.Draw(body.mesh, Colour(0.8, 0.74, 0.66));
    mesh.ShadeHollows();
    picture.Place(mesh, 0, row,
                  body.name + " " + std::to_string(body.mesh.triangles.size()) + " triangles");
    for (int l = level ? *level - 1 : 0; l < (level ? *level : levels); ++l) {
      Tile tile(centre, radius);
      std::size_t count = 0;
      for (const SpherePacket& packet :
           l < body.tree.levels() ? body.tree.level(l) : std::span<const SpherePacket>{}) {
        for (int lane = 0; lane < kTreeArity; ++lane) {
          if (packet.child[lane] < 0) continue;
          tile.DrawSphere(Vec3(packet.x[lane], packet.y[lane], packet.z[lane]), packet.radius[lane],
                          ColourOf(count++));
        }
      }
      tile.ShadeHollows();
      picture.Place(tile, level ? 1 : 1 + l, row,
                    "level " + std::to_string(l + 1) + "  " + std::to_string(count) + " spheres");
    }
  }
  picture.Save(png_file);
}

void DrawWhole(const Scene& scene, const std::string& png_file) {
  const auto placed = [](const Body& body) {
    TriangleMesh mesh = body.mesh;
    for (Vec3& v : mesh.vertices) v = body.X_WB.p + body.X_WB.q * v;
    return mesh;
  };
  std::vector<std::pair<TriangleMesh, Colour>> meshes;
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    meshes.emplace_back(placed(scene.objects[i]), 0.45 + 0.45 * ColourOf(i));
  }
  for (const Body& tool : scene.tools) meshes.emplace_back(placed(tool), Colour(1.0, 0.45, 0.1));
  Eigen::AlignedBox3d box;
  for (const auto& [mesh, colour] : meshes) {
    for (const Vec3& v : mesh.vertices) box.extend(v);
  }
  Tile tile(box.center(), 0.5 * 0.85 * box.diagonal().norm());
  for (const auto& [mesh, colour] : meshes) tile.Draw(mesh, colour);
  tile.ShadeHollows();
  Picture picture(1, 1);
  picture.Place(tile, 0, 0, scene.name);
  picture.Save(png_file);
}

}  // namespace palpate
