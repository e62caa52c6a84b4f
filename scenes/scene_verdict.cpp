#include "scenes/scene_verdict.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "common/error.h"
#include "common/text/quoted.h"
#include "scenes/grid/solid_grid.h"
#include "scenes/mesh/hidden_surface.h"
#include "scenes/mesh/mesh_solid.h"
#include "scenes/mesh/units.h"

namespace palpate {
namespace {

constexpr double kAllowed = 0.01;  // of the longest side
constexpr double kTooMuch = 0.10;  // of it: then the tool is visibly inside, or in the air

double LongestSide(const MeshReport& report) {
  return (report.box_max - report.box_min).maxCoeff();
}

/// "{:.3g} mm".
std::string Millimetres(double metres) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g mm", 1e3 * metres);
  return text;
}

/// Adds a finding about a gap, if it is too large.
/// @param what  "1 % of the surface lies over"   @param then  what is felt there, and the remedy.
void JudgeGap(const std::string& what, double gap, const std::string& then,
              const MeshReport& report, Verdict& verdict) {
  if (gap <= AllowedGap(report)) return;
  const bool too_much = gap > kTooMuch * LongestSide(report);
  (too_much ? verdict.faults : verdict.limits)
      .push_back(what + " " + Millimetres(gap) + ", which should be at most " +
                 Millimetres(AllowedGap(report)) + then);
}

/// A body outside these sizes probably has another unit than was assumed [m].
constexpr double kMost = 50.0, kLeast = kShortestByMesh;

/// @param separation  which contact keeps between meshes [m]; 0 if they are not felt.
void JudgeSize(const std::string& whose, const MeshReport& report, double separation,
               Verdict& verdict) {
  const double longest = LongestSide(report);
  if (longest <= kMost && longest >= kLeast) return;
  std::string finding =
      whose + ": its longest side is " + Millimetres(longest) +
      ", an unusual size for an object to feel; check that \"unit\" is the unit of its file";
  if (longest < 100.0 * separation) finding.append("; if it is, ").append(kTooShortByMesh);
  verdict.limits.push_back(std::move(finding));
}

/// Adds a fault for balls without a radius, which the physics rejects.  If the builder found no
/// larger ones, the body has no inside.
void JudgeBalls(const std::string& whose, const SphereTree& tree, Verdict& verdict) {
  const auto empty = std::ranges::count_if(tree.leaf_radius, [](double r) { return !(r > 0.0); });
  if (empty == 0) return;
  verdict.faults.push_back(
      whose + ": " + std::to_string(empty) + " of its " + std::to_string(tree.leaves()) +
      " spheres have no radius, for its mesh encloses nothing there: it is a sheet, or has a "
      "vertex far away; give it a thickness in a mesh editor (Solidify), or remove the vertex");
}

/// Checks that a body that burs cut is closed, and fits into memory.
void JudgeGrid(const Body& body, Verdict& verdict) {
  if (!body.grid) return;
  try {
    MakeSolidGrid(body);
  } catch (const Error& error) {
    verdict.faults.push_back("object " + std::string(error.what()));
  }
}

bool Yields(const Material& material) {
  return std::isfinite(material.stiffness);
}

}  // namespace

void Verdict::Add(const Verdict& other) {
  limits.insert(limits.end(), other.limits.begin(), other.limits.end());
  faults.insert(faults.end(), other.faults.begin(), other.faults.end());
}

bool FeltBySpheres(const Scene& scene, const Body& body, bool is_tool) {
  if (is_tool && body.tree.leaves() == 1) return false;  // the leaf is exactly that ball
  if (scene.features.contact == ContactModel::kSpheres) return true;
  const auto yields = [](const Body& object) {
    return std::ranges::any_of(object.materials, Yields);
  };
  return is_tool ? std::ranges::any_of(scene.objects, yields) : yields(body);
}

double AllowedGap(const MeshReport& report) {
  return kAllowed * LongestSide(report);
}

Verdict JudgeMesh(const std::string& whose, const MeshReport& report) {
  Verdict verdict;
  if (!report.refusal.empty()) verdict.faults.push_back(whose + ": " + report.refusal);
  for (const std::string& remark : report.remarks) {
    verdict.limits.push_back(whose + ": " + remark);
  }
  return verdict;
}

Verdict JudgeCoverage(const std::string& whose, const MeshReport& report, const Coverage& coverage,
                      std::size_t leaves) {
  Verdict verdict;
  const std::string more = std::to_string(leaves) + " leaves";
  JudgeGap(whose + ": 1 % of its surface is outside its spheres by more than",
           coverage.uncovered.p99, "; the tool sinks in that far there: give it more than " + more,
           report, verdict);
  JudgeGap(
      whose + ": 1 % of its spheres' surface sticks out by more than", coverage.outside.p99,
      "; the tool is stopped that far in the air: close the mesh, or give it more than " + more,
      report, verdict);
  return verdict;
}

BodyFindings JudgeBody(const Scene& scene, const Body& body, bool is_tool, MeasureGaps measure) {
  BodyFindings found;
  const std::string whose = (is_tool ? "tool " : "object ") + body.name;
  found.report = InspectMesh(body.mesh);
  found.by_spheres = FeltBySpheres(scene, body, is_tool);
  found.verdict = JudgeMesh(whose, found.report);
  for (const std::string& remark : body.remarks) {
    found.verdict.limits.push_back(whose + ": " + remark);
  }
  if (!found.report.refusal.empty()) return found;
  MeshSolid solid;
  if (found.by_spheres || measure == MeasureGaps::kAlways) solid = SolidOf(body.mesh);
  if (found.by_spheres && solid.added()) {
    found.verdict.limits.push_back(whose + ": " + SolidRemark(solid, 1e3, "mm"));
  }
  JudgeSize(whose, found.report,
            scene.features.contact == ContactModel::kSurface && !found.by_spheres
                ? scene.tuning.separation
                : 0.0,
            found.verdict);
  JudgeBalls(whose, body.tree, found.verdict);
  JudgeGrid(body, found.verdict);
  if (found.by_spheres || measure == MeasureGaps::kAlways) {
    found.coverage = MeasureCoverage(solid.mesh, body.tree);
  }
  if (found.by_spheres) {
    found.verdict.Add(JudgeCoverage(whose, found.report, found.coverage, body.tree.leaves()));
  }
  found.hidden = HiddenRemark(FindHiddenParts(body.mesh), 1e3, "mm");
  if (!found.hidden.empty()) found.verdict.limits.push_back(whose + ": " + found.hidden);
  return found;
}

Verdict JudgeScene(const Scene& scene) {
  Verdict verdict = JudgeEffects(scene);
  verdict.Add(JudgeRest(scene));
  for (const auto* bodies : {&scene.tools, &scene.objects}) {
    for (const Body& body : *bodies) {
      const bool is_tool = bodies == &scene.tools;
      verdict.Add(JudgeBody(scene, body, is_tool, MeasureGaps::kWhereFelt).verdict);
    }
  }
  return verdict;
}

std::string ToText(const Verdict& verdict) {
  const bool usable = verdict.usable();
  const std::vector<std::string>& findings = usable ? verdict.limits : verdict.faults;
  std::string text = "verdict: ";
  if (findings.empty()) return text + "good to touch\n";
  text += usable ? "usable with these limits:\n" : "not usable:\n";
  for (const std::string& finding : findings) text += "  - " + Printable(finding) + "\n";
  return text;
}

}  // namespace palpate
