// The type hashes that ROS 2 compares, computed from the message definitions by REP-2016.
#include "client/crtk/crtk_station.h"

#include <cstdio>
#include <limits>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <openssl/sha.h>

#include "tests/support/milliseconds.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;

TEST(RosNames, BeginWithNoDigit) {
  EXPECT_EQ(RosNamespace("hand"), "/hand");
  EXPECT_EQ(RosNamespace("7"), "/station_7");
}

TEST(RosNames, HaveNoTwoUnderscoresSideBySide) {
  for (const char* name : {"hand", "left_hand", "_hidden", "hand_", "7_", "a_b_c"}) {
    EXPECT_EQ(WhyNoRosName(name), "") << name;
  }
  for (const char* name : {"left__hand", "__", "a___b", "__hand", "hand__"}) {
    EXPECT_THAT(WhyNoRosName(name), HasSubstr("give the station an --id without it")) << name;
  }
}

/// The force with which a station's guide pulls a hand at rest, once it has ramped in.
Wrench PullOf(const Vec3& force, const Vec3& torque, const GuideLimits& limits) {
  const Pose X_WH{Vec3(0.1, -0.2, 0.3), Quat(0.5, 0.5, -0.5, 0.5)};
  Guide guide(limits);
  Wrench pull{};
  for (std::int64_t tick = 0; tick < 1000; ++tick) {
    const auto aim = ServoAim(X_WH, {force, torque}, limits);
    if (aim && tick % 5 == 0) guide.Take(tick * kMs, {1, *aim});
    pull = guide.Pull(tick * kMs, 1e-3, X_WH, {});
  }
  return pull;
}

TEST(ServoAim, MakesAStationPullWithTheWrenchThatWasAskedFor) {
  const GuideLimits limits = GuideLimits::OfForce(0.8);
  const Vec3 force(0.3, -0.4, 0.1), torque(0.001, 0.002, -0.004);
  const Wrench pull = PullOf(force, torque, limits);
  EXPECT_LT((pull.force - force).norm(), 1e-9);
  EXPECT_LT((pull.torque - torque).norm(), 1e-9);
}

TEST(ServoAim, ShortensWhatIsMoreThanTheLimitAndKeepsItsDirection) {
  const GuideLimits limits = GuideLimits::OfForce(0.5);
  const Wrench pull = PullOf({0, 1e6, 0}, {0, 0, -1e300}, limits);
  EXPECT_LT((pull.force - Vec3(0, 0.5, 0)).norm(), 1e-9);
  EXPECT_LT((pull.torque - Vec3(0, 0, -0.005)).norm(), 1e-9);
}

TEST(ServoAim, IsNoneOfWhatIsNotFinite) {
  const GuideLimits limits = GuideLimits::OfForce(0.5);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(ServoAim({}, {Vec3(0, nan, 0), Vec3::Zero()}, limits));
  EXPECT_FALSE(ServoAim({}, {Vec3::Zero(), Vec3(inf, 0, 0)}, limits));
}

TEST(ServoAim, IsForgottenByTheStationATenthOfASecondAfterTheLast) {
  const GuideLimits limits = GuideLimits::OfForce(0.5);
  const Pose X_WH{Vec3::Zero(), Quat::Identity()};
  Guide guide(limits);
  double before = 0.0, greatest_step = 0.0;
  for (std::int64_t tick = 0; tick <= 1100; ++tick) {
    if (tick < 1000) guide.Take(tick * kMs, {1, *ServoAim(X_WH, {Vec3(0.5, 0, 0), {}}, limits)});
    const double now = guide.Pull(tick * kMs, 1e-3, X_WH, {}).force.x();
    greatest_step = std::max(greatest_step, before - now);
    before = now;
  }
  EXPECT_EQ(before, 0.0);
  EXPECT_LE(greatest_step, 0.5 / 50 + 1e-12);  // smoothly: over 50 ms
}

