#include "client/viewer/mouse_command.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <span>

#include <nlohmann/json.hpp>

namespace palpate {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kLongestName = 64;  // as idl/session.idl has it

bool ReadNumbers(const Json& object, const char* field, std::span<double> numbers) {
  const auto found = object.find(field);
  if (found == object.end() || !found->is_array() || found->size() != numbers.size()) return false;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (!(*found)[i].is_number()) return false;
    numbers[i] = (*found)[i].get<double>();
    if (!std::isfinite(numbers[i])) return false;
  }
  return true;
}

std::string Text(const Json& object, const char* field) {
  const auto found = object.find(field);
  return found != object.end() && found->is_string() ? found->get<std::string>() : "";
}

}  // namespace

std::optional<MouseCommand> ParseMouseCommand(std::string_view text, std::string& complaint) {
  const auto refuse = [&](const char* why) {
    complaint = why;
    return std::nullopt;
  };
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object()) return refuse("is no JSON object");
  const std::string op = Text(json, "op");
  MouseCommand command;
  if (op == "release") return command;
  if (op == "take" || op == "whole") {
    command.op = op == "take" ? MouseCommand::Op::kTake : MouseCommand::Op::kWhole;
    command.scene = Text(json, "scene");
    command.tool = Text(json, "tool");
    if (command.scene.empty()) return refuse("'take' and 'whole' need the name of a scene");
    if (std::max(command.scene.size(), command.tool.size()) > kLongestName) {
      return refuse("the name of a scene or a tool has 64 bytes at most");
    }
    return command;
  }
  if (op == "pose") {
    command.op = MouseCommand::Op::kPose;
    std::array<double, 3> p{};
    std::array<double, 4> q{};
    if (!ReadNumbers(json, "p", p) || !ReadNumbers(json, "q", q)) {
      return refuse("'pose' needs p, three numbers, and q, four");
    }
    command.X_WT = {Vec3(p[0], p[1], p[2]), Quat(q[0], q[1], q[2], q[3])};
    return command;
  }
  return refuse("its op is none of take, pose, release and whole");
}

std::string ToMouseLine(const Pose& X) {
  std::string line;
  for (const double value : {X.p.x(), X.p.y(), X.p.z(), X.q.w(), X.q.x(), X.q.y(), X.q.z()}) {
    char text[32];
    const char* end = std::to_chars(text, text + sizeof text, value).ptr;
    if (!line.empty()) line += ' ';
    line.append(static_cast<const char*>(text), end);
  }
  return line + '\n';
}

}  // namespace palpate
