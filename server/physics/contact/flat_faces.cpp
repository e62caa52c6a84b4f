#include <algorithm>
#include <cmath>

#include "server/physics/contact/sub_step.h"
#include "server/physics/limits.h"

namespace palpate {
namespace {

using namespace limits::mesh;

/// Returns whether a triangle's edge or corner lies within a flat face: all faces at it lie in the
/// triangle's plane, and none ends there.
bool IsWithinFace(const ContactMesh& mesh, std::uint32_t triangle, Feature of) {
  const ContactMesh::Triangle& t = mesh.triangles()[triangle];
  const auto is_inner = [&](std::uint32_t edge) {
    const auto faces = mesh.FacesAtEdge(edge);
    return faces.size() > 1 && std::ranges::all_of(faces, [&](std::uint32_t face) {
             return (mesh.triangles()[face].normal - t.normal).norm() <= kSame;
           });
  };
  if (of.kind == Feature::kEdge) return is_inner(t.edge[of.index]);
  const std::uint32_t vertex = t.vertex[of.index];
  return std::ranges::all_of(mesh.FacesAtVertex(vertex), [&](std::uint32_t face) {
    const ContactMesh::Triangle& at = mesh.triangles()[face];
    for (std::size_t c = 0; c < 3; ++c) {
      const bool meets = at.vertex[c] == vertex || at.vertex[(c + 1) % 3] == vertex;
      if (meets && !is_inner(at.edge[c])) return false;
    }
    return true;
  });
}

/// Returns the plane of the body's triangle, on the side of the tool.
ContactPlane FaceOf(const MeshPair& meshes, const Touch& touch) {
  const Vec3 n = meshes.OutwardOf(touch.nodes);
  return {ContactPlane::Of::kB, n.dot(touch.u) < 0.0 ? Vec3(-n) : n};
}

/// Returns whether a body has a row at a place.
bool HasRowAt(const FrameRows& rows, std::int32_t body, const Vec3& lever, const Vec3& n) {
  for (int row = 0; row < rows.count(); ++row) {
    if (!rows.IsLoose(row) && rows.id(row).body == body &&
        (rows.lever(row) - lever).norm() <= kRounding && (rows.normal(row) - n).norm() <= kSame) {
      return true;
    }
  }
  return false;
}

/// Adds those rows of a touch's plane that touch, at places without a row; returns whether there
/// was any.
bool AddRows(MeshContact& contact, Touch& touch, FrameRows& rows) {
  const TouchRowsAtCandidate of = RowsAt(contact, touch);
  const double before = GapAt(contact.meshes, touch.nodes, touch, touch.plane, contact.motion.from);
  bool added = false;
  for (int i = 0; i < of.count; ++i) {
    const TouchRow& row = of.row[i];
    if (!row.is_over || !(row.before <= kWitnessRatio * before + contact.meshes.margins.witness)) {
      continue;
    }
    added = true;
    if (!HasRowAt(rows, touch.nodes.number, row.lever, row.n)) SetRow(contact, touch, row, rows);
  }
  return added;
}

/// Returns whether two touches are on the same flat face, or on faces of a body in one plane.
bool AreOnOneFace(const Touch& a, const Touch& b) {
  return a.is_flush && b.is_flush && a.nodes.number == b.nodes.number &&
         (a.plane.n - b.plane.n).norm() <= kSame;
}

/// Walks over the vertices of the tool that are near the face of a touch, from its triangles in
/// all touches there along edges.
/// @param touches  the first one, and others
void MeetCorners(MeshContact& contact, std::span<const Touch> touches) {
  const MeshPair& meshes = contact.meshes;
  const ContactMesh& mesh = meshes.a.mesh;
  const RelativePose& at = contact.motion.from;
  const Touch& first = touches.front();
  const double height = meshes.High(first.nodes, first.plane.n) - first.plane.n.dot(at.p);
  const Vec3 n_G = at.R.transpose() * first.plane.n;
  CornerScratch& corners = contact.corners;
  corners.met.clear();
  ++corners.walk;
  const auto meet = [&](std::uint32_t face) {
    for (const std::uint32_t vertex : mesh.triangles()[face].vertex) {
      if (corners.seen[vertex] == corners.walk) continue;
      corners.seen[vertex] = corners.walk;
      const double above = n_G.dot(mesh.vertices()[vertex]) - height;
      if (std::abs(above) <= meshes.margins.touching) corners.met.push_back(vertex);
    }
  };
  for (const Touch& touch : touches) {
    if (AreOnOneFace(first, touch)) meet(HullTree::TriangleOf(touch.nodes.a));
  }
  for (std::size_t i = 0; i < corners.met.size() && i < kCornersOfFace; ++i) {
    std::ranges::for_each(mesh.FacesAtVertex(corners.met[i]), meet);
  }
}

/// Adds the row of a vertex of the tool that lies over a face of a body.
void AddRowOfCorner(MeshContact& contact, std::uint32_t vertex, const Touch& beside,
                    FrameRows& rows) {
  const MeshPair& meshes = contact.meshes;
  const ContactMesh& mesh = meshes.a.mesh;
  const RelativePose& at = contact.motion.from;
  const Vec3 lever = at.R * mesh.vertices()[vertex], &n = beside.plane.n;
  if (HasRowAt(rows, beside.nodes.number, lever, n)) return;
  const std::uint32_t triangle = mesh.FacesAtVertex(vertex).front();
  const auto& corner = mesh.triangles()[triangle].vertex;
  const auto c = static_cast<std::uint8_t>(std::ranges::find(corner, vertex) - corner.begin());
  if (IsWithinFace(mesh, triangle, {Feature::kVertex, c}) || !contact.HasRoomForTouch()) return;
  const Placement& X_BS = meshes.FrameOf(beside.nodes);
  const auto face = FaceAt(*beside.nodes.shape, X_BS.Inverse() * (lever + at.p),
                           X_BS.R.transpose() * n, meshes.margins.touching, kSame);
  if (!face) return;
  NodesOfPair nodes = beside.nodes;
  nodes.a = static_cast<HullTree::Node>(~triangle);
  nodes.b = static_cast<HullTree::Node>(~*face);
  Touch& touch = contact.touches.emplace_back(TouchAt(meshes, nodes, at));
  if (!(touch.distance > 0.0)) return;
  touch.plane = beside.plane;
  const TouchRow row = RowsAt(contact, touch).row[c];
  if (row.is_over) SetRow(contact, touch, row, rows);
}

}  // namespace

void AddRowsOnFace(MeshContact& contact, Touch& touch, FrameRows& rows) {
  if (touch.distance <= 0.0 || touch.plane.of != ContactPlane::Of::kNone) return;
  const MeshPair& meshes = contact.meshes;
  const ContactPlane face = FaceOf(meshes, touch);
  if (touch.in_cone && !meshes.IsBall() && (face.n - touch.u).norm() <= kSame) {
    touch.plane = face;
    const Feature of = touch.nearest.of_q;
    touch.is_flush = AddRows(contact, touch, rows) || of.kind == Feature::kFace ||
                     IsWithinFace(touch.nodes.shape->mesh, HullTree::TriangleOf(touch.nodes.b), of);
    if (touch.is_flush) return;
  }
  touch.plane = ChoosePlane(meshes, touch, contact.motion);
  AddRows(contact, touch, rows);
}

void AddRowsOfHidden(MeshContact& contact, std::span<const ContactId> active, double reach,
                     FrameRows& rows) {
  const MeshPair& meshes = contact.meshes;
  if (meshes.IsBall()) return;
  for (const ContactId& id : active) {
    const auto body = static_cast<std::size_t>(id.body);
    if (id.IsOfLeaves() || body >= meshes.b.size() || meshes.b[body].frame != meshes.frame)
      continue;
    const auto is_same = [&](const Touch& touch) { return IdOf(touch.nodes).IsBeside(id); };
    auto touch = std::ranges::find_if(contact.touches, is_same);
    if (touch == contact.touches.end()) {
      if (!contact.HasRoomForTouch()) return;
      contact.touches.push_back(
          TouchAt(meshes, meshes.NodesOf(~id.a, ~id.b, id.body), contact.motion.from));
      touch = contact.touches.end() - 1;
      if (touch->distance <= reach) AddRowsOnFace(contact, *touch, rows);
    }
    const bool has_rows = std::ranges::any_of(touch->row, [](int row) { return row >= 0; });
    if (has_rows) continue;
    // It has left its triangle.  Another one of the same face may be below A's corners.
    Touch beside = *touch;
    beside.plane = FaceOf(meshes, *touch);
    for (const std::uint32_t corner :
         meshes.a.mesh.triangles()[static_cast<std::uint32_t>(id.a)].vertex) {
      AddRowOfCorner(contact, corner, beside, rows);
    }
  }
}

void AddRowsOfCorners(MeshContact& contact, FrameRows& rows) {
  const std::span<const Touch> touches(contact.touches);  // before others are added
  for (std::size_t i = 0, faces = 0; i < touches.size() && faces < kFlatFaces; ++i) {
    const auto is_known = [&](const Touch& touch) { return AreOnOneFace(touch, touches[i]); };
    if (!touches[i].is_flush || std::ranges::any_of(touches.first(i), is_known)) continue;
    ++faces;
    MeetCorners(contact, touches.subspan(i));
    for (const std::uint32_t vertex : contact.corners.met) {
      AddRowOfCorner(contact, vertex, touches[i], rows);
    }
  }
}

}  // namespace palpate