TEST(OperatingState, IsWhatCrtkCallsTheSession) {
  EXPECT_STREQ(CrtkStateOf(palpate_SESSION_ACTIVE, false, 0).state, "ENABLED");
  EXPECT_STREQ(CrtkStateOf(palpate_SESSION_ACTIVE, true, 0).state, "PAUSED");
  EXPECT_STREQ(CrtkStateOf(palpate_SESSION_ACTIVE, false, kFaultBadPose).state, "FAULT");
  EXPECT_STREQ(CrtkStateOf(palpate_SESSION_ACTIVE, false, kFaultJammed).state, "ENABLED");
  EXPECT_TRUE(CrtkStateOf(palpate_SESSION_ACQUIRING, false, 0).busy);
  EXPECT_STREQ(CrtkStateOf(palpate_SESSION_ENDED, false, 0).state, "DISABLED");
  EXPECT_EQ(WishOf("pause", palpate_SESSION_ACTIVE), palpate_OPERATE_MUTE);
  EXPECT_EQ(WishOf("enable", palpate_SESSION_HELD), palpate_OPERATE_ADMIT);
  EXPECT_FALSE(WishOf("home", palpate_SESSION_ACTIVE));
}

TEST(SampleClock, TakesTheFastestWayOfLateAndFollowsAClockThatIsSet) {
  SampleClock clock;
  std::int64_t system_ns = 1'700'000'000'000'000'000, sample_ns = 55;
  for (int i = 0; i < 5000; ++i) {
    const std::int64_t late_ns = i % 10 == 0 ? 30'000 : 900'000;
    clock.Hear(sample_ns, system_ns + late_ns);
    system_ns += kMs;
    sample_ns += kMs;
  }
  EXPECT_NEAR(static_cast<double>(clock.ToSystem(sample_ns) - system_ns), 30'000.0, 2'000.0);
  system_ns += 3600 * 1000 * kMs;  // set forward by an hour
  clock.Hear(sample_ns, system_ns);
  EXPECT_EQ(clock.ToSystem(sample_ns), system_ns);
}

/// type_description_interfaces/msg/FieldType; 1: another message.
const std::map<std::string, int> kBuiltIn = {
    {"int32", 6}, {"uint32", 7}, {"float64", 11}, {"bool", 15}, {"string", 17}};

/// The .msg files: the type of each field, by name.
using Fields = std::vector<std::pair<std::string, std::string>>;
const std::map<std::string, Fields> kMessages = {
    {"builtin_interfaces/msg/Time", {{"sec", "int32"}, {"nanosec", "uint32"}}},
    {"std_msgs/msg/Header", {{"stamp", "builtin_interfaces/msg/Time"}, {"frame_id", "string"}}},
    {"std_msgs/msg/String", {{"data", "string"}}},
    {"geometry_msgs/msg/Point", {{"x", "float64"}, {"y", "float64"}, {"z", "float64"}}},
    {"geometry_msgs/msg/Vector3", {{"x", "float64"}, {"y", "float64"}, {"z", "float64"}}},
    {"geometry_msgs/msg/Quaternion",
     {{"x", "float64"}, {"y", "float64"}, {"z", "float64"}, {"w", "float64"}}},
    {"geometry_msgs/msg/Pose",
     {{"position", "geometry_msgs/msg/Point"}, {"orientation", "geometry_msgs/msg/Quaternion"}}},
    {"geometry_msgs/msg/Twist",
     {{"linear", "geometry_msgs/msg/Vector3"}, {"angular", "geometry_msgs/msg/Vector3"}}},
    {"geometry_msgs/msg/Wrench",
     {{"force", "geometry_msgs/msg/Vector3"}, {"torque", "geometry_msgs/msg/Vector3"}}},
    {"geometry_msgs/msg/PoseStamped",
     {{"header", "std_msgs/msg/Header"}, {"pose", "geometry_msgs/msg/Pose"}}},
    {"geometry_msgs/msg/TwistStamped",
     {{"header", "std_msgs/msg/Header"}, {"twist", "geometry_msgs/msg/Twist"}}},
    {"geometry_msgs/msg/WrenchStamped",
     {{"header", "std_msgs/msg/Header"}, {"wrench", "geometry_msgs/msg/Wrench"}}},
    {"crtk_msgs/msg/OperatingState",
     {{"header", "std_msgs/msg/Header"},
      {"state", "string"},
      {"is_homed", "bool"},
      {"is_busy", "bool"}}},
    {"crtk_msgs/msg/StringStamped", {{"header", "std_msgs/msg/Header"}, {"string", "string"}}},
};

