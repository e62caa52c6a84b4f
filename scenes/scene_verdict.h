#pragma once

#include <string>
#include <vector>

#include "scenes/mesh/mesh_report.h"
#include "scenes/scene.h"
#include "scenes/tree/tree_error.h"

namespace palpate {

/// What a scene or a mesh is fit for: findings, each a sentence with its remedy.
struct Verdict {
  std::vector<std::string> limits;  ///< defects that show, though it can be touched
  std::vector<std::string> faults;  ///< reasons not to touch it

  bool usable() const { return faults.empty(); }
  void Add(const Verdict& other);
};

/// Returns whether a body is felt by its spheres and not by its mesh (catalogue/README.md,
/// "contact").  For a tool that depends on the objects.
bool FeltBySpheres(const Scene& scene, const Body& body, bool is_tool);

/// Returns how far the spheres of a body that is felt by them may stick out of it, and its surface
/// may lie from them [m]: a hundredth of the longest side, which is five pixels when the body fills
/// half a screen.
double AllowedGap(const MeshReport& report);

/// @param whose  the beginning of each finding: "object cheek".
Verdict JudgeMesh(const std::string& whose, const MeshReport& report);
Verdict JudgeCoverage(const std::string& whose, const MeshReport& report, const Coverage& coverage,
                      std::size_t leaves);

/// What is known about a body of a scene.
struct BodyFindings {
  MeshReport report;
  Coverage coverage;        ///< if it was measured
  bool by_spheres = false;  ///< whether its spheres are felt, not its mesh
  std::string hidden;       ///< which parts of the mesh lie inside others; empty: none
  Verdict verdict;
};

enum class MeasureGaps { kWhereFelt, kAlways };
BodyFindings JudgeBody(const Scene& scene, const Body& body, bool is_tool, MeasureGaps measure);

/// Tries each of the scene's effects about the objects, in a process of its own: whether it
/// crashes, fails, takes long, gives the same bits twice, and is as passive as it says.
Verdict JudgeEffects(const Scene& scene);

/// Finds free bodies that overlap other objects where they are placed, by points of their surfaces.
Verdict JudgeRest(const Scene& scene);

/// Judges all bodies and effects: what palpate-scene says of a scene, and what palpate-server says
/// before it serves it.
Verdict JudgeScene(const Scene& scene);

/// Returns the end of a report for people: "verdict: good to touch", or the limits or faults,
/// one per line.
std::string ToText(const Verdict& verdict);

}  // namespace palpate
