#pragma once

#include <optional>
#include <string>
#include <vector>

#include "client/course/local_text.h"
#include "common/json/json_file.h"
#include "common/math/pose.h"
#include "scenes/scene.h"

namespace palpate {

/// A box or a ball in W; empty: everywhere.
using Place = std::optional<MaterialRegion>;

/// One criterion by which a trial is graded: the value `best` earns all of its points, `worst`
/// none, and a value between them a proportional share.
struct Criterion {
  std::string name;  ///< English, or of the only language: under it marks are stored
  LocalText names{}, why{};
  std::string measure;        ///< one of kMeasures
  double limit_N = 0.0;       ///< the force limit, for "force_over_share"
  std::string tissue{};       ///< the tissue that a cutting measure is restricted to, or must name
  Vec3 axis = Vec3::UnitY();  ///< unit vector in W: out of the solid along the preparation
  Place place{};              ///< only what lies within it counts
  double best = 0.0, worst = 1.0;
  double weight = 1.0;
  bool gates = false;  ///< says how far the task is done: those that do not gate count only so far
  bool harms =
      false;  ///< who does not meet it does harm: all others count only as far as it is met
};

/// A site at which the depth is to be probed.
struct ProbingSite {
  std::string name;            ///< English, or of the only language
  Vec3 margin = Vec3::Zero();  ///< W [m]: the depth is measured from here
  Vec3 into = -Vec3::UnitY();  ///< unit vector in W: along which the depth is measured
  double radius = 0.0;         ///< [m]: largest distance of the tip from that line
  double depth = 0.0;          ///< [m]: correct depth
  double tolerance = 0.0;      ///< [m]
  LocalText names{};
};

/// The criteria by which a trial is graded, read from a file that a teacher edits.
struct Criteria {
  std::string file, title;
  LocalText titles{};
  double pass = 0.0;        ///< points of 100 that pass
  Vec3 tip = Vec3::Zero();  ///< tip of the tool, in the tool's frame [m]
  std::vector<Criterion> criteria{};
  std::vector<ProbingSite> sites{};
};

/// What it measures is said in client/replayer/score/words.
struct Measure {
  const char* name;
  const char* unit;
  enum class Tissue { kNone, kMayName, kMustName };
  Tissue tissue = Tissue::kNone;
  bool of_cut = false;       ///< measures what was cut
  bool along_axis = false;   ///< measures a preparation along its axis
  bool in_a_place = of_cut;  ///< accepts a "region"
};
/// The measures that a criterion may name.
extern const std::vector<Measure> kMeasures;
const Measure& MeasureOf(const std::string& name);

/// Returns whether any criterion measures what was cut.
bool AsksForCuts(const Criteria& criteria);

/// Reads the criteria of a criteria file, or those that are a part of another file.  Throws Error
/// "file:line: field: what is wrong; remedy".
/// @param title  the title of that file, used if the criteria have none; empty: they must have one.
Criteria ReadCriteria(const JsonNode& node, const std::string& file, const LocalText& title = {});
/// A template for teachers: periodontal probing with 25 g.
extern const char* const kCriteriaToBeginWith;

}  // namespace palpate
