#include "client/replayer/export/export.h"

#include <bit>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <limits>
#include <map>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "client/replayer/export/export_folder.h"
#include "common/error.h"
#include "common/revision.h"
#include "common/step_fault.h"
#include "tests/common/recording/samples.h"
#include "tests/replayer/export/csv_table.h"
#include "tests/replayer/lesson_recording.h"
#include "tests/support/read_file.h"

namespace palpate::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::uint64_t Bits(double value) {
  return std::bit_cast<std::uint64_t>(value);
}

/// A finite double of any bits, which its shortest text must give back.
double AnyDouble(std::uint64_t& seed) {
  for (;;) {
    seed = seed * 6364136223846793005ull + 1442695040888963407ull;
    const double value = std::bit_cast<double>(seed ^ (seed >> 29));
    if (std::isfinite(value)) return value;
  }
}

/// Exports as CSV; tests/python/recording_test.py compares NumPy's files with it.
class ExportOf : public testing::Test {
 protected:
  Table Read(const std::string& table) const { return ReadCsv(out + "/" + table + ".csv"); }
  void Run() { Export({.files = {recording}, .folder = out}, stop); }
  /// A recording of one pose.
  void Record() {
    RecordingWriter writer({.file = recording, .overwrite = true});
    Add(writer, dds::PoseTopic("hand", 5), SamplePose(1), kBegin_ns);
    writer.Close("");
  }
  Folder folder;
  std::string recording = folder / "day.mcap";
  std::string out = folder / "out";
  StopSignal stop;
};

