#include "scenes/mesh/mesh_mend.h"

#include <spdlog/fmt/fmt.h>

#include "scenes/mesh/mesh_crumbs.h"
#include "scenes/mesh/mesh_orient.h"
#include "scenes/mesh/mesh_weld.h"

namespace palpate {

std::vector<std::string> MendMesh(TriangleMesh& mesh, std::vector<MeshGroup>* groups) {
  std::vector<std::string> done;
  if (const Welding welding = WeldOpenEdges(mesh); welding.vertices > 0) {
    done.push_back(fmt::format(
        "{} vertices of open edges lay beside others and are welded within {:.2g} of the file's "
        "unit; merge by distance in a mesh editor",
        welding.vertices, welding.tolerance));
  }
  if (const std::size_t repeated = LeaveOutRepeatedTriangles(mesh, groups); repeated > 0) {
    done.push_back(fmt::format(
        "{} triangles stood there twice, face to face or back to back: one of each is left; merge "
        "by distance in a mesh editor",
        repeated));
  }
  const Crumbs crumbs = LeaveOutCrumbs(mesh, groups);
  if (crumbs.left_out > 0) {
    done.push_back(fmt::format(
        "{} float{} apart from the rest, {:.2g} of the file's unit across at most, and {} left "
        "out, as a scanner's noise; delete such pieces in a mesh editor, or join to the rest what "
        "should be felt",
        crumbs.left_out == 1 ? "a small piece" : fmt::format("{} small pieces", crumbs.left_out),
        crumbs.left_out == 1 ? "s" : "", crumbs.largest, crumbs.left_out == 1 ? "is" : "are"));
  }
  if (crumbs.kept > 0) {
    done.push_back(fmt::format(
        "{} float{} apart from the rest, {:.2g} of the file's unit across at most, and {} felt, as "
        "closed; delete in a mesh editor what is a scanner's noise",
        crumbs.kept == 1 ? "a small piece" : fmt::format("{} small pieces", crumbs.kept),
        crumbs.kept == 1 ? "s" : "", crumbs.largest, crumbs.kept == 1 ? "is" : "are"));
  }
  if (const std::size_t turned = OrientTriangles(mesh); turned == mesh.triangles.size()) {
    done.push_back(
        "the mesh was inside out: all of it is turned; flip its normals in a mesh editor");
  } else if (turned > 0) {
    done.push_back(fmt::format(
        "{} triangles were inside out, alone or as whole pieces: they are turned; recalculate the "
        "normals in a mesh editor",
        turned));
  }
  return done;
}

}  // namespace palpate