void CollectReferenced(const std::string& message, std::set<std::string>& all) {
  for (const auto& [field, type] : kMessages.at(message)) {
    if (!kBuiltIn.contains(type) && all.insert(type).second) CollectReferenced(type, all);
  }
}

std::string Description(const std::string& message) {
  std::string json = "{\"type_name\": \"" + message + "\", \"fields\": [";
  bool first = true;
  for (const auto& [field, type] : kMessages.at(message)) {
    const auto built_in = kBuiltIn.find(type);
    const bool nested = built_in == kBuiltIn.end();
    json += (std::exchange(first, false) ? "" : ", ");
    json += "{\"name\": \"" + field +
            "\", \"type\": {\"type_id\": " + std::to_string(nested ? 1 : built_in->second) +
            ", \"capacity\": 0, \"string_capacity\": 0, \"nested_type_name\": \"" +
            (nested ? type : "") + "\"}}";
  }
  return json + "]}";
}

std::string Rihs01(const std::string& message) {
  std::set<std::string> referenced;  // sorted by name, as the REP demands
  CollectReferenced(message, referenced);
  std::string json =
      "{\"type_description\": " + Description(message) + ", \"referenced_type_descriptions\": [";
  bool first = true;
  for (const std::string& each : referenced) {
    json += (std::exchange(first, false) ? "" : ", ") + Description(each);
  }
  json += "]}";
  unsigned char digest[SHA256_DIGEST_LENGTH];
  SHA256(reinterpret_cast<const unsigned char*>(json.data()), json.size(), digest);
  std::string text = "RIHS01_";
  char two[3];
  for (const unsigned char byte : digest) {
    std::snprintf(two, sizeof two, "%02x", byte);
    text += two;
  }
  return text;
}

TEST(TypeHash, IsComputedHereAsRos2PublishesIt) {
  // As in ROS 2 Jazzy.
  const std::map<std::string, std::string> published = {
      {"std_msgs/msg/String",
       "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"},
      {"std_msgs/msg/Header",
       "RIHS01_f49fb3ae2cf070f793645ff749683ac6b06203e41c891e17701b1cb597ce6a01"},
      {"geometry_msgs/msg/Point",
       "RIHS01_6963084842a9b04494d6b2941d11444708d892da2f4b09843b9c43f42a7f6881"},
      {"geometry_msgs/msg/Quaternion",
       "RIHS01_8a765f66778c8ff7c8ab94afcc590a2ed5325a1d9a076ffff38fbce36f458684"},
      {"geometry_msgs/msg/Pose",
       "RIHS01_d501954e9476cea2996984e812054b68026ae0bfae789d9a10b23daf35cc90fa"},
      {"geometry_msgs/msg/PoseStamped",
       "RIHS01_10f3786d7d40fd2b54367835614bff85d4ad3b5dab62bf8bca0cc232d73b4cd8"},
      {"geometry_msgs/msg/TwistStamped",
       "RIHS01_5f0fcd4f81d5d06ad9b4c4c63e3ea51b82d6ae4d0558f1d475229b1121db6f64"},
  };
  for (const auto& [message, hash] : published) EXPECT_EQ(Rihs01(message), hash) << message;
}

TEST(TypeHash, OfEveryTopicIsThatOfItsMessage) {
  EXPECT_EQ(ros2::kTypeHash<ros2::PoseStamped>, Rihs01("geometry_msgs/msg/PoseStamped"));
  EXPECT_EQ(ros2::kTypeHash<ros2::TwistStamped>, Rihs01("geometry_msgs/msg/TwistStamped"));
  EXPECT_EQ(ros2::kTypeHash<ros2::WrenchStamped>, Rihs01("geometry_msgs/msg/WrenchStamped"));
  EXPECT_EQ(ros2::kTypeHash<ros2::OperatingState>, Rihs01("crtk_msgs/msg/OperatingState"));
  EXPECT_EQ(ros2::kTypeHash<ros2::StringStamped>, Rihs01("crtk_msgs/msg/StringStamped"));
}

}  // namespace
}  // namespace palpate::test
