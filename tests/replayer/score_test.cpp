#include "client/replayer/score.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/error.h"
#include "common/math/rotation.h"
#include "tests/common/recording/samples.h"

namespace palpate::test {
namespace {

/// A hand along x by 100 mm in so many seconds, `side` away from the line, with this force.
HandPath Stroke(double seconds, const Vec3& side = Vec3::Zero(), double force_N = 1.0) {
  HandPath path;
  const int n = static_cast<int>(1000 * seconds);
  for (int i = 0; i <= n; ++i) {
    const double s = static_cast<double>(i) / n;
    path.time_s.push_back(1e-3 * i);
    path.X_WH.push_back({Vec3(0.1 * s, 0, 0) + side, Quat::Identity()});
    path.force_N.push_back(Vec3(0, 0, force_N));
    path.torque_Nm.push_back(Vec3::Zero());
  }
  return path;
}

TEST(Score, IsNothingBetweenAPathAndItself) {
  const Score score = ScorePath(Stroke(2.0), Stroke(2.0));
  EXPECT_EQ(score.path_max_mm, 0.0);
  EXPECT_EQ(score.frechet_mm, 0.0);
  EXPECT_EQ(score.force_rms_N, 0.0);
  EXPECT_EQ(score.turn_mean_deg, 0.0);
  EXPECT_EQ(score.expert_s, score.trainee_s);
}

TEST(Score, IsTheDistanceOfParallelPathsWhateverTheirPace) {
  const Score score = ScorePath(Stroke(2.0), Stroke(5.0, Vec3(0, 0.003, 0.004)));
  EXPECT_NEAR(score.path_mean_mm, 5.0, 0.01);
  EXPECT_NEAR(score.path_max_mm, 5.0, 0.1);
  EXPECT_NEAR(score.frechet_mm, 5.0, 0.01);
  EXPECT_NEAR(score.trainee_s / score.expert_s, 2.5, 0.02);
}

TEST(Score, LeavesOutThatAHandWaitsBeforeAndAfter) {
  HandPath late = Stroke(2.0);
  HandPath waiting;
  for (int i = 0; i < 3000; ++i) {
    waiting.time_s.push_back(1e-3 * i);
    waiting.X_WH.push_back(late.X_WH.front());
    waiting.force_N.push_back(Vec3::Zero());
    waiting.torque_Nm.push_back(Vec3::Zero());
  }
  for (std::size_t i = 0; i < late.size(); ++i) {
    waiting.time_s.push_back(3.0 + late.time_s[i]);
    waiting.X_WH.push_back(late.X_WH[i]);
    waiting.force_N.push_back(late.force_N[i]);
    waiting.torque_Nm.push_back(late.torque_Nm[i]);
  }
  const Score score = ScorePath(Stroke(2.0), waiting);
  EXPECT_NEAR(score.trainee_s, score.expert_s, 0.01);
  EXPECT_NEAR(score.path_max_mm, 0.0, 0.2);
}

TEST(Score, SeesADetourByItsGreatestDistance) {
  HandPath detour = Stroke(2.0);
  for (std::size_t i = 0; i < detour.size(); ++i) {
    const double s = static_cast<double>(i) / static_cast<double>(detour.size() - 1);
    detour.X_WH[i].p.y() = 0.020 * std::sin(std::numbers::pi * s);
  }
  const Score score = ScorePath(Stroke(2.0), detour);
  EXPECT_NEAR(score.frechet_mm, 20.0, 0.1);
  EXPECT_NEAR(score.path_max_mm, 20.0, 0.5);
  EXPECT_LT(score.path_mean_mm, 15.0);
}

TEST(Score, ComparesForcesAndRotations) {
  HandPath turned = Stroke(2.0, Vec3::Zero(), 1.5);
  for (Pose& X : turned.X_WH) X.q = RotationExp(Vec3(0, 0, 0.1));
  const Score score = ScorePath(Stroke(2.0, Vec3::Zero(), 1.0), turned);
  EXPECT_NEAR(score.force_rms_N, 0.5, 1e-12);
  EXPECT_EQ(score.expert_peak_N, 1.0);
  EXPECT_EQ(score.trainee_peak_N, 1.5);
  EXPECT_NEAR(score.turn_mean_deg, 0.1 * 180 / std::numbers::pi, 1e-6);
  EXPECT_NEAR(score.trainee_contact_s, score.trainee_s, 0.01);
}

TEST(Score, RefusesAHandThatNeverMoves) {
  HandPath still = Stroke(2.0);
  for (Pose& X : still.X_WH) X = Pose{};
  EXPECT_THROW(ScorePath(Stroke(2.0), still), Error);
}

TEST(HandPath, IsThatOfTheLongestSession) {
  const Folder folder;
  RecordingWriter writer({.file = folder / "a.mcap"});
  for (std::uint64_t i = 1; i <= 20; ++i) {
    if (i <= 5) Add(writer, dds::PoseTopic("short", 1), SamplePose(i), 0);
    wire::HapticPose pose = SamplePose(i);
    pose.orientation_wxyz[0] = 1.0;
    for (int k = 1; k < 4; ++k) pose.orientation_wxyz[k] = 0.0;
    Add(writer, dds::PoseTopic("long", 2), pose, 0);
    if (i != 7) Add(writer, dds::WrenchTopic("long", 2), SampleWrench(i), 0);
  }
  Add(writer, dds::kSessionStateTopic, SampleState("long", 2), 0);
  writer.Close("");
  const HandPath path = ReadHandPath({folder / "a.mcap"});
  EXPECT_EQ(path.station, "long");
  EXPECT_EQ(path.scene, "cube");
  ASSERT_EQ(path.size(), 20u);
  EXPECT_NEAR(path.duration_s(), 0.019, 1e-12);
  EXPECT_EQ(path.X_WH[3].p.x(), 0.5);
  EXPECT_EQ(path.force_N[3].x(), 0.5);
  EXPECT_EQ(path.force_N[6], Vec3::Zero());
}

TEST(HandPath, LeavesOutPosesThatNobodyCanUse) {
  const Folder folder;
  const auto record = [&](int poses, int usable) {
    RecordingWriter writer({.file = folder / "a.mcap", .overwrite = true});
    for (int i = 1; i <= poses; ++i) {
      wire::HapticPose pose = SamplePose(static_cast<std::uint64_t>(i));
      if (i > usable) {
        for (double& q : pose.orientation_wxyz) q = i % 2 == 0 ? 0.0 : 1.0 / 0.0;
      }
      Add(writer, dds::PoseTopic("hand", 1), pose, 1'000'000 * i);
    }
    writer.Close("");
  };
  record(10, 3);
  EXPECT_EQ(ReadHandPath({folder / "a.mcap"}).size(), 3u);
  record(10, 0);
  EXPECT_THROW(ReadHandPath({folder / "a.mcap"}), Error);
}

}  // namespace
}  // namespace palpate::test
