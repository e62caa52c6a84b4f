#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "tests/support/program.h"

namespace palpate {
namespace {

using test::Program;
using testing::HasSubstr;
namespace fs = std::filesystem;

/// palpate-bench in a folder of its own, which goes with the test.
class PalpateBench : public testing::Test {
 protected:
  PalpateBench() : folder_(fs::temp_directory_path() / ("palpate-bench-" + Unique())) {
    fs::create_directory(folder_);
  }
  ~PalpateBench() override { fs::remove_all(folder_); }

  std::string File(const std::string& name) const { return (folder_ / name).string(); }
  nlohmann::json Json(const std::string& name) const {
    return nlohmann::json::parse(std::ifstream(File(name)));
  }
  /// Runs it to its end; what it said is in said_.
  int Run(std::vector<std::string> arguments) {
    Program program(PALPATE_BIN_DIR "/palpate-bench", std::move(arguments));
    const int status = program.Exit(100.0);
    said_ = program.Output();
    return status;
  }

  std::string said_;

 private:
  static std::string Unique() {
    return std::to_string(getpid()) + "-" +
           testing::UnitTest::GetInstance()->current_test_info()->name();
  }
  fs::path folder_;
};

TEST_F(PalpateBench, CycleMeasuresAScenesPathAndItsPenetration) {
  ASSERT_EQ(Run({"cycle", "--scene", "cube", "--steps", "3000", "--repeats", "2", "--json",
                 File("cycle.json")}),
            0)
      << said_;
  const nlohmann::json json = Json("cycle.json");
  EXPECT_EQ(json["scene"], "cube");
  EXPECT_EQ(json["steps"], 3000);
  EXPECT_EQ(json["tool_spheres"], 1);
  EXPECT_EQ(json["object_spheres"], 4096);
  EXPECT_LE(json["best_step_us"]["p50"], json["best_step_us"]["p999"]);
  EXPECT_LE(json["best_step_us"]["max"], json["raw_step_us"]["max"]);
  for (const char* stage : {"prediction", "rows", "solve", "response"}) {
    EXPECT_TRUE(json["best_stage_us"][stage].contains("p999")) << stage;
  }
  EXPECT_GT(json["pairs"]["conventional"]["max"], 0) << "the path never touched the cube";
  EXPECT_LT(json["penetration_um"]["max"], 1.0);
  EXPECT_EQ(json["qp"]["unsolved"], 0);
  EXPECT_LT(json["jump"]["force_N_max"], 1.0);
}

TEST_F(PalpateBench, CycleTakesPosesFromAFileAndNamesTheLineThatIsWrong) {
  std::ofstream(File("poses.csv")) << "x,y,z,qw,qx,qy,qz\n0,0.05,0,1,0,0,0\n0,0.049,0,1,0,0,0\n";
  ASSERT_EQ(Run({"cycle", "--scene", "cube", "--poses", File("poses.csv"), "--repeats", "1",
                 "--json", File("cycle.json")}),
            0)
      << said_;
  EXPECT_EQ(Json("cycle.json")["steps"], 2);
  std::ofstream(File("short.csv")) << "0,0.05,0,1,0,0,0\n0,0.05,0\n";
  EXPECT_EQ(Run({"cycle", "--scene", "cube", "--poses", File("short.csv")}), 1);
  EXPECT_THAT(said_, HasSubstr("short.csv:2: needs seven numbers"));
  std::ofstream(File("long.csv")) << "0,0.05,0,2,0,0,0\n";
  EXPECT_EQ(Run({"cycle", "--scene", "cube", "--poses", File("long.csv")}), 1);
  EXPECT_THAT(said_, HasSubstr("long.csv:1: the pose is not finite or its quaternion"));
}

TEST_F(PalpateBench, QpReadsBackWhatItDumped) {
  // One problem: the origin's nearest point with x >= 1 and y >= 2.
  std::ofstream file(File("two.pqp"), std::ios::binary);
  const auto put = [&](const void* data, std::size_t n) {
    file.write(static_cast<const char*>(data), static_cast<std::streamsize>(n));
  };
  const std::uint32_t count = 1, rows = 2;
  const double target[6] = {}, A[12] = {1, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0}, b[2] = {1, 2};
  put("PQP1", 4);
  put(&count, 4);
  put(&rows, 4);
  put(target, sizeof target);
  put(A, sizeof A);
  put(b, sizeof b);
  file.close();
  ASSERT_EQ(Run({"qp", "--load", File("two.pqp"), "--json", File("qp.json")}), 0) << said_;
  const nlohmann::json json = Json("qp.json");
  EXPECT_EQ(json["problems"], 1);
  EXPECT_EQ(json["unsolved"], 0);
  EXPECT_LE(json["kkt_residual_max"], 1e-12);

  for (const std::uintmax_t size : {3u, 7u, 11u, 60u, 170u}) {
    fs::copy_file(File("two.pqp"), File("cut.pqp"), fs::copy_options::overwrite_existing);
    fs::resize_file(File("cut.pqp"), size);
    EXPECT_EQ(Run({"qp", "--load", File("cut.pqp")}), 1) << size;
    EXPECT_THAT(said_, HasSubstr("cut.pqp: ends within"));
  }
  std::ofstream(File("foreign")) << "not a file of problems";
  EXPECT_EQ(Run({"qp", "--load", File("foreign")}), 1);
  EXPECT_THAT(said_, HasSubstr("is no file of QPs"));
}

TEST_F(PalpateBench, AccuracyFindsSmallerErrorsWithMoreSpheresAndNoneOnAFlatFace) {
  ASSERT_EQ(
      Run({"accuracy", "--object", "cube", "--spheres", "64,512", "--contact", "spheres", "--steps",
           "400", "--repeats", "1", "--json", File("cube.json"), "--plot", File("cube.svg")}),
      0)
      << said_;
  const nlohmann::json spheres = Json("cube.json");
  ASSERT_EQ(spheres["results"].size(), 2u);
  double error = 1.1;
  for (const nlohmann::json& row : spheres["results"]) {
    EXPECT_LT(row["force_error"]["magnitude"]["mean"], error);
    error = row["force_error"]["magnitude"]["mean"];
    EXPECT_GT(error, 1e-3) << "spheres are no plane";
    EXPECT_LT(row["truncation_um"]["max"], 1.0) << "chapter 2.5.1";
  }
  std::ifstream plot(File("cube.svg"));
  EXPECT_THAT(std::string(std::istreambuf_iterator<char>(plot), {}), HasSubstr("512 spheres"));

  ASSERT_EQ(Run({"accuracy", "--object", "cube", "--spheres", "64", "--contact", "surface",
                 "--steps", "400", "--repeats", "1", "--json", File("cube.json")}),
            0)
      << said_;
  const nlohmann::json surface = Json("cube.json");
  EXPECT_EQ(surface["spheres"], 64);
  EXPECT_LE(surface["force_error"]["magnitude"]["mean"], 0.001);
  EXPECT_LE(surface["force_error"]["magnitude"]["max"], 0.005);
  EXPECT_LE(surface["direction_deg"]["max"], 0.3);
  EXPECT_TRUE(surface["best_step_us"].contains("p999"));
}

TEST_F(PalpateBench, AccuracySetsTheTrianglesOfAMeshBesideTheSpheres) {
  ASSERT_EQ(Run({"accuracy", "--object", "ellipsoid", "--spheres", "512", "--triangles", "4000",
                 "--contact", "surface", "--steps", "400", "--repeats", "1", "--json",
                 File("ellipsoid.json")}),
            0)
      << said_;
  const nlohmann::json json = Json("ellipsoid.json");
  EXPECT_EQ(json["triangles"], 5120);
  EXPECT_LE(json["force_error"]["magnitude"]["max"], 0.01);
  // Flat triangles: the true surface lies up to e^2 / 8R outside them.
  EXPECT_EQ(json["mesh"]["triangles"], 5120);
  EXPECT_GT(json["mesh"]["force_error"]["magnitude"]["max"], 0.01);
  EXPECT_LT(json["mesh"]["force_error"]["magnitude"]["max"], 0.1);
}

TEST_F(PalpateBench, StabilityRunsACaseByItsNameAndExitsWithOneWhereItDoesNotHold) {
  ASSERT_EQ(Run({"stability", "--case", "no-drift", "--contact", "spheres", "--steps", "4000",
                 "--json", File("drift.json")}),
            0)
      << said_;
  const nlohmann::json json = Json("drift.json");
  EXPECT_EQ(json["held"], 1);
  EXPECT_EQ(json["total"], 1);
  const nlohmann::json& drift = json["cases"][0];
  EXPECT_EQ(drift["name"], "no-drift");
  EXPECT_GE(drift["steps"], 4000);
  EXPECT_LE(drift["figure"], drift["bound"]);
  EXPECT_EQ(drift["unit"], "um");
  EXPECT_EQ(drift["held"], true);

  EXPECT_EQ(Run({"stability", "--case", "no-such-case"}), 2);
  EXPECT_THAT(said_, HasSubstr("wedge-5"));
}

TEST_F(PalpateBench, LevelsShowFinerTreesCloserToTheFinest) {
  ASSERT_EQ(Run({"levels", "--scene", "cube", "--leaves", "512,64,4096", "--contact", "spheres",
                 "--repeats", "1", "--json", File("levels.json"), "--plot", File("levels.svg")}),
            0)
      << said_;
  const nlohmann::json levels = Json("levels.json")["levels"];
  ASSERT_EQ(levels.size(), 3u);
  EXPECT_EQ(levels[0]["object_spheres"], 64);
  EXPECT_EQ(levels[2]["object_spheres"], 4096);
  EXPECT_EQ(levels[2]["tool_spheres"], 1);
  EXPECT_GT(levels[0]["against_finest"]["force"], levels[1]["against_finest"]["force"]);
  EXPECT_GT(levels[1]["against_finest"]["force"], 0.0);
  EXPECT_EQ(levels[2]["against_finest"]["force"], 0.0);
  EXPECT_GT(levels[0]["uncovered_um"]["mean"], levels[2]["uncovered_um"]["mean"]);
}

TEST_F(PalpateBench, CycleRunsWithTheFrictionThatIsAskedFor) {
  std::vector<double> jump;
  for (const std::string friction : {"off", "chapter", "coulomb"}) {
    ASSERT_EQ(Run({"cycle", "--scene", "cube", "--steps", "3000", "--repeats", "1", "--contact",
                   "spheres", "--friction", friction, "--json", File("cycle.json")}),
              0)
        << said_;
    const nlohmann::json json = Json("cycle.json");
    EXPECT_EQ(json["friction"], friction);
    EXPECT_EQ(json["contact"], "spheres");
    EXPECT_LT(json["penetration_um"]["max"], 1.0) << friction;
    jump.push_back(json["jump"]["force_N_max"]);
  }
  EXPECT_NE(jump[0], jump[1]);
  EXPECT_NE(jump[0], jump[2]);
}

TEST_F(PalpateBench, RefusesWhatThisVersionHasNot) {
  EXPECT_EQ(Run({"cycle", "--scene", "cube", "--contact", "putty"}), 2);
  EXPECT_EQ(Run({"cycle", "--scene", "cube", "--friction", "glue"}), 2);
  EXPECT_EQ(Run({"qp"}), 2);
  EXPECT_EQ(Run({"cycle", "--steps", "0"}), 2);
}

}  // namespace
}  // namespace palpate
