#include "scenes/mesh/mesh_mend.h"

#include <spdlog/fmt/fmt.h>

#include "scenes/mesh/mesh_orient.h"
#include "scenes/mesh/mesh_weld.h"

namespace palpate {

std::vector<std::string> MendMesh(TriangleMesh& mesh) {
  std::vector<std::string> done;
  if (const Welding welding = WeldOpenEdges(mesh); welding.vertices > 0) {
    done.push_back(fmt::format(
        "{} vertices of open edges lay beside others and are welded within {:.2g} of the file's "
        "unit; merge by distance in a mesh editor",
        welding.vertices, welding.tolerance));
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
