#include "tests/benchmarks/commands.h"

#include "scenes/files/scene_file.h"
#include "scenes/tree/sph_file.h"
#include "scenes/tree/tree_source.h"

namespace palpate::bench {

void AddJson(const CommandLine& command, std::string& file) {
  Add(command, "--json", file, "Write one JSON object to FILE (- is stdout)");
}

void AddModels(const CommandLine& command, std::string& folder) {
  Add(command, "--models", folder, "Folder of models that are not packaged");
}

void AddPathSteps(const CommandLine& command, std::optional<int>& steps) {
  Add(command, "--steps", steps, "Steps (default: the whole path)").Positive();
}

void AddRepeats(const CommandLine& command, int& repeats) {
  Add(command, "--repeats", repeats, "Identical runs; 'best' is the least of each step").Positive();
}

Option AddTreeFile(const CommandLine& command, const char* usual_unit, TreeSource& source) {
  source.where = "--tree";
  const Option file =
      Add(command, "--tree", source.file,
          "A tree of the Sphere-Tree Construction Toolkit of the same mesh "
          "(FILE.sph; none is supplied), to be measured beside those that are built");
  Add(command, "--level", source.level, "Level of that file, from 1; 0: its finest")
      .Range(0, kMaxSphLevels)
      .Needs(file);
  return command
      .AddText(
          "--unit",
          [&source](const std::string& unit) { source.metres_per_unit = MetresPerUnit(unit); },
          std::string("What a number in the file means (default: ") + usual_unit + ")")
      .OneOf({kUnits.begin(), kUnits.end()});
}

}  // namespace palpate::bench
