#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/json/json_file.h"
#include "common/math/pose.h"
#include "scenes/scene.h"

namespace palpate {

/// A box or a ball in W; none: everywhere.
using Place = std::optional<MaterialRegion>;

/// One thing that a trial is graded by: `best` earns everything, `worst` nothing, and what lies
/// between its share.
struct Criterion {
  std::string name, why;
  std::string measure;        ///< one of kMeasures
  double limit_N = 0.0;       ///< of "force_over_share"
  std::string tissue{};       ///< of some measures of what was cut
  Vec3 axis = Vec3::UnitY();  ///< unit, W: of a preparation, out of the solid
  Place place{};              ///< what lies elsewhere does not count
  double best = 0.0, worst = 1.0;
  double weight = 1.0;
};

/// A place whose depth is to be probed.
struct ProbingSite {
  std::string name;
  Vec3 margin = Vec3::Zero();  ///< W [m]: where depth is counted from
  Vec3 into = -Vec3::UnitY();  ///< unit, W: along which it is
  double radius = 0.0;         ///< [m]: how far from that line the tip may be
  double depth = 0.0;          ///< [m]: what is right
  double tolerance = 0.0;      ///< [m]
};

/// By what a teacher grades: a file that a teacher edits.
struct Criteria {
  std::string file, title;
  double pass = 0.0;        ///< of 100
  Vec3 tip = Vec3::Zero();  ///< of the tool, in its frame [m]
  std::vector<Criterion> criteria{};
  std::vector<ProbingSite> sites{};
};

struct Measure {
  const char* name;
  const char* unit;
  const char* text;
  enum class Tissue { kNone, kMayName, kMustName };
  Tissue tissue = Tissue::kNone;
  bool of_cut = false;       ///< of what was cut
  bool along_axis = false;   ///< of a preparation
  bool in_a_place = of_cut;  ///< a place may be named
};
/// What a criterion may be about.
extern const std::vector<Measure> kMeasures;
const Measure& MeasureOf(const std::string& name);

/// Whether a criterion is about what was cut.
bool AsksForCuts(const Criteria& criteria);

/// Of a file of criteria, or of an exercise (exercise.h).  Throws Error "file:line: field: what is
/// wrong; remedy".
Criteria LoadCriteria(const std::string& file);
/// What such a file holds, where it is a part of another.
/// @param title  of that, where it has none of its own; empty: it must have one.
Criteria ReadCriteria(const JsonNode& node, const std::string& file, const std::string& title = "");
/// For a teacher to begin with: periodontal probing with 25 g.
extern const char* const kCriteriaToBeginWith;

}  // namespace palpate
