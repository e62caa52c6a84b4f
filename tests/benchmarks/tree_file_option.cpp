#include "tests/benchmarks/tree_file_option.h"

#include <string>
#include <vector>

#include "scenes/files/scene_file.h"
#include "scenes/tree/sph_file.h"

namespace palpate::bench {

CLI::Option* AddTreeFileOptions(CLI::App& command, const char* usual_unit, TreeSource& source) {
  source.where = "--tree";
  CLI::Option* tree = command.add_option("--tree", source.file,
                                         "A tree of the Sphere-Tree Construction Toolkit of the "
                                         "same mesh (FILE.sph; none is supplied), to be measured "
                                         "beside those that are built");
  command.add_option("--level", source.level, "Level of that file, from 1 (default: its finest)")
      ->check(CLI::Range(1, kMaxSphLevels))
      ->needs(tree);
  return command
      .add_option_function<std::string>(
          "--unit",
          [&source](const std::string& unit) { source.metres_per_unit = MetresPerUnit(unit); },
          std::string("What a number in the file means (default: ") + usual_unit + ")")
      ->check(CLI::IsMember(std::vector<std::string>(kUnits.begin(), kUnits.end())));
}

}  // namespace palpate::bench
