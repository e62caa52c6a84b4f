#include "tests/benchmarks/pose_source.h"

#include <cctype>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "common/error.h"
#include "common/json/pose_script.h"
#include "scenes/catalogue.h"

namespace palpate::bench {

std::vector<Pose> ReadPoses(const std::string& file) {
  std::ifstream in(file);
  if (!in) throw Error(file + ": cannot be opened; give --poses a CSV file x,y,z,qw,qx,qy,qz");
  std::vector<Pose> poses;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos || line[0] == '#') continue;
    double value[7];
    const char* at = line.c_str();
    int count = 0;
    for (; count < 7; ++count) {
      char* end = nullptr;
      value[count] = std::strtod(at, &end);
      if (end == at) break;
      at = end;
      while (*at == ',' || *at == ' ' || *at == '\t' || *at == '\r') ++at;
    }
    if (count == 0 && poses.empty() && std::isalpha(static_cast<unsigned char>(line[0])) != 0) {
      continue;  // names of the columns
    }
    const std::string where = file + ":" + std::to_string(number) + ": ";
    if (count != 7 || *at != '\0') {
      throw Error(where + "needs seven numbers x,y,z,qw,qx,qy,qz");
    }
    Pose X{Vec3(value[0], value[1], value[2]), Quat(value[3], value[4], value[5], value[6])};
    if (!X.p.allFinite() || !(std::abs(X.q.norm() - 1.0) < 1e-3)) {
      throw Error(where + "the pose is not finite or its quaternion not of length 1; mend the row");
    }
    poses.push_back(X);
  }
  if (poses.empty()) throw Error(file + ": holds no pose; one row a millisecond is needed");
  return poses;
}

std::vector<Pose> ScriptPoses(const std::string& scene, std::optional<int> steps) {
  const auto file = std::filesystem::path(FindSceneFile(scene)).replace_extension(".path.json");
  const PoseScript script = PoseScript::Load(file.string());
  const int once = static_cast<int>(std::ceil(script.duration() * 1000.0));
  const int count = steps.value_or(once + 1);
  std::vector<Pose> poses;
  for (int i = 0; i < count; ++i) poses.push_back(script.At(1e-3 * (i % (once + 1))));
  return poses;
}

}  // namespace palpate::bench