TEST_F(ExportOf, GivesEveryBitOfEveryPoseAndWrenchOfEachSession) {
  std::map<std::uint64_t, std::vector<wire::HapticPose>> poses;
  std::map<std::uint64_t, std::vector<wire::Wrench>> wrenches;
  std::uint64_t seed = 1;
  RecordingWriter writer({.file = recording});
  for (std::uint64_t i = 0; i < 200; ++i) {
    for (const std::uint64_t run : {5u, 6u}) {
      wire::HapticPose pose = SamplePose(1000 * run + i);
      for (double& x : pose.position_m) x = AnyDouble(seed);
      for (double& x : pose.angular_velocity_rad_s) x = AnyDouble(seed);
      wire::Wrench wrench = SampleWrench(1000 * run + i);
      for (double& x : wrench.force_N) x = AnyDouble(seed);
      if (i == 77) {
        wrench.force_N[0] = std::numeric_limits<double>::quiet_NaN();
        wrench.torque_Nm[1] = -std::numeric_limits<double>::infinity();
      }
      const std::int64_t now_ns = kBegin_ns + static_cast<std::int64_t>(i) * kMs;
      Add(writer, dds::PoseTopic("hand", run), pose, now_ns);
      Add(writer, dds::WrenchTopic("hand", run), wrench, now_ns + 250'000);
      poses[run].push_back(pose);
      wrenches[run].push_back(wrench);
    }
  }
  writer.Close("");
  Run();

  for (const std::uint64_t run : {5u, 6u}) {
    const std::string session = "hand_000000000000000" + std::to_string(run);
    const Table pose = Read(session + "/poses"), wrench = Read(session + "/wrenches");
    ASSERT_EQ(pose.rows(), 200u);
    ASSERT_EQ(wrench.rows(), 200u);
    const auto time_s = pose.Numbers("time_s"), x = pose.Numbers("hand_x_m"),
               turning = pose.Numbers("hand_turning_z_rad_per_s"), fx = wrench.Numbers("force_x_N"),
               ty = wrench.Numbers("torque_y_Nm"), tool = wrench.Numbers("tool_z_m"),
               qz = wrench.Numbers("tool_qz"), age_s = wrench.Numbers("age_s");
    for (std::size_t i = 0; i < 200; ++i) {
      const wire::HapticPose& p = poses[run][i];
      const wire::Wrench& w = wrenches[run][i];
      EXPECT_NEAR(time_s[i], 1e-3 * static_cast<double>(i), 1e-12);
      EXPECT_EQ(pose.text.at("pose_sequence")[i], std::to_string(p.pose_sequence));
      EXPECT_EQ(Bits(x[i]), Bits(p.position_m[0]));
      EXPECT_EQ(Bits(turning[i]), Bits(p.angular_velocity_rad_s[2]));
      if (i == 77) {
        EXPECT_TRUE(std::isnan(fx[i]));
        EXPECT_EQ(ty[i], -std::numeric_limits<double>::infinity());
      } else {
        EXPECT_EQ(Bits(fx[i]), Bits(w.force_N[0]));
        EXPECT_EQ(ty[i], w.torque_Nm[1]);
      }
      EXPECT_EQ(tool[i], w.graphic_position_m[2]);
      EXPECT_EQ(qz[i], w.graphic_orientation_wxyz[3]);
      EXPECT_NEAR(age_s[i], 250e-6, 1e-9);
    }
  }
}

TEST_F(ExportOf, KnowsTheAgeOfAWrenchThatOvertookItsPoseAndSaysWhereThereIsNone) {
  RecordingWriter writer({.file = recording});
  Add(writer, dds::PoseTopic("hand", 5), SamplePose(1), kBegin_ns);
  Add(writer, dds::WrenchTopic("hand", 5), SampleWrench(2), kBegin_ns + 2 * kMs);
  Add(writer, dds::PoseTopic("hand", 5), SamplePose(2), kBegin_ns + 3 * kMs);
  Add(writer, dds::WrenchTopic("hand", 5), SampleWrench(9), kBegin_ns + 4 * kMs);
  writer.Close("");
  Run();
  const Table wrenches = Read("hand_0000000000000005/wrenches");
  EXPECT_THAT(wrenches.text.at("pose_sequence"), ElementsAre("2", "9"));
  const auto age_s = wrenches.Numbers("age_s");
  EXPECT_NEAR(age_s[0], -1e-3, 1e-9);
  EXPECT_TRUE(std::isnan(age_s[1]));
}

TEST_F(ExportOf, TellsOfPhasesFaultsContactsAndTheLimiter) {
  RecordingWriter writer({.file = recording});
  wire::SessionState state = SampleState("hand", 5);
  wire::FromText("as \"they\" want,\nit", state.reason);
  state.stiffness_N_per_m = 1000.0;
  Add(writer, dds::kSessionStateTopic, state, kBegin_ns);
  for (std::uint64_t i = 1; i <= 4; ++i) {
    wire::Wrench wrench = SampleWrench(i);
    wrench.faults = i == 3 ? kFaultJammed : kFaultNone;
    Add(writer, dds::WrenchTopic("hand", 5), wrench,
        kBegin_ns + static_cast<std::int64_t>(i) * kMs);
  }
  wire::ToolState tool{};
  wire::FromText("hand", tool.station);
  tool.points = 2;
  Number(tool.point[1].force_N, 7.5);
  Add(writer, dds::kToolStateTopic, tool, kBegin_ns + 5 * kMs);
  wire::StationStatistics station{};
  wire::FromText("hand", station.station);
  wire::FromText("An Arm", station.device);
  station.run = 5;
  station.clamped = 11;
  station.applied_force_N_max = 3.25;
  Add(writer, dds::kStationStatisticsTopic, station, kBegin_ns + 6 * kMs);
  writer.Close("");
  Run();

  const std::string session = "hand_0000000000000005/";
  EXPECT_THAT(Read(session + "session").text.at("phase"), ElementsAre("active"));
  EXPECT_THAT(Read(session + "session").text.at("reason"), ElementsAre("as \"they\" want,\\nit"));
  EXPECT_THAT(Read(session + "faults").text.at("words"), ElementsAre("jammed", "none"));
  EXPECT_THAT(Read(session + "contacts").Numbers("force_y_N"), ElementsAre(0.0, 8.5));
  EXPECT_THAT(Read(session + "limiter").text.at("clamped"), ElementsAre("11"));

  const auto methods = nlohmann::json::parse(ReadWholeFile(out + "/methods.json"));
  EXPECT_EQ(methods["palpate"]["recorded_with"], PALPATE_VERSION);
  EXPECT_EQ(methods["palpate"]["recorded_physics"], kPhysicsRevision);
  const auto& told = methods["sessions"][0];
  EXPECT_EQ(told["folder"], "hand_0000000000000005");
  EXPECT_EQ(told["device"], "An Arm");
  EXPECT_EQ(told["spring"]["stiffness_N_per_m"], 1000.0);
  EXPECT_EQ(told["limiter"]["applied_force_max_N"], 3.25);
  EXPECT_EQ(told["limiter"]["calls"]["clamped"], 11);
  EXPECT_THAT(ReadWholeFile(out + "/METHODS.md"), HasSubstr("clamped 11"));
}

TEST_F(ExportOf, LeavesOutAStationWhoseNameWouldBeAPath) {
  RecordingWriter writer({.file = recording});
  Add(writer, "palpate/../../evil/0000000000000005/pose", SamplePose(1), kBegin_ns);
  Add(writer, dds::kSessionStateTopic, SampleState("../evil", 5), kBegin_ns);
  Add(writer, dds::PoseTopic("hand", 5), SamplePose(1), kBegin_ns);
  writer.Close("");
  Run();
  const auto methods = nlohmann::json::parse(ReadWholeFile(out + "/methods.json"));
  EXPECT_EQ(methods["samples"]["left_out"], 2);
  EXPECT_EQ(methods["sessions"].back()["folder"], "hand_0000000000000005");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(out), {}), 3);
}

