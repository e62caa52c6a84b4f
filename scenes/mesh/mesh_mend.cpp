#include "scenes/mesh/mesh_mend.h"

#include "scenes/mesh/figure.h"
#include "scenes/mesh/mesh_crumbs.h"
#include "scenes/mesh/mesh_orient.h"
#include "scenes/mesh/mesh_weld.h"

namespace palpate {
namespace {

/// Returns "3 small pieces float apart from the rest, 0.5 of the file's unit across at
/// most, and are".
std::string AreApart(std::size_t count, double largest) {
  const bool one = count == 1;
  return (one ? "a small piece floats" : std::to_string(count) + " small pieces float") +
         " apart from the rest, " + Figure(largest, 2) +
         " of the file's unit across at most, and " + (one ? "is" : "are");
}

}  // namespace

std::vector<std::string> MendMesh(TriangleMesh& mesh, std::vector<MeshGroup>* groups) {
  std::vector<std::string> done;
  if (const Welding welding = WeldOpenEdges(mesh); welding.vertices > 0) {
    done.push_back(std::to_string(welding.vertices) +
                   " vertices of open edges lay beside others and are welded within " +
                   Figure(welding.tolerance, 2) +
                   " of the file's unit; merge by distance in a mesh editor");
  }
  if (const std::size_t repeated = LeaveOutRepeatedTriangles(mesh, groups); repeated > 0) {
    done.push_back(std::to_string(repeated) +
                   " triangles stood there twice, face to face or back to back: one of each is "
                   "left; merge by distance in a mesh editor");
  }
  const Crumbs crumbs = LeaveOutCrumbs(mesh, groups);
  if (crumbs.left_out > 0) {
    done.push_back(AreApart(crumbs.left_out, crumbs.largest) +
                   " left out, as a scanner's noise; delete such pieces in a mesh editor, or join "
                   "to the rest what should be felt");
  }
  if (crumbs.kept > 0) {
    done.push_back(AreApart(crumbs.kept, crumbs.largest) +
                   " felt, as closed; delete in a mesh editor what is a scanner's noise");
  }
  if (const std::size_t turned = OrientTriangles(mesh); turned == mesh.triangles.size()) {
    done.push_back(
        "the mesh was inside out: all of it is turned; flip its normals in a mesh editor");
  } else if (turned > 0) {
    done.push_back(std::to_string(turned) +
                   " triangles were inside out, alone or as whole pieces: they are turned; "
                   "recalculate the normals in a mesh editor");
  }
  return done;
}

}  // namespace palpate
