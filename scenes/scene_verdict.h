#pragma once

#include <string>
#include <vector>

#include "scenes/mesh/mesh_report.h"
#include "scenes/scene.h"
#include "scenes/tree/tree_error.h"

namespace palpate {

/// What a scene, or a mesh, is good for: findings, each a sentence with its remedy.
struct Verdict {
  std::vector<std::string> limits;  ///< it can be touched, but these show
  std::vector<std::string> faults;  ///< it should not be

  bool usable() const { return faults.empty(); }
  void Add(const Verdict& other);
};

/// Whether a body's spheres are what is felt of it, and not its mesh (catalogue/README.md,
/// "contact").  Tools are asked for by what they touch.
bool FeltBySpheres(const Scene& scene, const Body& body, bool is_tool);

/// How far spheres may stick out of a body whose spheres are felt, and its surface lie from them
/// [m]: a hundredth of the longest side, which is five pixels where the body fills half a screen.
double AllowedGap(const MeshReport& report);

/// @param whose  begins each finding: "object cheek".
Verdict JudgeMesh(const std::string& whose, const MeshReport& report);
Verdict JudgeCoverage(const std::string& whose, const MeshReport& report, const Coverage& coverage,
                      std::size_t leaves);

/// What is known of a body that a scene holds.
struct BodyFindings {
  MeshReport report;
  Coverage coverage;        ///< where it was measured
  bool by_spheres = false;  ///< what is felt
  std::string hidden;       ///< what parts of the mesh hide of each other; empty: nothing
  Verdict verdict;
};

enum class MeasureGaps { kWhereFelt, kAlways };
BodyFindings JudgeBody(const Scene& scene, const Body& body, bool is_tool, MeasureGaps measure);

/// Whether its effects are as passive as they say, along closed paths about its objects.
Verdict JudgeEffects(const Scene& scene);

/// Of all its bodies and effects: what palpate-scene says of a scene, and palpate-server before it
/// serves it.
Verdict JudgeScene(const Scene& scene);

/// For people, to end a report with: "verdict: good to touch", or the limits or faults, a line
/// each.
std::string ToText(const Verdict& verdict);

}  // namespace palpate
