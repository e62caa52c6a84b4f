#include "client/viewer/page_messages.h"

#include <algorithm>
#include <array>
#include <limits>
#include <span>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "common/dds/topics.h"
#include "common/json/json_file.h"
#include "common/text/number_of.h"

namespace palpate {
namespace {

using Json = nlohmann::json;
using Words = std::vector<std::string_view>;

/// In the order of MouseCommand::Op.
const Words kMouseOps = {"take", "pose", "release", "whole", "bookmark", "back"};
/// In the order of idl/session.idl, then a goal.
const Words kOperateOps = {"admit", "take_back", "mute", "unmute", "goal"};
/// In the order of TrialCommand::Op.
const Words kTrialOps = {"begin", "stop", "submit"};
/// In the order of idl/replay.idl, like the kinds of marks.
const Words kWishes = {"play", "pause", "seek", "rate", "add_bookmark", "drop_bookmark"};
constexpr std::array kMarks = {"bookmark", "session", "contact", "fault", "whole"};

std::size_t IndexIn(const Words& words, const JsonNode& node) {
  return static_cast<std::size_t>(std::ranges::find(words, node.OneOf(words)) - words.begin());
}

std::string TextOf(const JsonNode& node, std::size_t most) {
  std::string text = node.Text();
  if (text.size() > most) node.Fail(fmt::format("has more than {} bytes; give fewer", most));
  return text;
}

/// Reads the name of a scene or a tool.
std::string Name(const JsonNode& node) {
  constexpr std::size_t kLongest = 64;  // as in idl/session.idl
  return TextOf(node, kLongest);
}

std::string Hex(std::uint64_t id) {
  return fmt::format("{:x}", id);
}

/// Reads 1 to 16 hexadecimal digits, as written by Hex, not 0.
std::uint64_t ReadId(const JsonNode& node) {
  const std::string text = node.String();
  const std::uint64_t id = NumberOf<std::uint64_t>(text, 16).value_or(0);
  if (id == 0 || Hex(id) != text) {
    node.Fail("is not the replay's number as its state gives it, in hexadecimal digits");
  }
  return id;
}

}  // namespace

MouseCommand ParseMouseCommand(std::string_view text) {
  const JsonNode json = JsonNode::Parse(text, "/palpate/mouse");
  MouseCommand command;
  command.op = static_cast<MouseCommand::Op>(IndexIn(kMouseOps, json.At("op")));
  switch (command.op) {
    case MouseCommand::Op::kTake:
    case MouseCommand::Op::kWhole:
    case MouseCommand::Op::kBookmark:
    case MouseCommand::Op::kBack:
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
      if (const auto still = json.Find("still")) command.still = still->Boolean();
      break;
    }
    case MouseCommand::Op::kRelease:
      break;
  }
  return command;
}

std::string_view OperateWishName(wire::OperateWish wish) {
  return kOperateOps.at(static_cast<std::size_t>(wish));
}

OperateCommand ParseOperateCommand(std::string_view text) {
  const JsonNode json = JsonNode::Parse(text, "/palpate/operate");
  const std::size_t op = IndexIn(kOperateOps, json.At("op"));
  OperateCommand command;
  if (kOperateOps[op] == "goal") {
    json.AllowOnly({"op", "scene", "text", "limit_N"});
    command.goal = {json.At("scene").Text(),
                    TextOf(json.At("text"), OperateCommand::Goal::kLongest),
                    json.At("limit_N").Number(0.0)};
    return command;
  }
  json.AllowOnly({"op", "station"});
  const JsonNode station = json.At("station");
  command.station = station.Text();
  if (!dds::IsStationName(command.station)) station.Fail("names no station");
  command.wish = static_cast<wire::OperateWish>(op);
  return command;
}

TrialCommand ParseTrialCommand(std::string_view text) {
  const JsonNode json = JsonNode::Parse(text, "/palpate/trial");
  TrialCommand command;
  command.op = static_cast<TrialCommand::Op>(IndexIn(kTrialOps, json.At("op")));
  switch (command.op) {
    case TrialCommand::Op::kBegin:
      json.AllowOnly({"op", "exercise", "tool"});
      command.exercise = Name(json.At("exercise"));
      if (const auto tool = json.Find("tool")) command.tool = Name(*tool);
      break;
    case TrialCommand::Op::kStop:
      json.AllowOnly({"op"});
      break;
    case TrialCommand::Op::kSubmit:
      json.AllowOnly({"op", "exercise", "n"});
      command.exercise = Name(json.At("exercise"));
      command.n = static_cast<int>(json.At("n").Integer(0, 1'000'000));
      break;
  }
  return command;
}

ReplayWish ParseReplayWish(std::string_view text) {
  const JsonNode json = JsonNode::Parse(text, "/palpate/replay");
  ReplayWish read;
  wire::ReplayRequest& request = read.request;
  request.replay = ReadId(json.At("replay"));
  read.tag = static_cast<std::uint32_t>(
      json.At("tag").Integer(0, std::numeric_limits<std::uint32_t>::max()));
  request.kind = static_cast<std::uint32_t>(IndexIn(kWishes, json.At("wish")));
  request.wish = static_cast<palpate_ReplayWish>(request.kind);
  if (request.wish == palpate_REPLAY_PLAY || request.wish == palpate_REPLAY_PAUSE) return read;
  request.value = json.At("value").Number();
  if (request.wish != palpate_REPLAY_ADD_BOOKMARK) return read;
  const JsonNode node = json.At("text");
  const std::string name = TextOf(node, sizeof request.text - 1);
  // The text after it would be lost silently.
  if (name.find('\0') != std::string::npos) node.Fail("contains a NUL character");
  wire::FromText(name, request.text);
  return read;
}

std::string ReplayAnswer(std::uint32_t tag, std::uint64_t request, const std::string& refusal) {
  return ToText(Json({{"tag", tag}, {"request", Hex(request)}, {"refusal", refusal}}));
}

std::string ToJson(const wire::ReplayContents& contents) {
  Json marks = Json::array();
  for (const wire::ReplayMark& mark : std::span(contents.marks._buffer, contents.marks._length)) {
    const auto kind = static_cast<std::size_t>(mark.kind);
    marks.push_back({{"at_s", mark.at_s},
                     {"number", mark.number},
                     {"kind", kind < kMarks.size() ? kMarks[kind] : ""},
                     {"text", mark.text}});
  }
  Json gaps = Json::array();
  for (const wire::ReplayGap& gap : std::span(contents.gaps._buffer, contents.gaps._length)) {
    gaps.push_back({{"from_s", gap.from_s},
                    {"to_s", gap.to_s},
                    {"station", gap.station},
                    {"reason", gap.reason}});
  }
  return ToText(Json({{"replay", Hex(contents.replay)},
                      {"recording", contents.recording},
                      {"begun_s", 1e-9 * static_cast<double>(contents.begun_ns)},
                      {"length_s", contents.length_s},
                      {"locked", contents.locked},
                      {"marks", marks},
                      {"gaps", gaps}}));
}

std::string ToJson(const wire::ReplayState& state) {
  return ToText(Json({{"replay", Hex(state.replay)},
                      {"at_s", state.at_s},
                      {"rate", state.rate},
                      {"sought", state.sought},
                      {"playing", state.playing},
                      {"ended", state.ended},
                      {"request", Hex(state.request)},
                      {"refusal", state.refusal}}));
}

}  // namespace palpate
