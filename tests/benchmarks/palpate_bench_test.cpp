#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/benchmarks/bench_fixture.h"

namespace palpate {
namespace {

using test::PalpateBench;
using testing::HasSubstr;
namespace fs = std::filesystem;

TEST_F(PalpateBench, CycleMeasuresAScenesPathAndItsPenetration) {
  const nlohmann::json json =
      Figures({"cycle", "--scene", "cube", "--steps", "3000", "--repeats", "2"});
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
  EXPECT_LT(json["mesh_penetration_um"]["max"], 1.0);
  EXPECT_EQ(json["mesh_penetration_um"]["share_over_1um"], 0.0);
  EXPECT_EQ(json["qp"]["unsolved"], 0);
  EXPECT_LT(json["jump"]["force_N_max"], 1.0);
}

TEST_F(PalpateBench, CycleJudgesSpheresByTheirMeshesToo) {
  // The leaves lie inside the meshes, so the meshes meet first.
  const nlohmann::json json = Figures(
      {"cycle", "--scene", "cube", "--steps", "3000", "--repeats", "1", "--contact", "spheres"});
  EXPECT_LT(json["penetration_um"]["max"], 1.0);
  EXPECT_GT(json["mesh_penetration_um"]["max"], 1.0);
  EXPECT_GT(json["mesh_intersecting_fraction"], 0.0);
  EXPECT_LT(json["mesh_intersecting_fraction"], 1.0);
}

TEST_F(PalpateBench, CycleTracesEveryStepSoThatItsPosesReadBack) {
  const nlohmann::json json = Figures({"cycle", "--scene", "cube", "--steps", "1200", "--repeats",
                                       "1", "--trace", File("trace.csv")});
  std::ifstream trace(File("trace.csv"));
  std::string line;
  std::getline(trace, line);
  EXPECT_EQ(line,
            "step,hx,hy,hz,hqw,hqx,hqy,hqz,gx,gy,gz,gqw,gqx,gqy,gqz,fx,fy,fz,tx,ty,tz,contacts,"
            "faults,substeps,step_us");
  int rows = 0;
  double jump = 0.0, before[3] = {};
  // The recorded hand reads back to the same bits: driving it again gives the same jumps.
  std::ofstream poses(File("poses.csv"));
  while (std::getline(trace, line)) {
    std::istringstream cells(line);
    std::vector<std::string> cell;
    for (std::string text; std::getline(cells, text, ',');) cell.push_back(text);
    ASSERT_EQ(cell.size(), 25u) << line;
    EXPECT_EQ(cell[0], std::to_string(rows));
    double change = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
      const double force = std::stod(cell[15 + i]);
      change += (force - before[i]) * (force - before[i]);
      before[i] = force;
    }
    if (rows > 0) jump = std::max(jump, std::sqrt(change));
    for (std::size_t i = 1; i <= 7; ++i) poses << cell[i] << (i < 7 ? "," : "\n");
    ++rows;
  }
  poses.close();
  EXPECT_EQ(rows, 1200);
  EXPECT_GT(before[0] * before[0] + before[1] * before[1] + before[2] * before[2], 0.01);
  EXPECT_NEAR(json["jump"]["force_N_max"], jump, 1e-12);
  const nlohmann::json again =
      Figures({"cycle", "--scene", "cube", "--poses", File("poses.csv"), "--repeats", "1"});
  EXPECT_EQ(again["jump"], json["jump"]);
}

TEST_F(PalpateBench, CycleTakesPosesFromAFileAndNamesTheLineThatIsWrong) {
  std::ofstream(File("poses.csv")) << "x,y,z,qw,qx,qy,qz\n0,0.05,0,1,0,0,0\n0,0.049,0,1,0,0,0\n";
  const nlohmann::json json =
      Figures({"cycle", "--scene", "cube", "--poses", File("poses.csv"), "--repeats", "1"});
  EXPECT_EQ(json["steps"], 2);
  std::ofstream(File("short.csv")) << "0,0.05,0,1,0,0,0\n0,0.05,0\n";
  EXPECT_EQ(Run({"cycle", "--scene", "cube", "--poses", File("short.csv")}), 1);
  EXPECT_THAT(said_, HasSubstr("short.csv:2: needs seven numbers"));
  std::ofstream(File("long.csv")) << "0,0.05,0,2,0,0,0\n";
  EXPECT_EQ(Run({"cycle", "--scene", "cube", "--poses", File("long.csv")}), 1);
  EXPECT_THAT(said_, HasSubstr("long.csv:1: the pose is not finite or its quaternion"));
}

TEST_F(PalpateBench, CycleSaysWhetherTheToolArrivesAndTheCauseOfEveryJump) {
  const nlohmann::json json =
      Figures({"cycle", "--scene", "cube", "--steps", "3000", "--repeats", "1", "--check-every",
               "5", "--settle-every", "300", "--subsample"});
  EXPECT_EQ(json["arrived_fraction"], 1.0);
  EXPECT_EQ(json["lag_mm"]["max"], 0.0);
  EXPECT_LT(json["force_error_N"]["max"], 1e-3);
  EXPECT_EQ(json["not_arrived"], 0);
  EXPECT_EQ(json["not_arrived_run_max"], 0);
  EXPECT_EQ(json["never_arriving"]["tried"], 0);
  EXPECT_EQ(json["notches"], 0);
  EXPECT_EQ(json["largest_jump"]["force_N"], json["jump"]["force_N_max"]);
  EXPECT_EQ(json["largest_ledge"]["force_N"], json["ledge_force_N_max"]);
  EXPECT_EQ(json["jump"]["unexplained"], 0);
  for (const char* cause : {"hand", "ledge", "contact_gained", "contact_lost", "unexplained"}) {
    EXPECT_TRUE(json["jump"]["causes"][cause].contains("count")) << cause;
  }
  EXPECT_EQ(json["settle"]["poses"], 10);
  EXPECT_EQ(json["settle"]["within_10ms"], 1.0);
  EXPECT_LT(json["force_4khz_rms_fraction"], 0.01);
}

TEST_F(PalpateBench, HandsDriveAnySceneAndTheirPosesReadBack) {
  const nlohmann::json hand =
      Figures({"hands", "--scene", "cube", "--seed", "4", "--speed", "0.2", "--steps", "1500",
               "--check-every", "10", "--poses-out", File("hand.csv")});
  EXPECT_EQ(hand["scene"], "cube");
  EXPECT_EQ(hand["seed"], 4);
  EXPECT_EQ(hand["steps"], 1500);
  EXPECT_GT(hand["force_rms_N"], 0.1) << "the hand never pressed";
  EXPECT_TRUE(hand["settle"].contains("within_50ms"));
  EXPECT_TRUE(hand.contains("force_4khz_rms_fraction"));
  const nlohmann::json cycle = Figures({"cycle", "--scene", "cube", "--poses", File("hand.csv"),
                                        "--repeats", "1", "--check-every", "10"});
  EXPECT_EQ(cycle["jump"], hand["jump"]);
  EXPECT_EQ(hand["support"]["judged"], 150) << "a ball on a cube always arrives";
  EXPECT_LT(hand["unsupported_force_N"]["max"], 0.01);
  EXPECT_LT(hand["unsupported_torque_Nm"]["max"], 1e-6) << "nothing turns a ball";
  EXPECT_GT(hand["nudged"]["places"], 10);
  EXPECT_EQ(hand["nudged"]["freed"], 0);
  EXPECT_EQ(hand["friction_cycles"]["unsolved"], 0);
}

TEST_F(PalpateBench, HandsDriveBodiesMadeFromASeed) {
  const nlohmann::json hand = Figures({"hands", "--scene", "sharp-dice:5", "--press-mm", "8",
                                       "--steps", "300", "--settle-every", "0"});
  EXPECT_EQ(hand["scene"], "sharp-dice:5");
  EXPECT_EQ(hand["press_mm"], 8.0);
  EXPECT_EQ(hand["mesh_intersecting_fraction"], 0.0);
  EXPECT_EQ(hand["not_arrived"], hand["never_arriving"]["tried"]);
}

TEST_F(PalpateBench, HandsOfSeveralSeedsPutTheWorstFirst) {
  const nlohmann::json seeds =
      Figures({"hands", "--scene", "cube", "--seeds", "1..3", "--steps", "800", "--check-every",
               "10", "--contact", "spheres"})["seeds"];
  ASSERT_EQ(seeds.size(), 3u);
  const auto worse = [](const nlohmann::json& a, const nlohmann::json& b) {
    return std::make_pair(a["mesh_intersecting_fraction"] > 0.0, a["mesh_penetration_um"]["max"]) >=
           std::make_pair(b["mesh_intersecting_fraction"] > 0.0, b["mesh_penetration_um"]["max"]);
  };
  EXPECT_TRUE(worse(seeds[0], seeds[1]) && worse(seeds[1], seeds[2])) << seeds;
  EXPECT_EQ(Run({"hands", "--scene", "cube", "--seeds", "3..1"}), 2);
  EXPECT_THAT(said_, HasSubstr("--seeds 3..1 is no range"));
}

TEST_F(PalpateBench, QpReadsBackWhatItDumped) {
  // One problem: the point nearest to the origin with x >= 1 and y >= 2.
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
  const nlohmann::json json = Figures({"qp", "--load", File("two.pqp")});
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

TEST_F(PalpateBench, CycleRunsWithTheFrictionThatIsAskedFor) {
  std::vector<double> jump;
  for (const std::string friction : {"off", "chapter", "coulomb"}) {
    const nlohmann::json json = Figures({"cycle", "--scene", "cube", "--steps", "3000", "--repeats",
                                         "1", "--contact", "spheres", "--friction", friction});
    EXPECT_EQ(json["friction"], friction);
    EXPECT_EQ(json["contact"], "spheres");
    EXPECT_LT(json["penetration_um"]["max"], 1.0) << friction;
    jump.push_back(json["jump"]["force_N_max"]);
  }
  EXPECT_NE(jump[0], jump[1]);
  EXPECT_NE(jump[0], jump[2]);
}

TEST_F(PalpateBench, AccuracyFindsSmallerErrorsWithMoreSpheresAndNoneOnAFlatFace) {
  const nlohmann::json spheres =
      Figures({"accuracy", "--object", "cube", "--spheres", "64,512,4096", "--contact", "spheres",
               "--steps", "400", "--repeats", "1"});
  ASSERT_EQ(spheres["results"].size(), 3u);
  double error = 2.0;
  for (const nlohmann::json& row : spheres["results"]) {
    EXPECT_LT(row["force_error"]["magnitude"]["mean"], 0.5 * error);
    error = row["force_error"]["magnitude"]["mean"];
    EXPECT_GT(error, 1e-3) << "spheres are no plane";
    EXPECT_LT(row["truncation_um"]["max"], 1.0) << "chapter 2.5.1";
  }
  EXPECT_THAT(Drawn("figures.json"), HasSubstr(">cube, sphere contact<"));

  const nlohmann::json surface =
      Figures({"accuracy", "--object", "cube", "--spheres", "64", "--contact", "surface", "--steps",
               "400", "--repeats", "1"});
  EXPECT_EQ(surface["spheres"], 64);
  // The ball keeps limits::mesh::kSeparation from the face, a thousandth of its 1 mm of depth.
  EXPECT_LE(surface["force_error"]["magnitude"]["mean"], 0.001 + 1e-9);
  EXPECT_LE(surface["force_error"]["magnitude"]["max"], 0.005);
  EXPECT_LE(surface["direction_deg"]["max"], 0.3);
  EXPECT_TRUE(surface["best_step_us"].contains("p999"));
}

TEST_F(PalpateBench, AccuracySetsTheTrianglesOfAMeshBesideTheSpheres) {
  const auto measure = [&](const std::string& tolerance_um) {
    return Figures({"accuracy", "--object", "ellipsoid", "--spheres", "64", "--triangles", "4000",
                    "--tolerance-um", tolerance_um, "--contact", "surface", "--repeats", "1"});
  };
  const nlohmann::json flat = measure("0");
  EXPECT_EQ(flat["triangles"], 5120);
  EXPECT_EQ(flat["felt_triangles"], 5120);
  EXPECT_GT(flat["force_error"]["magnitude"]["max"], 0.01);
  // 3 um off the surface is 0.003 of the force at 1 mm of depth; 0.1 degrees is 0.0017 of it.
  const nlohmann::json json = measure("3");
  EXPECT_EQ(json["triangles"], 5120);
  EXPECT_GT(json["felt_triangles"], 50'000);
  EXPECT_LE(json["force_error"]["magnitude"]["max"], 0.003);
  EXPECT_LE(json["direction_deg"]["max"], 0.25);
  // The true surface lies up to e^2 / 8R outside flat triangles.
  EXPECT_EQ(json["mesh"]["triangles"], 5120);
  EXPECT_GT(json["mesh"]["force_error"]["magnitude"]["max"], 0.01);
  EXPECT_LT(json["mesh"]["force_error"]["magnitude"]["max"], 0.1);
}

TEST_F(PalpateBench, StabilityRunsACaseByItsNameAndExitsWithOneWhereItDoesNotHold) {
  const nlohmann::json json =
      Figures({"stability", "--case", "no-drift", "--contact", "spheres", "--steps", "4000"});
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

TEST_F(PalpateBench, ParetoWritesAReportTableAndJsonOfAllThatItMeasured) {
  ASSERT_EQ(Run({"pareto", "--quick", "--repeats", "1", "--out", File("pareto")}), 0) << said_;
  const nlohmann::json json = Json("pareto/pareto.json");
  EXPECT_TRUE(json["complete"]);
  EXPECT_FALSE(json["machine"]["cpu"].get<std::string>().empty());

  ASSERT_EQ(json["scenes"].size(), 3u);
  for (const auto& scene : json["scenes"]) {
    ASSERT_EQ(scene["runs"].size(), 6u) << scene["scene"];
    const auto& spheres = scene["runs"][0];
    ASSERT_TRUE(spheres["available"]) << spheres;
    EXPECT_LE(spheres["best_step_us"]["p50"], spheres["best_step_us"]["p999"]);
    EXPECT_LT(spheres["sphere_overlap_um"], 1.0) << scene["scene"];
    EXPECT_GT(spheres["jump"]["force_N_max"], 0.0) << "the path never touched " << scene["scene"];
    for (const auto& run : scene["runs"]) {
      EXPECT_TRUE(run["available"] || run.contains("reason")) << run;
    }
  }
  // More spheres are more accurate.
  std::map<int, double> cube;
  for (const auto& slide : json["accuracy"]) {
    if (slide["object"] == "cube" && slide["contact"] == "spheres") {
      cube[slide["spheres"]] = slide["force_error"]["mean"];
    }
  }
  EXPECT_LT(cube.at(512), 0.5 * cube.at(64));

  for (const auto& goal : json["goals"]) {
    if (!goal.contains("figure")) continue;
    EXPECT_EQ(goal["held"], goal["figure"] <= goal["bound"]) << goal;
  }
  // Every installed peer has run the path and the slide over the cube.
  for (const auto& peer : json["peers"]["known"]) {
    const auto here = [&](const auto& run) { return run["id"] == peer["id"] && run["available"]; };
    const auto& path = json["peers"]["path"];
    EXPECT_EQ(std::any_of(path.begin(), path.end(), here), peer["installed"]) << peer;
  }

  const std::string report = Read("pareto/report.md");
  for (const char* section :
       {"# Palpate: speed against error\n", "\n## Machine\n", "\n## Speed against error\n",
        "\n## Force error\n", "\n## Scenes\n", "\n| `bunny-bunny` | ", "\n## Peers\n",
        "\n## Where a figure is missed\n"}) {
    EXPECT_THAT(report, HasSubstr(section));
  }
  // One row for each run in the JSON, with as many cells as the header.
  std::size_t runs = 0;
  const auto count = [&](const nlohmann::json& all) {
    for (const auto& run : all) runs += run["available"] == true;
  };
  count(json["accuracy"]);
  for (const auto& scene : json["scenes"]) count(scene["runs"]);
  for (const char* part : {"path", "slide"}) count(json["peers"][part]);
  std::istringstream csv(Read("pareto/pareto.csv"));
  std::size_t rows = 0;
  for (std::string row; std::getline(csv, row); ++rows) {
    // A quoted name may contain a comma.
    row = std::regex_replace(row, std::regex("\"[^\"]*\""), "");
    EXPECT_EQ(std::count(row.begin(), row.end(), ','), 18) << row;
  }
  EXPECT_EQ(rows, 1 + runs);
  EXPECT_THAT(Read("pareto/pareto.svg"), HasSubstr("</svg>"));
}

TEST_F(PalpateBench, PeersMeasuresALibraryOfOnesOwnAndSaysWhatItCannotDo) {
  ASSERT_EQ(Run({"peers", "--quick", "--repeats", "1", "--out", File("p"), "--peers",
                 PALPATE_BIN_DIR "/palpate_peer_for_tests.so"}),
            0)
      << said_;
  EXPECT_THAT(Read("p/peers.csv"), HasSubstr("\npeer slide,\"Ghost\",,,,,,,yes,"));
  EXPECT_THAT(Read("p/peers.csv"), HasSubstr("\npeer slide on ellipsoid,\"Ghost\","));
  const std::string report = Read("p/report.md");
  EXPECT_THAT(report, HasSubstr("- **Ghost 1** (`palpate_peer_for_tests.so`): goes where"));
  EXPECT_THAT(report, HasSubstr("Not available: Ghost (it has a ball only)."));
  EXPECT_THAT(report, HasSubstr("was not asked for")) << "the others";
}

TEST_F(PalpateBench, TruthKnowsTheForceOfABallOnAnyPlate) {
  const nlohmann::json json = Figures({"truth", "--only", "/needles/ball", "--seeds", "1..2"});
  ASSERT_EQ(json["cases"].size(), 4u);  // with those in grooves
  const nlohmann::json &smooth = json["cases"][0], &rough = json["cases"][1];
  EXPECT_EQ(smooth["name"], "flat/needles/ball");
  EXPECT_EQ(smooth["slides"], 2);
  EXPECT_EQ(smooth["late"], 0);
  EXPECT_LT(smooth["sideways N"], 1e-6);
  EXPECT_LT(smooth["force off N"], 1e-3);
  EXPECT_EQ(rough["name"], "flat-friction/needles/ball");
  EXPECT_GT(rough["judged"], 100);
  EXPECT_NEAR(rough["mu least"], 0.3, 1e-6);
  EXPECT_NEAR(rough["mu most"], 0.3, 1e-6);
  EXPECT_LT(rough["direction deg"], 1e-3);
  EXPECT_LT(rough["change N/N"], 1e-3);
}

// A trust region of this tool once bounded every later step to nothing.
TEST_F(PalpateBench, TruthFollowsAToolWhoseFirstShortStepOnlyTurns) {
  const nlohmann::json slide =
      Figures({"truth", "--only", "flat/needles/triangle", "--seeds", "20..20"})["cases"][0];
  EXPECT_EQ(slide["late"], 0);
  EXPECT_LT(slide["sideways N"], 0.01);
}

// So many slivers meet at the middle of a fan that a cycle cannot look at all of them.
TEST_F(PalpateBench, TruthFeelsAPlateWhereThereIsNoTimeToLookAtIt) {
  const nlohmann::json slide =
      Figures({"truth", "--only", "flat/fan/cup", "--seeds", "3..3"})["cases"][0];
  EXPECT_GT(slide["late"], 10);
  EXPECT_LT(slide["force off N"], 0.2);
}

TEST_F(PalpateBench, TruthKnowsTheForceOfABallInAGrooveAndOnACurvedBody) {
  const nlohmann::json groove =
      Figures({"truth", "--only", "/quad/ball", "--seeds", "1..2"})["cases"];
  ASSERT_EQ(groove.size(), 4u);
  EXPECT_EQ(groove[2]["name"], "folds/quad/ball");
  EXPECT_LT(groove[2]["force off N"], 1e-3);
  EXPECT_LT(groove[2]["out um"], 0.01);
  EXPECT_EQ(groove[3]["name"], "folds-friction/quad/ball");
  EXPECT_NEAR(groove[3]["mu least"], 0.3, 1e-6);
  EXPECT_NEAR(groove[3]["mu most"], 0.3, 1e-6);
  EXPECT_LT(groove[3]["across off N"], 1e-3);
  const nlohmann::json curved = Figures({"truth", "--only", "/sphere-1e3/ball"})["cases"];
  ASSERT_EQ(curved.size(), 2u);
  EXPECT_EQ(curved[0]["over"], 0);
  EXPECT_GT(curved[0]["cycles"], 300);
  EXPECT_EQ(curved[1]["over deg"], 0.0);
  EXPECT_NEAR(curved[1]["mu least"], 0.3, 1e-3);
  EXPECT_NEAR(curved[1]["mu most"], 0.3, 1e-3);
  EXPECT_GT(curved[1]["judged"], 50);
}

TEST_F(PalpateBench, TruthDrawsABurOutOfABarWithItsHand) {
  const nlohmann::json cone =
      Figures({"truth", "--only", "cut/bar/cone", "--seeds", "13..13"})["cases"][0];
  EXPECT_EQ(cone["hands"], 1);
  EXPECT_EQ(cone["wrong"], 0);
  EXPECT_LT(cone["gains uJ"], -100.0);  // it has cut
  EXPECT_LT(cone["kept by N"], 1e-9);
}

TEST_F(PalpateBench, TruthMillsWithABurThatTiltsAsItsHandDoes) {
  const nlohmann::json cone = Figures({"truth", "--only", "cut/tilt/cone"})["cases"][0];
  EXPECT_EQ(cone["wrong"], 0);
  EXPECT_EQ(cone["late"], 0);
  EXPECT_LT(cone["gains uJ"], -100.0);  // it has cut
}

TEST_F(PalpateBench, TruthDrivesTheSameHandForTheSameSeedAlone) {
  const std::vector<std::string> slides{"truth", "--only", "flat/strips/box", "--seeds"};
  const nlohmann::json of_three = Figures(test::Joined(slides, {"1..3"}))["cases"][0];
  const std::string worst = std::to_string(of_three["sideways N, seed"].get<int>());
  const nlohmann::json alone = Figures(test::Joined(slides, {worst + ".." + worst}))["cases"][0];
  EXPECT_EQ(alone["slides"], 1);
  EXPECT_EQ(alone["sideways N"], of_three["sideways N"]);
  EXPECT_EQ(Run(test::Joined(slides, {"3..1"})), 2);
  EXPECT_EQ(Run({"truth", "--only", "round/earth"}), 2);
}

}  // namespace
}  // namespace palpate
