// The type hashes that ROS 2 compares, computed from the message definitions as REP-2016 says.
#include <cstdio>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <openssl/sha.h>

#include "common/dds/ros2.h"

namespace palpate::test {
namespace {

/// type_description_interfaces/msg/FieldType; 1: another message.
const std::map<std::string, int> kBuiltIn = {
    {"int32", 6}, {"uint32", 7}, {"float64", 11}, {"bool", 15}, {"string", 17}};

/// The .msg files: fields by name, each with its type.
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
  std::set<std::string> referenced;  // by name, as the REP orders them
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
  // As ROS 2 Jazzy has them.
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
