#include "client/replayer/score/cut_picture.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <span>

#include <Eigen/Geometry>

#include "scenes/mesh/mesh_query.h"

namespace palpate {
namespace {

constexpr double kMostVertices = 12'000.0;
constexpr std::uint32_t kPlain = 0xe6dfd0;  // for a material without colour

using Cube = std::array<int, 3>;

double AreaOf(const std::vector<SolidSurface>& surfaces) {
  double area = 0.0;
  for (const SolidSurface& surface : surfaces) {
    for (const auto& [a, b, c] : surface.triangles) {
      const Vec3& p = surface.vertices[a];
      area += 0.5 * (surface.vertices[b] - p).cross(surface.vertices[c] - p).norm();
    }
  }
  return area;
}

/// Adds a surface, merging the vertices in each cell of that width into one.
void AddThinned(const SolidSurface& surface, const CutSolid& solid, const Body& body, double width,
                CutPicture& picture) {
  struct Sum {
    std::uint32_t vertex;
    Vec3 sum = Vec3::Zero();
    int count = 0;
  };
  std::map<Cube, Sum> cells;
  const auto first = static_cast<std::uint32_t>(picture.vertices.size());
  std::vector<std::uint32_t> at;
  for (const Vec3& p : surface.vertices) {
    const Eigen::Vector3i cell = (p / width).array().floor().cast<int>();
    Sum& sum = cells
                   .try_emplace({cell.x(), cell.y(), cell.z()},
                                Sum{first + static_cast<std::uint32_t>(cells.size())})
                   .first->second;
    sum.sum += p;
    ++sum.count;
    at.push_back(sum.vertex);
  }
  picture.vertices.resize(first + cells.size());
  picture.colours.resize(picture.vertices.size(), kPlain);
  for (const auto& [cell, sum] : cells) {
    picture.vertices[sum.vertex] = solid.X_WB * Vec3(sum.sum / sum.count);
  }
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const auto& [a, b, c] = surface.triangles[t];
    const Material& material = body.materials[surface.materials[t]];
    const std::uint32_t colour = material.colour == Material::kNoColour ? kPlain : material.colour;
    for (const std::uint32_t corner : {a, b, c}) picture.colours[at[corner]] = colour;
    if (at[a] == at[b] || at[b] == at[c] || at[c] == at[a]) continue;
    picture.triangles.push_back({at[a], at[b], at[c]});
  }
}

/// The surface left of a solid, for the signed distance of points from it.
class Target {
 public:
  Target(const CutField& left, const SolidSurface& surface) : left_(left), surface_(surface) {}
  double Off(const Vec3& p_B) {
    const double near = left_.Sample(p_B).distance;
    const double band = 0.9 * left_.field().band();
    if (std::abs(near) < band) return near;
    if (!query_) {
      mesh_ = {surface_.vertices, surface_.triangles};
      query_.emplace(mesh_);
    }
    return std::copysign(std::min(query_->Nearest(p_B, kMostOff).distance, kMostOff), near);
  }

 private:
  const CutField& left_;
  const SolidSurface& surface_;
  TriangleMesh mesh_;
  std::optional<MeshQuery> query_;  // answers for points beyond the field's band
};

std::string Base64(std::span<const std::byte> bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      group =
          group << 8 | (i + k < bytes.size() ? std::to_integer<std::uint32_t>(bytes[i + k]) : 0u);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      text += i + k <= bytes.size() ? kDigits[group >> (18 - 6 * k) & 63] : '=';
    }
  }
  return text;
}

template <class T>
std::string Base64(const std::vector<T>& numbers) {
  static_assert(std::endian::native == std::endian::little);
  return Base64(std::as_bytes(std::span(numbers)));
}

}  // namespace

CutPicture PictureOf(const SolidsCut& trial, const std::vector<SolidSurface>& surfaces,
                     const SolidsCut& target, const std::vector<SolidSurface>& of_target) {
  const double width = std::sqrt(AreaOf(surfaces) / kMostVertices);
  CutPicture picture;
  for (std::size_t s = 0; s < surfaces.size(); ++s) {
    const CutSolid& solid = trial.objects->solids[s];
    AddThinned(surfaces[s], solid, trial.scene->objects[solid.object], width, picture);
    Target beside(target.after[s], of_target[s]);
    const Pose X_BW = solid.X_WB.Inverse();
    for (std::size_t v = picture.off.size(); v < picture.vertices.size(); ++v) {
      picture.off.push_back(beside.Off(X_BW * picture.vertices[v]));
    }
  }
  return picture;
}

PackedPicture Packed(const CutPicture& picture) {
  PackedPicture packed;
  Eigen::AlignedBox3d box;
  for (const Vec3& p : picture.vertices) box.extend(p);
  if (!picture.vertices.empty()) {
    packed.middle = box.center();
    packed.reach = 0.5 * box.diagonal().norm();
  }
  constexpr double kMost = std::numeric_limits<std::int16_t>::max();
  std::vector<std::int16_t> places;
  std::vector<std::int8_t> off;
  std::vector<std::uint8_t> colours;
  for (std::size_t v = 0; v < picture.vertices.size(); ++v) {
    const Vec3 p = kMost / packed.reach * (picture.vertices[v] - packed.middle);
    for (const double x : {p.x(), p.y(), p.z()}) {
      places.push_back(static_cast<std::int16_t>(std::lround(x)));
    }
    const double share = std::clamp(picture.off[v] / kMostOff, -1.0, 1.0);
    off.push_back(static_cast<std::int8_t>(std::lround(127.0 * share)));
    for (const int shift : {16, 8, 0}) {
      colours.push_back(static_cast<std::uint8_t>(picture.colours[v] >> shift));
    }
  }
  std::vector<std::uint32_t> corners;
  for (const auto& triangle : picture.triangles) {
    corners.insert(corners.end(), triangle.begin(), triangle.end());
  }
  packed.places = Base64(places);
  packed.off = Base64(off);
  packed.colours = Base64(colours);
  packed.corners = Base64(corners);
  return packed;
}

}  // namespace palpate
