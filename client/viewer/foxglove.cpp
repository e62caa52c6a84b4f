#include "client/viewer/foxglove.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "client/viewer/page_messages.h"
#include "client/viewer/viewer_limits.h"
#include "common/error.h"
#include "common/json/json_file.h"

namespace palpate::foxglove {
namespace {

using Json = nlohmann::json;

/// In the order of preference.
constexpr std::array<std::string_view, 2> kSubprotocols = {"foxglove.websocket.v1",
                                                           "foxglove.sdk.v1"};
constexpr std::uint8_t kMessageData = 1;
static_assert(std::endian::native == std::endian::little, "the protocol's integers are");

std::uint32_t Id(const JsonNode& node) {
  return static_cast<std::uint32_t>(node.Integer(0, std::numeric_limits<std::uint32_t>::max()));
}

std::vector<JsonNode> Items(const JsonNode& message, const char* field) {
  const JsonNode list = message.At(field);
  std::vector<JsonNode> items = list.Items();
  if (items.size() > ViewerLimits::kMostItems) {
    list.Fail(fmt::format("has more than {} entries; send fewer", ViewerLimits::kMostItems));
  }
  return items;
}

}  // namespace

std::string_view ChooseSubprotocol(std::string_view offered) {
  while (!offered.empty()) {
    std::string_view name = offered.substr(0, offered.find(','));
    offered.remove_prefix(std::min(name.size() + 1, offered.size()));
    name.remove_prefix(std::min(name.find_first_not_of(" \t"), name.size()));
    name = name.substr(0, name.find_last_not_of(" \t") + 1);
    for (const std::string_view known : kSubprotocols) {
      if (name == known) return known;
    }
  }
  return {};
}

std::string ServerInfo(const std::string& session_id, bool clients_may_publish,
                       const std::string& role) {
  Json info = {{"op", "serverInfo"},
               {"name", "palpate-viewer " PALPATE_VERSION},
               {"capabilities", Json::array()},
               {"metadata", {{"role", role}}},
               {"sessionId", session_id}};
  if (clients_may_publish) {
    info["capabilities"].push_back("clientPublish");
    info["supportedEncodings"] = {"json"};
  }
  return ToText(info);
}

std::string Advertise(const std::vector<Channel>& channels) {
  Json list = Json::array();
  for (const Channel& channel : channels) {
    list.push_back({{"id", channel.id},
                    {"topic", channel.topic},
                    {"encoding", channel.encoding},
                    {"schemaName", channel.schema_name},
                    {"schema", channel.schema},
                    {"schemaEncoding", channel.schema_encoding}});
  }
  return ToText(Json({{"op", "advertise"}, {"channels", list}}));
}

std::string Status(Level level, const std::string& message) {
  return ToText(Json({{"op", "status"}, {"level", static_cast<int>(level)}, {"message", message}}));
}

MessageHeader MakeMessageHeader(std::uint32_t subscription, std::int64_t time_ns) {
  MessageHeader header;
  header[0] = kMessageData;
  std::memcpy(&header[1], &subscription, sizeof subscription);
  std::memcpy(&header[5], &time_ns, sizeof time_ns);
  return header;
}

Request ParseRequest(std::string_view text) {
  const JsonNode message = JsonNode::Parse(text, "a text message");
  Request request;
  request.op = message.At("op").Text();
  if (request.op == "subscribe") {
    for (const JsonNode& item : Items(message, "subscriptions")) {
      request.subscriptions.push_back({Id(item.At("id")), Id(item.At("channelId"))});
    }
  } else if (request.op == "unsubscribe") {
    for (const JsonNode& item : Items(message, "subscriptionIds")) request.ids.push_back(Id(item));
  } else if (request.op == "advertise") {
    for (const JsonNode& item : Items(message, "channels")) {
      request.channels.push_back(
          {Id(item.At("id")), item.At("topic").Text(), item.At("encoding").Text()});
    }
  } else if (request.op == "unadvertise") {
    for (const JsonNode& item : Items(message, "channelIds")) request.ids.push_back(Id(item));
  }
  return request;
}

ClientMessage ParseMessage(std::span<const std::uint8_t> bytes) {
  ClientMessage message;
  constexpr std::size_t kHeader = 1 + sizeof message.channel;
  if (bytes.size() < kHeader) throw Error("a binary message that is cut short");
  if (bytes[0] != kMessageData) {
    throw Error("a binary message with opcode " + std::to_string(bytes[0]));
  }
  std::memcpy(&message.channel, &bytes[1], sizeof message.channel);
  message.payload = {reinterpret_cast<const char*>(bytes.data()) + kHeader, bytes.size() - kHeader};
  return message;
}

}  // namespace palpate::foxglove
