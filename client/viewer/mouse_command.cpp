#include "client/viewer/mouse_command.h"

#include <algorithm>
#include <charconv>
#include <vector>

#include "common/json/json_file.h"

namespace palpate {
namespace {

/// In the order of MouseCommand::Op.
const std::vector<std::string_view> kOps = {"take", "pose", "release", "whole"};
constexpr std::size_t kLongestName = 64;  // as idl/session.idl has it

std::string Name(const JsonNode& node) {
  std::string name = node.Text();
  if (name.size() > kLongestName) node.Fail("has more than 64 bytes; no scene and no tool has");
  return name;
}

}  // namespace

MouseCommand ParseMouseCommand(std::string_view text) {
  const JsonNode json = JsonNode::Parse(text, "/palpate/mouse");
  MouseCommand command;
  const auto op = std::ranges::find(kOps, json.At("op").OneOf(kOps));
  command.op = static_cast<MouseCommand::Op>(op - kOps.begin());
  switch (command.op) {
    case MouseCommand::Op::kTake:
    case MouseCommand::Op::kWhole:
      command.scene = Name(json.At("scene"));
      if (command.scene.empty()) json.At("scene").Fail("is empty; give a name");
      if (const auto tool = json.Find("tool")) command.tool = Name(*tool);
      break;
    case MouseCommand::Op::kPose: {
      const JsonNode q = json.At("q");
      const std::vector<JsonNode> wxyz = q.Items();
      if (wxyz.size() != 4) q.Fail("give four numbers: [w, x, y, z]");
      command.X_WT = {json.At("p").Vector(),
                      Quat(wxyz[0].Number(), wxyz[1].Number(), wxyz[2].Number(), wxyz[3].Number())};
      break;
    }
    case MouseCommand::Op::kRelease:
      break;
  }
  return command;
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
