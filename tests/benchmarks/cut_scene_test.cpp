#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/benchmarks/bench_fixture.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;

class CutCommand : public PalpateBench {
 protected:
  void WriteScene(const std::string& grid) {
    std::ofstream(File("block.json"))
        << R"({"tools": [{"name": "bur", "leaves": 16, "mesh": {"shape": "bur", "kind": "ball"}}],
 "objects": [{"name": "block", "leaves": 8, "mesh": {"shape": "box", "size_m": [0.004, 0.004, 0.004]})"
        << grid << "}]}";
  }
};

TEST_F(CutCommand, MeasuresASceneAgainstTheExactSweep) {
  WriteScene(R"(, "grid_um": 100, "material": {"cutting_pressure_MPa": 0.2})");
  std::ofstream poses(File("poses.csv"));
  for (int n = 0; n < 400; ++n) poses << "0," << 2.01e-3 - 3e-6 * n << ",0,1,0,0,0\n";
  poses.close();
  const nlohmann::json cut =
      Figures({"cut", "--scene", File("block.json"), "--poses", File("poses.csv"), "--repeats", "1",
               "--surface", File("left.stl")});
  EXPECT_EQ(cut["steps"], 400);
  EXPECT_EQ(cut["unsolved"], 0);
  // A ball of 1.4 mm, pressed with up to 1 N into 0.2 MPa.
  EXPECT_GT(cut["cut_m3"], 0.5e-9);
  EXPECT_LT(std::abs(cut["volume_error"].get<double>()), 0.01);
  EXPECT_LT(std::abs(cut["work_error"].get<double>()), 0.02);
  EXPECT_LT(cut["force_jump_N_max"], 0.02);
  EXPECT_LT(cut["surface_um"]["rms"], 10.0);
  EXPECT_LT(cut["surface_um"]["max"], 40.0);
  EXPECT_LT(cut["ripple"], 0.02);
  // STL: a header, a count, and 50 bytes per triangle.
  const auto size = std::filesystem::file_size(File("left.stl"));
  EXPECT_GT(size, 84u + 50u * 5000u);
  EXPECT_EQ((size - 84) % 50, 0u);
}

TEST_F(CutCommand, SaysWhatASceneLacks) {
  WriteScene("");
  EXPECT_EQ(Run({"cut", "--scene", File("block.json")}), 1);
  EXPECT_THAT(said_, HasSubstr("is a bur, but nothing can be cut; give an object \"grid_um\""));
  EXPECT_EQ(Run({"cut", "--scene", "cube"}), 1);
  EXPECT_THAT(said_, HasSubstr("cube: nothing of it can be cut"));
}

}  // namespace
}  // namespace palpate::test