TEST_F(ExportOf, GoesAsFarAsADamagedRecordingDoesAndSaysSo) {
  RecordingWriter writer({.file = recording});
  for (std::uint64_t i = 0; i < 3000; ++i) {
    Add(writer, dds::PoseTopic("hand", 5), SamplePose(i),
        kBegin_ns + static_cast<std::int64_t>(i) * kMs);
    if (i % 500 == 499) writer.Flush();
  }
  writer.Close("");
  std::filesystem::resize_file(recording, std::filesystem::file_size(recording) * 2 / 3);
  Run();
  const Table poses = Read("hand_0000000000000005/poses");
  EXPECT_GT(poses.rows(), 500u);
  EXPECT_LT(poses.rows(), 3000u);
  const auto methods = nlohmann::json::parse(ReadWholeFile(out + "/methods.json"));
  EXPECT_FALSE(methods["complete"]);
  EXPECT_FALSE(methods["problems"].empty());
}

TEST_F(ExportOf, WritesNothingOfAnEmptyRecordingOrWhereItIsStopped) {
  RecordingWriter({.file = recording}).Close("");
  EXPECT_THROW(Run(), Error);
  EXPECT_FALSE(std::filesystem::exists(out));

  Record();
  std::raise(SIGINT);
  EXPECT_THROW(Run(), Error);
  EXPECT_FALSE(std::filesystem::exists(out));
  EXPECT_FALSE(std::filesystem::exists(out + ".part"));
}

TEST_F(ExportOf, LeavesWhatIsThere) {
  Record();
  std::filesystem::create_directory(out);
  Run();  // in place of an empty folder
  EXPECT_THROW(Run(), Error);
  EXPECT_EQ(Read("hand_0000000000000005/poses").rows(), 1u);
  std::filesystem::remove_all(out);
  std::filesystem::create_directory(out + ".part");
  EXPECT_THROW(Run(), Error);
  EXPECT_TRUE(std::filesystem::exists(out + ".part"));
}

TEST(ExportFolder, LeavesWhatComesWhileItGrows) {
  const Folder folder;
  const std::string out = folder / "out", part = out + ".part";
  ExportFolder made(out);
  std::ofstream(made.path() / "poses.csv") << "1";
  // Somebody makes the folder meanwhile, and puts something into it.
  std::filesystem::create_directory(out);
  std::ofstream(out + "/thesis.txt") << "mine";
  EXPECT_THROW(made.Finish(), Error);
  EXPECT_EQ(ReadWholeFile(out + "/thesis.txt"), "mine");
  EXPECT_EQ(ReadWholeFile(part + "/poses.csv"), "1") << "the work is not lost";
}

TEST_F(ExportOf, TellsInItsTextWhatANameIsAndNoMore) {
  RecordingWriter writer({.file = recording});
  wire::SessionState state = SampleState("hand", 5);
  wire::FromText("<img src=x onerror=alert(1)>|`*_[a](b)\\", state.scene);
  Add(writer, dds::kSessionStateTopic, state, kBegin_ns);
  Add(writer, dds::PoseTopic("hand", 5), SamplePose(1), kBegin_ns);
  Add(writer, dds::PoseTopic("hand", 5), SamplePose(~std::uint64_t{0}), kBegin_ns);
  writer.Close("");
  Run();
  const std::string text = ReadWholeFile(out + "/METHODS.md");
  EXPECT_THAT(text, HasSubstr(R"(| &lt;img src=x onerror=alert(1)&gt;\|\`\*\_\[a\](b)\\ |)"));
  EXPECT_THAT(text, HasSubstr("| samples missing, by their numbers | 0 |"));
  EXPECT_THAT(text, HasSubstr("| samples with numbers that do not go on from those before | 1 |"));
}

}  // namespace
}  // namespace palpate::test
