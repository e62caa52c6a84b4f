#include "scenes/tree/tree_import.h"

#include <vector>

#include <fmt/format.h>

#include "common/error.h"
#include "scenes/tree/sph_file.h"
#include "scenes/tree/sphere_tree_builder.h"
#include "scenes/tree/tree_alignment.h"

namespace palpate {

ImportedTree ImportTree(const TreeSource& source, const TriangleMesh& mesh,
                        double metres_per_unit) {
  const std::string& file = source.file;
  const SphTree sph = ReadSph(file, source.metres_per_unit.value_or(metres_per_unit));
  const int level = source.level == 0 ? sph.levels : source.level;
  if (level > sph.levels) {
    throw Error(fmt::format("{}: there is no level {}; give 1, its root, to {}, its finest", file,
                            level, sph.levels));
  }
  std::vector<Sphere> balls = BallsOfLevel(sph, level);
  if (balls.empty()) {
    throw Error(fmt::format("{}: level {} has no spheres; give another", file, level));
  }
  if (balls.size() > kMaxLeaves) {
    throw Error(
        fmt::format("{}: level {} has {} spheres, but a body has at most {}; give a coarser level",
                    file, level, balls.size(), kMaxLeaves));
  }
  // Align with the finest level, which shows best where the mesh was, and whether it was this one.
  int finest = sph.levels;
  while (BallsOfLevel(sph, finest).size() > kMaxLeaves) --finest;
  ImportedTree made;
  TreeAlignment fit;
  try {
    fit = AlignBalls(mesh, BallsOfLevel(sph, finest), source.align);
  } catch (const Error& error) {
    throw Error(file + ": " + error.what());
  }
  for (Sphere& ball : balls) ball.centre += fit.shift;
  const Vec3 mm = 1e3 * fit.shift;
  made.found = fmt::format(
      "{}: level {} of {}, {} balls, {}; the surface lies {:.3g} +- {:.2g} mm outside the balls of "
      "its finest level, {:.3g} % of it uncovered",
      file, level, sph.levels, balls.size(),
      source.align ? fmt::format("moved by ({:.3f}, {:.3f}, {:.3f}) mm, {}", mm.x(), mm.y(), mm.z(),
                                 fit.fitted           ? "which fits best"
                                 : fit.shift.isZero() ? "for they fit as they are"
                                                      : "to the centre of the mesh's box")
                   : std::string("not moved"),
      1e3 * fit.mean, 1e3 * fit.residual, 100.0 * fit.uncovered_share);
  if (!fit.misfit.empty()) made.misfit = file + ": " + fit.misfit;
  made.tree = TreeOverBalls(mesh, balls);
  return made;
}

}  // namespace palpate
